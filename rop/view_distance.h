// Distance of a fragment from the eye, along the view's axis, of its window depth.
#pragma once

#include "base/error.h"
#include "rop/datapath.h"
#include "traces/trace.h"

#include <optional>
#include <string>
#include <string_view>

#include <fmt/format.h>

namespace ropsim {

// The view's z is a quotient of two polynomials of first degree in window depth, of which the numerator
// (perspective) or the denominator (parallel) is constant.
class ViewDistance {
 public:
    // Window depth itself.
    ViewDistance() = default;
    // Throws UserError at `where` (Parameters::where of the caller's key) without a camera or with one whose
    // z is not that of depth alone: `user` is what goes by the distance, `remedy` what to give instead.
    ViewDistance(const std::optional<Camera>& camera, const std::string& where, std::string_view user,
                 std::string_view remedy) {
        if (!camera)
            throw UserError(
                where, fmt::format("{} goes by the distance from the eye and the trace has no camera; {}",
                                   user, remedy));
        const glm::mat4& p = camera->projection;
        const double metres = camera->metres_per_unit;
        // z_clip = p22 z + p32 and w_clip = p23 z + p33, first index the column; z_clip / w_clip = 2 d - 1.
        const double p22 = p[2][2], p23 = p[2][3], p32 = p[3][2], p33 = p[3][3];
        const bool oblique = p[0][2] != 0 || p[1][2] != 0 || p[0][3] != 0 || p[1][3] != 0;
        perspective_ = p33 == 0;
        const double divisor = perspective_ ? p32 * metres : p22 / metres;
        if (oblique || (!perspective_ && p23 != 0) || divisor == 0)
            throw UserError(where, fmt::format("the distance from the eye cannot be told from depth with the "
                                               "trace's projection; {}",
                                               remedy));
        // Perspective: 1 / |z| = |offset + slope d|; parallel: |z| = |offset + slope d|.
        offset_ = static_cast<float>(perspective_ ? (-p23 - p22) / divisor : (-p33 - p32) / divisor);
        slope_ = static_cast<float>(perspective_ ? 2 * p23 / divisor : 2 * p33 / divisor);
    }

    // |z| in metres of window depth `z`.
    template <class D>
    typename D::Real of(const typename D::Real& z) const {
        using Real = typename D::Real;
        const Real linear = Real(offset_) + Real(slope_) * z;
        return magnitude(perspective_ ? Real(1.0f) / linear : linear);
    }

 private:
    bool perspective_ = false;
    float offset_ = 0;
    float slope_ = 1;
};

}  // namespace ropsim
