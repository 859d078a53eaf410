#include "capture/software_path/visibility_maps.h"

namespace ropsim {
namespace {

// What total transmittance is kept in: the colour's fourth channel or, where that sums weights, 16 bits of
// its own.
std::string total_kept(Parameters& parameters, bool normalised, StoredAs color) {
    if (!normalised) return keeping("TOTAL", color, false);
    const bool exact = parameters.get_choice("format", "paper", {"paper", "float32"}) == "float32";
    return fmt::format("#define TOTAL(v) kept_{}(v)\n",
                       parameters.get_choice("transmittance_format", exact ? "float32" : "unorm16",
                                             {"unorm16", "unorm8", "float16", "float32"}));
}

}  // namespace

std::unique_ptr<SoftwareTechnique> make_visibility_map(Parameters& parameters, const char* map,
                                                       const char* surface, StoredAs paper,
                                                       std::int64_t cells, const std::string& defines) {
    const bool variable = parameters.get_choice("memory", "fixed", {"fixed", "variable"}) == "variable";
    const bool normalised =
        parameters.get_choice("composite", "plain", {"plain", "normalised"}) == "normalised";
    ListTechnique technique;
    technique.image = stored_image(parameters);
    technique.defines =
        defines +
        fmt::format("#define CELLS {}\n#define BOUNDS_{}\n#define LEAST_TRANSMITTANCE {:.9e}\n", cells,
                    parameters.get_choice("bounds", "pixel", {"pixel", "frame"}),
                    static_cast<float>(parameters.get_real("least_transmittance", 1e-5, 1e-9, 0.5))) +
        keeping("IMAGE", technique.image);
    if (normalised) technique.defines += "#define NORMALISED\n";
    if (variable) {
        technique.defines += "#define VARIABLE\n" + keeping("CELL", StoredAs::kFloat32) +
                             keeping("COLOR", StoredAs::kFloat32) + keeping("TOTAL", StoredAs::kFloat32) +
                             keeping("LIST_COLOR", stored_by(parameters, "color", StoredAs::kUnorm8));
    } else {
        read_exact_depth(parameters, "bounds");
        const StoredAs color = stored_by(parameters, "color", StoredAs::kFloat16);
        technique.defines += keeping("CELL", stored_by(parameters, surface, paper)) +
                             keeping("COLOR", color) + total_kept(parameters, normalised, color);
    }
    technique.shaders = {"functions", "sample_means", "visibility_map", map, "visibility_map_resolve"};
    return make_list_technique(technique);
}

}  // namespace ropsim
