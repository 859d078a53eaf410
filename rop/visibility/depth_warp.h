// How the depth of a fragment becomes the parameter that a visibility function is stored over: 0 at the near
// plane, 1 at the far plane.
#pragma once

#include "base/error.h"
#include "base/parameters.h"
#include "rop/operation.h"
#include "rop/transcendental.h"

#include <cmath>
#include <string>

namespace ropsim {

class DepthWarp {
 public:
    enum class Kind : std::uint8_t {
        kLogarithm,  // of the distance from the eye
        kDistance,   // from the eye
        kDepth,      // the depth buffer's own value
    };
    // Reads `warp`, and `near` and `far`: distances between which the transparent fragments lie, in the
    // trace's units, by default the camera's planes. The narrower they are, the finer is what is stored. A
    // trace without a camera says nothing about distances: its depth is taken as it is. Where a camera leaves
    // its planes out, far is taken as 1000 near. Throws UserError where near is not before far.
    DepthWarp(Parameters& parameters, const Screen& screen, const std::string& fallback) {
        const std::string name = parameters.get_choice("warp", fallback, {"log", "linear", "depth"});
        if (!screen.camera || name == "depth") return;
        const Camera& camera = *screen.camera;
        const bool known = camera.near_plane > 0 && camera.far_plane > camera.near_plane;
        const double first = known ? camera.near_plane : 1.0;
        const double last = known ? camera.far_plane : 1000.0;
        const double near = parameters.get_real("near", first, 1e-6, 1e9);
        const double far = parameters.get_real("far", last, 1e-6, 1e9);
        if (!(near < far))
            throw UserError(
                parameters.where("near"),
                fmt::format("near={} is not before far={}; give distances from the eye", near, far));
        kind_ = name == "log" ? Kind::kLogarithm : Kind::kDistance;
        slope_ = static_cast<float>(1.0 - first / last);
        if (kind_ == Kind::kLogarithm) {
            const double range = natural_log_of(far / near);
            scale_ = static_cast<float>(-1.0 / range);
            offset_ = static_cast<float>(natural_log_of(first / near) / range);
        } else {
            scale_ = static_cast<float>(first / (far - near));
            offset_ = static_cast<float>(-near / (far - near));
        }
    }
    Kind kind() const { return kind_; }

    // `z` in [0, 1] as a perspective projection leaves it; what lies outside goes to the nearer end.
    template <class Real>
    Real operator()(const Real& z) const {
        const Real depth = minimum(maximum(z, Real(0.0f)), Real(1.0f));
        if (kind_ == Kind::kDepth) return depth;
        const Real nearness =
            Real(1.0f) - Real(slope_) * depth;  // the near plane's distance over the fragment's
        const Real distance =
            kind_ == Kind::kLogarithm ? natural_log(nearness) * Real(scale_) : Real(scale_) / nearness;
        return minimum(maximum(distance + Real(offset_), Real(0.0f)), Real(1.0f));
    }

 private:
    static double natural_log_of(double x) { return 0.6931471805599453 * deterministic_log2(x); }

    Kind kind_ = Kind::kDepth;
    float slope_ = 0;
    float scale_ = 1;
    float offset_ = 0;
};

}  // namespace ropsim
