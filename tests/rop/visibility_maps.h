// What the tests of visibility maps share: equation 2 of Salvi et al. 2011 in double precision for any
// visibility function, sample by sample, knowing nothing of the techniques' code.
#pragma once

#include "tests/rop/random_fragments.h"
#include "traces/depth_test.h"

#include <array>
#include <cmath>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace ropsim::test {

// A fragment at one spatial sample.
struct MapLayer {
    double z, a;
    std::array<double, 3> rgb;  // premultiplied
};
using Layers = std::vector<MapLayer>;
// The visibility that a map of the sample's layers gives depth z.
using Visibility = std::function<double(const Layers&, double z)>;

constexpr double kLeastTransmittance = 1e-5;  // the techniques' default

inline double absorbance(double alpha) {
    // The floor is a float.
    return -std::log(std::max(1.0 - alpha, static_cast<double>(static_cast<float>(kLeastTransmittance))));
}

inline Layers layers_of(const TraceHeader& header, std::span<const Fragment> fragments,
                        std::span<const DepthSlope> slopes, int x, int y, int m) {
    Layers layers;
    for (std::size_t i = 0; i < fragments.size(); ++i) {
        const Fragment& f = fragments[i];
        if (f.x != x || f.y != y || ((f.coverage >> m) & 1) == 0) continue;
        const float z = header.samples == 1
                            ? f.z
                            : sample_depth(f, slopes.empty() ? DepthSlope{} : slopes[i],
                                           sample_positions(header.samples)[static_cast<std::size_t>(m)]);
        layers.push_back({z, f.a, {f.r, f.g, f.b}});
    }
    return layers;
}

// Where z stands between the layers' depths, in [0, 1]; 0 where they have no extent.
inline double share_of(const Layers& layers, double z) {
    double nearest = 2;
    double furthest = -1;
    for (const MapLayer& l : layers) {
        nearest = std::min(nearest, l.z);
        furthest = std::max(furthest, l.z);
    }
    return furthest > nearest ? std::clamp((z - nearest) / (furthest - nearest), 0.0, 1.0) : 0.0;
}

struct MapImage {
    std::vector<double> rgb;  // 3 a pixel, row by row
};
// Sum of alpha c vis over what is behind; `normalised`: scaled so that the weights sum to the total alpha.
inline MapImage composited_by(const TraceHeader& header, std::span<const Fragment> fragments,
                              std::span<const DepthSlope> slopes, const Visibility& visibility,
                              bool normalised) {
    MapImage image;
    for (int y = 0; y < header.height; ++y) {
        for (int x = 0; x < header.width; ++x) {
            const auto background = background_of(header, x, y);
            std::array<double, 3> mean{};
            for (int m = 0; m < header.samples; ++m) {
                const Layers layers = layers_of(header, fragments, slopes, x, y, m);
                std::array<double, 3> sum{};
                double weight = 0;
                double t = 1;
                for (const MapLayer& l : layers) {
                    const double v = visibility(layers, l.z);
                    for (std::size_t c = 0; c < 3; ++c) sum[c] += v * l.rgb[c];
                    weight += v * l.a;
                    t *= 1 - l.a;
                }
                const double scale = normalised && weight > 0 ? (1 - t) / weight : 1;
                for (std::size_t c = 0; c < 3; ++c)
                    mean[c] += (sum[c] * scale + t * background[c]) / header.samples;
            }
            image.rgb.insert(image.rgb.end(), mean.begin(), mean.end());
        }
    }
    return image;
}

// Largest difference of a frame's image from `expected`.
inline double worst_difference(const std::vector<float>& image, const MapImage& expected) {
    double worst = 0;
    for (std::size_t i = 0; i < image.size(); ++i)
        worst = std::max(worst, std::abs(image[i] - expected.rgb[i]));
    return worst;
}

struct MapScene {
    TraceHeader header;
    std::vector<Fragment> fragments;
    std::vector<DepthSlope> slopes;  // empty for one spatial sample
};
// Random layers, about 24 a pixel, alphas of 0 and 1 among them.
inline MapScene map_scene(std::uint64_t seed, int samples = 1, int count = 1000) {
    Random random(seed);
    MapScene scene{opaque_header(7, 6, samples, random), {}, {}};
    FragmentOptions options;
    options.count = static_cast<std::size_t>(count);
    options.distinct_depths = true;
    scene.fragments = random_fragments(scene.header, options, random);
    if (samples > 1)
        for (std::size_t i = 0; i < scene.fragments.size(); ++i)
            scene.slopes.push_back({random.real(-0.02, 0.02), random.real(-0.02, 0.02)});
    return scene;
}

inline std::vector<float> drawn_image(const std::string& technique, const MapScene& scene) {
    TestFrame frame(technique, scene.header);
    frame.draw(scene.fragments, scene.slopes);
    return frame.image();
}

// What the frame's technique says of visibility at each depth of pixel 0, 0.
inline std::vector<float> visibility_at(TestFrame& frame, std::span<const float> depths) {
    std::vector<float> values(depths.size());
    frame.operation().visibility(frame.store(), 0, 0, depths, values);
    return values;
}

// Word `word` of a surface at pixel 0, 0.
inline std::uint32_t stored_bits(TestFrame& frame, std::string_view surface, int word) {
    for (const Surface& s : frame.declaration().surfaces)
        if (s.name == surface) return frame.words(0, 0)[static_cast<std::size_t>(s.first_word + word)];
    return 0;
}
inline float stored_word(TestFrame& frame, std::string_view surface, int word) {
    return std::bit_cast<float>(stored_bits(frame, surface, word));
}

// A pixel's layers as fragments, all of them grey of straight colour 1.
inline std::vector<Fragment> white_fragments(std::span<const std::array<float, 2>> depth_and_alpha) {
    std::vector<Fragment> fragments;
    for (const auto& [z, a] : depth_and_alpha) fragments.push_back(fragment_at(0, 0, z, a, {1, 1, 1}));
    return fragments;
}
inline float white_image(const std::string& technique,
                         std::span<const std::array<float, 2>> depth_and_alpha) {
    TestFrame frame(technique, header_of(1, 1, 1, {0, 0, 0}));
    frame.draw(white_fragments(depth_and_alpha));
    return frame.color()[0];
}

}  // namespace ropsim::test
