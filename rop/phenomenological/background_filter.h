// What of the opaque layer is seen through the transparent ones: displaced, and blurred by a gather whose
// radius each pixel has for itself. McGuire and Mara 2017, sections 5.0.2 and 5.0.3 and Listing 3.
//
// gather=strided is the listing's: taps 2 pixels apart within its standard deviation, 16 pixels at most, each
// weighted by the deviation of its own pixel; filter=gaussian its second formula, a Gaussian of twice that
// deviation cut off at one, which hardly differs from the disk. gather=exact takes every pixel: of the disk
// out to one deviation, of a true Gaussian out to three, up to max_radius. (The prose masks what is nearer
// than the smaller of the two deviations, the listing what is farther; only the latter shows anything.)
// Where displacement leads to a pixel that does not diffuse, the listing divides infinity by infinity; here a
// tap's deviation is half a pixel at least.
#pragma once

#include "rop/phenomenological/framebuffer_targets.h"
#include "rop/phenomenological/options.h"
#include "rop/transcendental.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace ropsim {

class BackgroundFilter {
 public:
    BackgroundFilter() = default;
    BackgroundFilter(const PhenomenologicalOptions& options, const Screen& screen)
        : gaussian_(options.gaussian),
          exact_(options.exact_gather),
          max_radius_(options.max_radius),
          adds_deviations_(options.adds_deviations),
          pixels_at_one_(options.listing_decoding ? kListingPixels : SurfaceShader::kPixelsAtOne),
          offset_x_(options.listing_decoding ? kListingScreen * static_cast<float>(screen.width)
                                             : SurfaceShader::kPixelsAtOne),
          offset_y_(options.listing_decoding ? kListingScreen * static_cast<float>(screen.height)
                                             : SurfaceShader::kPixelsAtOne) {}

    // Taps of the widest kernel.
    int most_taps() const { return (2 * (max_radius_ / stride()) + 1) * (2 * (max_radius_ / stride()) + 1); }

    // Variance in square pixels of a stored D.
    template <class Real>
    Real variance(const Real& stored) const {
        if (!adds_deviations_) return stored * Real(pixels_at_one_ * pixels_at_one_);
        const Real deviation = stored * Real(pixels_at_one_);
        return deviation * deviation;
    }
    template <class D>
    typename FramebufferTargets::Offset<D> pixels(const FramebufferTargets::Offset<D>& stored) const {
        using Real = typename D::Real;
        return {stored.x * Real(offset_x_), stored.y * Real(offset_y_)};
    }

    // Bilinear at a displacement from the pixel's centre; past the image's border, the border.
    template <class D, class P>
    static Rgb<D> displaced(Gather<P>& gather, const FramebufferTargets::Offset<D>& offset) {
        using Real = typename D::Real;
        const auto split = [](const Real& at, int from, int size) {
            // Beyond the image nothing changes any more; an integer has to hold it.
            const float value = std::clamp(value_of(at), -kWidestImage, kWidestImage);
            const float whole = std::floor(value);
            Axis<Real> axis;
            axis.low = std::clamp(from + static_cast<int>(whole), 0, size - 1);
            axis.high = std::clamp(from + static_cast<int>(whole) + 1, 0, size - 1);
            axis.part = value - whole;
            if constexpr (D::kCharged) {
                axis.part.ready = Ledger::active().charge(Unit::kIntegerAdder, at.ready);
                axis.part.ready = Ledger::active().charge(Unit::kAdder, axis.part.ready);
            }
            return axis;
        };
        const Axis<Real> x = split(offset.x, gather.x(), gather.width());
        const Axis<Real> y = split(offset.y, gather.y(), gather.height());
        const Rgb<D> top =
            mixed<D>(gather.background(x.low, y.low), gather.background(x.high, y.low), x.part);
        const Rgb<D> bottom =
            mixed<D>(gather.background(x.low, y.high), gather.background(x.high, y.high), x.part);
        return mixed<D>(top, bottom, y.part);
    }

    // Gathered around the displaced place, `variance` being the pixel's own. Takes steps of kind 0, taps
    // whose deviation is looked at, and 1, taps that count.
    template <class D, class P>
    Rgb<D> diffused(D& d, Gather<P>& gather, const FramebufferTargets& targets, float variance,
                    float offset_x, float offset_y) const {
        using Real = typename D::Real;
        const int x = std::clamp(gather.x() + whole(offset_x), 0, gather.width() - 1);
        const int y = std::clamp(gather.y() + whole(offset_y), 0, gather.height() - 1);
        const Kernel kernel = kernel_of(variance);
        thread_local std::vector<Tap> taps;
        taps.clear();
        for (int v = -kernel.radius; v <= kernel.radius; v += stride())
            for (int u = -kernel.radius; u <= kernel.radius; u += stride())
                if (static_cast<float>(u * u + v * v) <= kernel.reach * variance)
                    taps.push_back({u, v, 0, false});
        d.steps(kLook, static_cast<std::uint32_t>(taps.size()), [&](std::uint32_t i) {
            Tap& tap = taps[i];
            P at = gather.at(std::clamp(x + tap.u, 0, gather.width() - 1),
                             std::clamp(y + tap.v, 0, gather.height() - 1));
            targets.fetch_diffusion(at);
            const Real own = this->variance<Real>(targets.diffusion(at));
            const auto counts =
                Real(static_cast<float>(tap.u * tap.u + tap.v * tap.v)) <= own * Real(kernel.reach);
            tap.variance = value_of(own);
            tap.counts = value_of(counts);
        });
        const auto seen = std::remove_if(taps.begin(), taps.end(), [](const Tap& t) { return !t.counts; });
        // The pixel in the middle always counts: its distance is 0.
        const auto count = static_cast<std::uint32_t>(seen - taps.begin());
        std::array<float, 4> sum{};
        d.steps(kBlend, count, [&](std::uint32_t i) {
            const Tap& tap = taps[i];
            const Rgb<D> c = gather.background(std::clamp(x + tap.u, 0, gather.width() - 1),
                                               std::clamp(y + tap.v, 0, gather.height() - 1));
            const Real w = weight<Real>(tap);
            sum = {value_of(Real(sum[0]) + w * from_start<Real>(c.r)),
                   value_of(Real(sum[1]) + w * from_start<Real>(c.g)),
                   value_of(Real(sum[2]) + w * from_start<Real>(c.b)), value_of(Real(sum[3]) + w)};
        });
        const Real total(sum[3]);
        return {Real(sum[0]) / total, Real(sum[1]) / total, Real(sum[2]) / total};
    }

 private:
    static constexpr float kListingPixels = 200;  // PPD
    static constexpr float kListingScreen = 0.375f;
    static constexpr float kWidestImage = 16384;  // of a trace
    static constexpr int kLook = 0;
    static constexpr int kBlend = 1;

    template <class Real>
    struct Axis {
        int low = 0, high = 0;
        Real part{};
    };
    struct Tap {
        int u, v;
        float variance;
        bool counts;
    };
    struct Kernel {
        int radius;
        float reach;  // squared, in deviations
    };

    int stride() const { return exact_ ? 1 : 2; }
    Kernel kernel_of(float variance) const {
        const float reach = exact_ && gaussian_ ? 9.0f : 1.0f;
        const float radius = std::min(std::sqrt(reach * variance), static_cast<float>(max_radius_));
        return {static_cast<int>(radius / static_cast<float>(stride())) * stride(), reach};
    }
    // Towards zero, as a conversion to an integer goes.
    static int whole(float offset) {
        return static_cast<int>(std::clamp(offset, -kWidestImage, kWidestImage));
    }

    template <class Real>
    static Real from_start(const Real& value) {
        return Real(value_of(value));
    }
    template <class Real>
    Real weight(const Tap& tap) const {
        const Real variance = maximum(Real(tap.variance), Real(kLeastVariance));
        const Real inverse = Real(1.0f) / variance;
        if (!gaussian_) return inverse + Real(1e-5f);
        const auto distance = static_cast<float>(tap.u * tap.u + tap.v * tap.v);
        if (exact_) return exponential(Real(-0.5f * distance) * inverse) * inverse;
        // The listing divides by a deviation, not by a variance.
        return exponential(Real(-0.125f * distance) * inverse) / square_root(variance);
    }
    template <class D>
    static Rgb<D> mixed(const Rgb<D>& a, const Rgb<D>& b, const typename D::Real& part) {
        return {a.r + part * (b.r - a.r), a.g + part * (b.g - a.g), a.b + part * (b.b - a.b)};
    }

    static constexpr float kLeastVariance = 0.25f;  // square pixels
    bool gaussian_ = false;
    bool exact_ = false;
    int max_radius_ = 16;
    bool adds_deviations_ = false;
    float pixels_at_one_ = SurfaceShader::kPixelsAtOne;
    float offset_x_ = SurfaceShader::kPixelsAtOne;
    float offset_y_ = SurfaceShader::kPixelsAtOne;
};

}  // namespace ropsim
