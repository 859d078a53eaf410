// What `ropsim trace info` says of a trace.
#pragma once

#include "traces/trace.h"
#include "traces/trace_statistics.h"

#include <string>

namespace ropsim {

// Both end with a line break.
std::string trace_info_json(const TraceReader& reader, const TraceStatistics& statistics);
std::string trace_info_text(const TraceReader& reader, const TraceStatistics& statistics);

}  // namespace ropsim
