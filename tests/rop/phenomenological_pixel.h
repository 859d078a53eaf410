// One pixel of phenomenological transparency and what its targets hold.
#pragma once

#include "tests/rop/random_fragments.h"

#include <bit>
#include <string>

namespace ropsim::test {

// Words of a pixel: RT0, RT1 with D^2 in its last channel, RT2.
inline constexpr std::size_t kNetWord = 3;
inline constexpr std::size_t kBetaWord = 4;
inline constexpr std::size_t kDiffusionWord = 7;
inline constexpr std::size_t kOffsetWord = 8;

// A pixel in the middle of a black image, which surfaces are drawn over one at a time.
class TransparentPixel {
 public:
    explicit TransparentPixel(const std::string& parameters)
        : frame_("phenomenological:image_format=float32" + parameters,
                 header_of(kSide, kSide, 1, {0, 0, 0})) {}
    // Where surfaces have materials.
    static TransparentPixel of_materials(const std::string& parameters) {
        return TransparentPixel(parameters, with_materials(header_of(kSide, kSide, 1, {0, 0, 0})));
    }

    void draw(float z, float a, std::array<float, 3> color = {1, 1, 1}, const Material& material = {}) {
        const Fragment f = fragment_at(kAt, kAt, z, a, color);
        frame_.draw({&f, 1}, {}, {&material, 1});
    }
    // Layers until `done`, at most `most`.
    int draw_until(float z, float a, float color, int most, const auto& done) {
        for (int n = 1; n <= most; ++n) {
            draw(z, a, {color, color, color});
            if (done()) return n;
        }
        return -1;
    }
    double stored(std::size_t word) { return std::bit_cast<float>(frame_.words(kAt, kAt)[word]); }
    double color() { return frame_.color(kAt, kAt)[0]; }

 private:
    static constexpr int kSide = 96;
    static constexpr int kAt = kSide / 2;

    TransparentPixel(const std::string& parameters, const TraceHeader& header)
        : frame_("phenomenological:image_format=float32" + parameters, header) {}

    TestFrame frame_;
};

}  // namespace ropsim::test
