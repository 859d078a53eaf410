#include "analysis/stress/stress_variants.h"

#include "analysis/standard_techniques.h"
#include "base/error.h"
#include "rop/registry.h"

#include <algorithm>
#include <optional>
#include <set>

#include <fmt/format.h>

namespace ropsim {
namespace {

struct Built {
    std::vector<std::string> format_keys;  // of its surfaces: "depth_format", ...
    bool color = false;
    StressVariant variant;
};

// What the declaration says of formats and light.
void judge(StressVariant& variant, const Declaration& declaration) {
    variant.bits = declaration.storage_bits_per_pixel();
    variant.node_bits = declaration.storage_bits_per_node();
    variant.light = declaration.light;
    variant.light_ends = true;
    for (const Surface& surface : declaration.surfaces)
        for (const StoredField& field : surface.fields) {
            const NarrowField named{surface.name, field.format, field.range};
            if (!holds(field.format, field.range, true)) variant.narrow_if_bright.push_back(named);
            if (!holds(field.format, field.range, false)) variant.narrow.push_back(named);
            const bool unit = field.range == ValueRange::kUnit || field.range == ValueRange::kSignedUnit;
            if (unit && field.format != Format::kBits)
                variant.unit_half_step = std::max(variant.unit_half_step, half_step(field.format));
            if (field.range != ValueRange::kColor && field.range != ValueRange::kSum) continue;
            variant.half_step = std::max(variant.half_step, half_step(field.format));
            variant.light_ends = variant.light_ends && ends_at_one(field.format);
            // Of samples in planes it is the mean that shows.
            if (surface.layout == Layout::kInterleaved)
                variant.elements = std::max(variant.elements, surface.elements);
        }
}
// Absent where the technique refuses the text.
std::optional<Built> built(const std::string& text) {
    try {
        TechniqueSpec spec = parse_technique(text, "--technique");
        const auto operation = make_operation(spec, screen_with_camera());
        Built result;
        for (const auto& [key, resolved] : spec.parameters.resolved())
            if (key.ends_with("_format") && key != "image_format") result.format_keys.push_back(key);
        judge(result.variant, operation->declaration());
        result.color = operation->declaration().image_is_color;
        return result;
    } catch (const UserError&) {
        return std::nullopt;
    }
}

std::string with(const std::string& text, const std::string& settings) {
    return text + (text.find(':') == std::string::npos ? ":" : ",") + settings;
}
// Without the keys that name how values are rounded.
std::string without_rounding(const std::string& text) {
    const std::size_t colon = text.find(':');
    if (colon == std::string::npos) return text;
    std::string kept;
    std::size_t at = colon + 1;
    while (at < text.size()) {
        const std::size_t end = std::min(text.find(',', at), text.size());
        const std::string setting = text.substr(at, end - at);
        const std::string key = setting.substr(0, setting.find('='));
        if (!key.ends_with("_format") && key != "format" && key != "transmittance_rounding")
            kept += (kept.empty() ? "" : ",") + setting;
        at = end + 1;
    }
    return text.substr(0, colon) + (kept.empty() ? "" : ":" + kept);
}

void add(std::vector<StressVariant>& variants, const std::string& technique, const std::string& formats) {
    if (auto result = built(technique)) {
        result->variant.technique = technique;
        result->variant.formats = formats;
        variants.push_back(std::move(result->variant));
    }
}

// One surface at a time, then all that take the format together.
void add_formats(StressTechnique& technique, const std::string& exact, const Built& result) {
    const std::vector<std::string> names{"float16", "unorm24", "unorm16",   "unorm8",
                                         "snorm8",  "log8",    "r11g11b10", "rgb9e5"};
    for (const std::string& name : names) {
        std::string all = exact;
        std::size_t taken = 0;
        for (const std::string& key : result.format_keys) {
            const std::string stored = fmt::format("{}={}", key, name);
            const std::string one = with(exact, stored);
            if (!built(one)) continue;
            add(technique.variants, one,
                fmt::format("{} {}", key.substr(0, key.size() - std::string("_format").size()), name));
            const std::string more = with(all, stored);
            if (!built(more)) continue;
            all = more;
            ++taken;
        }
        if (taken > 1) add(technique.variants, all, "all " + name);
    }
}

}  // namespace

std::string bits_text(int bits, int node_bits) {
    return node_bits == 0 ? std::to_string(bits) : fmt::format("{} + {} a node", bits, node_bits);
}
std::string more_bits_text(int bits, int node_bits) {
    return node_bits == 0 ? fmt::format("{:+}", bits) : fmt::format("{:+}, a node {:+}", bits, node_bits);
}

std::vector<StressTechnique> stress_techniques(const std::vector<std::string>& techniques,
                                               bool every_format) {
    std::vector<StressTechnique> list;
    for (const std::string& text : techniques) {
        const auto own = built(text);
        if (!own)
            make_operation(*std::make_unique<TechniqueSpec>(parse_technique(text, "--technique")),
                           screen_with_camera());  // says why
        if (!own->color) throw UserError("--technique", text + ": makes no colour image");
        StressTechnique technique;
        technique.settings = text;
        const std::string plain = without_rounding(text);
        const std::string exact = with(plain, "format=float32");
        if (built(exact)) technique.exact = exact;
        add(technique.variants, text, "paper");
        if (const auto result = built(exact)) {
            add(technique.variants, exact, "float32");
            if (every_format) add_formats(technique, exact, *result);
        }
        list.push_back(std::move(technique));
    }
    return list;
}

std::vector<std::string> stress_configurations() {
    std::vector<std::string> all = standard_techniques();
    for (const char* more : {"weighted_blended:weight=eq8",
                             "weighted_blended:weight=eq9",
                             "weighted_blended:overflow=saturate",
                             "weighted_blended:weight=none",
                             "weighted_blended:weight=blog2015",
                             "weighted_blended:weight=learnopengl",
                             "phenomenological",
                             "phenomenological:form=alpha,weight=none",
                             "phenomenological:form=alpha,overflow=saturate",
                             "a_buffer:overflow=blend_tail",
                             "adaptive:nodes=8,removal=overestimate",
                             "adaptive:nodes=8,equal_depth=behind",
                             "adaptive:nodes=8,equal_depth=merge",
                             "adaptive:nodes=2",
                             "adaptive:nodes=64",
                             "aoit:nodes=16",
                             "slab:layers=4,bits=inf",
                             "slab:layers=8,bits=1024,composite=normalised",
                             "slab:layers=8,bits=16,composite=accumulated",
                             "slab:layers=8,bits=16,probability=non_stratified",
                             "stochastic:samples=8,correction=coverage",
                             "stochastic:samples=64",
                             "laine_karras:samples=8,correction=coverage",
                             "mlab:layers=1",
                             "mlab:layers=4,merge=closest",
                             "mlab:layers=4,merge=transmittance",
                             "mlab:layers=4,merge=opacity",
                             "z3:fragments=2",
                             "opacity_map:slices=64,composite=normalised",
                             "opacity_map:slices=16,sums=slab",
                             "fourier_map:coefficients=31,composite=normalised",
                             "fourier_map:coefficients=7,clamp=off",
                             "occupancy_map:alpha=geometric",
                             "moment_based:moments=4,guard=published",
                             "moment_based:moments=6,guard=published",
                             "moment_based:moments=8,guard=published",
                             "moment_based:moments=4,basis=trigonometric",
                             "moment_based:moments=8,basis=trigonometric",
                             "wavelet:rank=1",
                             "wavelet:rank=5",
                             "hybrid:layers=8,tail_factor=off"})
        if (std::ranges::find(all, more) == all.end()) all.emplace_back(more);
    return all;
}

}  // namespace ropsim
