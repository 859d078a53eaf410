#include "rop/phenomenological/surface_shader.h"

#include <algorithm>
#include <cmath>

namespace ropsim {

SurfaceShader::SurfaceShader(const PhenomenologicalOptions& options, const Parameters& parameters,
                             const Screen& screen)
    : options_(options),
      width_(static_cast<float>(screen.width)),
      height_(static_cast<float>(screen.height)) {
    if (options.weight != "eq5" && options.weight != "listing" && options.weight != "g3d")
        depth_weight_.emplace(options.weight, parameters, screen);
    if (!options.refracts && !options.diffuses) return;
    distance_ = ViewDistance(screen.camera, parameters.where("refraction"), "refraction",
                             "use refraction=off and diffusion=off");
    projection_ = screen.camera->projection;
    metres_ = screen.camera->metres_per_unit;
    focal_pixels_ = 0.5f * width_ * projection_[0][0];
}

float SurfaceShader::weight(float z, float net) const {
    if (depth_weight_) return depth_weight_->of<PlainDatapath>(z, net);
    const float near = 1.0f - 0.99f * z;
    if (options_.weight == "g3d") {
        const float w = net * std::clamp<float>(1e4f * (near * near * near), 1e-3f, 1.0f);
        return std::clamp<float>(w, 1e-3f, 150.0f);
    }
    const float w = 10.0f * near * net;
    return std::clamp<float>(w * w * w, 0.01f, 30.0f);
}

// For a parallel view distance does not shrink anything: a metre is as many pixels everywhere.
float SurfaceShader::deviation(float z, float opaque_depth, float collimation, float covered) const {
    const float distance = distance_.of<PlainDatapath>(z);
    float thickness = 1;
    if (!options_.infinite_background && opaque_depth < 1) {
        const float behind = std::max<float>(distance_.of<PlainDatapath>(opaque_depth) - distance, 0.0f);
        thickness = 1 - options_.thickness_metres / (options_.thickness_metres + behind);
    }
    const bool perspective = projection_[3][3] == 0;
    const float pixels_a_metre =
        perspective ? focal_pixels_ / std::max<float>(distance, 1e-6f) : focal_pixels_ / metres_;
    constexpr float kMost = 1e6f;  // its square is finite
    return std::min(pixels_a_metre * options_.scatter_metres * (1 - collimation) * covered * thickness,
                    kMost);
}

// `distance` along the view's axis and the result in scene units, camera space.
glm::vec3 SurfaceShader::position(float x, float y, float distance) const {
    const float depth = -distance;
    const glm::mat4& p = projection_;
    const float w = p[2][3] * depth + p[3][3];
    const float ndc_x = 2 * x / width_ - 1;
    const float ndc_y = 1 - 2 * y / height_;
    return {(ndc_x * w - p[2][0] * depth - p[3][0]) / p[0][0],
            (ndc_y * w - p[2][1] * depth - p[3][1]) / p[1][1], depth};
}

glm::vec2 SurfaceShader::pixel_of(const glm::vec3& position) const {
    const glm::mat4& p = projection_;
    const float w = p[2][3] * position.z + p[3][3];
    const float ndc_x = (p[0][0] * position.x + p[2][0] * position.z + p[3][0]) / w;
    const float ndc_y = (p[1][1] * position.y + p[2][1] * position.z + p[3][1]) / w;
    return {0.5f * (ndc_x + 1) * width_, 0.5f * (1 - ndc_y) * height_};
}

glm::vec2 SurfaceShader::displacement(int x, int y, float z, const glm::vec3& normal, float index) const {
    if (!(index > 0)) return glm::vec2(0.0f);
    const float px = static_cast<float>(x) + 0.5f;
    const float py = static_cast<float>(y) + 0.5f;
    const glm::vec3 at = position(px, py, distance_.of<PlainDatapath>(z) / metres_);
    const bool perspective = projection_[3][3] == 0;
    const glm::vec3 to_eye = perspective ? -at / std::sqrt(glm::dot(at, at)) : glm::vec3(0, 0, 1);
    const float side = glm::dot(normal, to_eye) < 0 ? -1.0f : 1.0f;
    const glm::vec3 n = side * normal;
    const float cosine = glm::dot(n, to_eye);
    const float eta = 1 / index;  // of the air before over the matter after: equation 8 for the eye's ray
    const float k = 1 - eta * eta * (1 - cosine * cosine);
    if (k < 0) return glm::vec2(0.0f);  // nothing is transmitted
    const float along_normal =
        options_.printed_refraction ? -(eta - cosine + std::sqrt(k)) : eta * cosine - std::sqrt(k);
    const glm::vec3 ray = along_normal * n - eta * to_eye;
    // A ray that hardly goes away from the eye meets the plane behind out of all sight.
    constexpr float kLeastForward = 0.01f;
    if (-ray.z < kLeastForward) return glm::vec2(0.0f);
    const glm::vec3 behind = at + ray * (options_.refraction_metres / metres_ / -ray.z);
    return pixel_of(behind) - glm::vec2(px, py);
}

Exports SurfaceShader::shade(const ShadedFragment& s) const {
    const Fragment& f = s.fragment;
    const bool material = !options_.alpha_only;
    Exports out{};
    float mean = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        const float t = material ? s.material.transmission[c] : 0.0f;
        const float absorbed = f.a * (1 - t);
        out[surface_export::kAbsorbed + c] = options_.third_of_beta ? absorbed * (1.0f / 3.0f) : absorbed;
        mean += t * (1.0f / 3.0f);
    }
    const float net = f.a * std::max<float>(1 - mean, 0.0f);
    const float w = weight(f.z, net);
    out[surface_export::kColor] = w * f.r;
    out[surface_export::kColor + 1] = w * f.g;
    out[surface_export::kColor + 2] = w * f.b;
    out[surface_export::kNet] = w * net;
    if (options_.diffuses && s.material.collimation < 1) {
        const float covered = options_.net_diffusion ? net : f.a;
        const float d = deviation(f.z, s.opaque_depth, s.material.collimation, covered) * (1 / kPixelsAtOne);
        out[surface_export::kDiffusion] = options_.adds_deviations ? d : d * d;
    }
    // An index of 1 bends nothing, but for equation 9 as printed.
    if (options_.refracts && (s.material.eta != 1.0f || options_.printed_refraction)) {
        const glm::vec3 normal(s.material.normal[0], s.material.normal[1], s.material.normal[2]);
        const float covered = options_.alpha_refraction ? f.a : net;
        const glm::vec2 moved =
            displacement(s.x, s.y, f.z, normal, s.material.eta) * (covered / kPixelsAtOne);
        // A coordinate that is not a number is a camera's that a file made up.
        for (int c = 0; c < 2; ++c)
            out[surface_export::kOffset + static_cast<std::size_t>(c)] =
                std::isfinite(moved[c]) ? moved[c] : 0.0f;
    }
    return out;
}

Exports SurfaceShader::joined(const Exports& a, const Exports& b) const {
    Exports out;
    for (std::size_t i = 0; i < kMaxExports; ++i) out[i] = a[i] + b[i];
    for (std::size_t c = surface_export::kAbsorbed; c < surface_export::kAbsorbed + 3; ++c)
        out[c] = 1 - (1 - a[c]) * (1 - b[c]);
    return out;
}

AddedShading SurfaceShader::added_shading() const {
    AddedShading added;
    // 1 - t, alpha (1 - t), the mean; the weight; A.
    added.alu_instructions = 3 + 3 + 3 + 2 + 8 + 5;
    // Of Listing 1 and equation 7: depths to distances, the thickness, the factors, the square.
    if (options_.diffuses) added.alu_instructions += 16;
    if (options_.refracts) added.alu_instructions += 45;
    added.opaque_depth_fetches = options_.diffuses && !options_.infinite_background ? 1 : 0;
    return added;
}

}  // namespace ropsim
