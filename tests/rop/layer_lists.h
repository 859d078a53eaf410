// Sorted layers merged by brute force in double precision, and pixels full of layers to try them on: what the
// tests of mlab, aoit and z3 share.
#pragma once

#include "tests/rop/random_fragments.h"

#include <algorithm>
#include <array>
#include <functional>
#include <vector>

namespace ropsim::test {

// A layer: premultiplied colour and own transmittance.
struct ListLayer {
    double z;
    std::array<double, 3> rgb;
    double t;
};
using LayerList = std::vector<ListLayer>;

inline ListLayer layer_of(const Fragment& f) {
    return {f.z, {f.r, f.g, f.b}, 1.0 - static_cast<double>(f.a)};
}

inline std::array<double, 3> composited(const LayerList& front_to_back, std::array<double, 3> background) {
    std::array<double, 3> color = background;
    for (auto l = front_to_back.rbegin(); l != front_to_back.rend(); ++l)
        for (std::size_t c = 0; c < 3; ++c) color[c] = l->rgb[c] + l->t * color[c];
    return color;
}

// Merges entry j into j - 1.
inline void merge_at(LayerList& list, std::size_t j) {
    ListLayer& near = list[j - 1];
    for (std::size_t c = 0; c < 3; ++c) near.rgb[c] += near.t * list[j].rgb[c];
    near.t *= list[j].t;
    list.erase(list.begin() + static_cast<std::ptrdiff_t>(j));
}

// The list after the fragments of pixel (x, y), in their order; `choose` says which entry of one too many
// merges into the one in front of it.
inline LayerList merged_list(std::span<const Fragment> fragments, int x, int y, std::size_t layers,
                             bool newest_in_front,
                             const std::function<std::size_t(const LayerList&)>& choose) {
    LayerList list;
    for (const Fragment& f : fragments) {
        if (f.x != x || f.y != y) continue;
        const auto at = std::find_if(list.begin(), list.end(), [&](const ListLayer& l) {
            return newest_in_front ? !(l.z < f.z) : l.z > f.z;
        });
        list.insert(at, layer_of(f));
        if (list.size() > layers) merge_at(list, choose(list));
    }
    return list;
}

// `count` layers in each pixel of side x side at random depths, of random colours and of alpha(i), in random
// order.
inline std::vector<Fragment> random_layers(int side, int count, Random& random,
                                           const std::function<float()>& alpha) {
    std::vector<Fragment> fragments;
    for (int layer = 0; layer < count; ++layer)
        for (int pixel = 0; pixel < side * side; ++pixel)
            fragments.push_back(fragment_at(pixel % side, pixel / side, random.real(0, 1), alpha(),
                                            {random.real(0, 1), random.real(0, 1), random.real(0, 1)},
                                            static_cast<std::uint32_t>(layer)));
    return fragments;
}

// Root mean square and mean of an image's error against exact compositing, in 1/255, with the standard error
// of the mean square over pixels.
struct ErrorFigures {
    double rms8 = 0;
    double mean8 = 0;
    double rms8_deviation = 0;
};
inline ErrorFigures error_figures(TestFrame& frame, std::span<const Fragment> fragments) {
    const TraceHeader& header = frame.header();
    const std::vector<float> image = frame.image();
    std::vector<std::vector<Fragment>> own(static_cast<std::size_t>(header.width * header.height));
    for (const Fragment& f : fragments) own[static_cast<std::size_t>(f.y * header.width + f.x)].push_back(f);
    double sum = 0;
    double squares = 0;
    double fourths = 0;
    for (std::size_t pixel = 0; pixel < own.size(); ++pixel) {
        const int x = static_cast<int>(pixel) % header.width;
        const int y = static_cast<int>(pixel) / header.width;
        const auto exact = composited(own[pixel], x, y, background_of(header, x, y));
        double square = 0;
        for (std::size_t c = 0; c < 3; ++c) {
            const double error = 255 * (image[3 * pixel + c] - exact[c]);
            sum += error / 3;
            square += error * error / 3;
        }
        squares += square;
        fourths += square * square;
    }
    const auto n = static_cast<double>(own.size());
    ErrorFigures figures;
    figures.rms8 = std::sqrt(squares / n);
    figures.mean8 = sum / n;
    const double variance = fourths / n - (squares / n) * (squares / n);
    figures.rms8_deviation = std::sqrt(variance / n) / (2 * figures.rms8);
    return figures;
}

// The word of element `element` of field `word` words behind the surface's start, as a float.
inline float stored_real(TestFrame& frame, int word) {
    return std::bit_cast<float>(frame.words(0, 0)[static_cast<std::size_t>(word)]);
}

}  // namespace ropsim::test
