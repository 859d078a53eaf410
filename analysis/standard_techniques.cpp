// Standard sizes and modes of what is registered, and the families of techniques.
#include "analysis/standard_techniques.h"

#include "base/error.h"
#include "rop/registry.h"

#include <algorithm>
#include <map>
#include <optional>

#include <fmt/format.h>

namespace ropsim {
namespace {

// What identifies a configuration: name and every parameter in force; absent where it is refused or makes no
// colour image.
std::optional<std::string> identity(const std::string& text) {
    Screen screen;
    screen.camera = Camera{};
    screen.camera->near_plane = 0.1f;
    screen.camera->far_plane = 100;
    screen.camera->fovy_degrees = 45;
    try {
        TechniqueSpec spec = parse_technique(text, "--technique");
        const auto operation = make_operation(spec, screen);
        if (!operation->declaration().image_is_color) return std::nullopt;
        std::string key = spec.name;
        for (const auto& [name, resolved] : spec.parameters.resolved())
            key += fmt::format(" {}={}", name, resolved.value);
        return key;
    } catch (const UserError&) {
        return std::nullopt;
    }
}

std::string at_default(const TechniqueInfo& info) {
    return info.headline_parameters.empty() ? std::string(info.name)
                                            : fmt::format("{}:{}", info.name, info.headline_parameters);
}

std::string name_of(const std::string& technique) {
    return technique.substr(0, technique.find(':'));
}

// Sizes around the headline's own, with what else the headline sets left to follow from the size.
std::vector<std::string> sized(const TechniqueInfo& info) {
    std::vector<std::string> texts;
    for (const StandardSizes& standard : standard_sizes())
        for (const int size : standard.sizes)
            texts.push_back(fmt::format("{}:{}={}", info.name, standard.key, size));
    return texts;
}

struct Family {
    const char* name;
    std::vector<const char*> members;  // names, or their beginnings
};

const std::vector<Family>& families() {
    static const std::vector<Family> list{
        {"blending and weighted sums", {"alpha_blend", "weighted_blended", "phenomenological"}},
        {"all fragments: lists, peeling", {"a_buffer", "depth_peeling", "dual_depth_peeling"}},
        {"nodes of visibility", {"adaptive", "aoit"}},
        {"layers of colour",
         {"slab", "k_buffer", "k_plus_buffer", "hybrid", "mlab", "multi_layer", "z3", "bucket"}},
        {"stored samples", {"stochastic", "laine_karras", "hashed_alpha"}},
        {"maps, series and moments",
         {"opacity", "occupancy", "fourier", "moment", "wavelet", "deep_opacity", "transmittance"}},
        {"other", {}},
    };
    return list;
}

}  // namespace

const std::vector<StandardSizes>& standard_sizes() {
    static const std::vector<StandardSizes> sizes{
        {"samples", {4, 8, 16, 32}},   {"nodes", {4, 8, 16, 32}},   {"layers", {4, 8, 16}},
        {"fragments", {4, 8}},         {"moments", {4, 6, 8}},      {"rank", {2, 3, 4}},
        {"coefficients", {7, 15, 31}}, {"terms", {4, 8, 16}},       {"slices", {8, 16, 32}},
        {"slabs", {16, 32, 64}},       {"intervals", {16, 32, 64}}, {"maps", {8, 16, 32}},
        {"buckets", {4, 8, 16}},
    };
    return sizes;
}

const std::vector<std::string>& standard_modes() {
    static const std::vector<std::string> modes{
        "stochastic:samples=8,method=depth_based",
        "stochastic:samples=8,method=depth_based,correction=accumulated",
        "laine_karras:samples=8,method=depth_based",
        "laine_karras:samples=8,method=depth_based,correction=accumulated",
        "slab:layers=8,bits=inf",
        "adaptive:nodes=8,memory=variable",
    };
    return modes;
}

std::vector<std::string> techniques_at_defaults() {
    std::vector<std::string> techniques;
    for (const TechniqueInfo& info : technique_list())
        if (identity(at_default(info))) techniques.push_back(at_default(info));
    return techniques;
}

std::vector<std::string> standard_techniques() {
    std::vector<std::string> techniques;
    std::map<std::string, bool> seen;
    const auto add = [&](const std::string& text) {
        const auto key = identity(text);
        if (key && seen.emplace(*key, true).second) techniques.push_back(text);
    };
    for (const TechniqueInfo& info : technique_list()) {
        add(at_default(info));
        for (const std::string& text : sized(info)) add(text);
        for (const std::string& text : standard_modes())
            if (name_of(text) == info.name) add(text);
    }
    return techniques;
}

const std::vector<std::string>& technique_families() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> list;
        for (const Family& family : families()) list.emplace_back(family.name);
        return list;
    }();
    return names;
}

std::size_t family_of(const std::string& technique) {
    const std::string name = name_of(technique);
    const auto belongs = [&](const Family& family) {
        return std::any_of(family.members.begin(), family.members.end(),
                           [&](const char* member) { return name.starts_with(member); });
    };
    const auto found = std::find_if(families().begin(), families().end() - 1, belongs);
    return static_cast<std::size_t>(found - families().begin());
}

Screen screen_of(const TraceHeader& header, std::uint64_t seed) {
    Screen screen{header.width, header.height, header.samples, seed, {}, {}};
    for (const Draw& draw : header.draws) screen.objects.push_back(draw.object_id);
    screen.camera = header.camera;
    return screen;
}

}  // namespace ropsim
