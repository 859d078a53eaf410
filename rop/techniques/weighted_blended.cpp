// Weighted blended order-independent transparency: McGuire and Bavoil 2013, with the depth weight of their
// equation
// 10. Two fixed-function targets, additive and multiplicative; no order, no list.
#include "rop/technique.h"
#include "rop/technique_formats.h"

namespace ropsim {

class WeightedBlended {
 public:
    static constexpr TechniqueInfo kInfo = {"weighted_blended",
                                            "weighted blended OIT (McGuire and Bavoil 2013)", "", false, ""};

    WeightedBlended(Parameters& parameters, const Screen&) {
        const TechniqueFormats formats(parameters);
        accumulated_ =
            declaration_.surface("accumulated_color", 1, Layout::kInterleaved, Initial::kClear,
                                 {FieldSpec::real(formats.of("color", Format::kFloat16), 4, 0.0f)})[0];
        revealage_ =
            declaration_.surface("revealage", 1, Layout::kInterleaved, Initial::kClear,
                                 {FieldSpec::real(formats.of("revealage", Format::kUnorm8), 1, 1.0f)})[0];
        declaration_.passes = {{"accumulate", Shading::kFull}};
        declaration_.paths = {"accumulate", "resolve"};
        declaration_.ordering = Ordering::kAny;
        declaration_.image_format = formats.image();
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D&, int, const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        pixel.fetch_all(accumulated_, 1);
        pixel.fetch_all(revealage_, 1);
        const Real nearness = Real(1.0f) - f.z;
        const Real cube = nearness * nearness * nearness;
        const Real weight = f.a * maximum(Real(0.01f), Real(3000.0f) * cube);
        const Rgb<D> sum = pixel.load_rgb(accumulated_);
        pixel.write(accumulated_);
        pixel.put_rgb(accumulated_, 0,
                      {sum.r + weight * f.premultiplied.r, sum.g + weight * f.premultiplied.g,
                       sum.b + weight * f.premultiplied.b});
        pixel.put(accumulated_, 0, 3, pixel.load(accumulated_, 0, 3) + weight * f.a);
        pixel.write(revealage_);
        pixel.put(revealage_, 0, 0, pixel.load(revealage_) * (Real(1.0f) - f.a));
        return 0;
    }

    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>& background, P& pixel, int& path) const {
        using Real = typename D::Real;
        path = 1;
        pixel.fetch_all(accumulated_, 1);
        pixel.fetch_all(revealage_, 1);
        const Rgb<D> sum = pixel.load_rgb(accumulated_);
        const Real revealage = pixel.load(revealage_);
        // The floor keeps an empty pixel from dividing by zero; it is below any weight the clamp of equation
        // 10 allows for alpha of at least 0.4%.
        const Real scale = (Real(1.0f) - revealage) / maximum(pixel.load(accumulated_, 0, 3), Real(1e-7f));
        return {sum.r * scale + revealage * background.mean.r, sum.g * scale + revealage * background.mean.g,
                sum.b * scale + revealage * background.mean.b};
    }

 private:
    Declaration declaration_;
    Field accumulated_;
    Field revealage_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(weighted_blended, WeightedBlended)
