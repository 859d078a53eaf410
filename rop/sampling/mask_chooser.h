// How stochastic transparency picks a fragment's samples (Enderton et al. 2011, sections 2, 3.1, 5 and 6): a
// chooser of stored_samples.h, by itself for techniques that keep depth alone. techniques/stochastic.cpp says
// what the paper leaves open.
#pragma once

#include "rop/sampling/blue_noise.h"
#include "rop/sampling/mask_table.h"
#include "rop/sampling/random_masks.h"
#include "rop/sampling/stored_samples.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <memory>

namespace ropsim {

class MaskChooser {
 public:
    static constexpr const char* kNothing = "empty_mask";
    static constexpr const char* kWrite = "write";

    MaskChooser(Parameters& parameters, const Screen& screen, const SamplingOptions& options);

    static void declare(Declaration&, std::vector<int>&) {}
    static void declare_order(Declaration& declaration) { declaration.ordering = Ordering::kAny; }
    bool samples_vary() const { return bright_samples_ != options_->samples; }
    static int used_samples(std::uint32_t pixel_constant) { return static_cast<int>(pixel_constant); }

    // Section 6: "making S higher in pixels where the background is dark".
    std::uint32_t pixel_constant(glm::vec3 background) const;
    // Section 6's seeds. Also has to be the technique's own random_key().
    std::uint64_t random_key(const Fragment& f) const;

    template <class D, class P>
    SampleChoice<D> choose(D& d, const ChoiceInput<D, P>& in) const {
        const FragmentInput<D>& f = in.fragment;
        const int used = used_samples(value_of(f.pixel_constant));
        const std::uint64_t covered = in.covered & low_bits(static_cast<std::uint32_t>(used));
        if (depth_first_) return choose_survivors(d, in, covered);
        const SampleMask<D> mask =
            both(masked<D>(f, covered), mask_at<D>(covered, 0), options_->hardware_samples);
        if (d.decide(inverse(any_sample(mask, options_->hardware_samples)))) return {true, {}};
        fetch(in, in.whole_pixel ? mask_at<D>(~0ull, 0) : mask);
        return {false, nearer(in, mask)};
    }

 private:
    enum class Masks : std::uint8_t { kCoin, kChoose, kRun, kTable, kAlphaToCoverage, kBlueNoise };
    enum class SeedFrom : std::uint8_t { kPrimitive, kDepth, kObject, kObjectFacing, kPattern };

    void check(const Parameters& parameters) const;
    bool uses_any_samples() const;

    template <class D, class P>
    void fetch(const ChoiceInput<D, P>& in, const SampleMask<D>& mask) const {
        for (int s = 0; s < options_->hardware_samples; ++s) in.pixel.fetch_if(mask.test(s), in.depth, s);
    }
    // Those of the mask where the fragment is nearer than what is stored.
    template <class D, class P>
    SampleMask<D> nearer(const ChoiceInput<D, P>& in, const SampleMask<D>& mask) const {
        return compared<DepthCompare::kLess, D>(mask, in.depths, in.pixel, in.depth,
                                                options_->hardware_samples);
    }

    template <class D, class P>
    SampleChoice<D> choose_survivors(D& d, const ChoiceInput<D, P>& in, std::uint64_t covered) const {
        const auto coverage = mask_at<D>(covered, 0);
        fetch(in, in.whole_pixel ? mask_at<D>(~0ull, 0) : coverage);
        const SampleMask<D> survivors = nearer(in, coverage);
        const auto n = count_samples(survivors, options_->hardware_samples);
        const FragmentInput<D>& f = in.fragment;
        const SampleMask<D> mask =
            random_subset<D>(round_key(f), count_of<D>(f, n), survivors, n, options_->hardware_samples);
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
                                                           charge_selector(options_->rounds(), ready)};
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
                return of_round(coin_mask<D>(key, f.a, samples), f.round);
            case Masks::kChoose: {
                // Coverage repeats with the round, so that all rounds' is known in each.
                std::uint64_t all = covered;
                for (int s = options_->hardware_samples; s < samples; s += options_->hardware_samples)
                    all |= covered << s;
                const typename D::Uint n(count_samples(SampleMask<PlainDatapath>{all}, samples));
                return of_round(random_subset<D>(key, count_of<D>(f, n), mask_at<D>(all, 0), n, samples),
                                f.round);
            }
            case Masks::kRun: {
                const typename D::Uint n(static_cast<std::uint32_t>(samples));
                const auto count = count_of<D>(f, n);
                const auto start = scaled_draw<D>(draw_bits<D>(key, 1), n);
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
            entry = scaled_draw<D>(draw_bits<D>(key, 0), Uint(MaskTable::kEntries));
        return looked_up<D>(table_->mask(value_of(entry), MaskTable::level(value_of(f.a))), entry, f.a);
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

}  // namespace ropsim
