// Hybrid transparency: the k nearest fragments, and a tail that sums the others.
#include "capture/software_path/list_technique.h"

namespace ropsim {

std::unique_ptr<SoftwareTechnique> make_software_hybrid(Parameters& parameters, const TraceHeader& header) {
    check_one_sample("hybrid", header);
    read_exact_depth(parameters);
    const bool exact = parameters.get_choice("format", "paper", {"paper", "float32"}) == "float32";
    const std::string tail =
        parameters.get_choice("tail_format", exact ? "float32" : "packed", {"packed", "float16", "float32"});
    ListTechnique technique;
    technique.defines =
        fmt::format("#define LAYERS {}\n", parameters.get_integer("layers", 8, 1, 64)) +
        keeping("COLOR", stored_by(parameters, "color", StoredAs::kUnorm8)) +
        (tail == "packed" ? "#define TAIL_PACKED\n" : keeping("TAIL", stored_as(tail, "tail_format")));
    if (parameters.get_choice("tail_factor", "on", {"on", "off"}) == "on")
        technique.defines += "#define TAIL_FACTOR\n";
    technique.image = stored_image(parameters);
    technique.shaders = {"functions", "sorted_layers", "hybrid"};
    return make_list_technique(technique);
}

}  // namespace ropsim
