// Two layers and four, and their errors by enumeration.
#include "analysis/claims/stochastic_pixels.h"

#include <algorithm>
#include <cmath>

namespace ropsim::stochastic_claims {

Values three(const std::array<double, 3>& values) {
    return {values.begin(), values.end()};
}
MaskPixel example1() {
    return {{{0.45, {1, 0, 0}}, {0.45, {0, 1, 0}}}, {0, 0, 1}, 4};
}
MaskPixel example2(int samples) {
    return {std::vector<MaskLayer>(4, {0.25, {1, 1, 1}}), {0.25, 0.25, 0.25}, samples};
}
MaskPixel two_quarters() {
    return {{{0.25, {1, 0, 0}}, {0.25, {0, 1, 0}}}, {0, 0, 0}, 4};
}

Values rms(const MaskPixel& pixel, MaskDraw draw, MaskEstimate estimate) {
    return three(mask_errors(pixel, draw, estimate).rms);
}
Values mean(const MaskPixel& pixel, MaskDraw draw, MaskEstimate estimate) {
    return three(mask_errors(pixel, draw, estimate).mean);
}

double bias(const MaskPixel& pixel, MaskDraw draw, MaskEstimate estimate) {
    const Values got = mean(pixel, draw, estimate);
    const auto correct = blended(pixel);
    double most = 0;
    for (std::size_t c = 0; c < 3; ++c) most = std::max(most, std::abs(got[c] - correct[c]));
    return most;
}

}  // namespace ropsim::stochastic_claims
