// Stochastic transparency, the basic one-pass method with stratified masks: Enderton, Sintorn, Shirley and
// Luebke 2011, section 3.1. Each fragment takes R = floor(alpha n + xi) of the n stored samples it covers, a
// uniformly random subset, and the depth test decides each sample. Left open by the paper and decided here:
// the subset is chosen before the depth test, and of equal depths the first arrival stays.
#include "rop/sample_mean.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"

#include <array>

namespace ropsim {

class Stochastic {
 public:
    static constexpr TechniqueInfo kInfo = {
        "stochastic", "stochastic transparency, one pass (Enderton et al. 2011)",
        "samples=8 (1..32, a multiple of the trace's), masks=choose", true, "samples=8"};
    static constexpr bool kRandom = true;
    static constexpr int kMaxSamples = 32;

    Stochastic(Parameters& parameters, const Screen& screen)
        : samples_(static_cast<int>(parameters.get_integer("samples", 8, 1, kMaxSamples))),
          spatial_samples_(screen.samples) {
        if (samples_ % spatial_samples_ != 0)
            throw UserError(
                parameters.where("samples"),
                fmt::format("{} stored samples over a trace of {} samples a pixel; use a multiple of {}",
                            samples_, spatial_samples_, spatial_samples_));
        parameters.get_choice("masks", "choose", {"choose"});
        const TechniqueFormats formats(parameters);
        depth_ = declaration_.surface("depth", samples_, Layout::kPlanar, Initial::kOpaqueDepth,
                                      {FieldSpec::real(formats.of("depth", Format::kFloat32), 1, 1.0f)})[0];
        color_ = declaration_.surface("color", samples_, Layout::kPlanar, Initial::kOpaqueColor,
                                      {FieldSpec::real(formats.rgb("color", Format::kUnorm8), 4, 1.0f)})[0];
        declaration_.passes = {{"draw", Shading::kFull}};
        declaration_.paths = {"empty_mask", "write", "resolve"};
        declaration_.ordering = Ordering::kAny;
        declaration_.uses_coverage = true;
        declaration_.random = true;
        declaration_.resolve_reads_background = false;
        declaration_.image_format = formats.image();
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D& d, int, const FragmentInput<D>& f, P& pixel) const {
        using Uint = typename D::Uint;
        std::array<typename D::Bool, kMaxSamples> chosen;
        const Uint count = choose_mask<D>(f, chosen);
        if (d.decide(count == Uint(0u))) return kEmptyMask;
        for (int s = 0; s < samples_; ++s) pixel.fetch_if(chosen[static_cast<std::size_t>(s)], depth_, s);
        for (int s = 0; s < samples_; ++s) {
            const auto pass = both(chosen[static_cast<std::size_t>(s)], f.z < pixel.load(depth_, s));
            pixel.write_if(pass, depth_, s);
            pixel.write_if(pass, color_, s);
            pixel.put_if(pass, depth_, s, 0, f.z);
            pixel.put_rgb_if(pass, color_, s, f.straight);
        }
        return kWrite;
    }

    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>&, P& pixel, int& path) const {
        path = kResolve;
        pixel.fetch_all(color_, samples_);
        return mean_of_samples<D>(pixel, color_, samples_);
    }

 private:
    enum Path { kEmptyMask, kWrite, kResolve };

    bool covers(std::uint32_t coverage, int sample) const { return bit(coverage, sample % spatial_samples_); }

    // Uniform choice of R out of the n covered samples by selection sampling: sample s is taken with
    // probability (still to take) / (still to come). Exact up to 2^-32. Returns R.
    template <class D>
    typename D::Uint choose_mask(const FragmentInput<D>& f,
                                 std::array<typename D::Bool, kMaxSamples>& chosen) const {
        using Real = typename D::Real;
        using Uint = typename D::Uint;
        std::uint32_t covered = 0;
        for (int s = 0; s < samples_; ++s)
            covered |= static_cast<std::uint32_t>(covers(value_of(f.coverage), s)) << s;
        const auto n = static_cast<std::uint32_t>(std::popcount(covered));
        const Uint count = floor_to_uint(f.a * Real(static_cast<float>(n)) + draw_unit<D>(f.key, 0));
        Uint wanted = count;
        std::uint32_t left = n;
        for (int s = 0; s < samples_; ++s) {
            const auto k = static_cast<std::size_t>(s);
            if constexpr (!D::kCharged) {
                chosen[k] = false;
                if (!bit(covered, s)) continue;
                if (wanted == 0) break_rest(chosen, k);
                if (wanted == 0) break;
            }
            const auto position = scaled<D>(draw_bits<D>(f.key, static_cast<std::uint32_t>(1 + s)), left);
            const auto take = position < wanted;
            chosen[k] = covered_gate<D>(take, bit(covered, s));
            wanted = wanted - select(chosen[k], Uint(1u), Uint(0u));
            left -= bit(covered, s) ? 1 : 0;
        }
        return count;
    }
    static void break_rest(std::array<bool, kMaxSamples>& chosen, std::size_t from) {
        for (std::size_t k = from; k < chosen.size(); ++k) chosen[k] = false;
    }
    template <class D>
    static typename D::Bool covered_gate(const typename D::Bool& take, bool covered) {
        return both(take, typename D::Bool(covered));
    }
    // floor(bits * n / 2^32): uniform in [0, n).
    template <class D>
    static typename D::Uint scaled(const typename D::Uint& bits, std::uint32_t n) {
        const auto high = static_cast<std::uint32_t>((static_cast<std::uint64_t>(value_of(bits)) * n) >> 32);
        if constexpr (D::kCharged)
            return {high, Ledger::active().charge(Unit::kIntegerMultiplier, bits.ready)};
        else
            return high;
    }

    int samples_;
    int spatial_samples_;
    Declaration declaration_;
    Field depth_;
    Field color_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(stochastic, Stochastic)
