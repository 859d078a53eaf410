// A pixel's surfaces as text, from what a technique declares of them alone.
#include "analysis/pixel_run.h"

#include <algorithm>
#include <bit>

#include <fmt/format.h>

namespace ropsim {
namespace {

std::string field_name(const StoredField& field) {
    if (field.format == Format::kBits) return fmt::format("{} bits", field.bits);
    const std::string_view name = format_info(field.format).name;
    return field.channels == 1 ? std::string(name) : fmt::format("{} × {}", name, field.channels);
}

bool fixed_point(Format format) {
    return format == Format::kUnorm8 || format == Format::kSnorm8 || format == Format::kLog8;
}

// Digits that the format can tell apart, and not many more.
int digits_of(Format format) {
    return format == Format::kFloat32 || format == Format::kUnorm24 ? 7 : 4;
}

std::string value_text(const StoredField& field, const std::uint32_t* words) {
    std::string text;
    if (field.format == Format::kBits) {
        for (int c = field.channels; c-- > 0;) text += fmt::format("{:0{}x}", words[c], text.empty() ? 1 : 8);
        return "0x" + text;
    }
    for (int c = 0; c < field.channels; ++c) {
        if (c > 0) text += "  ";
        if (field.format == Format::kUint32)
            text += words[c] == kNoNode ? "none" : fmt::format("{}", words[c]);
        else
            text += fixed_point(field.format)
                        ? fmt::format("{:.4f}", std::bit_cast<float>(words[c]))
                        : fmt::format("{:.{}g}", std::bit_cast<float>(words[c]), digits_of(field.format));
    }
    return text;
}

// Element `e` of a surface whose words begin at `words`.
std::vector<std::string> element_text(const Surface& surface, const std::uint32_t* words, int e) {
    std::vector<std::string> values;
    for (const StoredField& field : surface.fields) {
        const int first = field.first_word + e * field.channels;
        values.push_back(value_text(field, words + first));
    }
    return values;
}

bool changed(const Surface& surface, const std::uint32_t* now, const std::uint32_t* before, int e) {
    return std::any_of(surface.fields.begin(), surface.fields.end(), [&](const StoredField& field) {
        const int first = field.first_word + e * field.channels;
        return !std::equal(now + first, now + first + field.channels, before + first);
    });
}

}  // namespace

std::vector<StoredSurface> PixelRun::stored() {
    std::vector<std::uint32_t> now, before;
    store_->copy_pixel(x_, y_, now);
    store_->initial_pixel(x_, y_, before);
    std::vector<StoredSurface> result;
    for (const Surface& surface : operation_->declaration().surfaces) {
        StoredSurface out{surface.name, {}, surface.elements, {}};
        for (const StoredField& field : surface.fields) out.fields.push_back(field_name(field));
        if (surface.layout == Layout::kPool) {
            NodePool& pool = *store_->pool();
            out.elements = static_cast<int>(pool.used());
            for (int node = 0; node < out.elements; ++node)
                out.changed.push_back(
                    {node,
                     element_text(surface, pool.words(static_cast<std::uint32_t>(node)) + surface.first_word,
                                  0)});
        } else {
            const std::uint32_t* words = now.data() + surface.first_word;
            for (int e = 0; e < surface.elements; ++e)
                if (changed(surface, words, before.data() + surface.first_word, e))
                    out.changed.push_back({e, element_text(surface, words, e)});
        }
        result.push_back(std::move(out));
    }
    return result;
}

std::string PixelRun::beyond_one_pixel(const Declaration& declaration, const TraceHeader& header) {
    if (declaration.shades_materials && header.materials) return "its shader goes by the surfaces' materials";
    if (!declaration.joined_draws.empty()) return "its shader joins fragments";
    const auto low = [](const auto& part) { return part.scale != 1; };
    if (std::any_of(declaration.surfaces.begin(), declaration.surfaces.end(), low) ||
        std::any_of(declaration.passes.begin(), declaration.passes.end(), low))
        return "it keeps surfaces of a lower resolution";
    if (std::any_of(declaration.passes.begin(), declaration.passes.end(),
                    [](const Pass& pass) { return pass.gathers; }))
        return "a pass of it reads pixels around its own";
    return {};
}

}  // namespace ropsim
