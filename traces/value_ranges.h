// What values a trace may hold, and how values outside are brought in where a trace holds them as shaders
// made them.
#pragma once

#include "traces/half_float.h"
#include "traces/trace.h"

#include <algorithm>
#include <cmath>

namespace ropsim {

inline bool in_range(const Fragment& f) {
    return f.z >= 0 && f.z <= 1 && f.a >= 0 && f.a <= 1 && std::isfinite(f.r) && std::isfinite(f.g) &&
           std::isfinite(f.b);
}

inline bool in_range(const DepthSlope& slope) {
    return std::isfinite(slope.dx) && std::isfinite(slope.dy);
}

inline bool in_range(const Material& m) {
    const auto share = [](float value) { return value >= 0 && value <= 1; };
    return share(m.transmission[0]) && share(m.transmission[1]) && share(m.transmission[2]) &&
           share(m.collimation) && std::isfinite(m.eta) && std::isfinite(m.normal[0]) &&
           std::isfinite(m.normal[1]) && std::isfinite(m.normal[2]);
}

namespace value_ranges {

inline float clamped(float value, float of_nan) {
    return std::isnan(value) ? of_nan : std::clamp(value, 0.0f, 1.0f);
}
inline float finite(float value, float of_nan) {
    return std::isnan(value) ? of_nan : std::isinf(value) ? std::copysign(kLargestHalf, value) : value;
}

}  // namespace value_ranges

// As documented at TraceReader::next: NaN becomes what does least (depth 1, alpha 0, colour 0), infinite
// colours
// +-65504, the largest half. Direct3D 11's functional specification converts NaN to 0 at UNORM outputs alike.
inline void bring_into_range(Fragment& f) {
    f.z = value_ranges::clamped(f.z, 1);
    f.a = value_ranges::clamped(f.a, 0);
    f.r = value_ranges::finite(f.r, 0);
    f.g = value_ranges::finite(f.g, 0);
    f.b = value_ranges::finite(f.b, 0);
}

inline void bring_into_range(DepthSlope& slope) {
    if (!in_range(slope)) slope = {};
}

inline void bring_into_range(Material& m) {
    const Material plain;
    for (int c = 0; c < 3; ++c) {
        m.transmission[c] = value_ranges::clamped(m.transmission[c], plain.transmission[c]);
        m.normal[c] = value_ranges::finite(m.normal[c], plain.normal[c]);
    }
    m.collimation = value_ranges::clamped(m.collimation, plain.collimation);
    m.eta = value_ranges::finite(m.eta, plain.eta);
}

}  // namespace ropsim
