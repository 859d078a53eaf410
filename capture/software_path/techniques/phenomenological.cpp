// Phenomenological transparency: three targets under fixed-function blending, and a resolve that displaces
// and blurs the background (McGuire and Mara 2017, Table 2 and Listings 1 and 3), as the model reads the
// paper by default.
#include "base/error.h"
#include "capture/shader_sources.h"
#include "capture/software_path/software_technique.h"

namespace ropsim {
namespace {

// Offset and slope of 1 / |z| (perspective) or |z| (parallel), in metres, over window depth.
glm::vec4 distance_of(const Camera& camera) {
    const glm::dmat4 p(camera.projection);
    const double metres = static_cast<double>(camera.metres_per_unit);
    // Window depth d is (z_clip / w_clip + 1) / 2; here z is negative before the eye.
    const bool perspective = p[3][3] == 0;
    const double offset =
        perspective ? (-p[2][3] - p[2][2]) / (p[3][2] * metres) : (-p[3][3] - p[3][2]) * metres / p[2][2];
    const double slope = perspective ? 2 * p[2][3] / (p[3][2] * metres) : 2 * p[3][3] * metres / p[2][2];
    return {static_cast<float>(offset), static_cast<float>(slope), perspective ? 1.0f : 0.0f,
            camera.metres_per_unit};
}

class Phenomenological : public SoftwareTechnique {
 public:
    Phenomenological(Parameters& p, const TraceHeader& header)
        : accumulated_(stored_by(p, "accumulated", StoredAs::kFloat16)),
          beta_(stored_by(p, "beta", StoredAs::kUnorm8)),
          delta_(stored_by(p, "delta", StoredAs::kSnorm8)),
          image_(stored_by(p, "image", StoredAs::kFloat16)),
          weight_(p.get_choice("weight", "eq5", {"eq5", "listing", "none"})),
          refracts_(p.get_choice("refraction", "snell", {"snell", "off"}) == "snell" && header.materials),
          diffuses_(p.get_choice("diffusion", "on", {"on", "off"}) == "on" && header.materials),
          self_modulates_(p.get_choice("self_modulation", "on", {"on", "off"}) == "on"),
          scatter_metres_(static_cast<float>(p.get_real("k0", 0.128, 0, 1000))),
          thickness_metres_(static_cast<float>(p.get_real("k1", 0.5, 1e-6, 1000))),
          refraction_metres_(static_cast<float>(p.get_real("refraction_depth", 2, 0, 1e6))),
          max_radius_(static_cast<std::uint32_t>(p.get_integer("max_radius", 16, 0, 63))) {
        if (header.samples > 1)
            throw UserError("--technique", "phenomenological takes traces of one sample a pixel");
        if (!header.camera && (refracts_ || diffuses_))
            throw UserError(p.where("refraction"),
                            "refraction and diffusion go by the camera and the trace has "
                            "none; use refraction=off and diffusion=off");
    }

    SoftwareImage render(Arrivals& arrivals, const SoftwareOptions& options) override {
        const std::vector<BlendedTarget> targets = {
            {{accumulated_, 4}, BlendFunction::kAdd, BlendFunction::kAdd, glm::vec4(0.0f)},
            {{beta_, 4}, BlendFunction::kMultiply, BlendFunction::kAdd, glm::vec4(1, 1, 1, 0)},
            {{delta_, 2}, BlendFunction::kAdd, BlendFunction::kAdd, glm::vec4(0.0f)}};
        BlendPass pass(arrivals,
                       defines() + std::string(shader_source("view_distance")) +
                           std::string(shader_source("phenomenological")),
                       arrivals.header().materials, targets, options.blending);
        set_view(arrivals, pass.pass());
        const RenderTargets images({arrivals.width(), arrivals.height()}, specs_of(targets));
        images.bind();
        for (int i = 0; i < 3; ++i) images.clear_color(i, targets[static_cast<std::size_t>(i)].clear);
        pass.draw();
        for (int i = 0; i < 3; ++i) images.bind_color_texture(i, 10 + static_cast<GLuint>(i));
        const ScreenPass resolve("resolve", resolve_text("phenomenological_resolve", image_, defines()));
        resolve.program().set("u_max_radius", max_radius_);
        return {resolved_image(arrivals, resolve),
                pass.in_shader() ? "blending in the shader" : "fixed-function blending", 0};
    }

 private:
    std::string defines() const {
        std::string text = fmt::format("#define BETA_STORED kept_{}\n#define DELTA_STORED kept_{}\n",
                                       stored_name(beta_), stored_name(delta_));
        text += fmt::format("#define LEAST_DIFFUSION {}\n", beta_ == StoredAs::kUnorm8   ? "(1.0 / 255.0)"
                                                            : beta_ == StoredAs::kSnorm8 ? "(1.0 / 127.0)"
                                                                                         : "0.0");
        text += "#define WEIGHT_" + weight_ + "\n";
        if (refracts_) text += "#define REFRACTS\n";
        if (diffuses_) text += "#define DIFFUSES\n";
        if (self_modulates_) text += "#define SELF_MODULATES\n";
        return text;
    }
    void set_view(const Arrivals& arrivals, ArrivalPass& pass) const {
        if (!refracts_ && !diffuses_) return;
        const Camera& camera = *arrivals.header().camera;
        const auto width = static_cast<float>(arrivals.width());
        pass.set("u_lens", camera.projection);
        pass.set("u_distance", distance_of(camera));
        pass.set("u_image_size", glm::vec4(width, arrivals.height(), 0, 0));
        pass.set("u_scattering", glm::vec4(scatter_metres_, thickness_metres_, refraction_metres_,
                                           0.5f * width * camera.projection[0][0]));
    }

    StoredAs accumulated_;
    StoredAs beta_;
    StoredAs delta_;
    StoredAs image_;
    std::string weight_;
    bool refracts_;
    bool diffuses_;
    bool self_modulates_;
    float scatter_metres_;
    float thickness_metres_;
    float refraction_metres_;
    std::uint32_t max_radius_;
};

}  // namespace

std::unique_ptr<SoftwareTechnique> make_software_phenomenological(Parameters& parameters,
                                                                  const TraceHeader& header) {
    return std::make_unique<Phenomenological>(parameters, header);
}

}  // namespace ropsim
