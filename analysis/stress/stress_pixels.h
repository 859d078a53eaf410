// A technique on the pixels of one input, for the stability study: colours, visibility, and what becomes of
// them when fragments arrive otherwise or are white.
#pragma once

#include "analysis/stress/stress_inputs.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

struct PixelOutcome {
    std::array<double, 3> color{};
    std::vector<std::uint64_t> paths;
    std::vector<double> visibility;  // at some of its fragments' depths and right before and behind them
    double order_change = -1;
    double white = -1;  // the largest channel of the same fragments in white before white; -1: not run
};

struct InputOutcome {
    bool random = false;
    std::vector<PixelOutcome> pixels;
};

enum class Precision : std::uint8_t { kSingle, kDouble };

InputOutcome run_pixels(const std::string& technique, Precision precision, const StressInput& input,
                        std::uint64_t seed);
// Whether the input's lists would take too long: techniques that peel one layer a pass, or walk a list once
// for each of its fragments.
bool takes_too_long(const std::string& technique, const StressInput& input);

}  // namespace ropsim
