// The page of all techniques, made from what each declares: nothing in it is written by hand.
#pragma once

#include <string>

namespace ropsim {

// Markdown: for each technique of the registry, at its headline parameters, its keys with their ranges,
// surfaces, passes, control paths with their cost on the hardware of `run`'s default, and worst-case bytes.
std::string technique_reference();

}  // namespace ropsim
