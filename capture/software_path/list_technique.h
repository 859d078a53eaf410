// What techniques share that work on lists of fragments in passes over the screen.
#pragma once

#include "capture/software_path/fragment_lists.h"
#include "capture/software_path/software_technique.h"

#include <memory>
#include <string>
#include <vector>

namespace ropsim {

// One pass over lists.
struct ListTechnique {
    std::vector<const char*> shaders;  // the last defines resolved()
    std::string defines;
    StoredAs image = StoredAs::kFloat16;
};
std::unique_ptr<SoftwareTechnique> make_list_technique(ListTechnique technique);

// Of the resolved image.
StoredAs stored_image(Parameters& parameters);
// Reads `<surface>_format`. Throws UserError unless it is float32: passes over lists compare depths as they
// are.
void read_exact_depth(Parameters& parameters, const char* surface = "depth");
// Throws UserError for traces of several spatial samples.
void check_one_sample(const char* technique, const TraceHeader& header);

}  // namespace ropsim
