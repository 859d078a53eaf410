// Stacked bars of a report: bytes by surface, cycles by label.
#pragma once

#include "analysis/run_record.h"

#include <string>
#include <vector>

namespace ropsim {

// HTML of both figures, captions and legends included; empty where no run measured anything of the kind.
// Failed runs are left out.
std::string traffic_bars(const std::vector<RunRecord>& runs);
std::string stage_bars(const std::vector<RunRecord>& runs);

}  // namespace ropsim
