// Stochastic transparency of one pixel, enumerated over all masks.
#include "analysis/claims/mask_enumeration.h"

#include "base/error.h"

#include <bit>
#include <cmath>

namespace ropsim {
namespace {

using Color = std::array<double, 3>;

Color added(const Color& a, double weight, const Color& b) {
    return {a[0] + weight * b[0], a[1] + weight * b[1], a[2] + weight * b[2]};
}

// The layers in front as one combination of masks leaves them.
struct Partial {
    std::uint32_t taken = 0;
    Color basic{}, depth{};  // F(B) and U
    double depth_alpha = 0;  // U1
};

Partial behind(const Partial& front, const MaskLayer& layer, std::uint32_t mask, int samples) {
    Partial next = front;
    const double seen = std::popcount(mask & ~front.taken);
    const double visible = samples - std::popcount(front.taken);
    next.basic = added(front.basic, seen / samples, layer.color);
    next.depth = added(front.depth, visible / samples * layer.alpha, layer.color);
    next.depth_alpha += visible / samples * layer.alpha;
    next.taken |= mask;
    return next;
}

Color estimated(const Partial& all, const MaskPixel& pixel, MaskEstimate estimate) {
    const double covered = static_cast<double>(std::popcount(all.taken)) / pixel.samples;
    const double alpha = total_alpha(pixel.layers);
    const auto corrected = [&](const Color& color, double divisor) {
        const Color front = divisor > 0 ? added({}, alpha / divisor, color) : Color{};
        return added(front, 1 - alpha, pixel.background);
    };
    switch (estimate) {
        case MaskEstimate::kBasic:
            return added(all.basic, 1 - covered, pixel.background);
        case MaskEstimate::kDepth:
            return added(all.depth, 1 - covered, pixel.background);
        case MaskEstimate::kCorrected:
            return corrected(all.basic, covered);
        case MaskEstimate::kDepthByCoverage:
            return corrected(all.depth, covered);
        case MaskEstimate::kDepthByAlpha:
            break;
    }
    return corrected(all.depth, all.depth_alpha);
}

// Calls take(outcome, probability) for every combination of masks that can occur.
template <class Take>
void for_outcomes(const MaskPixel& pixel, const std::vector<std::vector<double>>& probabilities,
                  std::size_t layer, const Partial& front, double probability, const Take& take) {
    if (layer == pixel.layers.size()) return take(front, probability);
    for (std::uint32_t mask = 0; mask < probabilities[layer].size(); ++mask)
        if (probabilities[layer][mask] > 0)
            for_outcomes(pixel, probabilities, layer + 1,
                         behind(front, pixel.layers[layer], mask, pixel.samples),
                         probability * probabilities[layer][mask], take);
}

}  // namespace

double total_alpha(const std::vector<MaskLayer>& layers) {
    double clear = 1;
    for (const MaskLayer& layer : layers) clear *= 1 - layer.alpha;
    return 1 - clear;
}

std::array<double, 3> blended(const MaskPixel& pixel) {
    Color color{};
    double clear = 1;
    for (const MaskLayer& layer : pixel.layers) {
        color = added(color, clear * layer.alpha, layer.color);
        clear *= 1 - layer.alpha;
    }
    return added(color, clear, pixel.background);
}

double binomial(int n, int k) {
    if (k < 0 || k > n) return 0;
    double value = 1;
    for (int i = 1; i <= k; ++i) value = value * (n - k + i) / i;
    return value;
}

std::vector<double> mask_probabilities(MaskDraw draw, int samples, double alpha) {
    CHECK(samples >= 1 && samples <= 16, "{}", samples);
    std::vector<double> probability(std::size_t{1} << samples, 0.0);
    if (draw == MaskDraw::kCoin) {
        for (std::size_t mask = 0; mask < probability.size(); ++mask)
            probability[mask] =
                std::pow(alpha, std::popcount(mask)) * std::pow(1 - alpha, samples - std::popcount(mask));
        return probability;
    }
    const int low = static_cast<int>(std::floor(alpha * samples));
    const double high_share = alpha * samples - low;
    const auto share_of = [&](int count) {
        return count == low ? 1 - high_share : count == low + 1 ? high_share : 0;
    };
    if (draw == MaskDraw::kChoose) {
        for (std::size_t mask = 0; mask < probability.size(); ++mask) {
            const int count = std::popcount(mask);
            probability[mask] = share_of(count) / binomial(samples, count);
        }
        return probability;
    }
    for (int count = low; count <= std::min(low + 1, samples); ++count) {
        for (int first = 0; first < samples; ++first) {
            std::size_t mask = 0;
            for (int i = 0; i < count; ++i) mask |= std::size_t{1} << ((first + i) % samples);
            probability[mask] += share_of(count) / samples;
        }
    }
    return probability;
}

MaskErrors mask_errors(const MaskPixel& pixel, MaskDraw draw, MaskEstimate estimate) {
    std::vector<std::vector<double>> probabilities;
    for (const MaskLayer& layer : pixel.layers)
        probabilities.push_back(mask_probabilities(draw, pixel.samples, layer.alpha));
    const Color exact = blended(pixel);
    MaskErrors errors;
    Color squares{};
    for_outcomes(pixel, probabilities, 0, {}, 1, [&](const Partial& all, double probability) {
        const Color color = estimated(all, pixel, estimate);
        for (std::size_t c = 0; c < 3; ++c) {
            errors.mean[c] += probability * color[c];
            squares[c] += probability * (color[c] - exact[c]) * (color[c] - exact[c]);
        }
    });
    for (std::size_t c = 0; c < 3; ++c) errors.rms[c] = std::sqrt(squares[c]);
    return errors;
}

double empty_bins_variance(int balls, int bins) {
    // E(X^2) by pairs: two given bins stay empty with probability (1 - 2/n)^m.
    const double n = bins;
    const double one = std::pow(1 - 1 / n, balls);
    const double two = std::pow(1 - 2 / n, balls);
    return n * one + n * (n - 1) * two - n * n * one * one;
}

double two_masks_cover(int samples, int count, int least, int most) {
    double probability = 0;
    for (int both = 0; both <= count; ++both) {
        const int covered = 2 * count - both;
        if (covered < least || covered > most) continue;
        probability +=
            binomial(count, both) * binomial(samples - count, count - both) / binomial(samples, count);
    }
    return probability;
}

}  // namespace ropsim
