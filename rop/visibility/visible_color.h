// The colour of fragments weighted by the visibility that a map gives them: equation 2 of Salvi et al. 2011,
// for each spatial sample, and what resolve makes of it.
#pragma once

#include "rop/technique.h"
#include "rop/technique_formats.h"
#include "rop/visibility/map_options.h"
#include "rop/visibility/storable.h"

#include <array>

namespace ropsim {

// The sums of one sample: sum of alpha c vis, sum of alpha vis, product of 1 - alpha.
template <class D>
struct VisibleSum {
    Rgb<D> color{0.0f, 0.0f, 0.0f};
    typename D::Real weight = 0.0f;
    typename D::Real transmittance = 1.0f;
};

class VisibleColor {
 public:
    VisibleColor() = default;
    // Declares RGBA16F "accumulated_color", whose alpha multiplies while its colour adds, as separate blend
    // functions do it; where the sums are normalised its alpha sums weights and the product is in
    // "transmittance".
    VisibleColor(Declaration& declaration, const TechniqueFormats& formats, const MapOptions& options)
        : samples_(options.spatial_samples),
          normalised_(options.normalised),
          image_(declaration.image_format) {
        if (options.memory == MapMemory::kVariable) return;
        const Format format = formats.of("color", Format::kFloat16);
        const Layout layout = Layout::kInterleaved;
        if (normalised_) {
            color_ = declaration.surface("accumulated_color", samples_, layout, Initial::kClear,
                                         {FieldSpec::real(format, 4, 0.0f, ValueRange::kSum)})[0];
            transmittance_ =
                declaration.surface("transmittance", samples_, layout, Initial::kClear,
                                    {FieldSpec::real(formats.of("transmittance", Format::kUnorm16), 1, 1.0f,
                                                     ValueRange::kUnit)})[0];
            return;
        }
        const auto fields = declaration.surface("accumulated_color", samples_, layout, Initial::kClear,
                                                {FieldSpec::real(format, 3, 0.0f, ValueRange::kSum),
                                                 FieldSpec::real(format, 1, 1.0f, ValueRange::kUnit)});
        color_ = fields[0];
        transmittance_ = fields[1];
    }

    template <class D, class P>
    void fetch(const FragmentInput<D>& f, P& pixel) const {
        for (int m = 0; m < samples_; ++m) {
            pixel.fetch_if(bit(f.coverage, m), color_, m);
            if (normalised_) pixel.fetch_if(bit(f.coverage, m), transmittance_, m);
        }
    }
    // Adds the fragment to sample m, where it covers that.
    template <class D, class P>
    void add(const FragmentInput<D>& f, P& pixel, int m, const typename D::Real& visibility) const {
        const typename D::Bool covered = bit(f.coverage, m);
        const VisibleSum<D> sum = added<D>(load<D>(pixel, m), f.premultiplied, f.a, visibility, normalised_);
        pixel.write_if(covered, color_, m);
        pixel.put_rgb_if(
            covered, color_, m,
            {storable_signed(color_.format, sum.color.r), storable_signed(color_.format, sum.color.g),
             storable_signed(color_.format, sum.color.b)});
        if (normalised_) {
            pixel.put_if(covered, color_, m, 3, storable(color_.format, sum.weight));
            pixel.write_if(covered, transmittance_, m);
        }
        pixel.put_if(covered, transmittance_, m, 0, sum.transmittance);
    }
    template <class D>
    static VisibleSum<D> added(const VisibleSum<D>& sum, const Rgb<D>& premultiplied,
                               const typename D::Real& alpha, const typename D::Real& visibility,
                               bool weights) {
        using Real = typename D::Real;
        return {{sum.color.r + visibility * premultiplied.r, sum.color.g + visibility * premultiplied.g,
                 sum.color.b + visibility * premultiplied.b},
                weights ? sum.weight + visibility * alpha : Real(0.0f),
                sum.transmittance * (Real(1.0f) - alpha)};
    }

    template <class P>
    void fetch_all(P& pixel) const {
        pixel.fetch_all(color_, samples_);
        if (normalised_) pixel.fetch_all(transmittance_, samples_);
    }
    template <class D, class P>
    VisibleSum<D> load(P& pixel, int m) const {
        return {pixel.load_rgb(color_, m), normalised_ ? pixel.load(color_, m, 3) : typename D::Real(0.0f),
                pixel.load(transmittance_, m)};
    }
    // The pixel's colour from the sums of its samples: the mean of each in front of its background.
    template <class D>
    Rgb<D> resolved(const Background<D>& background,
                    std::array<VisibleSum<D>, kMaxSpatialSamples>& sums) const {
        using Real = typename D::Real;
        std::array<Rgb<D>, kMaxSpatialSamples> color;
        for (int m = 0; m < samples_; ++m) {
            const auto k = static_cast<std::size_t>(m);
            color[k] = over_background<D>(sums[k], samples_ == 1 ? background.mean : background.sample[k]);
        }
        for (std::size_t stride = 1; stride < static_cast<std::size_t>(samples_); stride *= 2)
            for (std::size_t m = 0; m + stride < static_cast<std::size_t>(samples_); m += 2 * stride)
                color[m] = {color[m].r + color[m + stride].r, color[m].g + color[m + stride].g,
                            color[m].b + color[m + stride].b};
        if (samples_ > 1) {
            const Real share(1.0f / static_cast<float>(samples_));
            color[0] = {color[0].r * share, color[0].g * share, color[0].b * share};
        }
        return {storable_signed(image_, color[0].r), storable_signed(image_, color[0].g),
                storable_signed(image_, color[0].b)};
    }

 private:
    template <class D>
    Rgb<D> over_background(const VisibleSum<D>& sum, const Rgb<D>& background) const {
        using Real = typename D::Real;
        const Real t = sum.transmittance;
        Rgb<D> color = sum.color;
        if (normalised_) {
            // Weights that add up to nothing: light without alpha stays as it is.
            const Real exact = Real(1.0f) - t;
            const auto some = Real(kLeastWeight) <= sum.weight;
            const Real scale = select(some, exact / select(some, sum.weight, Real(1.0f)), Real(1.0f));
            color = {color.r * scale, color.g * scale, color.b * scale};
        }
        return {color.r + t * background.r, color.g + t * background.g, color.b + t * background.b};
    }
    // The least normal number of binary16: below it a quotient is rounding alone.
    static constexpr float kLeastWeight = 0x1p-14f;

    int samples_ = 1;
    bool normalised_ = false;
    Format image_ = Format::kFloat16;
    Field color_;
    Field transmittance_;
};

}  // namespace ropsim
