#include "analysis/volume_medium.h"

#include "rop/transcendental.h"

#include <algorithm>
#include <cmath>

namespace ropsim {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kLog2E = 1.4426950408889634;
constexpr double kDarkest = 700;  // exp(-700) is 1e-304

}  // namespace

double henyey_greenstein(double cosine, double anisotropy) {
    const double g = anisotropy;
    // 1 + g^2 - 2 g cosine without its cancellation near g = cosine = 1.
    const double distance = (1 - g) * (1 - g) + 2 * g * (1 - std::clamp(cosine, -1.0, 1.0));
    return (1 - g) * (1 + g) / (4 * kPi * distance * std::sqrt(distance));
}

double absorbed_share(double depth) {
    if (depth > kDarkest) return 1;
    if (depth > 1.0 / 32) return 1 - deterministic_exp2(-depth * kLog2E);
    double series = 1;  // of (1 - exp(-x)) / x = 1 - x/2 (1 - x/3 (1 - ...)), truncated at 1e-15
    for (int n = 9; n >= 2; --n) series = 1 - depth / n * series;
    return depth * series;
}

double extinction_at(const VolumeMedium& medium, double height) {
    if (!medium.height_falloff) return medium.extinction;
    const double folds = std::max(0.0, height - medium.base_height) / *medium.height_falloff;
    return folds > kDarkest ? 0 : medium.extinction * deterministic_exp2(-folds * kLog2E);
}

}  // namespace ropsim
