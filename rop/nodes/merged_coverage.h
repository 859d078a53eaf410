// Two layers that cover parts of a pixel as one over both parts: what their samples show on average.
#pragma once

#include "rop/technique.h"

#include <algorithm>

namespace ropsim {

// count / of for two population counts: a table of (M + 1)^2 entries. 0 of nothing.
template <class D>
typename D::Real share_of(const typename D::Uint& count, const typename D::Uint& of) {
    const float value =
        value_of(of) == 0 ? 0.0f : static_cast<float>(value_of(count)) / static_cast<float>(value_of(of));
    if constexpr (D::kCharged)
        return {value, Ledger::active().charge(Unit::kTable, std::max(count.ready, of.ready))};
    else
        return value;
}

// Of n samples in all, the nearer layer covers a (`alone` of them without the farther one), the farther b
// without the nearer and `both` with it:
//   n colour = a near + (b + both t) far,    n transmittance = alone t + (b + both t) t_far
// with t the nearer's own transmittance.
template <class D>
struct MergedCoverage {
    typename D::Uint mask;             // of the two together
    typename D::Real near;             // weight of the nearer's premultiplied colour
    typename D::Real far;              // ... of the farther's, and of its transmittance
    typename D::Real alone;            // what of the transmittance is the nearer's
    typename D::Bool far_covers_more;  // more samples than the nearer

    MergedCoverage(const typename D::Uint& near_mask, const typename D::Uint& far_mask,
                   const typename D::Real& t)
        : mask(near_mask | far_mask) {
        const auto shared = near_mask & far_mask;
        const auto all = population_count(mask);
        const auto near_count = population_count(near_mask);
        near = share_of<D>(near_count, all);
        far = share_of<D>(population_count(far_mask ^ shared), all) +
              share_of<D>(population_count(shared), all) * t;
        alone = share_of<D>(population_count(near_mask ^ shared), all) * t;
        far_covers_more = near_count < population_count(far_mask);
    }
};

}  // namespace ropsim
