// Stochastic transparency on render targets: sample masks and depth tests of the rasteriser, in multisampled
// targets as far as the driver has them and several of them beyond; where fragments are a scene's geometry,
// or have several spatial samples, a target a sample, since the driver's samples lie elsewhere. Then Enderton
// et al.'s total alpha and accumulation passes. An empty sample keeps depth 1: geometry at the far plane is
// not told from it.
#include "base/error.h"
#include "capture/shader_sources.h"
#include "capture/software_path/software_technique.h"

#include <algorithm>
#include <optional>

namespace ropsim {
namespace {

constexpr GLuint kDepthUnit = 10;
constexpr GLuint kColorUnit = 11;
constexpr GLuint kTotalUnit = 12;
constexpr GLuint kAccumulatedUnit = 13;

class Stochastic : public SoftwareTechnique {
 public:
    Stochastic(Parameters& p, const TraceHeader& header)
        : samples_(static_cast<int>(p.get_integer("samples", 8, 1, 64))),
          depth_based_(p.get_choice("method", "basic", {"basic", "depth_based"}) == "depth_based"),
          correction_(p.get_choice("correction", depth_based_ ? "accumulated" : "none",
                                   {"none", "coverage", "accumulated"})),
          masks_(p.get_choice("masks", "choose", {"choose", "coin", "run", "alpha_to_coverage"})),
          seed_from_(
              p.get_choice("seed_from", "primitive", {"primitive", "depth", "object", "object_facing"})),
          dithered_(p.get_choice("rounding", "random", {"random", "dither"}) == "dither") {
        p.get_choice("depth_test", "last", {"last"});
        p.get_choice("passes", "separate", {"separate"});
        if (!depth_based_) color_ = stored_by(p, "color", StoredAs::kUnorm8);
        if (has_total()) total_ = stored_by(p, "total_alpha", StoredAs::kFloat16);
        if (depth_based_) accumulation_ = stored_by(p, "accumulation", StoredAs::kFloat16);
        if (stored_by(p, "depth", StoredAs::kFloat32) != StoredAs::kFloat32)
            throw UserError(p.where("depth_format"), "the software path's depth buffer is float32");
        image_ = stored_by(p, "image", StoredAs::kFloat16);
        if (header.samples > 1 && (depth_based_ || has_total()))
            throw UserError("--technique",
                            "the software path's stochastic takes a trace of several samples with "
                            "method=basic and correction=none only");
    }

    SoftwareImage render(Arrivals& arrivals, const SoftwareOptions& options) override {
        const int per_target = samples_a_target(arrivals);
        std::optional<RenderTargets> total;
        std::optional<RenderTargets> accumulated;
        bool in_shader = false;
        if (has_total())
            in_shader = blend(
                arrivals, options, std::string(shader_source("alpha_source")),
                {{total_, 1}, BlendFunction::kMultiply, BlendFunction::kMultiply, glm::vec4(1.0f)}, total);
        std::vector<TargetSpec> colors;
        if (!depth_based_) colors.push_back({color_, 4});
        const RenderTargets samples(
            {arrivals.width(), arrivals.height(), samples_ / per_target, per_target, true}, colors);
        draw_samples(arrivals, options, per_target, samples);
        samples.bind_depth_texture(kDepthUnit);
        if (depth_based_)
            in_shader = blend(arrivals, options,
                              sampling_defines(per_target) + std::string(shader_source("stored_samples")) +
                                  std::string(shader_source("stochastic_accumulate")),
                              {{accumulation_, 4}, BlendFunction::kAdd, BlendFunction::kAdd, glm::vec4(0.0f)},
                              accumulated) ||
                        in_shader;
        else
            samples.bind_color_texture(0, kColorUnit);
        if (total) total->bind_color_texture(0, kTotalUnit);
        if (accumulated) accumulated->bind_color_texture(0, kAccumulatedUnit);
        samples.bind_depth_texture(kDepthUnit);
        std::string defines = sampling_defines(per_target) + "#define CORRECTION_" + correction_ + "\n";
        if (depth_based_) defines += "#define DEPTH_BASED\n";
        if (color_ == StoredAs::kUnorm8) defines += "#define COLOR_CODES\n";
        const ScreenPass resolve("resolve",
                                 resolve_text("stochastic_resolve", image_, defines, "stored_samples"));
        SoftwareImage result;
        result.image = resolved_image(arrivals, resolve);
        result.rendering =
            fmt::format("{} target{} of {} sample{}{}", samples_ / per_target,
                        samples_ == per_target ? "" : "s", per_target, per_target == 1 ? "" : "s",
                        !has_total() && !depth_based_ ? ""
                        : in_shader                   ? ", blending in the shader"
                                                      : ", fixed-function blending");
        return result;
    }

 private:
    bool has_total() const { return correction_ != "none"; }

    // As many as the driver's multisampled targets have, where its samples can stand for ours: points cover
    // all samples of their pixel.
    int samples_a_target(const Arrivals& arrivals) const {
        if (std::string_view(arrivals.kind()) != "fragments" || arrivals.samples() > 1) return 1;
        GLint color = 1;
        GLint depth = 1;
        glGetIntegerv(GL_MAX_COLOR_TEXTURE_SAMPLES, &color);
        glGetIntegerv(GL_MAX_DEPTH_TEXTURE_SAMPLES, &depth);
        for (int n = std::min({color, depth, 8}); n > 2; --n)
            if (samples_ % n == 0) return n;
        return 1;
    }
    std::string sampling_defines(int per_target) const {
        return fmt::format("#define TARGET_SAMPLES {}u\n#define STORED_SAMPLES {}u\n", per_target, samples_);
    }

    void draw_samples(Arrivals& arrivals, const SoftwareOptions& options, int per_target,
                      const RenderTargets& samples) const {
        const std::string stored =
            depth_based_ ? "" : fmt::format("#define STORED kept_{}\n", stored_name(color_));
        const std::string text =
            sampling_defines(per_target) + stored + fmt::format("#define DITHERED {}\n", dithered_) +
            "#define MASKS_" + masks_ + "\n#define SEED_FROM_" + seed_from_ + "\n" +
            std::string(shader_source("stored_formats")) + std::string(shader_source("random")) +
            std::string(shader_source("stochastic_masks")) + std::string(shader_source("stochastic"));
        const auto pass = arrivals.pass({text, {}, false});
        pass->set("u_seed_low", static_cast<std::uint32_t>(options.seed));
        pass->set("u_seed_high", static_cast<std::uint32_t>(options.seed >> 32));
        pass->set("u_stored", static_cast<std::uint32_t>(samples_));
        pass->set("u_image_width", static_cast<std::uint32_t>(arrivals.width()));
        std::optional<ScreenPass> opaque;
        if (over_opaque())
            opaque.emplace("opaque layer", depth_scale(arrivals) + std::string(shader_source("arrival")) +
                                               stored + std::string(shader_source("stored_formats")) +
                                               std::string(shader_source("opaque_fill")));
        glEnable(GL_DEPTH_TEST);
        glDepthMask(GL_TRUE);
        for (int target = 0; target < samples_ / per_target; ++target) {
            const auto first = static_cast<std::uint32_t>(target * per_target);
            samples.bind(target);
            samples.clear_depth(1.0f);
            if (!depth_based_) samples.clear_color(0, glm::vec4(0.0f));
            glDepthFunc(GL_ALWAYS);
            if (opaque) {
                opaque->program().set("u_sample", first % static_cast<std::uint32_t>(arrivals.samples()));
                arrivals.bind_shared();
                opaque->draw();
            }
            glDepthFunc(GL_LESS);
            pass->set("u_first", first);
            pass->draw();
        }
        glDisable(GL_DEPTH_TEST);
    }
    // Replayed depths are halved, exactly, so that an empty sample's 1 lies behind the far plane. A
    // rasteriser's are its own.
    static std::string depth_scale(const Arrivals& arrivals) {
        return std::string_view(arrivals.kind()) == "fragments" ? "#define DEPTH_SCALE 0.5\n"
                                                                : "#define DEPTH_SCALE 1.0\n";
    }
    bool over_opaque() const { return !depth_based_ && !has_total(); }

    // Draws one blended target; whether the shader blended.
    static bool blend(Arrivals& arrivals, const SoftwareOptions& options, const std::string& text,
                      const BlendedTarget& target, std::optional<RenderTargets>& image) {
        BlendPass pass(arrivals, text, false, {target}, options.blending);
        image.emplace(TargetShape{arrivals.width(), arrivals.height()}, std::vector<TargetSpec>{target.spec});
        image->bind();
        image->clear_color(0, target.clear);
        pass.draw();
        return pass.in_shader();
    }

    int samples_;
    bool depth_based_;
    std::string correction_;
    std::string masks_;
    std::string seed_from_;
    bool dithered_;
    StoredAs color_ = StoredAs::kFloat32;
    StoredAs total_ = StoredAs::kFloat32;
    StoredAs accumulation_ = StoredAs::kFloat32;
    StoredAs image_;
};

}  // namespace

std::unique_ptr<SoftwareTechnique> make_software_stochastic(Parameters& parameters,
                                                            const TraceHeader& header) {
    return std::make_unique<Stochastic>(parameters, header);
}

}  // namespace ropsim
