// Stochastic transparency of one pixel by enumeration in double precision (Enderton et al. 2011, sections 3
// and 4): every combination of masks with its probability, and every estimate of the paper from the masks.
// Shares nothing with rop/.
#pragma once

#include "tests/rop/pixel_moments.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace ropsim::test {

// How a layer's samples are drawn: each by a coin, any R of S alike, or R neighbours around a circle.
enum class MaskKind : std::uint8_t { kCoin, kChoose, kRun };

inline std::string name_of(MaskKind kind) {
    return kind == MaskKind::kCoin ? "coin" : kind == MaskKind::kChoose ? "choose" : "run";
}

// Probability of each of the 2^samples masks of a layer of alpha `a`; R = floor(a S + xi).
inline std::vector<double> mask_probabilities(MaskKind kind, int samples, double a) {
    const std::uint32_t masks = 1u << samples;
    std::vector<double> probability(masks, 0.0);
    const double expected = a * samples;
    const int low = static_cast<int>(std::floor(expected));
    for (std::uint32_t mask = 0; mask < masks; ++mask) {
        const int count = std::popcount(mask);
        if (kind == MaskKind::kCoin) {
            probability[mask] = std::pow(a, count) * std::pow(1 - a, samples - count);
            continue;
        }
        const double of_count = count == low ? low + 1 - expected : count == low + 1 ? expected - low : 0;
        if (kind == MaskKind::kChoose) probability[mask] = of_count / binomial(samples, count);
        if (kind == MaskKind::kRun) {
            // One run: going around, samples switch on at one place at most.
            const std::uint32_t turned = ((mask << 1) | (mask >> (samples - 1))) & (masks - 1);
            if (std::popcount(mask & ~turned) > 1) continue;
            probability[mask] = of_count / (count == 0 || count == samples ? 1 : samples);
        }
    }
    return probability;
}

struct Layer {
    double alpha = 0;
    std::array<double, 3> color{};
};

inline double total_alpha(const std::vector<Layer>& layers) {
    double clear = 1;
    for (const Layer& layer : layers) clear *= 1 - layer.alpha;
    return 1 - clear;
}

enum class Estimate : std::uint8_t {
    kBasic,             // 3.1: B over the background
    kBasicCorrected,    // 3.3, 4.1: A
    kDepth,             // 3.4: U, the background through the empty samples
    kDepthCoverage,     // U by F(B1)
    kDepthAccumulated,  // 4.2: D, U by U1
};

// A pixel's colour where layer i, nearest first, asks for the samples of masks[i]. `corrected_alpha`: what a
// corrected estimate is scaled to, total alpha in the paper.
inline std::array<double, 3> estimated(Estimate estimate, const std::vector<Layer>& layers,
                                       const std::vector<std::uint32_t>& masks, int samples,
                                       std::array<double, 3> background, double corrected_alpha) {
    std::array<double, 3> sum{};
    double ones = 0;  // the same with every colour 1
    std::uint32_t taken = 0;
    const bool depth = estimate != Estimate::kBasic && estimate != Estimate::kBasicCorrected;
    for (std::size_t i = 0; i < layers.size(); ++i) {
        const int seen = std::popcount(masks[i] & ~taken);
        const double visible = static_cast<double>(samples - std::popcount(taken)) / samples;
        const double weight = depth ? visible * layers[i].alpha : static_cast<double>(seen) / samples;
        for (std::size_t c = 0; c < 3; ++c) sum[c] += weight * layers[i].color[c];
        ones += weight;
        taken |= masks[i];
    }
    const double occupied = static_cast<double>(std::popcount(taken)) / samples;
    if (estimate == Estimate::kBasic || estimate == Estimate::kDepth) {
        for (std::size_t c = 0; c < 3; ++c) sum[c] += (1 - occupied) * background[c];
        return sum;
    }
    const double divisor = estimate == Estimate::kDepthAccumulated ? ones : occupied;
    for (std::size_t c = 0; c < 3; ++c)
        sum[c] = (divisor > 0 ? corrected_alpha * sum[c] / divisor : 0) +
                 (1 - total_alpha(layers)) * background[c];
    return sum;
}

// Calls body(masks, probability) for every combination of the layers' masks that can occur.
inline void for_masks(MaskKind kind, const std::vector<Layer>& layers, int samples,
                      const std::function<void(const std::vector<std::uint32_t>&, double)>& body) {
    std::vector<std::vector<double>> probability;
    for (const Layer& layer : layers) probability.push_back(mask_probabilities(kind, samples, layer.alpha));
    std::vector<std::uint32_t> masks(layers.size());
    const std::function<void(std::size_t, double)> descend = [&](std::size_t i, double p) {
        if (i == layers.size()) return body(masks, p);
        for (std::uint32_t mask = 0; mask < probability[i].size(); ++mask) {
            if (probability[i][mask] == 0) continue;
            masks[i] = mask;
            descend(i + 1, p * probability[i][mask]);
        }
    };
    descend(0, 1.0);
}

// Exact moments of the three channels. A negative `corrected_alpha` stands for total alpha.
inline std::array<Moments, 3> exact_moments(Estimate estimate, MaskKind kind,
                                            const std::vector<Layer>& layers, int samples,
                                            std::array<double, 3> background, double corrected_alpha = -1) {
    std::array<std::vector<std::pair<double, double>>, 3> outcomes;
    const double alpha = corrected_alpha < 0 ? total_alpha(layers) : corrected_alpha;
    for_masks(kind, layers, samples, [&](const std::vector<std::uint32_t>& masks, double p) {
        const auto color = estimated(estimate, layers, masks, samples, background, alpha);
        for (std::size_t c = 0; c < 3; ++c) outcomes[c].emplace_back(color[c], p);
    });
    return {moments_of(outcomes[0]), moments_of(outcomes[1]), moments_of(outcomes[2])};
}

// What blending the layers in order gives.
inline std::array<double, 3> blended(const std::vector<Layer>& layers, std::array<double, 3> background) {
    std::array<double, 3> color = background;
    for (auto layer = layers.rbegin(); layer != layers.rend(); ++layer)
        for (std::size_t c = 0; c < 3; ++c)
            color[c] = layer->alpha * layer->color[c] + (1 - layer->alpha) * color[c];
    return color;
}

// The layers as fragments of one pixel, nearest first.
inline std::vector<Fragment> fragments_of(const std::vector<Layer>& layers) {
    std::vector<Fragment> fragments;
    for (std::size_t i = 0; i < layers.size(); ++i) {
        const Layer& l = layers[i];
        fragments.push_back(fragment_at(
            0, 0, 0.1f + 0.8f * static_cast<float>(i) / static_cast<float>(layers.size()),
            static_cast<float>(l.alpha),
            {static_cast<float>(l.color[0]), static_cast<float>(l.color[1]), static_cast<float>(l.color[2])},
            static_cast<std::uint32_t>(i)));
    }
    return fragments;
}

// The parameters of stochastic that draw this estimate.
inline std::string technique_of(Estimate estimate, MaskKind kind, int samples) {
    std::string common =
        "stochastic:format=float32,samples=" + std::to_string(samples) + ",masks=" + name_of(kind);
    switch (estimate) {
        case Estimate::kBasic:
            return common;
        case Estimate::kBasicCorrected:
            return common + ",correction=coverage";
        case Estimate::kDepth:
            return common + ",method=depth_based,correction=none";
        case Estimate::kDepthCoverage:
            return common + ",method=depth_based,correction=coverage";
        case Estimate::kDepthAccumulated:
            return common + ",method=depth_based,correction=accumulated";
    }
    return common;
}

}  // namespace ropsim::test
