// Probability with which a surface that light passes casts a sample of shadow: McGuire and Mara 2017,
// equations 11 to 13. It is what a light's shader exports to the technique `colored_shadow_map`.
//
// Where the paper speaks against itself:
// * Section 4.3.3 first decreases shadowing at normal incidence and increases it at glancing angles, then
//   says that rho grows where |n . w| is close to 1 and falls where it is close to 0. Equations 12 and 13 do
//   the former: at |n . w| = 1 g is -1 and rho = (1 - s^0.2) alpha (1 - t), at 0 g is +1 and rho =
//   min(1, (1 + s^0.2) alpha (1 - t)). CausticSign::kProse is the latter, g negated.
// * eta is eta_before / eta_after (equation 8), so that light that enters a medium of index n has 1/eta = n
//   and s = (n - 1)/2 (CausticIndex::kMaterial, on both faces: "refractive index is specified once per
//   material"). Read face by face, light that leaves has eta = n, s = 0 and no caustic
//   (CausticIndex::kInterface). Figure 10 labels glass eta = 1.5; that in equation 11 gives s = 0 for every
//   material, as if caustics were off.
// * At s = 0 equation 12's exponent is 0, and |n . w| = 0 asks for 0^0, which GLSL leaves undefined. Its
//   factor s^0.2 is 0 whatever it is: rho is alpha (1 - t) here, without a power taken.
#pragma once

#include "rop/transcendental.h"
#include "traces/trace.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <glm/glm.hpp>

namespace ropsim {

enum class CausticSign : std::uint8_t { kEquations, kProse };
enum class CausticIndex : std::uint8_t { kMaterial, kInterface };

struct CausticModel {
    bool on = true;
    CausticSign sign = CausticSign::kEquations;
    CausticIndex index = CausticIndex::kMaterial;
};

// Equation 11 for a medium of index n: s in [0, 1]. `leaving`: the light goes out of the medium. Anything but
// a positive index bends nothing.
inline float caustic_strength(float n, bool leaving) {
    if (!(n > 0.0f)) return 0.0f;
    const float inverse_eta = leaving ? 1.0f / n : n;
    return std::clamp<float>((inverse_eta - 1.0f) / 2.0f, 0.0f, 1.0f);
}

// Equation 12: g in [-1, 1]; s in (0, 1], incidence |n . w| in [0, 1].
inline float caustic_contrast(float s, float incidence) {
    if (incidence == 0.0f) return 1.0f;
    const double exponent = 128.0 * static_cast<double>(s) * static_cast<double>(s);
    // Below 2^-126 the power is 0 beside 1.
    const double log2 = exponent * deterministic_log2(std::max(static_cast<double>(incidence), 0x1p-126));
    const double power = log2 < -126.0 ? 0.0 : deterministic_exp2(log2);
    return static_cast<float>(2.0 * std::clamp(1.0 - power, 0.0, 1.0) - 1.0);
}

// What multiplies alpha (1 - t) in equation 13: in [0, 2], the same for every wavelength. `back`: the surface
// turns its back to the light.
inline float caustic_factor(const CausticModel& model, float n, float incidence, bool back) {
    if (!model.on) return 1.0f;
    const float s = caustic_strength(n, back && model.index == CausticIndex::kInterface);
    if (s == 0.0f) return 1.0f;
    const float g = caustic_contrast(s, std::min<float>(std::abs(incidence), 1.0f));
    const auto strength = static_cast<float>(deterministic_power(static_cast<double>(s), 0.2));
    return 1.0f + (model.sign == CausticSign::kProse ? -g : g) * strength;
}

// Equation 13 for each wavelength: rho in [0, 1]. alpha and the material's transmission in [0, 1].
inline std::array<float, 3> shadow_probability(const CausticModel& model, float alpha, const Material& m,
                                               float incidence, bool back) {
    const float factor = caustic_factor(model, m.eta, incidence, back);
    std::array<float, 3> rho{};
    for (std::size_t c = 0; c < rho.size(); ++c)
        rho[c] = std::min<float>(1.0f, factor * (alpha * (1.0f - m.transmission[c])));
    return rho;
}

// The same of one map for all wavelengths, with the mean of the transmissions.
inline float mean_shadow_probability(const CausticModel& model, float alpha, const Material& m,
                                     float incidence, bool back) {
    const float mean = (m.transmission[0] + m.transmission[1] + m.transmission[2]) / 3.0f;
    return std::min<float>(1.0f, caustic_factor(model, m.eta, incidence, back) *
                                     (alpha * std::clamp<float>(1.0f - mean, 0.0f, 1.0f)));
}

// From a point of a light's view towards the light, in the camera space of that view, unit length: the same
// everywhere for an orthographic light, towards the eye for a perspective one. Without a camera, or with one
// whose projection cannot be inverted, the light is behind the viewer, orthographic.
class LightDirections {
 public:
    LightDirections(const std::optional<Camera>& camera, int width, int height)
        : width_(static_cast<float>(width)), height_(static_cast<float>(height)) {
        if (!camera) return;
        const glm::mat4& p = camera->projection;
        parallel_ = p[0][3] == 0.0f && p[1][3] == 0.0f && p[2][3] == 0.0f;
        from_clip_ = glm::inverse(p);
    }
    bool parallel() const { return parallel_; }
    glm::vec3 at(float x, float y) const {
        if (parallel_) return kAhead;
        const glm::vec2 clip(2.0f * x / width_ - 1.0f, 1.0f - 2.0f * y / height_);
        const glm::vec4 on_ray = from_clip_ * glm::vec4(clip, 0.5f, 1.0f);
        const glm::vec3 to_eye = glm::vec3(on_ray) / -on_ray.w;
        const float length = std::sqrt(glm::dot(to_eye, to_eye));
        if (!std::isfinite(length) || length == 0.0f) return kAhead;
        return to_eye / length;
    }
    // |n . w| at the fragment's pixel.
    float incidence(const Fragment& f, const Material& m) const {
        const glm::vec3 w = at(static_cast<float>(f.x) + 0.5f, static_cast<float>(f.y) + 0.5f);
        const float cosine = std::abs(m.normal[0] * w.x + m.normal[1] * w.y + m.normal[2] * w.z);
        return std::isfinite(cosine) ? std::min<float>(cosine, 1.0f) : 1.0f;
    }

 private:
    static constexpr glm::vec3 kAhead{0.0f, 0.0f, 1.0f};

    float width_, height_;
    bool parallel_ = true;
    glm::mat4 from_clip_{1.0f};
};

}  // namespace ropsim
