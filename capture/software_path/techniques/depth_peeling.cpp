// Depth peeling on the rasteriser's depth test: a round draws everything, keeps the nearest fragment behind
// the layer before and puts it under what has been accumulated, until an occlusion query counts none. A
// fragment of geometry at the far plane is not told from an empty depth buffer.
#include "capture/shader_sources.h"
#include "capture/software_path/list_technique.h"

#include <array>

namespace ropsim {
namespace {

constexpr GLuint kBeforeUnit = 10;
constexpr GLuint kLayerUnit = 11;
constexpr GLuint kAccumulatedUnit = 12;

// Whether any fragment of what is drawn passes.
class OcclusionQuery {
 public:
    OcclusionQuery() { glCreateQueries(GL_ANY_SAMPLES_PASSED, 1, &id_); }
    ~OcclusionQuery() { glDeleteQueries(1, &id_); }
    OcclusionQuery(const OcclusionQuery&) = delete;
    OcclusionQuery& operator=(const OcclusionQuery&) = delete;
    template <class Draw>
    bool any(Draw draw) const {
        glBeginQuery(GL_ANY_SAMPLES_PASSED, id_);
        draw();
        glEndQuery(GL_ANY_SAMPLES_PASSED);
        GLuint result = 0;
        glGetQueryObjectuiv(id_, GL_QUERY_RESULT, &result);
        return result != 0;
    }

 private:
    GLuint id_ = 0;
};

class DepthPeeling : public SoftwareTechnique {
 public:
    explicit DepthPeeling(Parameters& p)
        : most_(static_cast<int>(p.get_integer("layers", 4096, 1, 4096))),
          layer_(stored_by(p, "layer", StoredAs::kUnorm8)),
          color_(stored_by(p, "color", StoredAs::kFloat16)),
          image_(stored_image(p)) {
        p.get_choice("ties", "collapse", {"collapse"});
        read_exact_depth(p);
    }

    SoftwareImage render(Arrivals& arrivals, const SoftwareOptions&) override;

 private:
    int most_;
    StoredAs layer_;
    StoredAs color_;
    StoredAs image_;
};

SoftwareImage DepthPeeling::render(Arrivals& arrivals, const SoftwareOptions&) {
    const std::string formats = std::string(shader_source("stored_formats")) +
                                keeping("LAYER", layer_, false) + keeping("COLOR", color_, false);
    const auto peel = arrivals.pass({formats + std::string(shader_source("depth_peel")), {}, false});
    const ScreenPass blend("blend of a layer", formats + std::string(shader_source("depth_peel_blend")));
    const TargetShape one{arrivals.width(), arrivals.height(), 1, 1, true};
    const TargetShape all{arrivals.width(), arrivals.height(), arrivals.samples()};
    const RenderTargets even(one, {{layer_, 4}});
    const RenderTargets odd(one, {{layer_, 4}});
    const RenderTargets even_sum(all, {{StoredAs::kFloat32, 4}});
    const RenderTargets odd_sum(all, {{StoredAs::kFloat32, 4}});
    const std::array<const RenderTargets*, 2> layer = {&even, &odd};
    const std::array<const RenderTargets*, 2> sum = {&even_sum, &odd_sum};
    const OcclusionQuery query;
    int most = 0;
    for (int m = 0; m < arrivals.samples(); ++m) {
        peel->set("u_sample", static_cast<std::uint32_t>(m));
        blend.program().set("u_layer_index", static_cast<std::uint32_t>(m));
        even_sum.bind(m);
        even_sum.clear_color(0, {0, 0, 0, 1});
        // Each round's sum goes to the other image; an even number of rounds leaves the first with all of it.
        bool found = true;
        for (int round = 0; found || round % 2 != 0; ++round) {
            const std::size_t now = round % 2 == 0 ? 0 : 1;
            layer[1 - now]->bind_depth_texture(kBeforeUnit);
            layer[now]->bind();
            layer[now]->clear_color(0, glm::vec4(0.0f));
            layer[now]->clear_depth(1.0f);
            found = found && round < most_;
            if (found) {
                glEnable(GL_DEPTH_TEST);
                glDepthMask(GL_TRUE);
                glDepthFunc(GL_LESS);
                peel->set("u_first_round", round == 0 ? 1u : 0u);
                found = query.any([&] { peel->draw(); });
                glDisable(GL_DEPTH_TEST);
                most = std::max(most, round + (found ? 1 : 0));
            }
            sum[1 - now]->bind(m);
            layer[now]->bind_color_texture(0, kLayerUnit);
            sum[now]->bind_color_texture(0, kAccumulatedUnit);
            blend.draw();
        }
    }
    even_sum.bind_color_texture(0, kAccumulatedUnit);
    const ScreenPass resolve("resolve", resolve_text("depth_peel_resolve", image_));
    return {resolved_image(arrivals, resolve), fmt::format("{} rounds", most), 0};
}

}  // namespace

std::unique_ptr<SoftwareTechnique> make_software_depth_peeling(Parameters& parameters, const TraceHeader&) {
    return std::make_unique<DepthPeeling>(parameters);
}

}  // namespace ropsim
