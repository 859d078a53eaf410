// Weighted blended transparency: two targets, one additive, one multiplicative, and a resolve over the
// screen.
#include "capture/shader_sources.h"
#include "capture/software_path/software_technique.h"

namespace ropsim {
namespace {

class WeightedBlended : public SoftwareTechnique {
 public:
    explicit WeightedBlended(Parameters& parameters)
        : color_(stored_by(parameters, "color", StoredAs::kFloat16)),
          revealage_(stored_by(parameters, "revealage", StoredAs::kUnorm8)),
          image_(stored_by(parameters, "image", StoredAs::kFloat16)),
          weight_(parameters.get_choice("weight", "eq10", {"eq10", "blog2015", "learnopengl", "none"})) {
        parameters.get_choice("overflow", "white", {"white"});
    }

    SoftwareImage render(Arrivals& arrivals, const SoftwareOptions& options) override {
        const std::vector<BlendedTarget> targets = {
            {{color_, 4}, BlendFunction::kAdd, BlendFunction::kAdd, glm::vec4(0.0f)},
            {{revealage_, 1}, BlendFunction::kMultiply, BlendFunction::kMultiply, glm::vec4(1.0f)}};
        BlendPass pass(
            arrivals,
            fmt::format("#define WEIGHT_{}\n", weight_) + std::string(shader_source("weighted_blended")),
            false, targets, options.blending);
        const RenderTargets images({arrivals.width(), arrivals.height()}, specs_of(targets));
        images.bind();
        images.clear_color(0, targets[0].clear);
        images.clear_color(1, targets[1].clear);
        pass.draw();
        images.bind_color_texture(0, 10);
        images.bind_color_texture(1, 11);
        const std::string codes = revealage_ == StoredAs::kUnorm8 ? "#define REVEALAGE_CODES\n" : "";
        const ScreenPass resolve("resolve", resolve_text("weighted_blended_resolve", image_, codes));
        return {resolved_image(arrivals, resolve),
                pass.in_shader() ? "blending in the shader" : "fixed-function blending", 0};
    }

 private:
    StoredAs color_;
    StoredAs revealage_;
    StoredAs image_;
    std::string weight_;
};

}  // namespace

std::unique_ptr<SoftwareTechnique> make_software_weighted_blended(Parameters& parameters,
                                                                  const TraceHeader&) {
    return std::make_unique<WeightedBlended>(parameters);
}

}  // namespace ropsim
