// Opacity maps of planes at equal steps as transparency.
#include "capture/software_path/visibility_maps.h"

namespace ropsim {

std::unique_ptr<SoftwareTechnique> make_software_opacity_map(Parameters& parameters, const TraceHeader&) {
    const std::int64_t planes = parameters.get_integer("slices", 16, 1, 64);
    parameters.get_choice("planes", "uniform", {"uniform"});
    parameters.get_choice("sums", "plane", {"plane"});
    return make_visibility_map(
        parameters, "opacity_map", "slices", StoredAs::kFloat32, planes,
        fmt::format("#define LOOKUP_{}\n", parameters.get_choice("lookup", "linear", {"linear", "step"})));
}

}  // namespace ropsim
