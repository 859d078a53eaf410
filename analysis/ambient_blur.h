// Smooths the noise that few taps leave in the ambient buffer: a bilateral filter by depth, across and down,
// as of McGuire, Mara and Luebke 2012. Its stride, reach and bell are those of the authors' shader; the
// weight by depth falls linearly to 0 at kBlurMetres, which is what their default comes to.
#pragma once

#include "analysis/ambient_view.h"
#include "rop/format.h"

#include <cstdint>
#include <vector>

namespace ropsim {

inline constexpr int kBlurStride = 2;        // pixels
inline constexpr double kBlurMetres = 0.15;  // of camera z

// Replaces `ambient`, a value for each texel of `depth`, by what two passes of 2 radius + 1 taps make of it,
// each stored in `format`; nothing for radius 0. Taps outside the image or where nothing was drawn are left
// out. Returns the taps read, each of which fetches depth and AO. Does not depend on `threads`.
std::uint64_t blur_ambient(std::vector<float>& ambient, const DepthBuffer& depth, const AmbientView& view,
                           int radius, Format format, int threads);

}  // namespace ropsim
