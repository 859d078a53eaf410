// The DRAM presets that are compiled into the program.
#pragma once

#include <string_view>
#include <vector>

namespace ropsim {

struct DramPreset {
    std::string_view name;
    std::string_view text;  // TOML; the first line, a comment, says what it is
};

const std::vector<DramPreset>& dram_presets();

}  // namespace ropsim
