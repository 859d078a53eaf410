// Alpha blending in arrival order: Porter and Duff 1984, "over", as every ROP does it today. The baseline:
// exact only when fragments arrive back to front. Blends into the opaque layer's own RGBA16F target.
#include "rop/technique.h"
#include "rop/technique_formats.h"

namespace ropsim {

class AlphaBlend {
 public:
    static constexpr TechniqueInfo kInfo = {
        "alpha_blend", "alpha blending in arrival order (Porter and Duff 1984)", "", true, ""};

    AlphaBlend(Parameters& parameters, const Screen&) {
        const TechniqueFormats formats(parameters);
        const Format format = formats.rgb("color", Format::kFloat16);
        color_ = declaration_.surface("color", 1, Layout::kInterleaved, Initial::kOpaqueTarget,
                                      {FieldSpec::real(format, 4, 1.0f)})[0];
        declaration_.passes = {{"blend", Shading::kFull}};
        declaration_.paths = {"blend"};
        declaration_.ordering = Ordering::kRaster;
        declaration_.resolves = false;
        declaration_.image_format = format;
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D&, int, const FragmentInput<D>& f, P& pixel) const {
        pixel.fetch_all(color_, 1);
        const auto t = typename D::Real(1.0f) - f.a;
        const Rgb<D> behind = pixel.load_rgb(color_);
        const auto behind_alpha = pixel.load(color_, 0, 3);
        pixel.write(color_);
        pixel.put_rgb(color_, 0,
                      {f.premultiplied.r + t * behind.r, f.premultiplied.g + t * behind.g,
                       f.premultiplied.b + t * behind.b});
        pixel.put(color_, 0, 3, f.a + t * behind_alpha);
        return 0;
    }

    // Nothing to resolve: the image is the target itself (declaration: resolves = false).
    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>&, P& pixel, int&) const {
        pixel.fetch_all(color_, 1);
        return pixel.load_rgb(color_);
    }

 private:
    Declaration declaration_;
    Field color_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(alpha_blend, AlphaBlend)
