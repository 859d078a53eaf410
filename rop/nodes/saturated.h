// Storing without infinities.
#pragma once

#include "rop/datapath.h"
#include "rop/declaration.h"

#include <type_traits>

namespace ropsim {

// The converter to binary16 stops at its largest number: infinity behind an opaque layer would be 0 times
// infinity. Other formats have what they need.
template <class Real>
Real saturated(const Field& field, Real value) {
    if (field.format == Format::kFloat16 && value_of(value) > 65504.0f) {
        if constexpr (std::is_same_v<Real, float>)
            value = 65504.0f;
        else
            value.value = 65504.0f;
    }
    return value;
}

}  // namespace ropsim
