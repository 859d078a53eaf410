// Multi-layer alpha blending, in order of arrival.
#include "capture/software_path/list_technique.h"

namespace ropsim {

std::unique_ptr<SoftwareTechnique> make_software_mlab(Parameters& parameters, const TraceHeader& header) {
    check_one_sample("mlab", header);
    read_exact_depth(parameters);
    parameters.get_choice("merge", "tail", {"tail"});
    ListTechnique technique;
    technique.defines =
        fmt::format("#define LAYERS {}\n#define TIES_{}\n", parameters.get_integer("layers", 8, 1, 64),
                    parameters.get_choice("ties", "newest", {"newest", "oldest"})) +
        keeping("COLOR", stored_by(parameters, "color", StoredAs::kUnorm8)) +
        keeping("OWN_TRANSMITTANCE", stored_by(parameters, "transmittance", StoredAs::kUnorm8));
    technique.image = stored_image(parameters);
    technique.shaders = {"mlab"};
    return make_list_technique(technique);
}

}  // namespace ropsim
