// Alpha blending in arrival order, by the blend unit: source over target. Several spatial samples are so many
// targets, whose mean is the image.
#include "capture/shader_sources.h"
#include "capture/software_path/software_technique.h"

namespace ropsim {
namespace {

class AlphaBlend : public SoftwareTechnique {
 public:
    explicit AlphaBlend(Parameters& parameters)
        : color_(stored_by(parameters, "color", StoredAs::kFloat16)) {}

    SoftwareImage render(Arrivals& arrivals, const SoftwareOptions& options) override {
        const std::vector<BlendedTarget> targets = {
            {{color_, 4}, BlendFunction::kOver, BlendFunction::kOver, {}}};
        BlendPass pass(arrivals, std::string(shader_source("alpha_blend")), false, targets, options.blending);
        const RenderTargets images({arrivals.width(), arrivals.height(), arrivals.samples()},
                                   specs_of(targets));
        const ScreenPass opaque("opaque layer", resolve_text("opaque_sample", color_));
        for (int m = 0; m < arrivals.samples(); ++m) {
            images.bind(m);
            glDisable(GL_DEPTH_TEST);
            opaque.program().set("u_sample", static_cast<std::uint32_t>(m));
            arrivals.bind_shared();
            opaque.draw();
            pass.pass().set("u_sample", static_cast<std::uint32_t>(m));
            pass.draw();
        }
        SoftwareImage result;
        result.rendering = pass.in_shader() ? "blending in the shader" : "fixed-function blending";
        if (arrivals.samples() == 1) {
            result.image = image_of(arrivals.width(), arrivals.height(), images.read(0));
            return result;
        }
        images.bind_color_texture(0, 10);
        const ScreenPass mean("mean of samples", resolve_text("mean_of_layers", color_));
        result.image = resolved_image(arrivals, mean);
        return result;
    }

 private:
    StoredAs color_;
};

}  // namespace

std::unique_ptr<SoftwareTechnique> make_software_alpha_blend(Parameters& parameters, const TraceHeader&) {
    return std::make_unique<AlphaBlend>(parameters);
}

}  // namespace ropsim
