// What maps of visibility over depth share as techniques: their passes' keys.
#pragma once

#include "capture/software_path/list_technique.h"

#include <string>

namespace ropsim {

// `map`: the shader file that says what a fragment adds and how visibility is read, over `cells` numbers
// stored as `<surface>_format` says, `paper` unless given. `defines`: the map's own.
std::unique_ptr<SoftwareTechnique> make_visibility_map(Parameters& parameters, const char* map,
                                                       const char* surface, StoredAs paper,
                                                       std::int64_t cells, const std::string& defines);

}  // namespace ropsim
