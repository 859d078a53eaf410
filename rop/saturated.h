// Storing without infinities.
#pragma once

#include "rop/datapath.h"
#include "rop/pixel.h"

#include <algorithm>
#include <type_traits>

namespace ropsim {

inline constexpr float kLargestFloat16 = 65504.0f;

// The converter to binary16 stops at its largest number, either way: infinity behind an opaque layer would be
// 0 times infinity. It is no larger than one that does not, so it costs nothing more. Other formats have what
// they need.
template <class Real>
Real saturated(const Field& field, Real value) {
    if (field.format != Format::kFloat16) return value;
    if constexpr (std::is_same_v<Real, float>)
        return std::clamp(value, -kLargestFloat16, kLargestFloat16);
    else
        return {std::clamp(value.value, -kLargestFloat16, kLargestFloat16), value.ready};
}
template <class D>
Rgb<D> saturated(const Field& field, const Rgb<D>& rgb) {
    return {saturated(field, rgb.r), saturated(field, rgb.g), saturated(field, rgb.b)};
}

}  // namespace ropsim
