// The parameters of phenomenological transparency, and the readings of its paper that each stands for.
#pragma once

#include "base/parameters.h"
#include "rop/operation.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

// Names in the comments are the keys' values.
struct PhenomenologicalOptions {
    PhenomenologicalOptions(Parameters& parameters, const Screen& screen);

    bool alpha_only = false;  // form: full, or alpha (88 bits: one channel of beta, no diffusion)

    // What the shader exports.
    std::string weight;                // eq5, listing (the same function), g3d, or one of DepthWeight's
    bool third_of_beta = false;        // beta: product (equation 2), or third (Listing 1's factor)
    bool net_diffusion = false;        // diffusion_weight: alpha (equations 6 and 7), or net (Listing 1)
    bool infinite_background = false;  // background: finite (equation 7), or infinite (equation 6)
    float scatter_metres = 0.128f;     // k0: deviation behind a scattering surface one metre away
    float thickness_metres = 0.5f;     // k1 (the listing has .05)
    bool printed_refraction = false;   // refraction: snell, or printed (equation 9 as it stands), or off
    bool refracts = true;
    bool diffuses = true;           // diffusion: on or off
    float refraction_metres = 2;    // refraction_depth: to the plane behind, equation 10's delta z
    bool alpha_refraction = false;  // refraction_weight: net (Listing 1), or alpha
    bool raises_diffusion = true;   // underflow: raise, or round

    // How the targets hold it.
    bool adds_deviations = false;  // diffusion_sum: variance (equation 7), or deviation (equation 6)
    bool separate_alpha = true;    // separate_alpha: on, or off (D in the third channel of RT2)
    enum class Offsets : std::uint8_t { kSigned, kBiased, kSplit };
    Offsets offsets = Offsets::kSigned;  // offsets: signed, biased, split
    bool saturates = false;              // overflow: replace (Listing 3), or saturate

    // Resolve.
    bool listing_decoding = false;   // decoding: table (1/63), or listing (200 pixels, .375 of the screen)
    bool listing_early_out = false;  // early_out: all, or beta (Listing 3)
    bool self_modulates = true;      // self_modulation: on or off
    bool gaussian = false;           // filter: disk or gaussian
    bool exact_gather = false;       // gather: strided (Listing 3) or exact
    int max_radius = 16;             // pixels

    // Draws that are not simply drawn.
    // By draw of the trace, chosen by the key of the same name: NAME[+NAME...] or all.
    struct Draws {
        bool given = false;
        std::vector<std::uint8_t> chosen;
        bool operator[](std::size_t draw) const { return given && chosen[draw] != 0; }
    };
    int low_scale = 1;  // low_resolution: 1, 2 or 4
    Draws low_draws;
    bool bilinear = false;  // upsample: tent7, or bilinear
    int aggregate_layers = 4;
    Draws aggregate_draws;  // at low_resolution too
    Draws register_draws;
};

}  // namespace ropsim
