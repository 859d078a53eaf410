// How far a coloured map's moments are from those of infinitely many samples, at each stage of the conversion
// to a variance shadow map, next to what the draws' own variance makes of it.
#pragma once

#include "analysis/shadow_colored_cast.h"

namespace ropsim {

// Of mean depth, window depth squared; means over all texels.
struct StageNoise {
    double measured = 0;  // mean square of (stored - expected)
    double expected = 0;  // variance by the probabilities
};

struct MapNoise {
    StageNoise stored;    // one texel, S samples
    StageNoise filtered;  // after the tent, at the map's size
    StageNoise reduced;   // of the variance shadow map
};

// `stored` and `expected` are moments of one wavelength at the map's size; samples of a texel are independent
// of each other and of other texels'.
MapNoise map_noise(const MomentImage& stored, const ExpectedMoments& expected, int samples,
                   const VarianceOptions& options, int threads);

}  // namespace ropsim
