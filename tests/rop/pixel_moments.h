// Moments of a pixel's colour: exact ones of enumerated outcomes, and those of the pixels of an image that
// draws the same layers everywhere, with the tolerance that their number leaves.
#pragma once

#include "tests/rop/random_fragments.h"

#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim::test {

// Mean, variance and fourth central moment of one channel.
struct Moments {
    double mean = 0, variance = 0, fourth = 0;
    double deviation() const { return std::sqrt(variance); }
};

inline Moments moments_of(const std::vector<std::pair<double, double>>& outcomes) {  // value, probability
    Moments m;
    for (const auto& [v, p] : outcomes) m.mean += p * v;
    for (const auto& [v, p] : outcomes) {
        m.variance += p * std::pow(v - m.mean, 2);
        m.fourth += p * std::pow(v - m.mean, 4);
    }
    return m;
}

// Of one channel of an image, all pixels alike.
inline Moments moments_of(const std::vector<float>& image, std::size_t channel) {
    std::vector<std::pair<double, double>> outcomes;
    for (std::size_t i = channel; i < image.size(); i += 3)
        outcomes.emplace_back(image[i], 3.0 / static_cast<double>(image.size()));
    return moments_of(outcomes);
}

// Each of the layers in every pixel, layer after layer in the order given.
inline std::vector<Fragment> everywhere(const TraceHeader& header, const std::vector<Fragment>& layers) {
    std::vector<Fragment> fragments;
    for (Fragment f : layers) {
        for (int i = 0; i < header.width * header.height; ++i) {
            f.x = static_cast<std::uint16_t>(i % header.width);
            f.y = static_cast<std::uint16_t>(i / header.width);
            fragments.push_back(f);
        }
    }
    return fragments;
}

inline std::vector<float> image_of(const std::string& technique, const TraceHeader& header,
                                   std::span<const Fragment> fragments, std::uint64_t seed = 7) {
    TestFrame frame(technique, header, seed, 1u << 20, /*record=*/false);
    frame.draw(fragments);
    return frame.image();
}

// The layers over a plain background, in side x side pixels.
inline std::vector<float> image_of_layers(const std::string& technique, const std::vector<Fragment>& layers,
                                          glm::vec3 background, int side = 256, std::uint64_t seed = 7) {
    const TraceHeader header = header_of(side, side, 1, background);
    return image_of(technique, header, everywhere(header, layers), seed);
}

// The pixels' mean and variance, independent of one another, within 4 standard errors of `m`; `rounding`
// bounds what float32 arithmetic adds.
inline void expect_moments(const std::vector<float>& image, std::size_t channel, const Moments& m,
                           double rounding = 1e-6) {
    const double n = static_cast<double>(image.size()) / 3;
    double mean = 0;
    double variance = 0;
    for (std::size_t i = channel; i < image.size(); i += 3) mean += image[i] / n;
    for (std::size_t i = channel; i < image.size(); i += 3)
        variance += (image[i] - m.mean) * (image[i] - m.mean) / n;
    EXPECT_NEAR(mean, m.mean, 4 * std::sqrt(m.variance / n) + rounding);
    EXPECT_NEAR(variance, m.variance,
                4 * std::sqrt(std::max(0.0, m.fourth - m.variance * m.variance) / n) + rounding);
}
inline void expect_moments(const std::string& technique, const std::vector<Fragment>& layers,
                           glm::vec3 background, std::size_t channel, const Moments& m) {
    SCOPED_TRACE(technique + ", channel " + std::to_string(channel));
    expect_moments(image_of_layers(technique, layers, background), channel, m);
}

}  // namespace ropsim::test
