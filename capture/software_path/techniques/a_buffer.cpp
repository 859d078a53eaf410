// A-buffer: every fragment, in per-pixel lists that are sorted and composited in a pass over the screen.
#include "capture/software_path/list_technique.h"

namespace ropsim {

std::unique_ptr<SoftwareTechnique> make_software_a_buffer(Parameters& parameters, const TraceHeader&) {
    // What a list of unbounded length does not tell apart, or has no use for.
    parameters.get_choice("resolve", "recursive", {"recursive"});
    parameters.get_choice("overflow", "drop", {"drop"});
    ListTechnique technique;
    technique.defines = keeping("LIST_COLOR", stored_by(parameters, "color", StoredAs::kUnorm8));
    technique.image = stored_image(parameters);
    technique.shaders = {"sample_means", "a_buffer"};
    return make_list_technique(technique);
}

}  // namespace ropsim
