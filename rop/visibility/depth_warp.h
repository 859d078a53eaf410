// How the depth of a fragment becomes the parameter that a visibility function is stored over: 0 at the near plane, 1 at
// the far plane.
#pragma once

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
    // Reads `warp`. What it takes from the camera is the ratio of far to near plane. A trace without a camera says nothing
    // about distances: its depth is taken as it is. A camera that leaves its planes out is taken as far = 1000 near.
    DepthWarp(Parameters& parameters, const Screen& screen, const std::string& fallback) {
        const std::string name = parameters.get_choice("warp", fallback, {"log", "linear", "depth"});
        if (!screen.camera || name == "depth") return;
        const bool known = screen.camera->near_plane > 0 && screen.camera->far_plane > screen.camera->near_plane;
        const double ratio =
            known ? static_cast<double>(screen.camera->far_plane) / screen.camera->near_plane : 1000.0;
        kind_ = name == "log" ? Kind::kLogarithm : Kind::kDistance;
        slope_ = static_cast<float>(1.0 - 1.0 / ratio);
        inverse_ratio_ = static_cast<float>(1.0 / ratio);
        inverse_log_ = static_cast<float>(1.0 / (0.6931471805599453 * deterministic_log2(ratio)));
    }
    Kind kind() const { return kind_; }

    // `z` in [0, 1] as a perspective projection leaves it; beyond it the nearer end is taken.
    template <class Real>
    Real operator()(const Real& z) const {
        const Real depth = minimum(maximum(z, Real(0.0f)), Real(1.0f));
        if (kind_ == Kind::kDepth) return depth;
        // The near plane's distance over the fragment's.
        const Real nearness = Real(1.0f) - Real(slope_) * depth;
        const Real warped = kind_ == Kind::kLogarithm ? natural_log(nearness) * Real(-inverse_log_)
                                                      : depth * Real(inverse_ratio_) / nearness;
        return minimum(maximum(warped, Real(0.0f)), Real(1.0f));
    }

 private:
    Kind kind_ = Kind::kDepth;
    float slope_ = 0;
    float inverse_ratio_ = 1;
    float inverse_log_ = 0;
};

}  // namespace ropsim
