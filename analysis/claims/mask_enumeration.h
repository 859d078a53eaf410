// Stochastic transparency of one pixel, enumerated over all masks: Enderton et al. 2011, sections 3 and 4.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace ropsim {

// How a layer's samples are drawn.
enum class MaskDraw : std::uint8_t {
    kCoin,    // each by itself: "naive"
    kChoose,  // R = floor(alpha S + xi) of S, every subset alike: "S-choose-R"
    kRun,     // R neighbours around a circle of S, at a random rotation
};

struct MaskLayer {
    double alpha = 0;
    std::array<double, 3> color{};
};

struct MaskPixel {
    std::vector<MaskLayer> layers;  // nearest first
    std::array<double, 3> background{};
    int samples = 4;  // up to 16; all combinations of masks are visited
};

// Alpha-blended in order: the correct colour.
std::array<double, 3> blended(const MaskPixel& pixel);
double total_alpha(const std::vector<MaskLayer>& layers);

enum class MaskEstimate : std::uint8_t {
    kBasic,            // 3.1: B
    kCorrected,        // 4.1: A
    kDepth,            // 4.2: U, the background through the empty samples
    kDepthByCoverage,  // alpha_C U / F(B1), as 3.3 corrects
    kDepthByAlpha,     // 4.2: D = alpha_C U / U1
};

struct MaskErrors {
    std::array<double, 3> mean{};
    std::array<double, 3> rms{};  // against the correct colour
};
MaskErrors mask_errors(const MaskPixel& pixel, MaskDraw draw, MaskEstimate estimate);

// Probability of each of the 2^samples masks.
std::vector<double> mask_probabilities(MaskDraw draw, int samples, double alpha);

// Variance of the number of empty bins after `balls` balls into `bins` bins.
double empty_bins_variance(int balls, int bins);

double binomial(int n, int k);

// Probability that two masks of `count` of `samples`, drawn by S-choose-R, cover between `least` and `most`.
double two_masks_cover(int samples, int count, int least, int most);

}  // namespace ropsim
