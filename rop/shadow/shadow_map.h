// A stored stochastic shadow map, and what one texel of it says about a depth.
#pragma once

#include "base/error.h"
#include "rop/declaration.h"
#include "rop/window.h"

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

namespace ropsim {

// What a look-up reads of a shadow map. Depths are window depths of the light's view.
struct StoredShadowMap {
    static constexpr float kEmpty = 1.0f;  // of a sample that no transparent fragment took, kept apart

    int width = 0;
    int height = 0;
    int samples = 1;            // S stored depths a texel
    std::vector<float> depths;  // width * height * S, row-major from the top left
    // Alpha-corrected maps (section 3.6) keep the opaque layer apart; both are empty otherwise, and `depths`
    // then includes it.
    std::vector<float> total_alpha;  // width * height, of the transparent fragments
    std::vector<float> opaque;       // width * height; +infinity where there is none

    bool corrected() const { return !total_alpha.empty(); }
    std::size_t texel(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    }
};

// The map that a shadow-map technique left in the pixels' state: its surface `depth`, and `total_alpha`, a
// product of transmittances, where it has one. Texels of tiles that no fragment reached are as initialised.
// `header` is the light's view, of one spatial sample a pixel (CHECK).
StoredShadowMap stored_shadow_map(const Declaration& declaration, const StoreMap& stores,
                                  const TraceHeader& header);

// The depths of one surface of such a map: of one wavelength of a coloured one, say. Opaque geometry is in
// them if the surface starts from it; the map is not corrected.
StoredShadowMap stored_depths_of(const Declaration& declaration, const StoreMap& stores,
                                 const TraceHeader& header, std::string_view surface);

// Stochastic visibility of depth z in texel (x, y), in [0, 1]: the share of its samples that are not nearer
// (Enderton et al. 2011, equation 4), as the samples are.
inline double stochastic_visibility(const StoredShadowMap& map, int x, int y, double z) {
    const float* const depth = &map.depths[map.texel(x, y) * static_cast<std::size_t>(map.samples)];
    int behind = 0;
    for (int s = 0; s < map.samples; ++s) behind += z <= static_cast<double>(depth[s]) ? 1 : 0;
    return static_cast<double>(behind) / map.samples;
}

// Section 3.6: the estimated drop 1 - svis(z), scaled by total alpha over the estimated total drop 1 -
// svis(infinity), so that the whole drop is right. Left open by the paper and decided here: where no sample
// of the texel kept anything, there is nothing to scale and the texel lets all light through, whatever its
// total alpha. Behind the opaque layer it is 0.
inline double corrected_visibility(const StoredShadowMap& map, int x, int y, double z) {
    CHECK(map.corrected(), "a map without total alpha");
    const std::size_t texel = map.texel(x, y);
    if (static_cast<double>(map.opaque[texel]) < z) return 0;
    const float* const depth = &map.depths[texel * static_cast<std::size_t>(map.samples)];
    int nearer = 0;
    int dropped = 0;
    for (int s = 0; s < map.samples; ++s) {
        nearer += static_cast<double>(depth[s]) < z ? 1 : 0;
        dropped += depth[s] < StoredShadowMap::kEmpty ? 1 : 0;
    }
    if (dropped == 0) return 1;
    return 1 - static_cast<double>(map.total_alpha[texel]) * nearer / dropped;
}

// Section 3.6: an opaque surface that the light reaches has all transparent fragments of the texel in front
// of it, so total alpha alone is its shadow, without noise. 0 behind the opaque layer.
//
// That holds for the surface whose depth the texel stores. Where the stored depth is beyond `own`, the texel
// is past a silhouette and total alpha counts what lies behind the point: no value then (decided here), and
// corrected_visibility() must be asked.
inline std::optional<double> opaque_surface_visibility(const StoredShadowMap& map, int x, int y, double z,
                                                       double own) {
    CHECK(map.corrected(), "a map without total alpha");
    const std::size_t texel = map.texel(x, y);
    const auto opaque = static_cast<double>(map.opaque[texel]);
    if (opaque < z) return 0.0;
    if (opaque > own) return std::nullopt;
    return 1 - static_cast<double>(map.total_alpha[texel]);
}

}  // namespace ropsim
