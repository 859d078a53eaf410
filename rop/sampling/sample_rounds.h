// What several rounds keep of one another (Enderton et al. 2011, notes 3 and 4), and the judgement whether a
// pixel needs another (section 6, adaptive sampling): image passes.
#pragma once

#include "rop/sampling/sample_resolve.h"

namespace ropsim {

class SampleRounds {
 public:
    SampleRounds() = default;
    // What it refers to must not move.
    SampleRounds(const SamplingOptions& options, const SampleSurfaces& surfaces, const SamplePaths& paths,
                 const SampleResolver& resolver)
        : options_(&options), surfaces_(&surfaces), paths_(&paths), resolver_(&resolver) {}

    // After a round: adds it to the sums and, with adaptive_error, decides whether the pixel goes on.
    template <class D, class P>
    int gather(D& d, P& pixel) const {
        using Uint = typename D::Uint;
        Uint rounds = 0u;
        if (options_->adaptive()) {
            pixel.fetch_all(surfaces_->rounds, 1);
            rounds = pixel.load_bits(surfaces_->rounds);
            const auto settled = Uint(kSettled - 1) < rounds;
            if (d.decide(settled)) return paths_->settled;
            pixel.next_fetch_stage(settled);
        }
        fetch(pixel);
        const Round<D> round = options_->depth_based() ? depth_based_round<D>(pixel) : basic_round<D>(pixel);
        return options_->adaptive() ? judge<D>(d, pixel, round, rounds + Uint(1u)) : paths_->gather;
    }

    // The corrected colour takes the place of the accumulated one, for a filter across pixels to read.
    template <class D, class P>
    int correct(P& pixel) const {
        pixel.fetch_all(surfaces_->accumulated, 1);
        if (options_->merged) pixel.fetch_all(surfaces_->weight, 1);
        pixel.fetch_all(surfaces_->total, options_->total_per_sample ? options_->hardware_samples : 1);
        const Rgb<D> color =
            resolver_->corrected<D>(pixel.load_rgb(surfaces_->accumulated), pixel.load(surfaces_->weight),
                                    resolver_->clear_share<D>(pixel));
        pixel.write(surfaces_->accumulated);
        pixel.put_rgb(surfaces_->accumulated, 0, color);
        return paths_->correct;
    }

 private:
    // A round's own luminance and what it is to be divided by.
    template <class D>
    struct Round {
        typename D::Real luminance;
        typename D::Real weight;
    };

    template <class P>
    void fetch(P& pixel) const {
        const int samples = options_->hardware_samples;
        const bool sums = !options_->depth_based() || options_->correction != Correction::kAccumulated;
        if (sums) {
            pixel.fetch_all(options_->depth_based() ? surfaces_->depth : surfaces_->color, samples);
            pixel.fetch_all(surfaces_->sum_coverage, 1);
        }
        if (!options_->adaptive()) return;
        pixel.fetch_all(surfaces_->statistics, 1);
        if (options_->depth_based()) pixel.fetch_all(surfaces_->accumulated, 1);
        if (options_->has_total())
            pixel.fetch_all(surfaces_->total, options_->total_per_sample ? samples : 1);
    }

    // Rec. 709.
    template <class D>
    static typename D::Real luminance(const Rgb<D>& c) {
        using Real = typename D::Real;
        return Real(0.2126f) * c.r + Real(0.7152f) * c.g + Real(0.0722f) * c.b;
    }

    template <class D, class P>
    Round<D> basic_round(P& pixel) const {
        const Rgb<D> mean =
            resolver_->mean<D>([&](int s) { return pixel.load_rgb(surfaces_->color, s); }, nullptr);
        typename D::Real coverage = 1.0f;
        if (!options_->over_opaque())
            coverage =
                resolver_->mean_value<D>([&](int s) { return pixel.load(surfaces_->color, s, 3); }, nullptr);
        pixel.write(surfaces_->sum);
        pixel.put_rgb(surfaces_->sum, 0, added<D>(pixel.load_rgb(surfaces_->sum), mean));
        pixel.put(surfaces_->sum_coverage, 0, 0, pixel.load(surfaces_->sum_coverage) + coverage);
        return {luminance<D>(mean), coverage};
    }

    template <class D, class P>
    Round<D> depth_based_round(P& pixel) const {
        using Real = typename D::Real;
        Round<D> round = {Real(0.0f), Real(1.0f)};
        if (options_->correction != Correction::kAccumulated) {
            round.weight = Real(1.0f) - resolver_->empty_share<D>(pixel);
            pixel.write(surfaces_->sum_coverage);
            pixel.put(surfaces_->sum_coverage, 0, 0, pixel.load(surfaces_->sum_coverage) + round.weight);
        }
        if (!options_->adaptive()) return round;
        // The accumulator goes through all rounds: this one's part is what has come to it.
        const Real sum = luminance<D>(pixel.load_rgb(surfaces_->accumulated));
        round.luminance = sum - pixel.load(surfaces_->statistics, 0, 0);
        if (options_->correction == Correction::kAccumulated) {
            const Real weight = pixel.load(surfaces_->weight);
            round.weight = weight - pixel.load(surfaces_->statistics, 0, 1);
            pixel.put(surfaces_->statistics, 0, 1, weight);
        }
        pixel.put(surfaces_->statistics, 0, 0, sum);
        return round;
    }

    // The standard error of the mean over the rounds so far, squared: (sum x^2 - (sum x)^2 / n) / (n (n -
    // 1)), against the one asked for. One round has none.
    template <class D, class P>
    int judge(D& d, P& pixel, const Round<D>& round, const typename D::Uint& rounds) const {
        using Real = typename D::Real;
        using Uint = typename D::Uint;
        Real x = round.luminance;
        if (options_->has_total()) {
            const auto empty = round.weight <= Real(0.0f);
            const Real ratio = x / select(empty, Real(1.0f), round.weight);
            x = (Real(1.0f) - resolver_->clear_share<D>(pixel)) * select(empty, Real(0.0f), ratio);
        }
        const Real sum = pixel.load(surfaces_->statistics, 0, 2) + x;
        const Real squares = pixel.load(surfaces_->statistics, 0, 3) + x * x;
        pixel.write(surfaces_->statistics);
        pixel.put(surfaces_->statistics, 0, 2, sum);
        pixel.put(surfaces_->statistics, 0, 3, squares);
        const Real spread = squares - sum * sum * SampleResolver::reciprocal<D>(rounds);
        const std::uint32_t n = value_of(rounds);
        const double error = options_->adaptive_error / 255.0;
        Real allowed = static_cast<float>(error * error * n * (n - 1));
        if constexpr (D::kCharged) allowed.ready = Ledger::active().charge(Unit::kTable, rounds.ready);
        const auto goes_on =
            either(rounds < Uint(static_cast<std::uint32_t>(options_->adaptive_rounds)), allowed < spread);
        pixel.write(surfaces_->rounds);
        pixel.put_bits(surfaces_->rounds, 0, 0, select(goes_on, rounds, rounds | Uint(kSettled)));
        return d.decide(goes_on) ? paths_->go_on : paths_->settle;
    }

    const SamplingOptions* options_ = nullptr;
    const SampleSurfaces* surfaces_ = nullptr;
    const SamplePaths* paths_ = nullptr;
    const SampleResolver* resolver_ = nullptr;
};

}  // namespace ropsim
