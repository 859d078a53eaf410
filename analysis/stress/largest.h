// The largest of values among which a NaN must not be lost.
#pragma once

#include <cmath>

namespace ropsim {

// NaN counts as larger than anything, and stays.
inline bool is_larger(double value, double most) {
    return !std::isnan(most) && !(value <= most);
}
inline void take_larger(double& most, double value) {
    if (is_larger(value, most)) most = value;
}

}  // namespace ropsim
