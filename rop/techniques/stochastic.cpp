// Stochastic transparency: Enderton, Sintorn, Shirley and Luebke 2011, all its methods (rop/sampling). How a
// fragment picks its samples: an independent coin a sample, or R = floor(alpha n + xi) of the n it covers as
// a uniformly random subset (3.1), a run, or an entry of a precomputed table (5); fixed alpha to coverage as
// hardware does it (2), and spatiotemporal blue noise (Wolfe et al. 2022). Left open by the paper and
// switchable here: whether occluded samples leave before R is chosen (depth_test=first, as Laine and Karras
// 2011, section 5, compare with). Section 6's seeds, and fewer samples over bright backgrounds.
// seed_from=pattern is the index of Salvi et al. 2011, section 4, whose x^2 + y is taken literally.
#include "rop/sampling/blue_noise.h"
#include "rop/sampling/mask_table.h"
#include "rop/sampling/stored_samples.h"

#include <memory>
#include <string>

namespace ropsim {

namespace {

enum class Masks : std::uint8_t { kCoin, kChoose, kRun, kTable, kAlphaToCoverage, kBlueNoise };
enum class SeedFrom : std::uint8_t { kPrimitive, kDepth, kObject, kObjectFacing, kPattern };

class MaskChooser {
 public:
    static constexpr const char* kNothing = "empty_mask";
    static constexpr const char* kWrite = "write";

    MaskChooser(Parameters& parameters, const Screen& screen, const SamplingOptions& options)
        : screen_(screen), options_(&options) {
        const std::string masks = parameters.get_choice(
            "masks", "choose", {"coin", "choose", "run", "table", "alpha_to_coverage", "blue_noise"});
        masks_ = masks == "coin"                ? Masks::kCoin
                 : masks == "choose"            ? Masks::kChoose
                 : masks == "run"               ? Masks::kRun
                 : masks == "table"             ? Masks::kTable
                 : masks == "alpha_to_coverage" ? Masks::kAlphaToCoverage
                                                : Masks::kBlueNoise;
        const std::string seed = parameters.get_choice(
            "seed_from", "primitive", {"primitive", "depth", "object", "object_facing", "pattern"});
        seed_from_ = seed == "primitive"       ? SeedFrom::kPrimitive
                     : seed == "depth"         ? SeedFrom::kDepth
                     : seed == "object"        ? SeedFrom::kObject
                     : seed == "object_facing" ? SeedFrom::kObjectFacing
                                               : SeedFrom::kPattern;
        dithers_ = parameters.get_choice("rounding", "random", {"random", "dither"}) == "dither";
        depth_first_ = parameters.get_choice("depth_test", "last", {"last", "first"}) == "first";
        bright_samples_ = static_cast<int>(
            parameters.get_integer("bright_samples", options.samples, 1, SamplingOptions::kMaxSamples));
        dark_below_ = static_cast<float>(parameters.get_real("dark_below", 0.25, 0, 65504));
        check(parameters);
        if (masks_ == Masks::kTable)
            table_ = std::make_unique<MaskTable>(options.strata_across_rounds ? options.samples
                                                                              : options.hardware_samples);
        if (masks_ == Masks::kBlueNoise) BlueNoise::instance();
    }

    static void declare(Declaration&, std::vector<int>&) {}
    static void declare_order(Declaration& declaration) { declaration.ordering = Ordering::kAny; }
    bool samples_vary() const { return bright_samples_ != options_->samples; }
    static int used_samples(std::uint32_t pixel_constant) { return static_cast<int>(pixel_constant); }

    // Section 6: "making S higher in pixels where the background is dark".
    std::uint32_t pixel_constant(glm::vec3 background) const {
        if (!samples_vary()) return static_cast<std::uint32_t>(options_->hardware_samples);
        const float luminance = 0.2126f * background.r + 0.7152f * background.g + 0.0722f * background.b;
        return static_cast<std::uint32_t>(luminance < dark_below_ ? options_->samples : bright_samples_);
    }

    std::uint64_t random_key(const Fragment& f) const {
        // Blue noise is a pattern over the pixels of a surface: its key leaves them out.
        const std::uint64_t place =
            masks_ == Masks::kBlueNoise
                ? 0
                : static_cast<std::uint64_t>(f.y) * static_cast<std::uint64_t>(screen_.width) + f.x + 1;
        const std::uint64_t seed = screen_.seed * 0x9E3779B97F4A7C15ull;
        const auto key = [&](std::uint64_t first, std::uint32_t second) {
            return mix64(mix64(seed + first) ^ ((place - 1) << 32) ^ second);
        };
        const std::uint32_t object = f.draw < screen_.objects.size() ? screen_.objects[f.draw] : f.draw;
        switch (seed_from_) {
            case SeedFrom::kPrimitive:
                return key(f.draw, primitive_number(f));
            case SeedFrom::kDepth:
                return key(1ull << 32, std::bit_cast<std::uint32_t>(f.z));
            case SeedFrom::kObject:
                return key((2ull << 32) + object, 0);
            case SeedFrom::kObjectFacing:
                return key((2ull << 32) + object, faces_back(f) ? 1 : 0);
            case SeedFrom::kPattern:
                break;
        }
        return screen_.seed + primitive_number(f) + static_cast<std::uint64_t>(f.x) * f.x + f.y;
    }

    template <class D, class P>
    SampleChoice<D> choose(D& d, const ChoiceInput<D, P>& in) const {
        const FragmentInput<D>& f = in.fragment;
        const int used = used_samples(value_of(f.pixel_constant));
        const std::uint64_t covered = in.covered & low_bits(static_cast<std::uint32_t>(used));
        if (depth_first_) return choose_survivors(d, in, covered);
        const SampleMask<D> mask = both(masked<D>(f, covered), mask_at<D>(covered, 0));
        if (d.decide(inverse(any_sample(mask, options_->hardware_samples)))) return {true, {}};
        fetch(in, in.whole_pixel ? mask_at<D>(~0ull, 0) : mask);
        return {false, nearer(in, mask)};
    }

 private:
    void check(const Parameters& parameters) const {
        if (dithers_ && masks_ != Masks::kChoose && masks_ != Masks::kRun)
            throw UserError(parameters.where("rounding"),
                            "dithers how many samples are chosen: use masks=choose or masks=run");
        if (depth_first_ && masks_ != Masks::kChoose)
            throw UserError(parameters.where("depth_test"),
                            "first chooses among the samples that survive: use masks=choose");
        if (depth_first_ && options_->rounds() > 1 && options_->strata_across_rounds)
            throw UserError(parameters.where("depth_test"),
                            "first knows the samples of one round only: use strata=pass");
        if (seed_from_ == SeedFrom::kPattern && masks_ != Masks::kTable)
            throw UserError(parameters.where("seed_from"), "pattern is the index into masks=table");
        if (!samples_vary()) return;
        if (bright_samples_ > options_->samples || bright_samples_ % options_->spatial_samples != 0)
            throw UserError(parameters.where("bright_samples"),
                            fmt::format("{} must be at most samples={} and a multiple of the trace's {}",
                                        bright_samples_, options_->samples, options_->spatial_samples));
        if (options_->rounds() > 1 || options_->filter != DisplayFilter::kBox || !uses_any_samples())
            throw UserError(parameters.where("bright_samples"),
                            "needs one round, filter=box, accumulator=pixel and, with method=depth_based, "
                            "correction=accumulated");
    }
    bool uses_any_samples() const {
        if (options_->accumulator_per_sample) return false;
        return !options_->depth_based() || options_->correction == Correction::kAccumulated;
    }

    template <class D, class P>
    void fetch(const ChoiceInput<D, P>& in, const SampleMask<D>& mask) const {
        for (int s = 0; s < options_->hardware_samples; ++s) in.pixel.fetch_if(mask.test(s), in.depth, s);
    }
    // Those of the mask where the fragment is nearer than what is stored.
    template <class D, class P>
    SampleMask<D> nearer(const ChoiceInput<D, P>& in, const SampleMask<D>& mask) const {
        SampleMask<D> result;
        if constexpr (D::kCharged) {
            for (int s = 0; s < options_->hardware_samples; ++s)
                result.wires[static_cast<std::size_t>(s)] =
                    both(mask.test(s), in.depths.of(s) < in.pixel.load(in.depth, s));
        } else {
            std::uint64_t bits = 0;
            for (int s = 0; s < options_->hardware_samples; ++s)
                bits |= static_cast<std::uint64_t>(in.depths.of(s) < in.pixel.load(in.depth, s)) << s;
            result.bits = bits & mask.bits;
        }
        return result;
    }

    template <class D, class P>
    SampleChoice<D> choose_survivors(D& d, const ChoiceInput<D, P>& in, std::uint64_t covered) const {
        const auto coverage = mask_at<D>(covered, 0);
        fetch(in, in.whole_pixel ? mask_at<D>(~0ull, 0) : coverage);
        const SampleMask<D> survivors = nearer(in, coverage);
        const auto n = count_samples(survivors, options_->hardware_samples);
        const FragmentInput<D>& f = in.fragment;
        const SampleMask<D> mask =
            subset<D>(round_key(f), count_of<D>(f, n), survivors, n, options_->hardware_samples);
        if (d.decide(inverse(any_sample(mask, options_->hardware_samples)))) return {true, {}};
        return {false, mask};
    }

    template <class D>
    std::uint64_t round_key(const FragmentInput<D>& f) const {
        if (options_->strata_across_rounds || f.round == 0) return f.key;
        return mix64(f.key + static_cast<std::uint64_t>(f.round) * 0xD1B54A32D192ED03ull);
    }
    // Masks are made for so many samples: of all rounds, or of one.
    int mask_samples() const {
        return options_->strata_across_rounds ? options_->samples : options_->hardware_samples;
    }
    // This round's part of a mask over all rounds.
    template <class D>
    SampleMask<D> of_round(const SampleMask<D>& mask, int round) const {
        if (!options_->strata_across_rounds || options_->rounds() == 1) return mask;
        const int first = round * options_->hardware_samples;
        SampleMask<D> part;
        if constexpr (D::kCharged) {
            // One design serves every round: a selector a sample, behind the slowest of its inputs.
            for (int s = 0; s < options_->hardware_samples; ++s) {
                int ready = 0;
                for (int other = s; other < options_->samples; other += options_->hardware_samples)
                    ready = std::max(ready, mask.test(other).ready);
                part.wires[static_cast<std::size_t>(s)] = {mask.test(first + s).value,
                                                           Ledger::active().charge(Unit::kMux, ready)};
            }
        }
        if constexpr (!D::kCharged)
            part.bits =
                (mask.bits >> first) & low_bits(static_cast<std::uint32_t>(options_->hardware_samples));
        return part;
    }

    // The samples a fragment asks for, before the depth test.
    template <class D>
    SampleMask<D> masked(const FragmentInput<D>& f, std::uint64_t covered) const {
        const std::uint64_t key = round_key(f);
        const int samples = mask_samples();
        switch (masks_) {
            case Masks::kCoin:
                return of_round(coins<D>(key, f, samples), f.round);
            case Masks::kChoose: {
                // Coverage repeats with the round, so that all rounds' is known in each.
                std::uint64_t all = covered;
                for (int s = options_->hardware_samples; s < samples; s += options_->hardware_samples)
                    all |= covered << s;
                const typename D::Uint n(count_samples(SampleMask<PlainDatapath>{all}, samples));
                return of_round(subset<D>(key, count_of<D>(f, n), mask_at<D>(all, 0), n, samples), f.round);
            }
            case Masks::kRun: {
                const typename D::Uint n(static_cast<std::uint32_t>(samples));
                const auto count = count_of<D>(f, n);
                const auto start = scaled<D>(draw_bits<D>(key, 1), n);
                return of_round(
                    looked_up<D>(run_mask(samples, value_of(start), value_of(count)), count, start), f.round);
            }
            case Masks::kTable:
                return of_round(from_table<D>(key, f), f.round);
            case Masks::kAlphaToCoverage:
                return of_round(looked_up<D>(alpha_to_coverage_mask(samples, value_of(f.a)), f.a, f.a),
                                f.round);
            case Masks::kBlueNoise:
                break;
        }
        return of_round(blue<D>(key, f, samples), f.round);
    }

    // R = floor(alpha n + xi), section 3.1.
    template <class D>
    typename D::Uint count_of(const FragmentInput<D>& f, const typename D::Uint& n) const {
        using Real = typename D::Real;
        const Real xi = dithers_ ? Real(dither_threshold(f.x, f.y)) : draw_unit<D>(round_key(f), 0);
        if constexpr (D::kCharged)
            return floor_to_uint(f.a * Real(static_cast<float>(n.value), n.ready) + xi);
        else
            return floor_to_uint(f.a * static_cast<float>(n) + xi);
    }
    // A word that a table or a shifter gives out for two inputs.
    template <class D, class A, class B>
    static SampleMask<D> looked_up(std::uint64_t bits, const A& a, const B& b) {
        if constexpr (D::kCharged)
            return mask_at<D>(bits, Ledger::active().charge(Unit::kTable, std::max(a.ready, b.ready)));
        else
            return mask_at<D>(bits, 0);
    }
    template <class D>
    SampleMask<D> from_table(std::uint64_t key, const FragmentInput<D>& f) const {
        using Uint = typename D::Uint;
        Uint entry = 0u;
        if (seed_from_ == SeedFrom::kPattern)
            entry = static_cast<std::uint32_t>(key % MaskTable::kEntries);
        else
            entry = scaled<D>(draw_bits<D>(key, 0), Uint(MaskTable::kEntries));
        return looked_up<D>(table_->mask(value_of(entry), MaskTable::level(value_of(f.a))), entry, f.a);
    }
    template <class D>
    SampleMask<D> coins(std::uint64_t key, const FragmentInput<D>& f, int samples) const {
        const std::uint64_t threshold = alpha_threshold(value_of(f.a));
        SampleMask<D> mask;
        for (int s = 0; s < samples; ++s) {
            const auto bits = draw_bits<D>(key, static_cast<std::uint32_t>(1 + s));
            const bool taken = value_of(bits) < threshold;
            if constexpr (D::kCharged)
                mask.wires[static_cast<std::size_t>(s)] = {
                    taken, Ledger::active().charge(Unit::kComparator, bits.ready)};
            else
                mask.bits |= static_cast<std::uint64_t>(taken) << s;
        }
        return mask;
    }
    template <class D>
    SampleMask<D> blue(std::uint64_t key, const FragmentInput<D>& f, int samples) const {
        const std::uint64_t bits = blue_noise_mask(samples, value_of(f.a), f.x, f.y, key);
        SampleMask<D> mask = mask_at<D>(bits, 0);
        if constexpr (D::kCharged) {
            const int drawn = Ledger::active().charge(Unit::kRandom, 0);
            for (int s = 0; s < samples; ++s)
                mask.wires[static_cast<std::size_t>(s)].ready =
                    Ledger::active().charge(Unit::kComparator, Ledger::active().charge(Unit::kTable, drawn));
        }
        return mask;
    }

    // floor(bits n / 2^32): uniform in [0, n).
    template <class D>
    static typename D::Uint scaled(const typename D::Uint& bits, const typename D::Uint& n) {
        const auto high =
            static_cast<std::uint32_t>((static_cast<std::uint64_t>(value_of(bits)) * value_of(n)) >> 32);
        if constexpr (D::kCharged)
            return {high, Ledger::active().charge(Unit::kIntegerMultiplier, std::max(bits.ready, n.ready))};
        else
            return high;
    }

    // Uniform choice of `count` of the n candidates by selection sampling: a candidate is taken with
    // probability (still to take) / (still to come). Exact up to 2^-32.
    template <class D>
    static SampleMask<D> subset(std::uint64_t key, const typename D::Uint& count,
                                const SampleMask<D>& candidates, const typename D::Uint& n, int samples) {
        using Uint = typename D::Uint;
        SampleMask<D> chosen;
        Uint wanted = count;
        Uint left = n;
        if constexpr (D::kCharged) {
            for (int s = 0; s < samples; ++s) {
                const auto position = scaled<D>(draw_bits<D>(key, static_cast<std::uint32_t>(1 + s)), left);
                const auto take = both(position < wanted, candidates.test(s));
                chosen.wires[static_cast<std::size_t>(s)] = take;
                wanted = wanted - select(take, Uint(1u), Uint(0u));
                left = left - select(candidates.test(s), Uint(1u), Uint(0u));
            }
        } else {
            std::uint64_t rest = candidates.bits;
            for (; rest != 0 && wanted != 0 && wanted < left; rest &= rest - 1, --left) {
                const int s = std::countr_zero(rest);
                const auto position = scaled<D>(draw_bits<D>(key, static_cast<std::uint32_t>(1 + s)), left);
                if (position >= wanted) continue;
                chosen.bits |= 1ull << s;
                --wanted;
            }
            if (wanted != 0) chosen.bits |= rest;  // as many as are left
        }
        return chosen;
    }

    Screen screen_;
    const SamplingOptions* options_;
    Masks masks_ = Masks::kChoose;
    SeedFrom seed_from_ = SeedFrom::kPrimitive;
    bool dithers_ = false;
    bool depth_first_ = false;
    int bright_samples_ = 0;
    float dark_below_ = 0;
    std::unique_ptr<MaskTable> table_;
};

}  // namespace

class Stochastic : public StoredSamples<MaskChooser> {
 public:
    static constexpr TechniqueInfo kInfo = {
        "stochastic", "stochastic transparency (Enderton et al. 2011)",
        "masks=choose|coin|run|table|alpha_to_coverage|blue_noise, rounding=random|dither, "
        "depth_test=last|first, seed_from=primitive|depth|object|object_facing|pattern, "
        "bright_samples=samples, dark_below=0.25, samples=8 (1..64, a multiple of the trace's), "
        "method=basic|depth_based, correction=none|coverage|accumulated, total_alpha=pixel|sample, "
        "accumulator=pixel|sample, passes=separate|merged, hardware_samples=0 (of one round; 0: all), "
        "strata=all|pass, filter=box|gaussian, early_termination=false, adaptive_error=0, cross_filter=0, "
        "cross_sigma=0.05",
        true, "samples=8"};
    using StoredSamples::StoredSamples;

    std::uint32_t pixel_constant(int, int, glm::vec3 background) const {
        return chooser().pixel_constant(background);
    }
    std::uint64_t random_key(const Fragment& f) const { return chooser().random_key(f); }
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(stochastic, Stochastic)
