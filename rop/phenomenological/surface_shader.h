// What the pixel shader of phenomenological transparency makes of a surface: McGuire and Mara 2017, section 4
// and Listing 1. Computed in float32, as shaders do, and not charged to the framebuffer operation.
#pragma once

#include "rop/depth_weight.h"
#include "rop/operation.h"
#include "rop/phenomenological/options.h"
#include "rop/shader_stage.h"
#include "rop/view_distance.h"

#include <optional>

#include <glm/glm.hpp>

namespace ropsim {

// Places in the exports.
namespace surface_export {
inline constexpr std::size_t kColor = 0;      // 3: w alpha L_r
inline constexpr std::size_t kNet = 3;        // w alpha (1 - mean t)
inline constexpr std::size_t kAbsorbed = 4;   // 3: alpha (1 - t), which the blend takes from 1
inline constexpr std::size_t kDiffusion = 7;  // (D / 63)^2, or D / 63 where deviations are added
inline constexpr std::size_t kOffset = 8;     // 2: delta / 63, pixels to the right and down
}  // namespace surface_export

class SurfaceShader {
 public:
    // Pixels that 1 stands for in the targets of displacement and diffusion (Table 2).
    static constexpr float kPixelsAtOne = 63;

    SurfaceShader(const PhenomenologicalOptions& options, const Parameters& parameters, const Screen& screen);

    Exports shade(const ShadedFragment& f) const;
    // Of two surfaces that lie in registers together: sums, and beta's product.
    Exports joined(const Exports& a, const Exports& b) const;
    // The last line of Listing 1: a small sum of squares must not round away. `smallest`: a code of the
    // format.
    float raised(float diffusion, float smallest) const {
        return options_.raises_diffusion && diffusion > 0 && diffusion < smallest ? smallest : diffusion;
    }
    // Arithmetic instructions of a fragment, counted in shade(), and whether it fetches the opaque depth.
    AddedShading added_shading() const;

    // Weight of a surface that covers `net` of what is behind, equation 5 and its alternatives.
    float weight(float z, float net) const;
    // See DepthWeight. Weights of this paper and its code are at their least without coverage; of what
    // transmits in colour the net coverage is less than what a channel is covered by.
    LightLaw light_law(Format sums, bool colored_transmission) const {
        const LightLaw law = depth_weight_ ? depth_weight_->light_law(sums) : LightLaw::kMean;
        return law == LightLaw::kMean && colored_transmission ? LightLaw::kScaled : law;
    }
    // Standard deviation, in pixels, of the background behind a surface: equations 6 and 7 for one.
    float deviation(float z, float opaque_depth, float collimation, float covered) const;
    // Displacement of the background, in pixels, right and down: equations 8 to 10. `normal` in camera space,
    // `index` the material's.
    glm::vec2 displacement(int x, int y, float z, const glm::vec3& normal, float index) const;

 private:
    glm::vec3 position(float x, float y, float distance) const;
    glm::vec2 pixel_of(const glm::vec3& position) const;

    PhenomenologicalOptions options_;
    std::optional<DepthWeight> depth_weight_;
    ViewDistance distance_;
    glm::mat4 projection_{1.0f};
    float metres_ = 1;  // of a scene unit
    float width_;
    float height_;
    float focal_pixels_ = 1;  // W / (2 tan(theta / 2))
};

}  // namespace ropsim
