// Adds a participating medium to a captured view, as the fragments of a ray march (McGuire and Mara 2017,
// section 7.2).
#pragma once

#include "analysis/volume_medium.h"
#include "traces/trace.h"

#include <cstdint>
#include <optional>
#include <string>

namespace ropsim {

struct VolumeOptions {
    VolumeMedium medium;
    int steps = 32;             // a pixel, 1 to kMaxVolumeSteps, equal in distance along its ray
    double near = 0;            // metres from the eye; the medium starts at the near plane at the soonest
    std::optional<double> far;  // metres from the eye; absent: the far plane
    glm::dvec3 ambient{0.1};    // radiance from all directions, in the units of the trace's colours
    std::optional<glm::dvec3> light;  // irradiance across the light's rays, from a perspective light at one
                                      // metre; absent: 3 where the trace has a light
    std::string shadows;              // trace of the light's view; empty: nothing dims the light
    int filter = 1;                   // side of the square of its texels that a step averages, odd
    bool jitter = false;              // samples each pixel's steps at a random place, else at their middles
    std::uint64_t seed = 0;
    std::optional<ColorStorage> color;  // absent: the trace's
    int threads = 1;                    // the result does not depend on it
};

inline constexpr int kMaxVolumeSteps = 65536;

struct VolumeSummary {
    std::uint64_t pixels = 0;  // with at least one fragment of the medium
    std::uint64_t fragments = 0;
    Draw draw;
};

// Writes `trace_path`'s trace with a last draw "volume": for every pixel the fragments of a march from the
// near end to the opaque layer or the far end, near to far, pixels in the order of the opaque layer's
// conversion (traces/trace_opaque.h). A step of length ds at x has
//     alpha = 1 - exp(-extinction(x) ds),  colour = alpha albedo (ambient + light p(cosine) visibility(x)),
// which is the exact integral over a step within which the medium and its light are constant; p is
// henyey_greenstein(). Light is scattered once, and the medium does not dim it on its way to x. Fragments
// with alpha 0 are left out. With several spatial samples a pixel is marched to the farthest, and a fragment
// covers those in front of whose opaque layer it lies. The draw makes no depth test: it ends at the layer.
// All fragments carry a Material, the old ones of a trace without materials the default.
//
// The draw's cost is counted from GLSL of the march (capture/shader_cost): that of a step and an even share
// of what a pixel does once.
//
// Throws UserError: for options out of range (named as `ropsim trace volume` spells them), a trace without
// usable camera or with a draw "volume" already, shadows of a light of 0, a `shadows` trace that is not its
// light's view, a damaged file or one that cannot be written.
VolumeSummary add_volume(const std::string& trace_path, const std::string& out_path,
                         const VolumeOptions& options);

}  // namespace ropsim
