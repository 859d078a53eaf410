// Alpha blending in arrival order: Porter and Duff 1984, "over", as every ROP does it today. The baseline:
// exact only when fragments arrive back to front. Blends into the opaque layer's own RGBA16F target. With M
// spatial samples each sample that is covered is blended, and resolve takes their mean, as multisampled
// targets do.
#include "rop/sample_mean.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"

namespace ropsim {

class AlphaBlend {
 public:
    static constexpr TechniqueInfo kInfo = {
        "alpha_blend", "alpha blending in arrival order (Porter and Duff 1984)", "", true, ""};

    AlphaBlend(Parameters& parameters, const Screen& screen) : samples_(screen.samples) {
        const TechniqueFormats formats(parameters);
        const Format format = formats.rgb("color", Format::kFloat16);
        const bool multisampled = samples_ > 1;
        color_ = declaration_.surface(
            "color", samples_, multisampled ? Layout::kPlanar : Layout::kInterleaved, Initial::kOpaqueTarget,
            {FieldSpec::real(format, 4, 1.0f, ValueRange::kColor)})[0];
        declaration_.passes = {{"blend", Shading::kFull}};
        declaration_.paths = {"blend"};
        if (multisampled) declaration_.paths.emplace_back("resolve");
        declaration_.ordering = Ordering::kRaster;
        declaration_.uses_coverage = true;
        declaration_.resolves = multisampled;
        declaration_.resolve_reads_background = false;
        declaration_.image_format = format;
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D&, int, const FragmentInput<D>& f, P& pixel) const {
        const auto t = typename D::Real(1.0f) - f.a;
        if (samples_ > 1) {
            blend_samples<D>(f, t, pixel);
            return kBlend;
        }
        pixel.fetch_all(color_, 1);
        const Rgb<D> behind = pixel.load_rgb(color_);
        const auto behind_alpha = pixel.load(color_, 0, 3);
        pixel.write(color_);
        pixel.put_rgb(color_, 0,
                      {f.premultiplied.r + t * behind.r, f.premultiplied.g + t * behind.g,
                       f.premultiplied.b + t * behind.b});
        pixel.put(color_, 0, 3, f.a + t * behind_alpha);
        return kBlend;
    }

    // One sample: nothing to resolve, the image is the target itself (declaration: resolves = false).
    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>&, P& pixel, int& path) const {
        pixel.fetch_all(color_, samples_);
        if (samples_ == 1) return pixel.load_rgb(color_);
        path = kResolve;
        return mean_of_samples<D>(pixel, color_, samples_);
    }

 private:
    enum Path { kBlend, kResolve };

    template <class D, class P>
    void blend_samples(const FragmentInput<D>& f, const typename D::Real& t, P& pixel) const {
        for (int m = 0; m < samples_; ++m) pixel.fetch_if(bit(f.coverage, m), color_, m);
        for (int m = 0; m < samples_; ++m) {
            const auto covered = bit(f.coverage, m);
            const Rgb<D> behind = pixel.load_rgb(color_, m);
            const auto behind_alpha = pixel.load(color_, m, 3);
            pixel.write_if(covered, color_, m);
            pixel.put_rgb_if(covered, color_, m,
                             {f.premultiplied.r + t * behind.r, f.premultiplied.g + t * behind.g,
                              f.premultiplied.b + t * behind.b});
            pixel.put_if(covered, color_, m, 3, f.a + t * behind_alpha);
        }
    }

    int samples_;
    Declaration declaration_;
    Field color_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(alpha_blend, AlphaBlend)
