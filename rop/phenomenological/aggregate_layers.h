// Draws that are composited by a small k-buffer of their own and then blended as one surface: McGuire and
// Mara 2017, section 7.3, for hair.
#pragma once

#include "rop/nodes/stored_layers.h"
#include "rop/phenomenological/framebuffer_targets.h"

namespace ropsim {

class AggregateLayers {
 public:
    enum Outcome { kAppended, kReplaced, kDropped };

    AggregateLayers() = default;
    // Declares surfaces layers and count, at that scale.
    AggregateLayers(Declaration& declaration, const TechniqueFormats& formats, int layers, int scale)
        : layers_(declaration, formats, layers, {}) {
        declaration.surfaces.back().scale = scale;
        count_ = declaration.surface("count", 1, Layout::kInterleaved, Initial::kClear,
                                     {FieldSpec::integer(32, 0)}, scale)[0];
    }

    // The k nearest, as a k-buffer keeps them. `alpha`: what the fragment takes of all that is behind it.
    template <class D, class P>
    Outcome insert(D& d, const FragmentInput<D>& f, const typename D::Real& alpha, P& pixel) const {
        using Uint = typename D::Uint;
        pixel.fetch_all(count_, 1);
        layers_.fetch(pixel);
        const Uint count = pixel.load_bits(count_);
        const auto front = layers_.in_front<D>(pixel, f.z, EqualDepth::kFragmentBehind);
        const auto full = count == Uint(static_cast<std::uint32_t>(layers_.layers()));
        const auto incoming = layers_.converted<D>(pixel, f.z, f.premultiplied, alpha, {0u, 0u});
        if (!d.decide(full)) {
            layers_.insert<D>(pixel, front, incoming);
            pixel.write(count_);
            pixel.put_bits(count_, 0, 0, count + Uint(1u));
            return kAppended;
        }
        if (d.decide(layers_.all<D>(front))) return kDropped;
        layers_.insert<D>(pixel, front, incoming);
        return kReplaced;
    }

    // All layers as one surface at the nearest one's depth, blended into `targets`.
    template <class D, class P>
    void blend(P& pixel, const FramebufferTargets& targets, const SurfaceShader& shader) const {
        using Real = typename D::Real;
        layers_.fetch(pixel);
        targets.fetch_accumulated(pixel);
        targets.fetch_rest(pixel);
        const auto [color, behind] = layers_.composited<D>(pixel);
        const Real alpha = Real(1.0f) - behind;
        // As for any surface, the weight is the shader's work.
        const Real w(shader.weight(std::min(value_of(layers_.depth(pixel, 0)), 1.0f), value_of(alpha)));
        std::array<Real, kMaxExports> exports{};
        exports[surface_export::kColor] = w * color.r;
        exports[surface_export::kColor + 1] = w * color.g;
        exports[surface_export::kColor + 2] = w * color.b;
        exports[surface_export::kNet] = w * alpha;
        targets.blend<D>(pixel, exports, {behind, behind, behind}, shader);
    }

 private:
    StoredLayers layers_;
    Field count_;
};

}  // namespace ropsim
