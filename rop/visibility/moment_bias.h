// The bias that moments are usually given, by their number, basis and stored format (Muenstermann et al.
// 2018).
#pragma once

#include "rop/visibility/power_moments.h"

#include <array>
#include <cstddef>

namespace ropsim {

struct UsualBias {
    double weight = 0;
    std::array<float, std::size_t{2} * kMaxMomentOrder> moments{};
};

// By number of moments 4, 6, 8. For 16 bits the public port by Neuhauser uses ten times these and has these
// in its comments; they are better on every scene tried.
namespace moment_bias {
using Orders = std::array<UsualBias, 3>;
inline constexpr Orders kPowerFloat{{{5e-7, {0, 0.375f, 0, 0.375f}},
                                     {5e-6, {0, 0.48f, 0, 0.451f, 0, 0.45f}},
                                     {5e-5, {0, 0.75f, 0, 0.67666667f, 0, 0.63f, 0, 0.60030303f}}}};
inline constexpr Orders kPowerUnorm{
    {{6e-5, {0, 0.628f, 0, 0.628f}},
     {6e-4, {0, 0.5566f, 0, 0.489f, 0, 0.47869382f}},
     {2.5e-3, {0, 0.42474916f, 0, 0.22407803f, 0, 0.15369231f, 0, 0.12900441f}}}};
inline constexpr Orders kTrigonometricFloat{{{4e-7, {}}, {8e-6, {}}, {1.5e-5, {}}}};
inline constexpr Orders kTrigonometricUnorm{{{4e-4, {}}, {6.5e-4, {}}, {8.5e-4, {}}}};
}  // namespace moment_bias

// `order`: half the number of moments.
constexpr const UsualBias& usual_bias(int order, bool trigonometric, bool quantised) {
    const auto at = static_cast<std::size_t>(order - 2);
    if (trigonometric)
        return quantised ? moment_bias::kTrigonometricUnorm[at] : moment_bias::kTrigonometricFloat[at];
    return quantised ? moment_bias::kPowerUnorm[at] : moment_bias::kPowerFloat[at];
}

}  // namespace ropsim
