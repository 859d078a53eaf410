// Sums that a narrow format cannot hold end at its largest number instead of infinity, which the next
// product with 0 would turn into no number at all.
#pragma once

#include "rop/saturated.h"

namespace ropsim {

// A sum of what is never negative, as `format` can keep it: a comparator and a mux where that can overflow.
template <class Real>
Real storable(Format format, const Real& sum) {
    return format == Format::kFloat16 ? minimum(sum, Real(kLargestFloat16)) : sum;
}
// The same of a sum of either sign.
template <class Real>
Real storable_signed(Format format, const Real& sum) {
    if (format != Format::kFloat16) return sum;
    return maximum(minimum(sum, Real(kLargestFloat16)), Real(-kLargestFloat16));
}

}  // namespace ropsim
