// Moments in 16 bits: Muenstermann et al. 2018, after Peters and Klein 2015. Kept are moments
// divided by the sum of all absorbance, under a linear map of odd and of even power moments that lets each
// stored number use its whole range [0, 1]; trigonometric ones only move from [-1, 1]. The maps are the
// paper's (public MomentMath.hlsli); their inverses are computed from them.
#pragma once

#include "rop/visibility/trigonometric_moments.h"

#include <array>
#include <cstddef>

namespace ropsim {

class MomentQuantiser {
 public:
    explicit MomentQuantiser(int order);

    // The map without its offset: linear, so that moments of different absorbance may be added under it.
    template <int kOrder, class Real>
    PowerMoments<kOrder, Real> mapped(const PowerMoments<kOrder, Real>& b) const {
        return applied<kOrder, Real>(forward_, b);
    }
    // Moments from what is stored.
    template <int kOrder, class Real>
    PowerMoments<kOrder, Real> restored(const PowerMoments<kOrder, Real>& stored) const {
        PowerMoments<kOrder, Real> centred;
        for (std::size_t k = 0; k < centred.size(); ++k) centred[k] = stored[k] - Real(offset_[k]);
        return applied<kOrder, Real>(inverse_, centred);
    }
    const std::array<float, std::size_t{2} * kMaxMomentOrder>& offset() const { return offset_; }

 private:
    using Matrix = std::array<std::array<float, kMaxMomentOrder>, kMaxMomentOrder>;

    // Odd moments by maps[0], even ones by maps[1].
    template <int kOrder, class Real>
    static PowerMoments<kOrder, Real> applied(const std::array<Matrix, 2>& maps,
                                              const PowerMoments<kOrder, Real>& b) {
        PowerMoments<kOrder, Real> result;
        for (std::size_t k = 0; k < result.size(); ++k) {
            const auto& row = maps[k % 2][k / 2];
            Real sum = Real(row[0]) * b[k % 2];
            for (std::size_t j = 1; j < kOrder; ++j)
                if (row[j] != 0.0f) sum = sum + Real(row[j]) * b[2 * j + k % 2];
            result[k] = sum;
        }
        return result;
    }

    std::array<Matrix, 2> forward_{};
    std::array<Matrix, 2> inverse_{};
    std::array<float, std::size_t{2} * kMaxMomentOrder> offset_{};  // b_1, b_2, ...
};

}  // namespace ropsim
