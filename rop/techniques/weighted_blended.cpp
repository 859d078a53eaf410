// Weighted blended order-independent transparency: McGuire and Bavoil 2013. Two fixed-function targets, one
// additive, one multiplicative; no order, no list. The weight of a fragment is a choice (rop/depth_weight.h).
// The target is binary16 and bright sums of large weights overflow it. overflow=white is what the authors'
// resolve does: an infinite sum of weights is replaced by the largest colour sum, and where a colour sum is
// infinite the colour is white. overflow=saturate stops the sums at 65504 instead.
#include "rop/depth_weight.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"

#include <algorithm>
#include <limits>
#include <string>

namespace ropsim {

class WeightedBlended {
 public:
    static constexpr TechniqueInfo kInfo = {
        "weighted_blended", "weighted blended OIT (McGuire and Bavoil 2013)",
        "weight=eq10|eq7|eq8|eq9|blog2015|learnopengl|none, overflow=white|saturate", false, ""};

    WeightedBlended(Parameters& parameters, const Screen& screen)
        : weight_(parameters.get_choice("weight", "eq10",
                                        {"eq7", "eq8", "eq9", "eq10", "blog2015", "learnopengl", "none"}),
                  parameters, screen),
          saturates_(parameters.get_choice("overflow", "white", {"white", "saturate"}) == "saturate") {
        const TechniqueFormats formats(parameters);
        accumulated_ = declaration_.surface(
            "accumulated_color", 1, Layout::kInterleaved, Initial::kClear,
            {FieldSpec::real(formats.of("color", Format::kFloat16), 4, 0.0f, ValueRange::kSum)})[0];
        revealage_ = declaration_.surface(
            "revealage", 1, Layout::kInterleaved, Initial::kClear,
            {FieldSpec::real(formats.of("revealage", Format::kUnorm8), 1, 1.0f, ValueRange::kUnit)})[0];
        declaration_.passes = {{"accumulate", Shading::kFull}};
        declaration_.paths = {"accumulate", "resolve"};
        declaration_.ordering = Ordering::kAny;
        declaration_.image_format = formats.image();
        declaration_.light = weight_.light_law(accumulated_.format);
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D&, int, const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        pixel.fetch_all(accumulated_, 1);
        pixel.fetch_all(revealage_, 1);
        const Real w = weight_.of<D>(f.z, f.a);
        const Rgb<D> sum = pixel.load_rgb(accumulated_);
        pixel.write(accumulated_);
        pixel.put_rgb(accumulated_, 0,
                      {bounded(sum.r + w * f.premultiplied.r), bounded(sum.g + w * f.premultiplied.g),
                       bounded(sum.b + w * f.premultiplied.b)});
        pixel.put(accumulated_, 0, 3, bounded(pixel.load(accumulated_, 0, 3) + w * f.a));
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
        const Real weights = pixel.load(accumulated_, 0, 3);
        const Real revealage = pixel.load(revealage_);
        const Real shown = Real(1.0f) - revealage;
        // Nor is the sum of two infinities of unlike sign finite: colours may be negative.
        const auto overflown = inverse(both(both(is_finite(sum.r), is_finite(sum.g)), is_finite(sum.b)));
        const Real divisor = select(is_finite(weights), weights, maximum(maximum(sum.r, sum.g), sum.b));
        // The floor keeps an empty pixel from dividing by zero; it is below any weight the clamp of equation
        // 10 allows for alpha of at least 0.4%.
        const Real scale = shown / maximum(divisor, Real(1e-7f));
        return {select(overflown, shown, sum.r * scale) + revealage * background.mean.r,
                select(overflown, shown, sum.g * scale) + revealage * background.mean.g,
                select(overflown, shown, sum.b * scale) + revealage * background.mean.b};
    }

 private:
    template <class R>
    static auto is_finite(const R& value) -> decltype(value < value) {
        return magnitude(value) <= R(std::numeric_limits<float>::max());
    }
    // A converter that saturates is no larger than one that does not.
    float bounded(float sum) const {
        const float most =
            accumulated_.format == Format::kFloat16 ? 65504.0f : std::numeric_limits<float>::max();
        return saturates_ ? std::clamp(sum, -most, most) : sum;
    }
    Wire<float> bounded(const Wire<float>& sum) const { return {bounded(sum.value), sum.ready}; }

    DepthWeight weight_;
    bool saturates_;
    Declaration declaration_;
    Field accumulated_;
    Field revealage_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(weighted_blended, WeightedBlended)
