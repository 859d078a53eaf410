// One technique on one pixel after another: for studies that run millions of pixels and no image. Made in
// single precision here and in double precision by rop/double_reading/, from the same source.
#pragma once

#include "traces/trace.h"

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace ropsim {

// What there is at a pixel: fragments in arrival order, none behind the opaque layer.
struct PixelScene {
    std::vector<Fragment> fragments;  // x and y are 0
    glm::vec3 background{0.0f};
    float opaque_depth = std::numeric_limits<float>::infinity();
};

struct PixelTechnique {
    bool any_order = false;  // any order gives the same result up to ties and rounding
    bool random = false;
    bool visibility = false;
    bool color = true;  // its image is one
    int bits = 0;       // storage of a pixel
    int node_bits = 0;  // and of a fragment in its list
    int passes = 1;     // over the geometry
};

class SinglePixel {
 public:
    SinglePixel() = default;
    SinglePixel(const SinglePixel&) = delete;
    SinglePixel& operator=(const SinglePixel&) = delete;
    virtual ~SinglePixel() = default;

    virtual const PixelTechnique& technique() const = 0;
    // Every pass and resolve, from the initial contents on. A double-precision pixel voids what others of
    // that kind hold on this thread.
    virtual std::array<double, 3> run(const PixelScene& scene) = 0;
    // Of the last run: the transmittance in front of each depth (of techniques that represent it), and how
    // often each control path was taken.
    virtual void visibility(std::span<const float> depths, std::span<double> values) = 0;
    virtual const std::vector<std::uint64_t>& paths() const = 0;
};

// An image of one pixel with this header's camera and draws. Throws UserError for a technique that is
// misspelt or refuses the trace.
std::unique_ptr<SinglePixel> make_single_pixel(const std::string& technique, const TraceHeader& header,
                                               std::uint64_t seed);

}  // namespace ropsim
