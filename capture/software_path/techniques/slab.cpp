// Stochastic layered alpha blending, with alphas: the list in order of arrival, then the colour from its
// layers or from all fragments.
#include "capture/software_path/list_technique.h"

namespace ropsim {

std::unique_ptr<SoftwareTechnique> make_software_slab(Parameters& parameters, const TraceHeader& header) {
    check_one_sample("slab", header);
    read_exact_depth(parameters);
    const std::int64_t layers = parameters.get_integer("layers", 8, 1, 64);
    const bool always = parameters.get_string("bits", fmt::format("{}", 2 * layers)) == "inf";
    const std::int64_t bits = always ? 0 : parameters.get_integer("bits", 2 * layers, 1, 1024);
    parameters.get_choice("coverage", "continuous", {"continuous"});
    const std::string composite =
        parameters.get_choice("composite", "direct", {"direct", "accumulated", "normalised"});
    const bool direct = composite == "direct";
    ListTechnique technique;
    technique.defines =
        fmt::format("#define LAYERS {}\n#define BITS {}\n#define COMPOSITE_{}\n", layers, bits, composite);
    if (parameters.get_choice("probability", "stratified", {"stratified", "non_stratified"}) == "stratified")
        technique.defines += "#define STRATIFIED\n";
    technique.defines +=
        keeping("LAYER", stored_by(parameters, direct ? "color" : "alpha",
                                   direct ? StoredAs::kUnorm8 : StoredAs::kFloat32)) +
        keeping("ACCUMULATION",
                direct ? StoredAs::kFloat32 : stored_by(parameters, "accumulation", StoredAs::kFloat16)) +
        keeping("TOTAL_ALPHA", composite == "normalised"
                                   ? stored_by(parameters, "total_alpha", StoredAs::kFloat16)
                                   : StoredAs::kFloat32);
    technique.image = stored_image(parameters);
    technique.shaders = {"random", "sorted_layers", "slab"};
    return make_list_technique(technique);
}

}  // namespace ropsim
