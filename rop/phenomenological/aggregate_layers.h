// Draws that are composited by a small k-buffer of their own and then blended as one surface: McGuire and
// Mara 2017, section 7.3, for hair.
#pragma once

#include "rop/nodes/counted_layers.h"
#include "rop/phenomenological/framebuffer_targets.h"

namespace ropsim {

class AggregateLayers {
 public:
    AggregateLayers() = default;
    AggregateLayers(Declaration& declaration, const TechniqueFormats& formats, int layers, int scale)
        : counted_(declaration, formats, layers, scale) {}

    // `alpha`: what the fragment takes of all that is behind it.
    template <class D, class P>
    CountedLayers::Outcome insert(D& d, const FragmentInput<D>& f, const typename D::Real& alpha,
                                  P& pixel) const {
        return counted_.insert<D>(d, f.z, f.premultiplied, alpha, pixel);
    }

    // All layers as one surface at the nearest one's depth, blended into `targets`.
    template <class D, class P>
    void blend(P& pixel, const FramebufferTargets& targets, const SurfaceShader& shader) const {
        using Real = typename D::Real;
        const StoredLayers& layers = counted_.layers();
        layers.fetch(pixel);
        targets.fetch_accumulated(pixel);
        targets.fetch_rest(pixel);
        const auto [color, behind] = layers.composited<D>(pixel);
        const Real alpha = Real(1.0f) - behind;
        // As for any surface, the weight is the shader's work.
        const Real w(shader.weight(std::min<float>(value_of(layers.depth(pixel, 0)), 1.0f), value_of(alpha)));
        std::array<Real, kMaxExports> exports{};
        exports[surface_export::kColor] = w * color.r;
        exports[surface_export::kColor + 1] = w * color.g;
        exports[surface_export::kColor + 2] = w * color.b;
        exports[surface_export::kNet] = w * alpha;
        targets.blend<D>(pixel, exports, {behind, behind, behind}, shader);
    }

 private:
    CountedLayers counted_;
};

}  // namespace ropsim
