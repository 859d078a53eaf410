// The GLSL files of capture/shaders, embedded into the program when CMake configures it.
#pragma once

#include <string_view>

namespace ropsim {

// Text of capture/shaders/NAME.glsl; an unknown name is a CHECK.
std::string_view shader_source(std::string_view name);

}  // namespace ropsim
