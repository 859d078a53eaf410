// Wavelet transparency: Aizenshtein, Smal and McGuire 2022 (arXiv 2201.00094), its transmittance; not its
// phenomenological part. Pass 0 finds each pixel's range of depth, pass 1 adds absorbance -ln(1 - alpha) to
// Haar coefficients over that range, pass 2 evaluates the transmittance in front of each fragment and
// accumulates, resolve scales to the total alpha. The paper's GLSL is known here by its public descendant
// (Colorwheel, wavelet.glsl). Decided here:
// - The transmittance of a fragment is at least 1e-5, as there; a pixel that reaches it is opaque.
// - A fragment's own step is taken out of the value of its bin, not out of each coefficient: the same
//   number by one product.
// - Fragments of alpha 0 do not widen the range. A range of a single depth maps to 0.
// - The range is of the depth buffer's values. A public application (Flywheel) takes distances from the eye
//   (warp=linear), which needs a division and is worse on every scene tried.
// - bounds=frame leaves pass 0 out and takes `near` and `far` for every pixel.
#include "rop/accumulated_color.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"
#include "rop/visibility/depth_warp.h"
#include "rop/visibility/haar_wavelets.h"

#include <array>
#include <cstddef>

namespace ropsim {

class Wavelet {
 public:
    static constexpr TechniqueInfo kInfo = {
        "wavelet", "wavelet transparency (Aizenshtein et al. 2022)",
        "rank=3 (1..5), bounds=pixel|frame, warp=depth|linear|log, near=NUMBER, far=NUMBER", false, ""};

    Wavelet(Parameters& parameters, const Screen& screen)
        : rank_(static_cast<int>(parameters.get_integer("rank", 3, 1, kMaxHaarRank))),
          bounded_(parameters.get_choice("bounds", "pixel", {"pixel", "frame"}) == "pixel"),
          warp_(parameters, screen, "depth") {
        const TechniqueFormats formats(parameters);
        if (bounded_)
            bounds_ = declaration_.surface(
                "bounds", 1, Layout::kInterleaved, Initial::kClear,
                {FieldSpec::real(formats.of("bounds", Format::kFloat32), 1, kNoNearest, ValueRange::kUnit),
                 FieldSpec::real(formats.of("bounds", Format::kFloat32), 1, kNoFarthest, ValueRange::kUnit)});
        coefficients_ = declaration_.surface("coefficients", haar_coefficients(rank_), Layout::kInterleaved,
                                             Initial::kClear,
                                             {FieldSpec::real(formats.of("coefficient", Format::kFloat16), 1,
                                                              0.0f, ValueRange::kSignedSum)})[0];
        color_ = declaration_.surface(
            "accumulated_color", 1, Layout::kInterleaved, Initial::kClear,
            {FieldSpec::real(formats.of("color", Format::kFloat16), 4, 0.0f, ValueRange::kSum)})[0];
        if (coefficients_.format != Format::kFloat32 && coefficients_.format != Format::kFloat16)
            throw UserError(parameters.where("coefficient_format"),
                            "coefficients exceed 1; use float32 or float16");
        if (bounded_) {
            declaration_.passes = {{"bounds", Shading::kAlphaOnly}};
            declaration_.paths = {"bounds"};
        }
        declaration_.passes.push_back({"coefficients", Shading::kAlphaOnly});
        declaration_.passes.push_back({"composite", Shading::kFull});
        for (const char* path : {"coefficients", "composite", "resolve"})
            declaration_.paths.emplace_back(path);
        if (bounded_) declaration_.paths.emplace_back("inside_bounds");
        declaration_.ordering = Ordering::kAny;
        declaration_.light = LightLaw::kScaled;
        declaration_.image_format = formats.image();
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D& d, int pass, const FragmentInput<D>& f, P& pixel) const {
        const int first = bounded_ ? 1 : 0;
        if (pass < first) return widen(d, f, pixel) ? 0 : kInsideBounds;
        const bool composites = pass == first + 1;
        if (composites) pixel.fetch_all(color_, 1);
        const HaarPlace<D> place = place_of<D>(f.z, pixel);
        const auto absorbance = absorbance_of<D>(f.a);
        if (composites)
            composite<D>(f, place, absorbance, pixel);
        else
            add<D>(place, absorbance, pixel);
        return pass;
    }

    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>& background, P& pixel, int& path) const {
        using Real = typename D::Real;
        path = bounded_ ? 3 : 2;
        pixel.fetch_all(color_, 1);
        pixel.fetch_if(typename D::Bool(true), coefficients_, haar_mean(rank_));
        for (int p = 0; p <= rank_; ++p) pixel.fetch_if(typename D::Bool(true), coefficients_, last_of(p));
        // The value of the last bin.
        std::array<Real, kMaxHaarRank + 2> terms;
        terms[0] = pixel.load(coefficients_, haar_mean(rank_));
        for (int p = 0; p <= rank_; ++p)
            terms[static_cast<std::size_t>(p) + 1] =
                pixel.load(coefficients_, last_of(p)) * Real(kHaarScale[static_cast<std::size_t>(p)]);
        const Real absorbance = sum_of<Real>(terms);
        const Real left = select(absorbance < Real(kOpaque), transmittance_of<Real>(absorbance), Real(0.0f));
        const Rgb<D> sum = pixel.load_rgb(color_);
        const Real alpha = pixel.load(color_, 0, 3);
        const auto some = Real(0.0f) < alpha;
        const Real scale = select(some, (Real(1.0f) - left) / select(some, alpha, Real(1.0f)), Real(0.0f));
        return {sum.r * scale + left * background.mean.r, sum.g * scale + left * background.mean.g,
                sum.b * scale + left * background.mean.b};
    }

    void visibility(PlainPixel& pixel, std::span<const float> depths, std::span<float> values) const {
        for (std::size_t i = 0; i < depths.size(); ++i) {
            const HaarPlace<PlainDatapath> place = place_of<PlainDatapath>(depths[i], pixel);
            values[i] = transmittance_of<float>(absorbance_at<PlainDatapath>(place, 0.0f, pixel));
        }
    }

 private:
    static constexpr int kInsideBounds = 4;  // control path
    // Depths after the warp, in [0, 1], of a pixel without fragments.
    static constexpr float kNoNearest = 1.0f;
    static constexpr float kNoFarthest = 0.0f;
    static constexpr float kMostAbsorbance = 11.5129255f;  // -ln 1e-5
    // A pixel with so much shows no background: 1/64 below, as float16 coefficients may be rounded.
    static constexpr float kOpaque = kMostAbsorbance - 1.0f / 64;

    static int last_of(int level) { return (2 << level) - 2; }

    template <class D>
    static typename D::Real absorbance_of(const typename D::Real& alpha) {
        using Real = typename D::Real;
        const Real absorbance = negative(natural_log(Real(1.0f) - alpha));
        return maximum(minimum(absorbance, Real(kMostAbsorbance)), Real(0.0f));
    }
    template <class Real>
    static Real transmittance_of(const Real& absorbance) {
        return minimum(exponential(negative(absorbance)), Real(1.0f));
    }

    // terms[0] to terms[rank + 1], as a tree.
    template <class Real>
    Real sum_of(std::array<Real, kMaxHaarRank + 2>& terms) const {
        std::size_t count = static_cast<std::size_t>(rank_) + 2;
        for (; count > 1; count = (count + 1) / 2) {
            for (std::size_t i = 0; i + 1 < count; i += 2) terms[i / 2] = terms[i] + terms[i + 1];
            if (count % 2 == 1) terms[count / 2] = terms[count - 1];
        }
        return terms[0];
    }

    // False where the fragment lies inside already, or has no alpha.
    template <class D, class P>
    bool widen(D& d, const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        pixel.fetch_all(bounds_[0], 1);
        const Real depth = pixel.as_stored(bounds_[0], warp_(f.z));
        const Real nearest = pixel.load(bounds_[0]);
        const Real farthest = pixel.load(bounds_[1]);
        const auto nearer = depth < nearest;
        const auto beyond = farthest < depth;
        if (!d.decide(both(either(nearer, beyond), Real(0.0f) < f.a))) return false;
        pixel.write(bounds_[0]);
        pixel.put(bounds_[0], 0, 0, select(nearer, depth, nearest));
        pixel.put(bounds_[1], 0, 0, select(beyond, depth, farthest));
        return true;
    }

    // What is stored of the range may be rounded: depth is brought into it.
    template <class D, class P>
    HaarPlace<D> place_of(const typename D::Real& z, P& pixel) const {
        using Real = typename D::Real;
        const Real depth = warp_(z);
        if (!bounded_) return HaarPlace<D>(rank_, depth);
        pixel.fetch_all(bounds_[0], 1);
        const Real nearest = pixel.load(bounds_[0]);
        const Real range = maximum(pixel.load(bounds_[1]) - nearest, Real(1e-30f));
        const Real within = minimum(maximum((depth - nearest) / range, Real(0.0f)), Real(1.0f));
        return HaarPlace<D>(rank_, within);
    }

    // The coefficients' addresses are known with the bin.
    template <class D, class P>
    static void wait_for(const typename D::Uint& bin, P& pixel) {
        if constexpr (D::kCharged)
            pixel.next_fetch_stage(Wire<bool>(true, bin.ready));
        else
            pixel.next_fetch_stage(true);
    }
    // One line of the decoder of a level's index.
    template <class D>
    static typename D::Bool is(const typename D::Uint& index, int k) {
        const bool equal = value_of(index) == static_cast<std::uint32_t>(k);
        if constexpr (D::kCharged)
            return {equal, Ledger::active().charge(Unit::kLogic, index.ready)};
        else
            return equal;
    }
    // Names a level's coefficient to memory. Which one is known from the fragment's depth and the pixel's
    // range.
    template <class D, class P>
    void fetch(P& pixel, int level, const typename D::Uint& index) const {
        const int first = (1 << level) - 1;
        if constexpr (D::kCharged)
            for (int k = 0; k < 1 << level; ++k) pixel.fetch_if(is<D>(index, k), coefficients_, first + k);
        else
            pixel.fetch_if(true, coefficients_, first + static_cast<int>(index));
    }
    // Loads it: out of the level's, a selector.
    template <class D, class P>
    typename D::Real load(P& pixel, int level, const typename D::Uint& index) const {
        auto value = pixel.load(coefficients_, (1 << level) - 1 + static_cast<int>(value_of(index)));
        if constexpr (D::kCharged)
            value.ready = charge_selector(1 << level, std::max(value.ready, index.ready));
        return value;
    }
    template <class D, class P>
    void store(P& pixel, int level, const typename D::Uint& index, const typename D::Real& value) const {
        const int first = (1 << level) - 1;
        if constexpr (D::kCharged)
            for (int k = 0; k < 1 << level; ++k) pixel.write_if(is<D>(index, k), coefficients_, first + k);
        else
            pixel.write(coefficients_, first + static_cast<int>(index));
        pixel.put(coefficients_, first + static_cast<int>(value_of(index)), 0,
                  saturated(coefficients_, value));
    }

    template <class D, class P>
    void add(const HaarPlace<D>& place, const typename D::Real& absorbance, P& pixel) const {
        if (bounded_) wait_for<D>(place.bin, pixel);
        const int mean = haar_mean(rank_);
        pixel.fetch_if(typename D::Bool(true), coefficients_, mean);
        for (int p = 0; p <= rank_; ++p) fetch<D>(pixel, p, HaarTerm<D>(rank_, p, place.bin).index);
        pixel.write(coefficients_, mean);
        pixel.put(coefficients_, mean, 0,
                  saturated(coefficients_,
                            pixel.load(coefficients_, mean) + haar_mean_addend<D>(rank_, place, absorbance)));
        for (int p = 0; p <= rank_; ++p) {
            const HaarTerm<D> term(rank_, p, place.bin);
            const auto sum =
                load<D>(pixel, p, term.index) + haar_addend<D>(rank_, p, place, term, absorbance);
            store<D>(pixel, p, term.index, sum);
        }
    }

    // In front of the place: between the value of the bin before, at its start, and its own without the
    // fragment's step, at its end. Fetched coefficients only.
    template <class D, class P>
    typename D::Real absorbance_at(const HaarPlace<D>& place, const typename D::Real& own, P& pixel) const {
        using Real = typename D::Real;
        using Uint = typename D::Uint;
        const Uint before_bin = bin_before<D>(place.bin);
        std::array<Real, kMaxHaarRank + 2> here;
        std::array<Real, kMaxHaarRank + 2> before;
        here[0] = before[0] = pixel.load(coefficients_, haar_mean(rank_));
        for (int p = 0; p <= rank_; ++p) {
            const auto i = static_cast<std::size_t>(p) + 1;
            const HaarTerm<D> term(rank_, p, place.bin);
            const HaarTerm<D> term_before(rank_, p, before_bin);
            here[i] = haar_value<D>(p, term, load<D>(pixel, p, term.index));
            before[i] = haar_value<D>(p, term_before, load<D>(pixel, p, term_before.index));
        }
        const Real end = sum_of<Real>(here) - own * (Real(1.0f) - place.into);
        const Real start = select(place.bin == Uint(0u), Real(0.0f), sum_of<Real>(before));
        return maximum(start + (end - start) * place.into, Real(0.0f));
    }
    // Bin 0 has none in front: its own stands for it, and is not used.
    template <class D>
    static typename D::Uint bin_before(const typename D::Uint& bin) {
        using Uint = typename D::Uint;
        return select(bin == Uint(0u), Uint(0u), bin - Uint(1u));
    }

    template <class D, class P>
    void composite(const FragmentInput<D>& f, const HaarPlace<D>& place, const typename D::Real& absorbance,
                   P& pixel) const {
        using Real = typename D::Real;
        const typename D::Uint before = bin_before<D>(place.bin);
        if (bounded_) wait_for<D>(before, pixel);
        pixel.fetch_if(typename D::Bool(true), coefficients_, haar_mean(rank_));
        for (int p = 0; p <= rank_; ++p) {
            fetch<D>(pixel, p, HaarTerm<D>(rank_, p, place.bin).index);
            fetch<D>(pixel, p, HaarTerm<D>(rank_, p, before).index);
        }
        const Real weight = transmittance_of<Real>(absorbance_at<D>(place, absorbance, pixel));
        accumulate_rgb<D>(pixel, color_, weight, f.premultiplied);
        pixel.put(color_, 0, 3, saturated(color_, pixel.load(color_, 0, 3) + weight * f.a));
    }

    int rank_;
    bool bounded_;
    DepthWarp warp_;
    Declaration declaration_;
    std::vector<Field> bounds_;
    Field coefficients_;
    Field color_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(wavelet, Wavelet)
