// Adaptive transparency: curves of few nodes, in order of arrival as framebuffer operations make them, or
// with memory=variable in the order of the lists.
#include "capture/software_path/list_technique.h"

namespace ropsim {

std::unique_ptr<SoftwareTechnique> make_software_adaptive(Parameters& parameters, const TraceHeader&) {
    const auto nodes = static_cast<int>(parameters.get_integer("nodes", 8, 2, 64));
    const std::string memory = parameters.get_choice("memory", "fixed", {"fixed", "shader", "variable"});
    const std::string removal =
        parameters.get_choice("removal", "underestimate", {"underestimate", "overestimate", "node_by_node"});
    const std::string candidates =
        parameters.get_choice("candidates", "paper", {"paper", "protect_furthest", "protect_front_half"});
    parameters.get_choice("equal_depth", "in_front", {"in_front"});
    const bool front_half = candidates == "protect_front_half" && nodes >= 8;
    ListTechnique technique;
    technique.defines = fmt::format(
        "#define NODES {}\n#define REMOVAL_{}\n#define FIRST_REMOVABLE {}\n#define LAST_REMOVABLE {}\n",
        nodes, removal,
        front_half                   ? nodes / 2
        : removal == "underestimate" ? 1
                                     : 0,
        candidates == "paper" ? nodes : nodes - 1);
    if (parameters.get_choice("composite", "plain", {"plain", "normalised"}) == "normalised")
        technique.defines += "#define NORMALISED\n";
    if (memory == "variable") {
        technique.defines += "#define VARIABLE\n" + keeping("NODE_TRANSMITTANCE", StoredAs::kFloat32) +
                             keeping("LIST_COLOR", stored_by(parameters, "color", StoredAs::kUnorm8));
    } else {
        read_exact_depth(parameters);
        parameters.get_choice("layout", "interleaved", {"interleaved", "planar"});
        technique.defines +=
            keeping("NODE_TRANSMITTANCE", stored_by(parameters, "transmittance", StoredAs::kFloat32)) +
            keeping("COLOR", stored_by(parameters, "color", StoredAs::kFloat16));
    }
    technique.image = stored_image(parameters);
    technique.shaders = {"sample_means", "adaptive"};
    return make_list_technique(technique);
}

}  // namespace ropsim
