#include "rop/technique_formats.h"

namespace ropsim {

Format TechniqueFormats::of(const std::string& surface, Format paper) const {
    const Format fallback = float32_ ? Format::kFloat32 : paper;
    const std::string name =
        parameters_.get_choice(surface + "_format", std::string(format_info(fallback).name),
                               {"float32", "float16", "unorm8", "unorm16", "unorm24", "snorm8", "r11g11b10", "rgb9e5"});
    for (std::size_t i = 0; i < format_table().size(); ++i)
        if (format_table()[i].name == name) return static_cast<Format>(i);
    return fallback;
}

}  // namespace ropsim
