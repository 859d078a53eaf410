// Weighted blended order-independent transparency: McGuire and Bavoil 2013. Two fixed-function targets, one
// additive, one multiplicative; no order, no list. The weight of a fragment is a choice:
//   eq7, eq8, eq9  the paper's, by distance |z| from the eye (known from public code that names them so:
//                  VisPy's and nvpro's). In metres here, by the camera of the trace; the paper tunes them for
//                  scenes of 0.1 to 500 units and names no unit
//   eq10           the paper's, by window depth (public code likewise)
//   blog2015       McGuire's article of March 2015 on implementing it, without the optional division by
//                  sqrt(|z|), as copies of that code with its comments have it: a factor of 1000 and a cap of
//                  300. As many copies have 10^8, which sits at the cap nearly everywhere
//   learnopengl    the tutorial's, the one most copied. For alpha above 0.031 it is 3000 at every depth
//   none           no depth: equations 5 and 6
// The target is binary16 and bright sums of large weights overflow it. overflow=white is what the authors'
// resolve does: an infinite sum of weights is replaced by the largest colour sum, and where a colour sum is
// infinite the colour is white. overflow=saturate stops the sums at 65504 instead.
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
        : weight_(read_weight(parameters)),
          saturates_(parameters.get_choice("overflow", "white", {"white", "saturate"}) == "saturate") {
        if (weight_ == Weight::kEq7 || weight_ == Weight::kEq8 || weight_ == Weight::kEq9)
            read_camera(parameters, screen);
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
        const Real w = weight<D>(f);
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
    enum class Weight : std::uint8_t { kEq7, kEq8, kEq9, kEq10, kBlog2015, kLearnOpenGl, kNone };

    static Weight read_weight(Parameters& parameters) {
        const std::string name = parameters.get_choice(
            "weight", "eq10", {"eq7", "eq8", "eq9", "eq10", "blog2015", "learnopengl", "none"});
        if (name == "eq7") return Weight::kEq7;
        if (name == "eq8") return Weight::kEq8;
        if (name == "eq9") return Weight::kEq9;
        if (name == "blog2015") return Weight::kBlog2015;
        if (name == "learnopengl") return Weight::kLearnOpenGl;
        return name == "none" ? Weight::kNone : Weight::kEq10;
    }

    // Distance from the eye as a function of window depth d: the view's z is a quotient of two polynomials of
    // first degree, of which the numerator (perspective) or the denominator (parallel) is constant.
    void read_camera(Parameters& parameters, const Screen& screen) {
        if (!screen.camera)
            throw UserError(parameters.where("weight"),
                            "this weight goes by the distance from the eye and the trace has no camera; use "
                            "weight=eq10, blog2015, learnopengl or none");
        const glm::mat4& p = screen.camera->projection;
        const double metres = screen.camera->metres_per_unit;
        // z_clip = p22 z + p32 and w_clip = p23 z + p33, first index the column; z_clip / w_clip = 2 d - 1.
        const double p22 = p[2][2], p23 = p[2][3], p32 = p[3][2], p33 = p[3][3];
        const bool oblique = p[0][2] != 0 || p[1][2] != 0 || p[0][3] != 0 || p[1][3] != 0;
        perspective_ = p33 == 0;
        const double divisor = perspective_ ? p32 * metres : p22 / metres;
        if (oblique || (!perspective_ && p23 != 0) || divisor == 0)
            throw UserError(
                parameters.where("weight"),
                "the distance from the eye cannot be told from depth with the trace's projection; "
                "use weight=eq10, blog2015, learnopengl or none");
        // Perspective: 1 / |z| = |offset + slope d|; parallel: |z| = |offset + slope d|.
        offset_ = static_cast<float>(perspective_ ? (-p23 - p22) / divisor : (-p33 - p32) / divisor);
        slope_ = static_cast<float>(perspective_ ? 2 * p23 / divisor : 2 * p33 / divisor);
    }

    template <class D>
    typename D::Real weight(const FragmentInput<D>& f) const {
        using Real = typename D::Real;
        switch (weight_) {
            case Weight::kEq7: {
                const Real z2 = square_of_distance<D>(f);
                return f.a *
                       clamped<D>(Real(10.0f) / (Real(1e-5f) + z2 * Real(1.0f / 25) + sixth_power<D>(z2)),
                                  3e3f);
            }
            case Weight::kEq8: {
                const Real z = distance<D>(f);
                const Real z2 = z * z;
                return f.a *
                       clamped<D>(Real(10.0f) / (Real(1e-5f) + z2 * (z * Real(1e-3f)) + sixth_power<D>(z2)),
                                  3e3f);
            }
            case Weight::kEq9: {
                const Real q = square_of_distance<D>(f) * Real(1.0f / 40000);
                return f.a * clamped<D>(Real(0.03f) / (Real(1e-5f) + q * q), 3e3f);
            }
            case Weight::kEq10:
                return f.a * maximum(Real(0.01f), Real(3000.0f) * cube<D>(Real(1.0f) - f.z));
            case Weight::kBlog2015:
                return clamped<D>(
                    Real(1e3f) * cube<D>((f.a * Real(8.0f) + Real(0.01f)) * (Real(1.0f) - f.z * Real(0.95f))),
                    3e2f);
            case Weight::kLearnOpenGl:
                return clamped<D>(
                    Real(1e8f) * (cube<D>(minimum(Real(1.0f), f.a * Real(10.0f)) + Real(0.01f)) *
                                  cube<D>(Real(1.0f) - f.z * Real(0.9f))),
                    3e3f);
            case Weight::kNone:
                return Real(1.0f);
        }
        return Real(1.0f);
    }
    template <class D>
    typename D::Real distance(const FragmentInput<D>& f) const {
        using Real = typename D::Real;
        const Real linear = Real(offset_) + Real(slope_) * f.z;
        return magnitude(perspective_ ? Real(1.0f) / linear : linear);
    }
    template <class D>
    typename D::Real square_of_distance(const FragmentInput<D>& f) const {
        const auto z = distance<D>(f);
        return z * z;
    }
    // (|z| / 200)^6 of |z|^2.
    template <class D>
    static typename D::Real sixth_power(const typename D::Real& z2) {
        return cube<D>(z2 * typename D::Real(1.0f / 40000));
    }
    template <class D>
    static typename D::Real cube(const typename D::Real& x) {
        return x * x * x;
    }
    template <class D>
    static typename D::Real clamped(const typename D::Real& w, float most) {
        using Real = typename D::Real;
        return minimum(maximum(Real(0.01f), w), Real(most));
    }

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

    Weight weight_;
    bool saturates_;
    bool perspective_ = false;
    float offset_ = 0;
    float slope_ = 0;
    Declaration declaration_;
    Field accumulated_;
    Field revealage_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(weighted_blended, WeightedBlended)
