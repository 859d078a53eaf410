// One line that a cache before the shader cores looks up.
#pragma once

#include <cstdint>

namespace ropsim {

struct LineRead {
    std::uint64_t address = 0;  // by which the cache knows the line
    std::uint32_t sectors = 0;
    std::uint8_t surface = 0;
};

}  // namespace ropsim
