// Fourier opacity maps (Jansen and Bavoil 2010) as transparency: FOMTF and FOMTV of Salvi et al. 2011,
// sections 4 and 4.1. The density of absorbance along a pixel's ray, between its bounds, is kept as the first
// coefficients of its Fourier series; integrated and exponentiated it is visibility:
//   a_k = sum of 2 A cos(2 pi k d),  b_k = sum of 2 A sin(2 pi k d),  A = -ln(1 - alpha), d in [0, 1]
//   -ln vis(d) = a_0 d / 2 + sum over k of a_k sin(2 pi k d) / (2 pi k) + b_k (1 - cos(2 pi k d)) / (2 pi k)
// Additive blending is all that it takes, in any order. The default is the paper's seven coefficients in two
// RGBA16F targets, one channel of which is left; table 1 of Salvi et al. is coefficients=15 in four RGBA32F.
//
// Decided here: the series rings, so that absorbance can be negative and visibility above 1; `clamp=on` keeps
// it at 1 at most, `off` takes it as it comes, up to binary16's largest number. A sum of binary16 stops
// at that too. `guard` is the share of the period that stays empty at either end: the series is periodic, and
// without a guard half of the nearest fragment's absorbance appears behind the furthest one.
#include "rop/sampling/sample_means.h"
#include "rop/visibility/absorbance.h"
#include "rop/visibility/map_passes.h"

#include <fmt/format.h>

namespace ropsim {

class FourierSeries {
 public:
    static constexpr bool kAddressed = false;
    static constexpr bool kInRegisters = true;
    static constexpr bool kZeroAlphaHarmless = true;
    static constexpr int kMostCoefficients = 31;

    FourierSeries(Parameters& parameters, const MapOptions& options)
        : samples_(options.spatial_samples),
          variable_(options.memory == MapMemory::kVariable),
          clamp_(parameters.get_choice("clamp", "on", {"on", "off"}) == "on"),
          guard_(static_cast<float>(parameters.get_real("guard", 0.0, 0.0, 0.45))),
          absorbance_(static_cast<float>(parameters.get_real("least_transmittance", 1e-5, 1e-9, 0.5))) {
        const auto count = static_cast<int>(parameters.get_integer("coefficients", 7, 1, kMostCoefficients));
        if (count % 2 == 0)
            throw UserError(
                parameters.where("coefficients"),
                fmt::format("a mean and pairs of cosine and sine are an odd number: take {} or {}", count - 1,
                            count + 1));
        pairs_ = count / 2;
    }
    // Targets of four channels each.
    void declare(Declaration& declaration, const TechniqueFormats& formats) {
        if (!clamp_) declaration.light = LightLaw::kAdded;
        if (variable_) return;
        const int channels = (2 * pairs_ + 1 + 3) / 4 * 4;
        coefficients_ = declaration.surface("coefficients", samples_, Layout::kInterleaved, Initial::kClear,
                                            {FieldSpec::real(formats.of("coefficients", Format::kFloat16),
                                                             channels, 0.0f, ValueRange::kSignedSum)})[0];
    }

    template <class D>
    struct Place {
        typename D::Real share;
        std::array<typename D::Real, kMostCoefficients / 2> sine;  // of 2 pi k share, k = 1, 2 ...
        std::array<typename D::Real, kMostCoefficients / 2> cosine;
    };
    // One sine and one cosine a pair, side by side.
    template <class D>
    Place<D> place(const typename D::Real& share) const {
        using Real = typename D::Real;
        Place<D> at;
        at.share = guard_ == 0.0f ? share : Real(guard_) + share * Real(1.0f - 2.0f * guard_);
        for (int k = 1; k <= pairs_; ++k) {
            const auto i = static_cast<std::size_t>(k - 1);
            const Real turns = k == 1 ? at.share : at.share * Real(static_cast<float>(k));
            if constexpr (D::kCharged) {
                at.sine[i] = sine(turns);
                at.cosine[i] = cosine(turns);
            } else {  // the same values from one reduction of the angle
                const SineCosine both = deterministic_sine_cosine(static_cast<double>(turns));
                at.sine[i] = static_cast<float>(both.sine);
                at.cosine[i] = static_cast<float>(both.cosine);
            }
        }
        return at;
    }
    template <class D>
    typename D::Real amount(const typename D::Real& alpha) const {
        return absorbance_.of<D>(alpha, 2.0f);
    }

    template <class P>
    void fetch(P& pixel, int m, const typename P::D::Bool& covered) const {
        pixel.fetch_if(covered, coefficients_, m);
    }
    template <class P>
    ChannelCells<P> cells(P& pixel, int m) const {
        return {pixel, coefficients_, m};
    }
    // Channel 0 is a_0, then a_1, b_1, a_2, b_2 ...
    template <class D, class Cells>
    void add(const Cells& cells, const typename D::Bool& covered, const Place<D>& at,
             const typename D::Real& amount) const {
        cells.put_if(covered, 0, cells.load(0) + amount);
        for (int k = 1; k <= pairs_; ++k) {
            const auto i = static_cast<std::size_t>(k - 1);
            cells.put_if(covered, 2 * k - 1, cells.load(2 * k - 1) + amount * at.cosine[i]);
            cells.put_if(covered, 2 * k, cells.load(2 * k) + amount * at.sine[i]);
        }
    }
    template <class D, class Cells>
    typename D::Real visibility(const Cells& cells, const Place<D>& at) const {
        using Real = typename D::Real;
        std::array<Real, kMaxElements> terms;
        terms[0] = cells.load(0) * (at.share * Real(0.5f));
        for (int k = 1; k <= pairs_; ++k) {
            const auto i = static_cast<std::size_t>(k - 1);
            const Real scale(static_cast<float>(0.15915494309189535 / k));  // 1 / (2 pi k)
            terms[2 * i + 1] = cells.load(2 * k - 1) * (at.sine[i] * scale);
            terms[2 * i + 2] = cells.load(2 * k) * ((Real(1.0f) - at.cosine[i]) * scale);
        }
        const Real absorbance = tree_sum(terms, 2 * pairs_ + 1);
        if (clamp_) return exponential(negative(maximum(absorbance, Real(0.0f))));
        return minimum(exponential(negative(absorbance)), Real(kLargestFloat16));
    }

 private:
    int samples_;
    bool variable_;
    bool clamp_;
    float guard_;
    Absorbance absorbance_;
    int pairs_ = 3;
    Field coefficients_;
};

class FourierMap : public MapPasses<FourierSeries> {
 public:
    static constexpr TechniqueInfo kInfo = {
        "fourier_map", "Fourier opacity maps as transparency (Jansen and Bavoil 2010; Salvi et al. 2011)",
        "coefficients=7 (1..31, odd), bounds=pixel|frame, guard=0 (to 0.45), clamp=on|off, "
        "memory=fixed|variable, composite=plain|normalised, least_transmittance=1e-5 (1e-9 to 0.5)",
        false, ""};

    FourierMap(Parameters& parameters, const Screen& screen)
        : MapPasses(parameters, fourier_map_options(parameters, screen)) {}

 private:
    static MapOptions fourier_map_options(Parameters& parameters, const Screen& screen) {
        MapOptions options = map_options(parameters, screen.samples, "plain");
        options.memory = map_memory(parameters);
        return options;
    }
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(fourier_map, FourierMap)
