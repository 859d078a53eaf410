// k-buffer: the k nearest fragments, in order of arrival.
#include "capture/software_path/list_technique.h"

namespace ropsim {

std::unique_ptr<SoftwareTechnique> make_software_k_buffer(Parameters& parameters, const TraceHeader& header) {
    check_one_sample("k_buffer", header);
    read_exact_depth(parameters);
    ListTechnique technique;
    technique.defines = fmt::format("#define LAYERS {}\n", parameters.get_integer("layers", 8, 1, 64)) +
                        keeping("COLOR", stored_by(parameters, "color", StoredAs::kUnorm8));
    technique.image = stored_image(parameters);
    technique.shaders = {"sorted_layers", "k_buffer"};
    return make_list_technique(technique);
}

}  // namespace ropsim
