// Names to techniques.
#pragma once

#include "rop/operation.h"

#include <memory>
#include <string>
#include <vector>

namespace ropsim {

// In the order of registry.def.
const std::vector<TechniqueInfo>& technique_list();

// "NAME" or "NAME:key=value,..." taken apart. Throws UserError, naming `where` (the option), for an unknown
// name.
struct TechniqueSpec {
    std::string name;
    Parameters parameters;
};
TechniqueSpec parse_technique(const std::string& text, const std::string& where);

// Builds the operation; throws UserError for an unknown, misspelt or impossible parameter.
std::unique_ptr<FramebufferOperation> make_operation(TechniqueSpec& spec, const Screen& screen);

}  // namespace ropsim
