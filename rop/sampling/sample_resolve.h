// From stored samples to a pixel's colour: filtering, alpha correction (Enderton et al. 2011, 3.3 to 3.5 and
// 4), and the filter across pixels of similar total alpha (section 6).
#pragma once

#include "rop/display_filter.h"
#include "rop/sampling/sample_means.h"
#include "rop/technique.h"
#include "rop/transcendental.h"

#include <algorithm>
#include <array>
#include <vector>

namespace ropsim {

class SampleResolver : public SampleMeans {
 public:
    SampleResolver() = default;
    SampleResolver(const SamplingOptions& options, const SampleSurfaces& surfaces);

    // `used`: stored samples of this pixel that count, the first ones; `varies`: not the same in all pixels.
    template <class D, class P>
    Rgb<D> resolve(const Background<D>& background, P& pixel, int used, bool varies) const {
        fetch(pixel);
        if (options_->over_opaque() && options_->rounds() > 1)
            return scaled<D>(pixel.load_rgb(surfaces_->sum), rounds_share<D>(pixel));
        if (options_->over_opaque()) {
            if (varies) return mean_of_first<D>(pixel, used);
            pixel.fetch_all(surfaces_->color, options_->hardware_samples);
            return mean<D>([&](int s) { return pixel.load_rgb(surfaces_->color, s); }, nullptr);
        }
        return composite<D>(filter_pixel<D>(background, pixel, nullptr));
    }

    template <class D, class P>
    Rgb<D> resolve_window(Window<P>& window) const {
        return options_->cross_filter > 0 ? cross_filtered<D>(window) : filtered_window<D>(window);
    }

    // Filtered total alpha times the ratio of colour to weight: A of ST 4.1 or D of ST 4.2, without
    // background.
    template <class D>
    Rgb<D> corrected(const Rgb<D>& color, const typename D::Real& weight,
                     const typename D::Real& clear) const {
        using Real = typename D::Real;
        const auto empty = weight <= Real(0.0f);
        const Real factor = (Real(1.0f) - clear) / select(empty, Real(1.0f), weight);
        return scaled<D>(color, select(empty, Real(0.0f), factor));
    }

 private:
    // Quantities of a pixel or a window, filtered.
    template <class D>
    struct Filtered {
        Rgb<D> color;             // F(B) or F(U)
        typename D::Real weight;  // F(B1) or F(U1)
        typename D::Real clear;   // product of transmittances, or share of samples without a fragment
        Rgb<D> behind;            // the background, dimmed sample by sample
    };

    template <class P>
    void fetch(P& pixel) const {
        const int samples = options_->hardware_samples;
        if (options_->adaptive()) pixel.fetch_all(surfaces_->rounds, 1);
        if (options_->gathers() &&
            (!options_->depth_based() || options_->correction != Correction::kAccumulated))
            pixel.fetch_all(options_->depth_based() ? surfaces_->sum_coverage : surfaces_->sum, 1);
        if (!options_->depth_based() && !options_->gathers() && !options_->over_opaque())
            pixel.fetch_all(surfaces_->color, samples);
        if (options_->depth_based()) {
            pixel.fetch_all(surfaces_->accumulated, options_->accumulator_per_sample ? samples : 1);
            if (options_->merged)
                pixel.fetch_all(surfaces_->weight, options_->accumulator_per_sample ? samples : 1);
            if (!options_->gathers() && options_->correction != Correction::kAccumulated)
                pixel.fetch_all(surfaces_->depth, samples);
        }
        if (options_->has_total())
            pixel.fetch_all(surfaces_->total, options_->total_per_sample ? samples : 1);
    }

    template <class D, class P>
    Rgb<D> mean_of_first(P& pixel, int used) const {
        using Real = typename D::Real;
        for (int s = 0; s < options_->hardware_samples; ++s)
            pixel.fetch_if(typename D::Bool(s < used), surfaces_->color, s);
        Real share = 1.0f / static_cast<float>(used);
        if constexpr (D::kCharged) share.ready = Ledger::active().charge(Unit::kTable, 0);
        const auto channel = [&](int c) {
            std::array<Real, kMaxElements> terms;
            for (int s = 0; s < options_->hardware_samples; ++s)
                terms[static_cast<std::size_t>(s)] =
                    select(typename D::Bool(s < used), pixel.load(surfaces_->color, s, c), Real(0.0f));
            return tree_sum(terms, options_->hardware_samples) * share;
        };
        return {channel(0), channel(1), channel(2)};
    }

    // `weights`: of the spatial samples, or null for the mean.
    template <class D, class P>
    Filtered<D> filter_pixel(const Background<D>& background, P& pixel, const float* weights) const {
        Filtered<D> f{};
        filter_color<D>(pixel, weights, f);
        if (!options_->has_total()) {
            filter_uncorrected_background<D>(background, pixel, weights, f);
            return f;
        }
        if (!options_->total_per_sample) {
            f.clear = pixel.load(surfaces_->total);
            f.behind = scaled<D>(background.mean, f.clear);
            return f;
        }
        const auto clear = [&](int s) { return pixel.load(surfaces_->total, s); };
        f.clear = mean_value<D>(clear, weights);
        f.behind = options_->spatial_samples == 1 && weights == nullptr
                       ? scaled<D>(background.mean, f.clear)
                       : mean<D>([&](int s) { return scaled<D>(behind(background, s), clear(s)); }, weights);
        return f;
    }
    template <class D>
    const Rgb<D>& behind(const Background<D>& background, int s) const {
        return background.sample[static_cast<std::size_t>(s % options_->spatial_samples)];
    }

    template <class D, class P>
    void filter_color(P& pixel, const float* weights, Filtered<D>& f) const {
        using Real = typename D::Real;
        f.weight = Real(1.0f);
        if (!options_->depth_based() && options_->gathers()) {
            f.color = pixel.load_rgb(surfaces_->sum);  // rounds cancel against those in the weight
            f.weight = pixel.load(surfaces_->sum_coverage);
        } else if (!options_->depth_based()) {
            f.color = mean<D>([&](int s) { return pixel.load_rgb(surfaces_->color, s); }, weights);
            f.weight = mean_value<D>([&](int s) { return pixel.load(surfaces_->color, s, 3); }, weights);
        } else if (options_->accumulator_per_sample) {
            f.color = mean<D>([&](int s) { return pixel.load_rgb(surfaces_->accumulated, s); }, weights);
            if (options_->has_total())
                f.weight = mean_value<D>([&](int s) { return pixel.load(surfaces_->weight, s); }, weights);
        } else {
            f.color = pixel.load_rgb(surfaces_->accumulated);
            if (options_->has_total()) f.weight = pixel.load(surfaces_->weight);
        }
        if (!options_->depth_based() || options_->correction == Correction::kAccumulated) return;
        if (options_->rounds() > 1) f.color = scaled<D>(f.color, rounds_share<D>(pixel));
        if (options_->correction != Correction::kCoverage) return;
        f.weight =
            options_->gathers()
                ? pixel.load(surfaces_->sum_coverage) * rounds_share<D>(pixel)
                : mean_value<D>([&](int s) { return select(is_empty<D>(pixel, s), Real(0.0f), Real(1.0f)); },
                                weights);
    }

    // Without total alpha the background shows through the samples that no fragment took: ST 3.4's example.
    template <class D, class P>
    void filter_uncorrected_background(const Background<D>& background, P& pixel, const float* weights,
                                       Filtered<D>& f) const {
        using Real = typename D::Real;
        if (options_->gathers()) {
            f.clear = Real(1.0f) - pixel.load(surfaces_->sum_coverage) * rounds_share<D>(pixel);
            f.behind = scaled<D>(background.mean, f.clear);
            return;
        }
        if (options_->spatial_samples == 1 && weights == nullptr) {
            f.clear = empty_share<D>(pixel);
            f.behind = scaled<D>(background.mean, f.clear);
            return;
        }
        f.clear = Real(0.0f);
        f.behind = mean<D>(
            [&](int s) {
                const auto empty = is_empty<D>(pixel, s);
                const Rgb<D>& b = behind(background, s);
                return Rgb<D>{select(empty, b.r, Real(0.0f)), select(empty, b.g, Real(0.0f)),
                              select(empty, b.b, Real(0.0f))};
            },
            weights);
    }

    template <class D>
    Rgb<D> composite(const Filtered<D>& f) const {
        if (!options_->has_total()) return added<D>(f.color, f.behind);
        return added<D>(corrected<D>(f.color, f.weight, f.clear), f.behind);
    }

    template <class D, class P>
    Rgb<D> filtered_window(Window<P>& window) const {
        const int reach = window.footprint();
        Filtered<D> sum{};
        std::size_t number = 0;
        for (int dy = -reach; dy <= reach; ++dy) {
            for (int dx = -reach; dx <= reach; ++dx, ++number) {
                P pixel = window.at(dx, dy);
                fetch(pixel);
                const float* weights = weights_[number].data();
                Filtered<D> f{};
                if (options_->over_opaque()) {
                    pixel.fetch_all(surfaces_->color, options_->hardware_samples);
                    f.color = mean<D>([&](int s) { return pixel.load_rgb(surfaces_->color, s); }, weights);
                    f.behind = {0.0f, 0.0f, 0.0f};
                } else {
                    f = filter_pixel<D>(window.background(dx, dy), pixel, weights);
                }
                sum = number == 0 ? f : joined<D>(sum, f);
            }
        }
        return options_->over_opaque() ? sum.color : composite<D>(sum);
    }
    template <class D>
    Filtered<D> joined(const Filtered<D>& a, const Filtered<D>& b) const {
        if (options_->over_opaque()) return {added<D>(a.color, b.color), a.weight, a.clear, a.behind};
        return {added<D>(a.color, b.color), a.weight + b.weight, a.clear + b.clear,
                added<D>(a.behind, b.behind)};
    }

    // Bilateral over the corrected colours, by nearness and by total alpha, which has no noise.
    template <class D, class P>
    Rgb<D> cross_filtered(Window<P>& window) const {
        using Real = typename D::Real;
        const int reach = window.footprint();
        P middle = window.at(0, 0);
        fetch_corrected(middle);
        const Real clear = clear_share<D>(middle);
        Rgb<D> sum = {0.0f, 0.0f, 0.0f};
        Real weights = 0.0f;
        for (int dy = -reach; dy <= reach; ++dy) {
            for (int dx = -reach; dx <= reach; ++dx) {
                P pixel = window.at(dx, dy);
                fetch_corrected(pixel);
                const Real weight = cross_weight<D>(clear_share<D>(pixel) - clear, dx * dx + dy * dy);
                sum = added<D>(sum, scaled<D>(pixel.load_rgb(surfaces_->accumulated), weight));
                weights = weights + weight;
            }
        }
        const Background<D> background = window.background(0, 0);
        Rgb<D> behind = scaled<D>(background.mean, clear);
        if (options_->total_per_sample)
            behind = mean<D>(
                [&](int s) {
                    return scaled<D>(this->behind(background, s), middle.load(surfaces_->total, s));
                },
                nullptr);
        return added<D>(scaled<D>(sum, Real(1.0f) / weights), behind);
    }
    template <class P>
    void fetch_corrected(P& pixel) const {
        pixel.fetch_all(surfaces_->accumulated, 1);
        pixel.fetch_all(surfaces_->total, options_->total_per_sample ? options_->hardware_samples : 1);
    }
    // exp(-d^2 / (2 sigma^2)) of the difference in total alpha, from a table, times that of the distance.
    template <class D>
    typename D::Real cross_weight(const typename D::Real& difference, int squared_distance) const {
        const double d = value_of(difference);
        const double sigma = options_->cross_sigma;
        const double spatial = 0.5 * options_->cross_filter;
        const double exponent = -d * d / (2 * sigma * sigma) - squared_distance / (2 * spatial * spatial);
        typename D::Real weight =
            static_cast<float>(deterministic_power(2.718281828459045, std::max(exponent, -40.0)));
        if constexpr (D::kCharged) weight.ready = Ledger::active().charge(Unit::kTable, difference.ready);
        return weight;
    }

    std::vector<std::vector<float>> weights_;  // of the window's pixels and their spatial samples
};

}  // namespace ropsim
