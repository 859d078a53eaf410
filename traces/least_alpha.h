// Alpha for those who know nothing of transmission.
#pragma once

#include "traces/trace.h"

#include <algorithm>

namespace ropsim {

// A surface of coverage `alpha` and transmission t lets 1 - alpha + alpha t of what is behind it through
// (McGuire and Mara 2017, equation 1), and its premultiplied colour is what it adds: many pairs of coverage
// and transmission mean the same. This is the alpha of the pair whose most absorbed channel has transmission
// 0: with it alone, glass without colour composites exactly and coloured glass as monochrome coverage (the
// paper's Fig. 7, left), where the alpha of a pane that covers its pixel would have made it opaque. Alpha of
// 1/255 at least, unless it was less before: perfectly clear matter keeps a trace of it to carry its
// reflections. A fragment that lets nothing through one channel keeps its alpha, bit for bit.
inline float least_alpha(float alpha, const Material& material) {
    const auto& t = material.transmission;
    const float absorbed = 1.0f - std::min({t[0], t[1], t[2]});
    return std::max(alpha * absorbed, std::min(alpha, 1.0f / 255));
}

}  // namespace ropsim
