#include "rop/visibility/map_options.h"

namespace ropsim {

MapOptions map_options(Parameters& parameters, int spatial_samples, const char* composite) {
    MapOptions options;
    options.spatial_samples = spatial_samples;
    if (parameters.get_choice("bounds", "pixel", {"pixel", "frame"}) == "frame")
        options.bounds = MapBounds::kFrame;
    options.normalised =
        parameters.get_choice("composite", composite, {"plain", "normalised"}) == "normalised";
    return options;
}

MapMemory map_memory(Parameters& parameters) {
    return parameters.get_choice("memory", "fixed", {"fixed", "variable"}) == "variable"
               ? MapMemory::kVariable
               : MapMemory::kFixed;
}

}  // namespace ropsim
