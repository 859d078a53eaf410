// The header section of a trace file: TraceHeader and the columns as JSON text, and its validation.
#pragma once

#include "traces/block_codec.h"
#include "traces/trace.h"

#include <string>
#include <vector>

namespace ropsim {

struct StoredHeader {
    TraceHeader header;  // without the opaque layer, which is a section of its own
    int region_side = 0;
    std::vector<ColumnDescription> columns;
};

// What is wrong with a header, and how to mend it; empty when nothing is.
std::string header_fault(const TraceHeader& header);

// JSON text of the header section. Deterministic.
std::string header_text(const TraceHeader& header, int region_side);
// The part of the header that belongs to the content, not to its storage: what the hash covers.
std::string header_content_text(const TraceHeader& header);
// The inverse of header_text; keys it does not know are ignored. Throws FormatFault.
StoredHeader parse_header(const std::string& text);

}  // namespace ropsim
