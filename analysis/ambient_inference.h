// Inferred ambient occlusion (McGuire and Mara 2017, section 6 and Listing 2): what a fragment at the edge of
// a cut-out receives, from the ambient buffer at the surface it belongs to.
//
// A bilateral filter over the buffer's texels along a ray from the fragment, or, where alpha does not change,
// over a square about it. A tap weighs 0.01 / (0.01 + |dz|) with dz the distance in z between the fragment
// and the tap's depth buffer texel, in camera space. What the listing leaves open or does unannounced:
//
// - Units of dz: the paper does not say; its engine's unit is the metre, which is taken here.
// - The ray runs up the gradient of alpha, into the surface, and its first tap, t = 0, is the fragment's own
//   pixel, whose texels belong to what lies behind. The last is 11 * 3 = 33 pixels away.
// - The shift of (|dy| & 1) - 1/2 steps is to make a checkerboard of the square. It does not: it moves even
//   rows one pixel to the left and odd ones one to the right, a whole step apart, so that both read the odd
//   columns, -7 to 5 and -5 to 7. The fragment's own column is in none, and as there are four odd rows to
//   three even ones the mean tap lies 1/7 pixel to the right. `checkerboard` moves odd rows half a step.
// - ivec2() cuts towards zero; with the clamp behind it that is the same as rounding down.
// - The quotient is sum.x / max(0.01, sum.y). Where all weights together are below 0.01 (twelve taps all more
//   than 12 m away; towards an empty background that is the far plane) the floor, which should only save the
//   division, takes over and AO goes to 0: an edge with no surface of its own in reach turns dark, not
//   bright. `floor` 0 is the other reading: the weighted mean whatever the weights, 1 without any.
// - A texel where nothing was drawn has the far plane's z and AO 1.
#pragma once

#include "analysis/ambient_view.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

namespace ropsim {

struct InferenceSettings {
    int line_taps = 12;
    int line_stride = 3;  // pixels
    int box_radius = 3;   // taps: (2 * 3 + 1)^2
    int box_stride = 2;   // pixels
    bool checkerboard = false;
    double half_weight = 0.01;     // metres of dz at which a tap weighs half
    double floor = 0.01;           // least divisor
    double least_gradient = 1e-4;  // of alpha a pixel; below it the square

    int box_taps() const { return (2 * box_radius + 1) * (2 * box_radius + 1); }
};

struct Inferred {
    double ambient = 1;
    bool line = false;
    int taps = 0;
    double weight = 0;  // sum.y of the listing
    double best = 0;    // the largest weight of a tap
};

class AmbientInference {
 public:
    // All must outlive it; `ambient` has a value for every texel of `depth`.
    AmbientInference(const DepthBuffer& depth, std::span<const float> ambient, const AmbientView& view,
                     const InferenceSettings& settings)
        : depth_(depth), ambient_(ambient), view_(view), settings_(settings) {}

    // Whether the gradient is one: along it, else over the square.
    bool along_line(glm::dvec2 gradient) const {
        return std::sqrt(glm::dot(gradient, gradient)) >= settings_.least_gradient;
    }

    // For a fragment at the centre of pixel (x, y) with window depth z and the gradient of alpha a pixel in
    // image coordinates, y down. Calls read(index) for every texel that a tap reads, of both buffers.
    template <typename Read>
    Inferred at(int x, int y, float z, glm::dvec2 gradient, const Read& read) const {
        Sum sum;
        const double z1 = view_.at_pixel(x, y, z).z;
        Inferred result;
        result.line = along_line(gradient);
        if (result.line) {
            const glm::dvec2 direction = gradient / std::sqrt(glm::dot(gradient, gradient));
            for (int t = 0; t < settings_.line_taps; ++t)
                tap(x, y, direction * static_cast<double>(t * settings_.line_stride), z1, sum, read);
            result.taps = settings_.line_taps;
        } else {
            const int radius = settings_.box_radius;
            for (int dy = -radius; dy <= radius; ++dy) {
                const int odd = std::abs(dy) & 1;
                const double shift = settings_.checkerboard ? 0.5 * odd : odd - 0.5;
                for (int dx = -radius; dx <= radius; ++dx)
                    tap(x, y, glm::dvec2(dx + shift, dy) * static_cast<double>(settings_.box_stride), z1, sum,
                        read);
            }
            result.taps = settings_.box_taps();
        }
        result.weight = sum.weight;
        result.best = sum.best;
        const double divisor = std::max(settings_.floor, sum.weight);
        result.ambient = divisor > 0 ? std::clamp(sum.ambient / divisor, 0.0, 1.0) : 1.0;
        return result;
    }

 private:
    struct Sum {
        double ambient = 0;
        double weight = 0;
        double best = 0;
    };

    template <typename Read>
    void tap(int x, int y, glm::dvec2 offset, double z1, Sum& sum, const Read& read) const {
        const int column = std::clamp(static_cast<int>(x + 0.5 + offset.x), 0, depth_.width - 1);
        const int row = std::clamp(static_cast<int>(y + 0.5 + offset.y), 0, depth_.height - 1);
        const std::size_t texel = depth_.index(column, row);
        read(texel);
        const double dz = std::abs(z1 - view_.at_pixel(column, row, depth_.stored(column, row)).z);
        // Two points of an infinite far plane have no distance.
        const double weight = std::isnan(dz) ? 0 : settings_.half_weight / (settings_.half_weight + dz);
        sum.ambient += static_cast<double>(ambient_[texel]) * weight;
        sum.weight += weight;
        sum.best = std::max(sum.best, weight);
    }

    const DepthBuffer& depth_;
    std::span<const float> ambient_;
    const AmbientView& view_;
    const InferenceSettings& settings_;
};

}  // namespace ropsim
