// Two images of the same frame, in units of the format that the image is stored in, against the bounds that
// two correct renderers must keep.
#pragma once

#include "rop/format.h"
#include "traces/image.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ropsim {

// What two renderers may differ by.
struct AgreementBound {
    double unit_limit = 0;     // units a value may be off
    double within_share = 1;   // of the pixels that must be within the limit
    double equal_share = 0;    // of the pixels that must be the same bits
    double absolute = 0;       // off by no more than this counts as within, whatever the unit
    std::string text() const;  // one line
};
// float32: 1e-6 of the value on all pixels, unless exp, log or pow allow `function_bound`, absolutely;
// float16: 1 unit in the last place on 99.99 %; unorm8: one code on all, the same on 99.9 %.
AgreementBound agreement_bound(Format stored, double function_bound);
// The name of a unit: "relative", "ulp" or "codes".
const char* unit_name(Format stored);
// Between two values of the format, in its units; infinite where one is not finite and the other not the
// same.
double units_apart(Format stored, float a, float b);

struct PixelDifference {
    int x = 0, y = 0;
    double units = 0;              // the largest of the channels
    bool other_fragments = false;  // the pixel's fragments are not the same bits on both sides
};

// Of a pixel, what makes it compared.
enum class PixelKind : std::uint8_t { kLeftOut, kSameFragments, kOtherFragments };

struct Agreement {
    Format stored = Format::kFloat32;
    AgreementBound bound;
    std::uint64_t pixels = 0;  // compared
    std::uint64_t equal = 0;   // the same bits in all channels
    std::uint64_t within = 0;  // the bound's limit
    // Of those not equal and of those outside the limit, those whose fragments differ already: no fault of
    // the operation, as long as they are few.
    std::uint64_t unequal_excused = 0;
    std::uint64_t outside_excused = 0;
    double worst_units = 0;  // of any channel
    double worst_absolute = 0;
    // Row by row, of those outside the limit, else of those not equal; with the same fragments before others.
    std::optional<PixelDifference> first;
    std::vector<PixelDifference> exceptions;  // outside the limit, at most kMostExceptions, row by row
    static constexpr std::size_t kMostExceptions = 64;
    static constexpr double kMostExcused = 1e-3;  // share of the pixels

    double equal_share() const { return share(equal); }
    double within_share() const { return share(within); }
    bool holds() const {
        return static_cast<double>(outside_excused) <= kMostExcused * static_cast<double>(pixels) &&
               share(within + outside_excused) >= bound.within_share &&
               share(equal + unequal_excused) >= bound.equal_share;
    }

 private:
    double share(std::uint64_t n) const {
        return pixels == 0 ? 1.0 : static_cast<double>(n) / static_cast<double>(pixels);
    }
};

// Channels R, G and B of images of one size (CHECK); `kinds`: a value a pixel, row by row.
Agreement compare_images(const Image& model, const Image& drawn, const std::vector<PixelKind>& kinds,
                         Format stored, double function_bound);
// R, G, B: black where equal or left out, white from 16 units (float32: 16 millionths of the value) on; and
// R, G, B of what was drawn with the channels model.* and units.*.
Image difference_picture(const Image& model, const Image& drawn, const std::vector<PixelKind>& kinds,
                         Format stored);
Image difference_channels(const Image& model, const Image& drawn, const std::vector<PixelKind>& kinds,
                          Format stored);

}  // namespace ropsim
