// Small images made by rule, for the tests of the error figures.
#pragma once

#include "base/random.h"
#include "traces/image.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>

namespace ropsim::test {

using Color = std::array<float, 3>;

inline Image filled(int width, int height, const std::function<Color(int, int)>& color) {
    Image image(width, height, {"R", "G", "B"});
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const Color c = color(x, y);
            std::copy(c.begin(), c.end(), image.pixel(x, y));
        }
    return image;
}

inline Image constant(int width, int height, Color color) {
    return filled(width, height, [color](int, int) { return color; });
}

inline Image noise(int width, int height, std::uint64_t seed) {
    return filled(width, height, [=](int x, int y) {
        const auto key = mix64(seed * 1000003 + static_cast<std::uint64_t>(y * width + x));
        return Color{random_unit(key, 0), random_unit(key, 1), random_unit(key, 2)};
    });
}

inline Image blend(const Image& a, const Image& b, float t) {
    Image out = a;
    for (std::size_t i = 0; i < out.values.size(); ++i) out.values[i] += t * (b.values[i] - a.values[i]);
    return out;
}

}  // namespace ropsim::test
