// Ambient occlusion from a depth buffer: Scalable Ambient Obscurance (McGuire, Mara and Luebke 2012, HPG)
// with the smooth falloff that its authors' shader recommends.
//
// A pixel whose depth buffer texel lies at C, with face normal n, looks at s texels of a disc about it whose
// radius is that of a sphere of r metres there. With v from C to such a texel's point,
//
//   A = max(0, 1 - 5 sigma / (s r^6) * sum max(0, r^2 - v.v)^3 * max(0, (v.n - beta) / (v.v + 0.01)))
//
// All lengths in metres: the quotient has the unit 1/m, so the estimate is not free of scale and a trace's
// metres_per_unit matters. 1 is unoccluded. Decisions, and where this is not the authors' shader:
//
// - Tap k lies at (k + 1/2) / s of the disc's radius, as theirs, k golden angles round; their number of turns
//   has to be tuned to s. A pixel turns its pattern by their hash of x and y, here with y down.
// - Full-resolution depth instead of its MIP levels, which change which bytes the taps read, not how many. No
//   guard band: taps outside the image add nothing. What smooths the noise is in ambient_blur.h.
// - n comes from the depth buffer: of each axis' two neighbours the one nearer in z, which beside a crease
//   can be the one across. Without any, A is 1.
// - Texels where nothing was drawn are unoccluded and occlude nothing.
#pragma once

#include "analysis/ambient_view.h"
#include "rop/format.h"

#include <cstdint>
#include <vector>

namespace ropsim {

struct ObscuranceSettings {
    double radius = 0.75;             // r, metres, > 0
    double bias = 0.02;               // beta, metres: what lies nearer to the plane of C occludes nothing
    double intensity = 1;             // sigma
    int taps = 32;                    // s
    Format format = Format::kUnorm8;  // what the buffer stores of A: unorm8, unorm16, float16 or float32
};

// Of a texel of the ambient buffer.
inline std::uint32_t ambient_bytes(Format format) {
    return static_cast<std::uint32_t>(format_info(format).bits) / 8;
}

struct Obscurance {
    std::vector<float> ambient;  // A of each pixel, as stored
    std::uint64_t pixels = 0;    // for which taps were taken
    std::uint64_t fetches = 0;   // of depth: each pixel's own, its neighbours' and the taps inside the image
};

// Does not depend on `threads`, nor on the machine.
Obscurance ambient_obscurance(const DepthBuffer& depth, const AmbientView& view,
                              const ObscuranceSettings& settings, int threads);

}  // namespace ropsim
