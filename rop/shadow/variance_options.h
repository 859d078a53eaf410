// How a stochastic shadow map becomes a variance shadow map: McGuire and Mara 2017, section 4.3.3.
#pragma once

#include <cstdint>

namespace ropsim {

// The paper filters "with a 15 x 15 tent kernel (in two 1D passes)" and downsamples "by a factor of four in
// each dimension"; it says neither which passes run at which size nor how the texels that remain are made.
enum class ConversionPasses : std::uint8_t {
    kSeparate,  // as the sentence reads: moments, tent across, tent down, all at the map's size; downsample
    kReduced,   // each tent pass makes only the texels that its axis keeps, as the authors' engine does
    kFused,     // the same, and the first tent pass squares depths itself: no moments at the map's size
};
enum class Reduction : std::uint8_t {
    kKept,  // one filtered texel of each D x D remains, that behind the middle: texel D i + D/2
    kMean,  // their mean: a kernel of K + D - 1 texels along each axis
};

struct VarianceOptions {
    static constexpr int kMaxTent = 63;
    static constexpr int kMaxDownsample = 16;

    int tent = 15;       // K texels along each axis, odd, 1 to kMaxTent; 1: unfiltered
    int downsample = 4;  // D, 1 to kMaxDownsample
    Reduction reduction = Reduction::kKept;
    ConversionPasses passes = ConversionPasses::kReduced;
    bool bilinear = true;        // the look-up's fetch; false: the nearest texel
    double min_variance = 1e-6;  // of window depth squared: what float32 moments leave undecided
    double light_bleeding = 0;   // a bound below this share counts as dark, what is above is stretched
};

}  // namespace ropsim
