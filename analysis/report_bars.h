// Stacked bars of a report: bytes by surface, cycles by label.
#pragma once

#include <string>
#include <vector>

#include "analysis/run_record.h"

namespace ropsim {

// HTML of both figures, captions and legends included; empty where no run measured anything of the kind. Failed runs
// are left out.
std::string traffic_bars(const std::vector<RunRecord>& runs);
std::string stage_bars(const std::vector<RunRecord>& runs);

}  // namespace ropsim
