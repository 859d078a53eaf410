// The render targets of phenomenological transparency and the fixed-function blend of each: McGuire and Mara
// 2017, Table 2 and the appendix. Values are clamped where a target's format clamps, and rounded to it.
#pragma once

#include "rop/phenomenological/options.h"
#include "rop/phenomenological/surface_shader.h"
#include "rop/saturated.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>

namespace ropsim {

// What is stored of each, one choice for targets of all resolutions.
struct TargetFormats {
    explicit TargetFormats(const TechniqueFormats& formats)
        : accumulated(formats.of("accumulated", Format::kFloat16)),
          beta(formats.of("beta", Format::kUnorm8)),
          delta(formats.of("delta", Format::kSnorm8)) {}
    // Whether the format of offsets can hold them as they are to be kept.
    bool fits(const PhenomenologicalOptions& options) const {
        const bool has_signs =
            delta == Format::kSnorm8 || delta == Format::kFloat16 || delta == Format::kFloat32;
        return has_signs || options.offsets != PhenomenologicalOptions::Offsets::kSigned;
    }
    Format accumulated;
    Format beta;
    Format delta;
};

class FramebufferTargets {
 public:
    FramebufferTargets() = default;
    // Declares RT0, RT1 and RT2 as surfaces <prefix>accumulated, <prefix>beta and <prefix>delta.
    FramebufferTargets(Declaration& declaration, const TargetFormats& formats,
                       const PhenomenologicalOptions& options, const std::string& prefix, int scale);

    template <class D>
    struct Offset {
        typename D::Real x, y;  // in the stored unit, 63 pixels; right and down
    };

    template <class P>
    void fetch_accumulated(P& pixel) const {
        pixel.fetch_all(accumulated_, 1);
    }
    template <class P>
    void fetch_rest(P& pixel) const {
        pixel.fetch_all(beta_, 1);
        pixel.fetch_all(offset_, 1);
    }
    // Of D alone.
    template <class P>
    void fetch_diffusion(P& pixel) const {
        pixel.fetch_all(diffusion_, 1);
    }

    template <class P>
    Rgb<typename P::D> color(P& pixel) const {
        return pixel.load_rgb(accumulated_);
    }
    template <class P>
    auto net(P& pixel) const {
        return pixel.load(accumulated_, 0, 3);
    }
    template <class P>
    Rgb<typename P::D> beta(P& pixel) const {
        if (beta_.channels == 3) return pixel.load_rgb(beta_);
        const auto b = pixel.load(beta_);
        return {b, b, b};
    }
    bool has_diffusion() const { return has_diffusion_; }
    template <class P>
    auto diffusion(P& pixel) const {
        return pixel.load(diffusion_);
    }
    template <class P>
    Offset<typename P::D> offset(P& pixel) const {
        using Real = typename P::D::Real;
        const auto at = [&](int channel) { return pixel.load(offset_, 0, channel); };
        switch (offsets_) {
            case Offsets::kBiased:
                return {(at(0) - Real(bias_)) * Real(2.0f), (at(1) - Real(bias_)) * Real(2.0f)};
            case Offsets::kSplit:
                return {at(0) - at(2), at(1) - at(3)};
            case Offsets::kSigned:
                break;
        }
        return {at(0), at(1)};
    }

    // Blends what a surface, or an upsampled pixel, exports into fetched targets. `transmitted`: what is left
    // of beta, per channel.
    template <class D, class P>
    void blend(P& pixel, const std::array<typename D::Real, kMaxExports>& e, const Rgb<D>& transmitted,
               const SurfaceShader& shader) const {
        using Real = typename D::Real;
        const Rgb<D> sum = color(pixel);
        const Real weights = net(pixel);
        const Rgb<D> behind = beta(pixel);
        pixel.write(accumulated_);
        pixel.write(beta_);
        pixel.write(offset_);
        pixel.put_rgb(accumulated_, 0, {kept(sum.r + e[0]), kept(sum.g + e[1]), kept(sum.b + e[2])});
        pixel.put(accumulated_, 0, 3, kept(weights + e[surface_export::kNet]));
        if (has_diffusion_) {
            // The shader's last line, not the blend's.
            const Real d = raised(e[surface_export::kDiffusion], shader);
            // An infinite variance would weight every tap of a Gaussian by nothing.
            pixel.put(diffusion_, 0, 0, saturated(diffusion_, diffusion(pixel) + d));
        }
        if (beta_.channels == 3)
            pixel.put_rgb(beta_, 0,
                          {behind.r * transmitted.r, behind.g * transmitted.g, behind.b * transmitted.b});
        else
            pixel.put(beta_, 0, 0, behind.r * transmitted.r);
        add_offset<D>(pixel, e[surface_export::kOffset], e[surface_export::kOffset + 1]);
    }

 private:
    using Offsets = PhenomenologicalOptions::Offsets;

    // A target of 16 bits overflows to infinity, or stops.
    template <class Real>
    Real kept(const Real& sum) const {
        return saturates_ ? saturated(accumulated_, sum) : sum;
    }
    float raised(float d, const SurfaceShader& shader) const { return shader.raised(d, least_diffusion_); }
    Wire<float> raised(const Wire<float>& d, const SurfaceShader& shader) const {
        return {raised(d.value, shader), d.ready};
    }
    // A target without negative numbers clamps what the shader exports; that is a converter's work.
    static float positive(float value) { return value > 0.0f ? value : 0.0f; }
    static Wire<float> positive(const Wire<float>& value) { return {positive(value.value), value.ready}; }
    // A fixed-point target clamps what is blended before it blends. (Only here it shows: what the others add
    // has one sign.)
    float representable(float value) const {
        return offset_.format == Format::kSnorm8 ? std::clamp<float>(value, -1.0f, 1.0f) : value;
    }
    Wire<float> representable(const Wire<float>& value) const {
        return {representable(value.value), value.ready};
    }

    template <class D, class P>
    void add_offset(P& pixel, const typename D::Real& x, const typename D::Real& y) const {
        using Real = typename D::Real;
        const auto add = [&](int channel, const Real& value) {
            pixel.put(offset_, 0, channel, pixel.load(offset_, 0, channel) + value);
        };
        switch (offsets_) {
            case Offsets::kSigned:
                add(0, representable(x));
                add(1, representable(y));
                return;
            case Offsets::kBiased:
                add(0, positive(x * Real(0.5f)));
                add(1, positive(y * Real(0.5f)));
                return;
            case Offsets::kSplit:
                add(0, positive(x));
                add(1, positive(y));
                add(2, positive(negative(x)));
                add(3, positive(negative(y)));
        }
    }

    bool saturates_ = false;
    bool has_diffusion_ = false;
    Offsets offsets_ = Offsets::kSigned;
    float bias_ = 0;
    float least_diffusion_ = 0;  // the smallest code that is not 0
    Field accumulated_;
    Field beta_;
    Field diffusion_;
    Field offset_;
};

}  // namespace ropsim
