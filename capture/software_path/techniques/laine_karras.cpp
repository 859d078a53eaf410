// Stratified stochastic transparency: stored samples of a pixel, by an ordered pass over its fragments.
#include "base/error.h"
#include "capture/software_path/list_technique.h"

#include <algorithm>

namespace ropsim {

std::unique_ptr<SoftwareTechnique> make_software_laine_karras(Parameters& parameters,
                                                              const TraceHeader& header) {
    const std::int64_t samples = parameters.get_integer("samples", 8, 1, 64);
    if (samples % header.samples != 0)
        throw UserError(parameters.where("samples"),
                        fmt::format("must be a multiple of the trace's {}", header.samples));
    const bool depth_based =
        parameters.get_choice("method", "basic", {"basic", "depth_based"}) == "depth_based";
    parameters.get_choice("correction", depth_based ? "accumulated" : "none",
                          {depth_based ? "accumulated" : "none"});
    if (depth_based) check_one_sample("laine_karras:method=depth_based", header);
    read_exact_depth(parameters);
    const bool compacts = parameters.get_flag("compaction", true);
    int order = 0;
    while ((1 << order) < std::max(header.width, header.height)) ++order;
    parameters.get_choice("hash", "paper", {"paper"});
    ListTechnique technique;
    technique.defines =
        fmt::format("#define STORED {}u\n#define INDEX_{}\n#define HILBERT_ORDER {}u\n", samples,
                    parameters.get_choice("index", "hilbert", {"hilbert", "morton"}), order);
    if (parameters.get_flag("tracking", true)) technique.defines += "#define TRACKING\n";
    if (compacts) technique.defines += "#define COMPACTION\n";
    if (parameters.get_flag("sort", compacts)) technique.defines += "#define SORT\n";
    if (depth_based)
        technique.defines +=
            "#define DEPTH_BASED\n" + keeping("COLOR", StoredAs::kFloat32) +
            keeping("ACCUMULATION", stored_by(parameters, "accumulation", StoredAs::kFloat16), false) +
            keeping("TOTAL_ALPHA", stored_by(parameters, "total_alpha", StoredAs::kFloat16), false);
    else
        technique.defines += keeping("COLOR", stored_by(parameters, "color", StoredAs::kUnorm8), false);
    technique.image = stored_image(parameters);
    technique.shaders = {"random", "sample_means", "laine_karras"};
    return make_list_technique(technique);
}

}  // namespace ropsim
