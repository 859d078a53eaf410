// Moment-based transparency of four power moments: an additive pass for absorbance and moments, one for
// colour by the visibility that they give, and a resolve.
#include "base/error.h"
#include "capture/shader_sources.h"
#include "capture/software_path/list_technique.h"

#include <cmath>
#include <string_view>

#include <fmt/format.h>

namespace ropsim {
namespace {

// Each pass over geometry shades it anew, and the compiler may order a pass's arithmetic as it likes: an
// alpha is then off by its last bit, and absorbance with it, as by a logarithm's 1e-6. Points of support that
// fall together are the double root of a quadratic with that error: their places, and the share in front, by
// its root. Times an absorbance of up to 4, behind which nothing is seen.
constexpr double kGeometryBound = 4e-3;

// As moments.glsl's u_warp: what a window depth becomes between two distances.
glm::vec4 warp_of(Parameters& p, const TraceHeader& header) {
    const std::string warp = p.get_choice("warp", "log", {"log", "linear", "depth"});
    if (!header.camera || warp == "depth") return {0, 1, 0, 0};
    const Camera& camera = *header.camera;
    const bool known = camera.near_plane > 0 && camera.far_plane > camera.near_plane;
    const double first = known ? camera.near_plane : 1.0;
    const double last = known ? camera.far_plane : 1000.0;
    const double near = p.get_real("near", first, 1e-6, 1e9);
    const double far = p.get_real("far", last, 1e-6, 1e9);
    if (!(near < far)) throw UserError(p.where("near"), "near must lie before far");
    // A fragment's distance is first / nearness, nearness being 1 - slope depth.
    const auto slope = static_cast<float>(1 - first / last);
    if (warp == "linear")
        return {slope, static_cast<float>(first / (far - near)), static_cast<float>(-near / (far - near)), 2};
    const double range = std::log(far / near);
    return {slope, static_cast<float>(-1 / range), static_cast<float>(std::log(first / near) / range), 1};
}

class MomentBased : public SoftwareTechnique {
 public:
    MomentBased(Parameters& p, const TraceHeader& header)
        : warp_(warp_of(p, header)),
          bias_(static_cast<float>(p.get_real("bias", 5e-7, 0, 0.5)),
                static_cast<float>(p.get_real("overestimation", 0.25, 0, 1)),
                static_cast<float>(p.get_real("absorbance_limit", 10, 1, 16)), 0) {
        check_one_sample("moment_based", header);
        p.get_choice("moments", "4", {"4"});
        p.get_choice("basis", "power", {"power"});
        p.get_choice("moment_format", "float32", {"float32"});
        p.get_choice("guard", "mended", {"mended"});
        read_exact_depth(p, "optical_depth");
        color_ = stored_by(p, "color", StoredAs::kFloat16);
        image_ = stored_image(p);
    }

    SoftwareImage render(Arrivals& arrivals, const SoftwareOptions& options) override {
        const std::vector<BlendedTarget> sums = {
            {{StoredAs::kFloat32, 1}, BlendFunction::kAdd, BlendFunction::kAdd, glm::vec4(0.0f)},
            {{StoredAs::kFloat32, 4}, BlendFunction::kAdd, BlendFunction::kAdd, glm::vec4(0.0f)}};
        const RenderTargets moments({arrivals.width(), arrivals.height()}, specs_of(sums));
        draw(arrivals, "moments_add", sums, moments, options);
        moments.bind_color_texture(0, 10);
        moments.bind_color_texture(1, 11);
        const std::vector<BlendedTarget> colors = {
            {{color_, 4}, BlendFunction::kAdd, BlendFunction::kAdd, glm::vec4(0.0f)}};
        const RenderTargets accumulated({arrivals.width(), arrivals.height()}, specs_of(colors));
        const bool in_shader = draw(arrivals, "moments_accumulate", colors, accumulated, options);
        accumulated.bind_color_texture(0, 12);
        const ScreenPass resolve("resolve",
                                 resolve_text({"functions", "moments_resolve"}, image_,
                                              fmt::format("#define ABSORBANCE_LIMIT {:.9e}\n", bias_.z)));
        return {resolved_image(arrivals, resolve),
                in_shader ? "blending in the shader" : "fixed-function blending",
                std::string_view(arrivals.kind()) == "geometry" ? kGeometryBound : 0};
    }

 private:
    // Whether the shader blended.
    bool draw(Arrivals& arrivals, const char* shader, const std::vector<BlendedTarget>& targets,
              const RenderTargets& images, const SoftwareOptions& options) const {
        // Transmittance stays above what the colour's format can sum.
        const float most_in_front = color_ == StoredAs::kFloat32 ? 64.0f : 13.862944f;
        BlendPass pass(arrivals,
                       fmt::format("#define MOST_IN_FRONT {:.9e}\n", most_in_front) +
                           std::string(shader_source("functions")) + std::string(shader_source("moments")) +
                           std::string(shader_source(shader)),
                       false, targets, options.blending);
        pass.pass().set("u_warp", warp_);
        pass.pass().set("u_bias", bias_);
        images.bind();
        for (std::size_t i = 0; i < targets.size(); ++i)
            images.clear_color(static_cast<int>(i), targets[i].clear);
        pass.draw();
        return pass.in_shader();
    }

    glm::vec4 warp_;
    glm::vec4 bias_;
    StoredAs color_;
    StoredAs image_;
};

}  // namespace

std::unique_ptr<SoftwareTechnique> make_software_moment_based(Parameters& parameters,
                                                              const TraceHeader& header) {
    return std::make_unique<MomentBased>(parameters, header);
}

}  // namespace ropsim
