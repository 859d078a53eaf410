// What a stability study comes to, by technique and format.
#pragma once

#include "analysis/stress/stress_study.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace ropsim {

// Kinds of inputs, as StressInput::kind names them.
inline constexpr std::array<std::string_view, 5> kStressKinds{"traces", "scenes", "thin", "even", "bright"};

struct VariantSummary {
    std::size_t technique = 0;
    std::size_t variant = 0;
    std::array<double, kStressKinds.size()> rounding{};  // the largest of a kind's inputs; -1: none
    std::array<double, kStressKinds.size()> error{};
    double worst_rounding = -1;
    std::size_t worst_input = 0;  // where that was
    double rise = -1, rise_exact = -1, outside = -1, order_change = -1, white_loss = -1, white_rounding = -1;
    std::uint64_t combinations = 0;
    std::uint64_t other_paths = 0;
    // By hazard: combinations and what went wrong in them.
    std::array<std::uint64_t, kStressHazardNames.size()> by_hazard{};
    std::array<StressFaults, kStressHazardNames.size()> faults{};
    std::array<bool, kStressKinds.size()> narrow{};  // a format is, on some input of the kind
    double hazard_rounding = -1;                     // the largest where a format is too narrow

    const StressFaults& faults_of(StressHazard hazard) const {
        return faults[static_cast<std::size_t>(hazard)];
    }
};

// Of every variant, in the study's order.
std::vector<VariantSummary> stress_summaries(const StressStudy& study);

// The variant of a technique with the fewest bits whose formats hold what is declared and whose rounding
// stays within 1/255 on all inputs of a kind (index into kStressKinds); of equal ones the one with the least
// rounding.
inline constexpr double kRoundingBound = 1.0 / 255;
std::optional<std::size_t> fewest_bits(const StressStudy& study, const std::vector<VariantSummary>& summaries,
                                       std::size_t technique, std::size_t kind);

}  // namespace ropsim
