#include "rop/technique_formats.h"

#include "base/error.h"

namespace ropsim {

Format TechniqueFormats::choose(const std::string& surface, Format paper, bool packed) const {
    const Format fallback = float32_ ? Format::kFloat32 : paper;
    const std::string key = surface + "_format";
    const std::string name = parameters_.get_choice(
        key, std::string(format_info(fallback).name),
        {"float32", "float16", "unorm8", "unorm16", "unorm24", "snorm8", "log8", "r11g11b10", "rgb9e5"});
    for (std::size_t i = 0; i < format_table().size(); ++i) {
        if (format_table()[i].name != name) continue;
        const auto format = static_cast<Format>(i);
        if (!packed && (format == Format::kR11G11B10 || format == Format::kRgb9e5))
            throw UserError(
                parameters_.where(key),
                fmt::format("{} keeps three channels, which is not what this surface holds; use float32, "
                            "float16, unorm8, unorm16, unorm24, snorm8 or log8",
                            name));
        return format;
    }
    return fallback;
}

}  // namespace ropsim
