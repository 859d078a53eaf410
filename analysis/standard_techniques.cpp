// The configurations at which techniques are compared, and their families.
#include "analysis/standard_techniques.h"

#include "base/error.h"
#include "rop/registry.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

namespace ropsim {
namespace {

// Whether a configuration is known, on a trace that has all that a technique may ask for, and makes a colour
// image.
bool takes_part(const std::string& text) {
    try {
        TechniqueSpec spec = parse_technique(text, "--technique");
        const auto operation = make_operation(spec, screen_with_camera());
        return operation->declaration().image_is_color;
    } catch (const UserError&) {
        return false;
    }
}

std::string name_of(const std::string& technique) {
    return technique.substr(0, technique.find(':'));
}

struct Family {
    const char* name;
    std::vector<std::string_view> members;  // names
};

const std::vector<Family>& families() {
    static const std::vector<Family> list{
        {"blending and weighted sums", {"alpha_blend", "weighted_blended", "phenomenological"}},
        {"all fragments: lists, peeling", {"a_buffer", "depth_peeling", "dual_depth_peeling"}},
        {"nodes of visibility", {"adaptive", "aoit"}},
        {"layers of colour", {"slab", "k_buffer", "k_plus_buffer", "hybrid", "mlab", "z3"}},
        {"stored samples", {"stochastic", "laine_karras", "hashed_alpha"}},
        {"maps, series and moments",
         {"opacity_map", "occupancy_map", "fourier_map", "moment_based", "wavelet"}},
        {"other", {}},
    };
    return list;
}

}  // namespace

Camera plain_camera() {
    Camera camera;
    camera.near_plane = 0.1f;
    camera.far_plane = 100;
    camera.fovy_degrees = 45;
    return camera;
}

Screen screen_with_camera() {
    Screen screen;
    screen.camera = plain_camera();
    return screen;
}

std::string at_default(const TechniqueInfo& info) {
    return info.headline_parameters.empty() ? std::string(info.name)
                                            : fmt::format("{}:{}", info.name, info.headline_parameters);
}

std::vector<std::string> techniques_at_defaults() {
    std::vector<std::string> techniques;
    for (const TechniqueInfo& info : technique_list())
        if (takes_part(at_default(info))) techniques.push_back(at_default(info));
    return techniques;
}

const std::vector<std::string>& standard_configurations() {
    static const std::vector<std::string> list{
        "alpha_blend",
        "weighted_blended",
        "weighted_blended:weight=eq7",
        "weighted_blended:weight=blog2015",
        "phenomenological:form=alpha",
        "a_buffer",
        "depth_peeling:layers=8",
        "depth_peeling:layers=16",
        "dual_depth_peeling:layers=8",
        "dual_depth_peeling:layers=16",
        "hashed_alpha",
        "stochastic:samples=4",
        "stochastic:samples=8",
        "stochastic:samples=16",
        "stochastic:samples=32",
        "stochastic:samples=8,method=depth_based",
        "stochastic:samples=16,method=depth_based",
        "laine_karras:samples=4",
        "laine_karras:samples=8",
        "laine_karras:samples=16",
        "laine_karras:samples=32",
        "laine_karras:samples=8,method=depth_based",
        "laine_karras:samples=16,method=depth_based",
        "adaptive:nodes=4",
        "adaptive:nodes=8",
        "adaptive:nodes=16",
        "adaptive:nodes=24",
        "adaptive:nodes=4,composite=normalised",
        "adaptive:nodes=8,composite=normalised",
        "adaptive:nodes=16,composite=normalised",
        "adaptive:nodes=8,removal=node_by_node,composite=normalised",
        "adaptive:nodes=8,depth_format=unorm16,transmittance_format=unorm16",
        "adaptive:nodes=8,memory=variable",
        "adaptive:nodes=24,memory=variable,composite=normalised",
        "aoit:nodes=2",
        "aoit:nodes=4",
        "aoit:nodes=8",
        "slab:layers=4,bits=8",
        "slab:layers=8,bits=16",
        "slab:layers=16,bits=32",
        "slab:layers=8,bits=16,composite=normalised",
        "slab:layers=8,bits=8,coverage=discrete,composite=normalised",
        "k_buffer:layers=4",
        "k_buffer:layers=8",
        "k_buffer:layers=16",
        "k_plus_buffer:layers=8",
        "k_plus_buffer:layers=16",
        "hybrid:layers=4",
        "hybrid:layers=8",
        "hybrid:layers=16",
        "mlab:layers=2",
        "mlab:layers=4",
        "mlab:layers=8",
        "mlab:layers=8,merge=least_error",
        "mlab:layers=16",
        "z3:fragments=3",
        "z3:fragments=8",
        "opacity_map:slices=16",
        "opacity_map:slices=16,composite=normalised",
        "opacity_map:slices=16,lookup=step,composite=normalised",
        "opacity_map:slices=32,composite=normalised",
        "opacity_map:slices=16,planes=deep,composite=normalised",
        "fourier_map:coefficients=7",
        "fourier_map:coefficients=7,composite=normalised",
        "fourier_map:coefficients=15,composite=normalised",
        "occupancy_map",
        "occupancy_map:counts=slab",
        "moment_based:moments=4",
        "moment_based:moments=6",
        "moment_based:moments=8",
        "moment_based:moments=6,basis=trigonometric",
        "moment_based:moments=6,moment_format=unorm16",
        "wavelet:rank=2",
        "wavelet:rank=3",
        "wavelet:rank=4",
    };
    return list;
}

std::vector<std::string> standard_techniques() {
    std::vector<std::string> techniques;
    std::set<std::string> names;
    for (const std::string& text : standard_configurations())
        if (takes_part(text)) {
            techniques.push_back(text);
            names.insert(name_of(text));
        }
    for (const std::string& text : techniques_at_defaults())
        if (!names.contains(name_of(text))) techniques.push_back(text);
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
        return std::ranges::find(family.members, name) != family.members.end();
    };
    const auto found = std::find_if(families().begin(), families().end() - 1, belongs);
    return static_cast<std::size_t>(found - families().begin());
}

std::string refusal(const std::string& technique, const TraceHeader& header) {
    try {
        TechniqueSpec spec = parse_technique(technique, "--technique");
        if (make_operation(spec, screen_of(header, 0))->declaration().image_is_color) return {};
        return fmt::format(
            "{}: makes no colour image; choose a technique that does (`ropsim list techniques`)", technique);
    } catch (const UserError& error) {
        return error.where() == "--technique" ? error.what()
                                              : fmt::format("{}: {}", error.where(), error.what());
    }
}

}  // namespace ropsim
