// Hazards that transparency techniques are known for, each reproduced by a format or an option and cured by
// another, with the bits that costs.
#pragma once

#include "rop/single_pixel.h"

#include <string>
#include <vector>

namespace ropsim {

struct StressHazardCase {
    std::string id;
    std::string what;
    std::string with;   // NAME[:key=value,...]
    std::string cured;  // the same technique otherwise
    std::vector<PixelScene> scenes;
    int seeds = 1;  // of random techniques: what is compared is the mean over so many
    // What both are held against: this in double precision where it is given, else exact compositing.
    std::string reference = "";
    // At least this is lost, at most that remains: root mean squares of a channel over the scenes.
    double least_lost = 0;
    double most_left = 0;
};
struct StressHazardOutcome {
    double lost = 0;
    double left = 0;
    // Storage of a pixel and, of lists, of a stored fragment with the hazard, and what the cure has more of
    // it and of passes over the geometry.
    int bits = 0, node_bits = 0;
    int more = 0, node_more = 0, more_passes = 0;
};

// Of products and of sums in narrow formats; of arithmetic, and of what techniques leave out.
std::vector<StressHazardCase> stored_product_hazards();
std::vector<StressHazardCase> stored_sum_hazards();
std::vector<StressHazardCase> arithmetic_hazards();
std::vector<StressHazardCase> approximation_hazards();

const std::vector<StressHazardCase>& stress_hazard_cases();
StressHazardOutcome run_hazard(const StressHazardCase& hazard);

// A row a hazard, for readers.
std::string stress_hazards_markdown();

}  // namespace ropsim
