#include "rop/phenomenological/options.h"

#include "base/error.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace ropsim {

namespace {

bool chooses(Parameters& parameters, const char* key, const char* usual, const char* other) {
    return parameters.get_choice(key, usual, {usual, other}) == other;
}

PhenomenologicalOptions::Draws draws_of(Parameters& parameters, const char* key, const Screen& screen) {
    PhenomenologicalOptions::Draws draws;
    draws.given = parameters.has(key);
    if (!draws.given) return draws;
    const std::string text = parameters.get_string(key, "");
    // Without a trace to speak of there is one draw.
    draws.chosen.assign(std::max<std::size_t>(screen.draws.size(), 1), text == "all" ? 1 : 0);
    for (std::size_t at = 0; text != "all" && at <= text.size();) {
        const std::size_t end = std::min(text.find('+', at), text.size());
        const std::string name = text.substr(at, end - at);
        bool found = false;
        for (std::size_t d = 0; d < screen.draws.size(); ++d) {
            if (screen.draws[d] != name) continue;
            draws.chosen[d] = 1;
            found = true;
        }
        if (!found && screen.draws.empty())
            throw UserError(parameters.where(key), "there is no trace here to have draws; use all");
        if (!found)
            throw UserError(
                parameters.where(key),
                fmt::format("'{}' is no draw of the trace; its draws are: {}; join names by +, or "
                            "give all",
                            name, fmt::join(screen.draws, ", ")));
        at = end + 1;
    }
    return draws;
}

}  // namespace

PhenomenologicalOptions::PhenomenologicalOptions(Parameters& p, const Screen& screen) {
    alpha_only = chooses(p, "form", "full", "alpha");
    weight = p.get_choice(
        "weight", "eq5",
        {"eq5", "listing", "g3d", "eq7", "eq8", "eq9", "eq10", "blog2015", "learnopengl", "none"});
    third_of_beta = chooses(p, "beta", "product", "third");
    net_diffusion = chooses(p, "diffusion_weight", "alpha", "net");
    infinite_background = chooses(p, "background", "finite", "infinite");
    scatter_metres = static_cast<float>(p.get_real("k0", 0.128, 0, 1000));
    thickness_metres = static_cast<float>(p.get_real("k1", 0.5, 1e-6, 1000));
    const std::string refraction = p.get_choice("refraction", "snell", {"snell", "printed", "off"});
    printed_refraction = refraction == "printed";
    refracts = refraction != "off" && screen.materials;
    const bool wants_diffusion = !chooses(p, "diffusion", "on", "off");
    diffuses = wants_diffusion && screen.materials && !alpha_only;
    refraction_metres = static_cast<float>(p.get_real("refraction_depth", 2, 0, 1e6));
    alpha_refraction = chooses(p, "refraction_weight", "net", "alpha");
    raises_diffusion = !chooses(p, "underflow", "raise", "round");
    adds_deviations = chooses(p, "diffusion_sum", "variance", "deviation");
    separate_alpha = !chooses(p, "separate_alpha", "on", "off");
    const std::string kept = p.get_choice("offsets", "signed", {"signed", "biased", "split"});
    offsets = kept == "biased" ? Offsets::kBiased : kept == "split" ? Offsets::kSplit : Offsets::kSigned;
    saturates = chooses(p, "overflow", "replace", "saturate");
    listing_decoding = chooses(p, "decoding", "table", "listing");
    listing_early_out = chooses(p, "early_out", "all", "beta");
    self_modulates = !chooses(p, "self_modulation", "on", "off");
    gaussian = chooses(p, "filter", "disk", "gaussian");
    exact_gather = chooses(p, "gather", "strided", "exact");
    max_radius = static_cast<int>(p.get_integer("max_radius", 16, 0, 63));
    low_scale = static_cast<int>(p.get_integer("low_resolution", 1, 1, 4));
    if (low_scale == 3) throw UserError(p.where("low_resolution"), "3 is not a power of two; use 1, 2 or 4");
    low_draws = draws_of(p, "low_draws", screen);
    bilinear = chooses(p, "upsample", "tent7", "bilinear");
    aggregate_layers = static_cast<int>(p.get_integer("aggregate_layers", 4, 1, 16));
    aggregate_draws = draws_of(p, "aggregate_draws", screen);
    register_draws = draws_of(p, "register_draws", screen);
    if (low_scale > 1 && !low_draws.given && !aggregate_draws.given)
        throw UserError(p.where("low_resolution"),
                        "says how, but not which draws; add low_draws=NAME[+NAME...] or aggregate_draws=");
    if (low_draws.given && low_scale == 1)
        throw UserError(p.where("low_draws"), "says which draws, but not how; add low_resolution=2 or 4");
    for (std::size_t d = 0; d < screen.draws.size(); ++d) {
        if (register_draws[d] && aggregate_draws[d])
            throw UserError(
                p.where("register_draws"),
                fmt::format("'{}' is in aggregate_draws too, whose layers are kept one by one; leave "
                            "it out of one",
                            screen.draws[d]));
        if (low_draws[d] && aggregate_draws[d])
            throw UserError(p.where("aggregate_draws"),
                            fmt::format("'{}' is in low_draws too; leave it out of one", screen.draws[d]));
    }
    if (!separate_alpha && alpha_only)
        throw UserError(p.where("separate_alpha"), "form=alpha has no D to move; leave it out");
    if (!screen.camera && (refracts || diffuses))
        throw UserError(p.where("refraction"),
                        "refraction and diffusion go by the camera and the trace has none; use "
                        "refraction=off and diffusion=off");
}

}  // namespace ropsim
