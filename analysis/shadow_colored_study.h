// A coloured stochastic shadow map from end to end: drawn, converted where the filter is a variance map's,
// looked up from the camera's view, and measured.
#pragma once

#include "analysis/shadow_colored_cast.h"
#include "analysis/shadow_map_noise.h"
#include "traces/image.h"

#include <string>
#include <vector>

namespace ropsim {

struct ColoredStudy {
    ColoredShadowedTrace shadowed;
    std::vector<MapNoise> noise;                // by wavelength; of variance maps only
    int reduced_width = 0, reduced_height = 0;  // of the variance shadow map
};

// Looks the camera's trace up in `run`'s map and writes `shadowed` and `exact`. Throws as cast_shadows().
ColoredStudy study_colored_shadows(TraceReader& light, TraceReader& camera, const ShadowMapRun& run,
                                   const FilterChoice& filter, const ShadowReceiving& receiving,
                                   const std::string& shadowed, const std::string& exact);

}  // namespace ropsim
