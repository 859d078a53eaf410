// Draws a stochastic shadow map, plain or coloured: a light's trace through the shadow-map technique, and the
// map as it is stored at the end.
#pragma once

#include "base/parameters.h"
#include "model/frame.h"
#include "rop/shadow/colored_shadow_options.h"
#include "rop/shadow/shadow_map.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

struct ShadowMapOptions {
    std::string trace;                     // of the light's view
    std::string technique = "shadow_map";  // shadow_map or colored_shadow_map[:key=value,...]
    std::string hardware = "desktop";
    std::vector<std::string> settings;  // key=value
    std::uint64_t seed = 0;
    int threads = 1;
};

// What drawing it moved and took, as at fidelity count: no caches, no clock.
struct ShadowMapRun {
    StoredShadowMap map;  // of shadow_map
    // Of colored_shadow_map: red, green, blue, or one for all.
    std::vector<StoredShadowMap> wavelengths;
    ColoredShadowOptions colored;
    Parameters technique, hardware;  // as resolved
    std::string trace_hash;
    Declaration declaration;
    FragmentCounts counts;
    std::vector<std::string> surfaces;    // names, the technique's first
    std::vector<SurfaceTraffic> traffic;  // by surface
    // Of one texel, as stored.
    std::uint32_t sample_bytes = 0;
    std::uint32_t total_alpha_bytes = 0;  // 0 without total alpha
    std::uint32_t opaque_bytes = 0;       // of the opaque layer's own depth; 0 where the map includes it

    bool is_colored() const { return !wavelengths.empty(); }
    const StoredShadowMap& any_map() const { return is_colored() ? wavelengths.front() : map; }
};

// Whether a --technique text names the coloured map.
bool names_colored_map(const std::string& technique);

// Throws UserError for anything wrong with the trace, the technique (also one that is no shadow map) or the
// hardware. The trace's view must have one spatial sample a pixel.
ShadowMapRun draw_shadow_map(const ShadowMapOptions& options);

}  // namespace ropsim
