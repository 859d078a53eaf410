// What the technique `colored_shadow_map` is asked for: read by the technique and by what looks its map up.
#pragma once

#include "base/parameters.h"
#include "rop/shadow/caustics.h"

#include <array>
#include <string>
#include <vector>

namespace ropsim {

struct ColoredShadowOptions {
    int wavelengths = 3;  // or 1
    CausticModel caustics;
    int samples = 1;              // stored depths a texel a wavelength
    bool empty_is_opaque = true;  // what kept nothing holds the opaque layer's depth, not the far plane

    static ColoredShadowOptions read(Parameters& parameters) {
        ColoredShadowOptions options;
        options.wavelengths = parameters.get_choice("wavelengths", "3", {"3", "1"}) == "3" ? 3 : 1;
        options.samples = static_cast<int>(parameters.get_integer("samples", 1, 1, 64));
        options.caustics.on = parameters.get_choice("caustics", "on", {"on", "off"}) == "on";
        if (parameters.get_choice("caustics_sign", "equations", {"equations", "prose"}) == "prose")
            options.caustics.sign = CausticSign::kProse;
        if (parameters.get_choice("caustics_index", "material", {"material", "interface"}) == "interface")
            options.caustics.index = CausticIndex::kInterface;
        options.empty_is_opaque = parameters.get_choice("empty", "opaque", {"opaque", "far"}) == "opaque";
        return options;
    }
    std::vector<std::string> surfaces() const {
        if (wavelengths == 1) return {"depth"};
        return {"depth_red", "depth_green", "depth_blue"};
    }
    // rho of each wavelength, the first `wavelengths` values, as the light's shader computes it.
    std::array<float, 3> probability(float alpha, const Material& m, float incidence, bool back) const {
        if (wavelengths == 1) return {mean_shadow_probability(caustics, alpha, m, incidence, back), 0, 0};
        return shadow_probability(caustics, alpha, m, incidence, back);
    }
};

}  // namespace ropsim
