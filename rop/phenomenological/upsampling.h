// Draws at a lower resolution, brought up to the image's: McGuire and Mara 2017, section 5.0.1. Each pixel is
// a weighted mean of the small targets around it, joint bilateral: a tent, times a weight by how near the
// opaque depth there is to the pixel's own, and is blended like a surface.
//
// upsample=tent7 is the 7x7 tent over pixels of the small targets; bilinear the one over 7x7 pixels of the
// image, which at a quarter of the resolution reaches just the 2x2 nearest. The paper names no weight for
// depth; here it is Listing 2's hyperbola, .01 / (.01 + |difference|), metres along the view.
#pragma once

#include "rop/phenomenological/framebuffer_targets.h"
#include "rop/view_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

namespace ropsim {

class Upsampling {
 public:
    Upsampling() = default;
    // Declares surface low_depth. Of a trace without a camera, window depths are compared.
    Upsampling(Declaration& declaration, const PhenomenologicalOptions& options, const Parameters& parameters,
               const Screen& screen)
        : scale_(options.low_scale),
          reach_(options.bilinear ? 1 : 3),
          tent_(options.bilinear ? 1.0f : 0.25f),
          width_(std::max(low_resolution(screen.width, scale_), 1)),
          height_(std::max(low_resolution(screen.height, scale_), 1)) {
        if (screen.camera)
            distance_ = ViewDistance(screen.camera, parameters.where("low_resolution"), "upsampling",
                                     "draw everything at the image's resolution");
        depth_ =
            declaration.surface("low_depth", 1, Layout::kInterleaved, Initial::kOpaqueDepth,
                                {FieldSpec::real(Format::kFloat32, 1, 1.0f, ValueRange::kUnit)}, scale_)[0];
        declaration.low_resolution_reach = reach_;
    }
    int taps() const { return reach_ == 1 ? 4 : (2 * reach_ + 1) * (2 * reach_ + 1); }

    template <class D>
    struct Sum {
        std::array<typename D::Real, kMaxExports> exports;
        Rgb<D> beta;
    };
    // What is to be blended at the gather's own pixel. Takes a step of kind 0 for each tap.
    template <class D, class P>
    Sum<D> upsampled(D& d, Gather<P>& gather, const FramebufferTargets& low) const {
        using Real = typename D::Real;
        const int centre = scale_ / 2;
        const float x = static_cast<float>(gather.x() - centre) / static_cast<float>(scale_);
        const float y = static_cast<float>(gather.y() - centre) / static_cast<float>(scale_);
        const int side = reach_ == 1 ? 2 : 2 * reach_ + 1;
        const int left =
            reach_ == 1 ? static_cast<int>(std::floor(x)) : static_cast<int>(std::floor(x + 0.5f)) - reach_;
        const int top =
            reach_ == 1 ? static_cast<int>(std::floor(y)) : static_cast<int>(std::floor(y + 0.5f)) - reach_;
        const Real own = distance<D>(gather.opaque_depth(gather.x(), gather.y()));
        std::array<float, kValues> sum{};
        d.steps(0, static_cast<std::uint32_t>(side * side), [&](std::uint32_t i) {
            const int u = left + static_cast<int>(i) % side;
            const int v = top + static_cast<int>(i) / side;
            P tap = gather.at(std::clamp(u, 0, width_ - 1), std::clamp(v, 0, height_ - 1));
            low.fetch_accumulated(tap);
            low.fetch_rest(tap);
            tap.fetch_all(depth_, 1);
            const float tent = (1 - std::abs(static_cast<float>(u) - x) * tent_) *
                               (1 - std::abs(static_cast<float>(v) - y) * tent_);
            const Real between = magnitude(distance<D>(tap.load(depth_)) - Real(value_of(own)));
            const Real w = Real(tent * kDepthScale) / (Real(kDepthScale) + between);
            const std::array<Real, kValues> value = values<D>(tap, low, w);
            for (std::size_t k = 0; k < kValues; ++k)
                sum[k] = value_of(Real(sum[k]) + inside(tent, value[k]));
        });
        const Real share = Real(1.0f) / Real(sum[kValues - 1]);
        Sum<D> out;
        const auto at = [&](std::size_t k) { return share * Real(sum[k]); };
        for (std::size_t k = 0; k < 4; ++k) out.exports[k] = at(k);
        out.beta = {at(4), at(5), at(6)};
        out.exports[surface_export::kDiffusion] = at(7);
        out.exports[surface_export::kOffset] = at(8);
        out.exports[surface_export::kOffset + 1] = at(9);
        return out;
    }

 private:
    static constexpr std::size_t kValues = 11;  // the targets' ten and the weight
    static constexpr float kDepthScale = 0.01f;
    static constexpr float kFarthest = 1e9f;  // metres; weights by it are not 0 yet

    // What a tap of that tent adds; outside of it nothing, not even 0 times infinity.
    static float inside(float tent, float value) { return tent > 0 ? value : 0.0f; }
    static Wire<float> inside(float tent, const Wire<float>& value) {
        return {inside(tent, value.value), value.ready};
    }
    template <class D>
    typename D::Real distance(const typename D::Real& z) const {
        using Real = typename D::Real;
        // Nothing behind: the far plane, which may be infinitely far away.
        const Real depth = minimum(z, Real(1.0f));
        return distance_ ? minimum(distance_->template of<D>(depth), Real(kFarthest)) : depth;
    }
    template <class D, class P>
    static std::array<typename D::Real, kValues> values(P& tap, const FramebufferTargets& low,
                                                        const typename D::Real& w) {
        const Rgb<D> color = low.color(tap);
        const Rgb<D> beta = low.beta(tap);
        const auto offset = low.offset(tap);
        const typename D::Real diffusion = low.has_diffusion() ? low.diffusion(tap) : typename D::Real(0.0f);
        return {w * color.r, w * color.g,   w * color.b,  w * low.net(tap), w * beta.r, w * beta.g,
                w * beta.b,  w * diffusion, w * offset.x, w * offset.y,     w};
    }

    int scale_ = 1;
    int reach_ = 1;
    float tent_ = 1;  // one over the tent's half width
    int width_ = 1;   // of the small targets; an image too small for a sample has one, that nothing draws to
    int height_ = 1;
    std::optional<ViewDistance> distance_;
    Field depth_;
};

}  // namespace ropsim
