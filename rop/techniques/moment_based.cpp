// Moment-based order-independent transparency: Muenstermann, Krumpen, Klein and Peters 2018. Pass 1 adds a
// fragment's absorbance A = -ln(1 - alpha) and its moments over depth, pass 2 takes the transmittance in
// front of each fragment from them (rop/visibility/) and accumulates, resolve scales the sum to the pixel's
// total alpha. The paper is known here by its abstract, its public shaders and Neuhauser's port of them.
// Decided here:
// - guard=mended, the default, reconstructs from power moments so that no rounding can fail.
//   guard=published keeps the arithmetic of the paper's shaders, which loses one in six pixels of a single
//   fragment. Trigonometric moments have one form.
// - A is at most 10, as in the port (the paper's additive pass has infinity at alpha 1). A pixel that reaches
//   it is opaque.
// - Bias: for float32 the port's, for 16 bits a tenth of it, as its comments have it.
// - moment_format=unorm16 keeps the sum of absorbance in float16: the paper counts 112 bits for 6 moments.
// - warp=log maps distances between `near` and `far` to [-1, 1]; by default the camera's planes.
// - The paper's shaders skip a pixel whose absorbance is below 0.001; only guard=published does.
// - guard=mended keeps transmittances at 2^-20 or more (e^-64 with colour in float32): four moments hide
//   dozens of nearly opaque fragments from one another, and sums that underflow scale to black or infinity.
#include "rop/accumulated_color.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"
#include "rop/visibility/depth_warp.h"
#include "rop/visibility/moment_bias.h"
#include "rop/visibility/moment_quantisation.h"
#include "rop/visibility/power_moments.h"
#include "rop/visibility/published_moments.h"
#include "rop/visibility/trigonometric_moments.h"

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <type_traits>

namespace ropsim {

class MomentBased {
 public:
    static constexpr TechniqueInfo kInfo = {
        "moment_based", "moment-based OIT (Muenstermann et al. 2018)",
        "moments=4|6|8, basis=power|trigonometric, moment_format=float32|unorm16, guard=mended|published, "
        "warp=log|linear|depth, near=NUMBER, far=NUMBER, overestimation=.25 (0..1), bias=NUMBER (0..0.5; "
        "default by moments), "
        "absorbance_limit=10 (1..16)",
        false, ""};

    MomentBased(Parameters& parameters, const Screen& screen) : warp_(parameters, screen, "log") {
        const std::string moments = parameters.get_choice("moments", "4", {"4", "6", "8"});
        order_ = (moments[0] - '0') / 2;
        trigonometric_ =
            parameters.get_choice("basis", "power", {"power", "trigonometric"}) == "trigonometric";
        quantised_ = parameters.get_choice("moment_format", "float32", {"float32", "unorm16"}) == "unorm16";
        published_ = parameters.get_choice("guard", "mended", {"mended", "published"}) == "published";
        if (published_ && trigonometric_)
            throw UserError(parameters.where("guard"),
                            "guard=published is the paper's arithmetic for power moments, which fails; "
                            "trigonometric moments have no such form: leave guard out or use basis=power");
        choose_bias(parameters);
        limit_ = static_cast<float>(parameters.get_real("absorbance_limit", 10.0, 1.0, 16.0));
        declare(parameters);
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D&, int pass, const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        pixel.fetch_all(total_, 1);
        pixel.fetch_all(moments_, 1);
        if (pass == 0) {
            with_order([&](auto order) { accumulate_moments<order.value, D>(f, pixel); });
            return kMoments;
        }
        pixel.fetch_all(color_, 1);
        const Real weight = transmittance<D>(f.z, pixel);
        accumulate_rgb<D>(pixel, color_, weight, f.premultiplied);
        pixel.put(color_, 0, 3, saturated(color_, pixel.load(color_, 0, 3) + weight * f.a));
        return kComposite;
    }

    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>& background, P& pixel, int& path) const {
        using Real = typename D::Real;
        path = kResolve;
        pixel.fetch_all(total_, 1);
        pixel.fetch_all(color_, 1);
        const Real absorbance = pixel.load(total_);
        const Rgb<D> sum = pixel.load_rgb(color_);
        const Real alpha = pixel.load(color_, 0, 3);
        const Real left =
            select(absorbance < Real(stored_limit_), exponential(negative(absorbance)), Real(0.0f));
        // What the shaders discard has left no alpha either. One over less than a normal number is infinite.
        const auto some = Real(std::numeric_limits<float>::min()) <= alpha;
        const Real scale = select(some, (Real(1.0f) - left) / select(some, alpha, Real(1.0f)), Real(0.0f));
        const auto skipped = absorbance < Real(least_absorbance_);
        const Real through = published_ ? select(skipped, Real(1.0f), left) : left;
        return {sum.r * scale + through * background.mean.r, sum.g * scale + through * background.mean.g,
                sum.b * scale + through * background.mean.b};
    }

    void visibility(PlainPixel& pixel, std::span<const float> depths, std::span<float> values) const {
        for (std::size_t i = 0; i < depths.size(); ++i)
            values[i] = transmittance<PlainDatapath>(depths[i], pixel);
    }

 private:
    enum Path { kMoments, kComposite, kResolve };

    void choose_bias(Parameters& parameters);
    void declare(Parameters& parameters);

    // Calls body with the order as a constant.
    template <class Body>
    auto with_order(Body body) const {
        switch (order_) {
            case 2:
                return body(std::integral_constant<int, 2>());
            case 3:
                return body(std::integral_constant<int, 3>());
            default:
                return body(std::integral_constant<int, 4>());
        }
    }

    template <class Real>
    Real absorbance_of(const Real& alpha) const {
        const Real absorbance = negative(natural_log(Real(1.0f) - alpha));
        return maximum(minimum(absorbance, Real(limit_)), Real(0.0f));
    }
    template <class Real>
    Real parameter(const Real& z) const {
        return Real(2.0f) * warp_(z) - Real(1.0f);
    }

    // z, z^2, ... or the powers of the point on the circle, real and imaginary part by turns. Each from two
    // of about half the power: no chain.
    template <int kOrder, class Real>
    PowerMoments<kOrder, Real> powers(const Real& z) const {
        PowerMoments<kOrder, Real> b;
        if (!trigonometric_) {
            b[0] = z;
            for (std::size_t k = 2; k <= b.size(); ++k) b[k - 1] = b[k / 2 - 1] * b[k - k / 2 - 1];
            return b;
        }
        std::array<Complex<Real>, kOrder> p;
        p[0] = circle_point(z);
        for (std::size_t k = 2; k <= kOrder; ++k) p[k - 1] = p[k / 2 - 1] * p[k - k / 2 - 1];
        for (std::size_t k = 0; k < kOrder; ++k) {
            b[2 * k] = p[k].re;
            b[2 * k + 1] = p[k].im;
        }
        return b;
    }

    template <int kOrder, class D, class P>
    PowerMoments<kOrder, typename D::Real> load_moments(P& pixel) const {
        PowerMoments<kOrder, typename D::Real> b;
        for (std::size_t k = 0; k < b.size(); ++k) b[k] = pixel.load(moments_, 0, static_cast<int>(k));
        return b;
    }

    template <int kOrder, class D, class P>
    void accumulate_moments(const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        const Real absorbance = absorbance_of<Real>(f.a);
        PowerMoments<kOrder, Real> added = powers<kOrder, Real>(parameter<Real>(f.z));
        const Real before = pixel.load(total_);
        const auto stored = load_moments<kOrder, D>(pixel);
        pixel.write(total_);
        pixel.put(total_, 0, 0, minimum(before + absorbance, Real(kMostAbsorbance)));
        pixel.write(moments_);
        if (!quantised_) {
            for (std::size_t k = 0; k < stored.size(); ++k)
                pixel.put(moments_, 0, static_cast<int>(k), stored[k] + absorbance * added[k]);
            return;
        }
        // Both shares of the new sum; without any absorbance, what is stored stays.
        const auto some = Real(0.0f) < absorbance;
        const Real inverse = Real(1.0f) / select(some, before + absorbance, Real(1.0f));
        const Real old_share = select(some, before * inverse, Real(1.0f));
        const Real new_share = absorbance * inverse;
        if (!trigonometric_) added = quantiser_->template mapped<kOrder, Real>(added);
        for (std::size_t k = 0; k < stored.size(); ++k) {
            const Real offset = Real(trigonometric_ ? 0.5f : quantiser_->offset()[k]);
            const Real term = trigonometric_ ? Real(0.5f) * added[k] : added[k];
            pixel.put(moments_, 0, static_cast<int>(k),
                      ((stored[k] - offset) * old_share + term * new_share) + offset);
        }
    }

    template <class D, class P>
    typename D::Real transmittance(const typename D::Real& z, P& pixel) const {
        return with_order([&](auto order) { return transmittance_of<order.value, D>(z, pixel); });
    }

    template <int kOrder, class D, class P>
    typename D::Real transmittance_of(const typename D::Real& z, P& pixel) const {
        using Real = typename D::Real;
        const Real total = pixel.load(total_);
        const auto skipped = total < Real(least_absorbance_);
        auto b = load_moments<kOrder, D>(pixel);
        if (!quantised_) {
            const Real divisor = select(skipped, Real(1.0f), total);
            if (published_) {
                for (Real& moment : b) moment = moment / divisor;
            } else {
                const Real inverse = Real(1.0f) / divisor;
                for (Real& moment : b) moment = moment * inverse;
            }
        } else if (trigonometric_) {
            for (Real& moment : b) moment = (moment + moment) - Real(1.0f);
        } else {
            b = quantiser_->template restored<kOrder, Real>(b);
        }
        const Real place = parameter<Real>(z);
        if (published_)
            return select(skipped, Real(0.0f),
                          published::transmittance<kOrder, Real>(bias_, total, b, place));
        Real share;
        if (trigonometric_) {
            TrigonometricMoments<kOrder, Real> complex;
            for (std::size_t k = 0; k < kOrder; ++k) complex[k] = {b[2 * k], b[2 * k + 1]};
            share = share_in_front<kOrder, Real>(bias_, complex, place);
        } else {
            share = share_in_front<kOrder, Real>(bias_, b, place);
        }
        return select(skipped, Real(1.0f),
                      exponential(negative(minimum(total * share, Real(most_in_front_)))));
    }

    static constexpr float kMostAbsorbance = 60000.0f;  // float16 holds it

    DepthWarp warp_;
    int order_ = 2;  // half the number of moments
    MomentBias bias_;
    bool trigonometric_ = false;
    bool quantised_ = false;
    bool published_ = false;
    float limit_ = 10.0f;
    float most_in_front_ = 64.0f;     // absorbance that a fragment may be behind
    float stored_limit_ = 10.0f;      // as the format of the sum keeps it
    float least_absorbance_ = 1e-6f;  // below it a pixel is taken as empty
    std::optional<MomentQuantiser> quantiser_;
    Declaration declaration_;
    Field total_;
    Field moments_;
    Field color_;
};

void MomentBased::choose_bias(Parameters& parameters) {
    const UsualBias& usual = usual_bias(order_, trigonometric_, quantised_);
    bias_.weight = static_cast<float>(parameters.get_real("bias", usual.weight, 0.0, 0.5));
    bias_.overestimation = static_cast<float>(parameters.get_real("overestimation", 0.25, 0.0, 1.0));
    bias_.moments = usual.moments;
}

void MomentBased::declare(Parameters& parameters) {
    const TechniqueFormats formats(parameters);
    const Format total_format = formats.of("optical_depth", quantised_ ? Format::kFloat16 : Format::kFloat32);
    if (total_format != Format::kFloat32 && total_format != Format::kFloat16)
        throw UserError(parameters.where("optical_depth_format"),
                        "a sum of absorbance exceeds 1; use float32 or float16");
    const Format format = quantised_ ? Format::kUnorm16 : Format::kFloat32;
    if (quantised_ && !trigonometric_) quantiser_.emplace(order_);
    if (published_) least_absorbance_ = 0.00100050033f;  // of alpha 0.001
    stored_limit_ = stored_value(total_format, limit_);
    total_ = declaration_.surface("optical_depth", 1, Layout::kInterleaved, Initial::kClear,
                                  {FieldSpec::real(total_format, 1, 0.0f, ValueRange::kSum)})[0];
    moments_ =
        declaration_.surface("moments", 1, Layout::kInterleaved, Initial::kClear,
                             {FieldSpec::real(format, 2 * order_, 0.0f,
                                              quantised_ ? ValueRange::kUnit : ValueRange::kSignedSum)})[0];
    color_ = declaration_.surface(
        "accumulated_color", 1, Layout::kInterleaved, Initial::kClear,
        {FieldSpec::real(formats.of("color", Format::kFloat16), 4, 0.0f, ValueRange::kSum)})[0];
    if (color_.format != Format::kFloat32) most_in_front_ = 13.862944f;  // -ln 2^-20, 16 steps of a half
    declaration_.passes = {{"moments", Shading::kAlphaOnly}, {"composite", Shading::kFull}};
    declaration_.paths = {"moments", "composite", "resolve"};
    declaration_.ordering = Ordering::kAny;
    declaration_.light = LightLaw::kScaled;
    declaration_.image_format = formats.image();
}

}  // namespace ropsim

ROPSIM_TECHNIQUE(moment_based, MomentBased)
