// What techniques of stored samples share: everything but how a fragment picks its samples. Enderton et al.
// 2011 (ST): the basic method (3.1), alpha correction (3.3), the depth-based method (3.4), several samples in
// space (3.5) and several rounds (notes 3 and 4). Decided here where the paper is silent: the accumulation
// pass lets equal depths through, so that a fragment sees its own samples, and depths are compared as they
// are stored. Which of equal depths stays in the stochastic pass is the chooser's business.
#pragma once

#include "rop/sampling/fragment_depths.h"
#include "rop/sampling/sample_rounds.h"
#include "rop/sampling/sample_surfaces.h"
#include "rop/technique.h"

#include <array>
#include <vector>

namespace ropsim {

// Chooser(Parameters&, const Screen&, const SamplingOptions&) with
//   void declare(Declaration&, std::vector<int>& restored)       its own surfaces
//   SampleChoice<D> choose(D&, const ChoiceInput<D, P>&) const   fetches what it needs
//   bool samples_vary() const, int used_samples(std::uint32_t pixel_constant) const     of a pixel
//   void declare_order(Declaration&) const                       ordering, harmless fragments
//   static constexpr const char* kNothing, * kWrite              names of its control paths
template <class Chooser>
class StoredSamples {
 public:
    static constexpr bool kRandom = true;

    StoredSamples(Parameters& parameters, const Screen& screen)
        : options_(parameters, screen), chooser_(parameters, screen, options_) {
        const TechniqueFormats formats(parameters);
        declare_samples(options_, formats, declaration_, surfaces_);
        chooser_.declare(declaration_, surfaces_.restored);
        declare_rounds(options_, formats, declaration_, surfaces_);
        kinds_ =
            declare_passes(options_, Chooser::kNothing, Chooser::kWrite, declaration_, surfaces_, paths_);
        declaration_.image_format = formats.image();
        chooser_.declare_order(declaration_);
        resolver_ = SampleResolver(options_, surfaces_);
        rounds_ = SampleRounds(options_, surfaces_, paths_, resolver_);
    }
    StoredSamples(const StoredSamples&) = delete;
    StoredSamples& operator=(const StoredSamples&) = delete;
    const Declaration& declaration() const { return declaration_; }
    const Chooser& chooser() const { return chooser_; }

    template <class D, class P>
    int fragment(D& d, int pass, const FragmentInput<D>& f, P& pixel) const {
        switch (kinds_[static_cast<std::size_t>(pass)]) {
            case SamplePass::kTotalAlpha:
                fetch_total<D>(f, pixel);
                multiply_total<D>(f, pixel);
                return paths_.total_alpha;
            case SamplePass::kWrite:
                return write(d, f, pixel);
            case SamplePass::kAccumulate:
                return accumulate(d, f, pixel);
            case SamplePass::kGather:
            case SamplePass::kCorrect:
                break;
        }
        CHECK(false, "pass {} is not over fragments", pass);
    }

    // Only the stochastic pass draws.
    bool draws(int pass) const { return kinds_[static_cast<std::size_t>(pass)] == SamplePass::kWrite; }

    template <class D, class P>
    int image_pass(D& d, int pass, P& pixel) const {
        return kinds_[static_cast<std::size_t>(pass)] == SamplePass::kGather
                   ? rounds_.gather(d, pixel)
                   : rounds_.template correct<D>(pixel);
    }
    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>& background, P& pixel, int& path) const {
        path = paths_.resolve;
        const int used = chooser_.used_samples(value_of(pixel.constant(declaration_.pixel_words)));
        return resolver_.template resolve<D>(background, pixel, used, chooser_.samples_vary());
    }
    // Of several rounds, that of the last one's samples.
    void visibility(PlainPixel& pixel, std::span<const float> depths, std::span<float> values) const {
        const int used = chooser_.used_samples(pixel.constant(declaration_.pixel_words));
        visible_shares(pixel, surfaces_.depth, std::min(options_.hardware_samples, used), depths, values);
    }
    template <class D, class P>
    Rgb<D> resolve_window(D&, Window<P>& window, int& path) const {
        path = paths_.resolve;
        return resolver_.template resolve_window<D>(window);
    }

 protected:
    SamplingOptions options_;
    Chooser chooser_;
    Declaration declaration_;

 private:
    template <class D>
    std::uint64_t covered(const FragmentInput<D>& f) const {
        return stored_coverage(value_of(f.coverage), options_.spatial_samples, options_.hardware_samples);
    }

    // The nearest depth of a fragment, at any sample.
    template <class D>
    typename D::Real nearest(const FragmentDepths<D>& depths) const {
        typename D::Real z = depths.z[0];
        for (int m = 1; m < options_.spatial_samples; ++m)
            z = minimum(z, depths.z[static_cast<std::size_t>(m)]);
        return z;
    }

    // Whether the pixel takes part in this round: hardware reads a byte before it asks for the rest.
    template <class D, class P>
    bool settled(D& d, P& pixel) const {
        using Uint = typename D::Uint;
        if (!options_.adaptive()) return false;
        pixel.fetch_all(surfaces_.rounds, 1);
        const auto is_settled = Uint(kSettled - 1) < pixel.load_bits(surfaces_.rounds);
        if (d.decide(is_settled)) return true;
        pixel.next_fetch_stage(is_settled);
        return false;
    }
    // Whether every sample is nearer than the fragment.
    template <class D, class P>
    bool saturated(D& d, const FragmentDepths<D>& depths, P& pixel) const {
        if (!options_.early_termination) return false;
        pixel.fetch_all(surfaces_.farthest, 1);
        const auto is_behind = pixel.load(surfaces_.farthest) < nearest<D>(depths);
        if (d.decide(is_behind)) return true;
        pixel.next_fetch_stage(is_behind);
        return false;
    }

    template <class D, class P>
    void fetch_total(const FragmentInput<D>& f, P& pixel) const {
        if (!options_.total_per_sample) return pixel.fetch_all(surfaces_.total, 1);
        const auto mask = mask_at<D>(covered(f), 0);
        for (int s = 0; s < options_.hardware_samples; ++s) pixel.fetch_if(mask.test(s), surfaces_.total, s);
    }
    // Total alpha as the product of transmittances: ST eq. 5. A pixel's single value takes a fragment that
    // covers part of the pixel as a thinner one.
    template <class D, class P>
    void multiply_total(const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        if (options_.total_per_sample) {
            const Real transmittance = Real(1.0f) - f.a;
            for_samples(mask_at<D>(covered(f), 0), options_.hardware_samples, [&](int s) {
                const auto mine = mask_at<D>(covered(f), 0).test(s);
                pixel.write_if(mine, surfaces_.total, s);
                pixel.put_if(mine, surfaces_.total, s, 0, pixel.load(surfaces_.total, s) * transmittance);
            });
            return;
        }
        Real alpha = f.a;
        if (options_.spatial_samples > 1) {
            const auto samples = static_cast<float>(
                std::popcount(value_of(f.coverage) & ((1u << options_.spatial_samples) - 1u)));
            alpha = alpha * Real(samples / static_cast<float>(options_.spatial_samples));
        }
        pixel.write(surfaces_.total);
        pixel.put(surfaces_.total, 0, 0, pixel.load(surfaces_.total) * (Real(1.0f) - alpha));
    }

    // The stochastic pass: depth, and with the basic method colour, into the samples chosen.
    template <class D, class P>
    int write(D& d, const FragmentInput<D>& f, P& pixel) const {
        if (settled(d, pixel)) return paths_.settled_write;
        const bool totals = options_.merged && !options_.depth_based();
        if (totals) fetch_total<D>(f, pixel);
        const FragmentDepths<D> depths = stored_depths<D>(f, pixel, surfaces_.depth);
        if (saturated(d, depths, pixel)) {
            if (totals) multiply_total<D>(f, pixel);
            return paths_.saturated_write;
        }
        const SampleChoice<D> choice = chooser_.choose(
            d, ChoiceInput<D, P>{f, depths, covered(f), pixel, surfaces_.depth, options_.early_termination});
        if (totals) multiply_total<D>(f, pixel);
        if (choice.nothing) return paths_.nothing;
        if (options_.early_termination) lower_farthest<D>(choice.write, depths, f, pixel);
        store<D>(choice.write, depths, f, pixel);
        return paths_.write;
    }

    template <class D, class P>
    void store(const SampleMask<D>& samples, const FragmentDepths<D>& depths, const FragmentInput<D>& f,
               P& pixel) const {
        for_samples(samples, options_.hardware_samples, [&](int s) {
            pixel.write_if(samples.test(s), surfaces_.depth, s);
            pixel.put_if(samples.test(s), surfaces_.depth, s, 0, depths.of(s));
        });
        if (options_.depth_based()) return;
        const auto color = pixel.converted(surfaces_.color, f.straight());
        for_samples(samples, options_.hardware_samples, [&](int s) {
            pixel.write_if(samples.test(s), surfaces_.color, s);
            pixel.put_converted_if(samples.test(s), surfaces_.color, s, color);
            if (!options_.over_opaque())
                pixel.put_if(samples.test(s), surfaces_.color, s, 3, typename D::Real(1.0f));
        });
    }

    // The farthest stored depth once the fragment is written: a tree of comparators over the samples.
    template <class D, class P>
    void lower_farthest(const SampleMask<D>& taken, const FragmentDepths<D>& depths,
                        const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        std::array<Real, kMaxElements> z;
        const int samples = options_.hardware_samples;
        const int used = chooser_.used_samples(value_of(f.pixel_constant));
        for (int s = 0; s < samples; ++s) {
            Real& mine = z[static_cast<std::size_t>(s)];
            mine = select(taken.test(s), depths.of(s), pixel.load(surfaces_.depth, s));
            // Samples that this pixel does without must not hold it open.
            if (chooser_.samples_vary()) mine = select(typename D::Bool(s < used), mine, Real(0.0f));
        }
        for (int stride = 1; stride < samples; stride *= 2)
            for (int s = 0; s + stride < samples; s += 2 * stride)
                z[static_cast<std::size_t>(s)] =
                    maximum(z[static_cast<std::size_t>(s)], z[static_cast<std::size_t>(s + stride)]);
        pixel.write_if(any_sample(taken, samples), surfaces_.farthest, 0);
        pixel.put(surfaces_.farthest, 0, 0, z[0]);
    }

    // ST eqs. 4 and 6: the fragment's colour times the share of samples it is not hidden in.
    template <class D, class P>
    int accumulate(D& d, const FragmentInput<D>& f, P& pixel) const {
        if (settled(d, pixel)) return paths_.settled_accumulate;
        if (options_.merged) fetch_total<D>(f, pixel);
        const FragmentDepths<D> depths = stored_depths<D>(f, pixel, surfaces_.depth);
        // Samples that the pixel does not use stay empty: a fragment would be seen in all of them.
        const auto used = static_cast<std::uint32_t>(chooser_.used_samples(value_of(f.pixel_constant)));
        const std::uint64_t mine = covered(f) & low_bits(used);
        if (saturated(d, depths, pixel)) {
            if (options_.merged) multiply_total<D>(f, pixel);
            return paths_.saturated_accumulate;
        }
        const auto coverage = mask_at<D>(mine, 0);
        fetch_accumulated<D>(coverage, pixel);
        const SampleMask<D> visible = compared<DepthCompare::kLessEqual, D>(
            mask_at<D>(mine, 0), depths, pixel, surfaces_.depth, options_.hardware_samples);
        if (options_.merged) multiply_total<D>(f, pixel);
        const auto any = any_sample(visible, options_.hardware_samples);
        if (d.decide(inverse(any))) return paths_.unseen;
        if (options_.accumulator_per_sample)
            add_to_samples<D>(visible, f, pixel);
        else
            add_to_pixel<D>(visible, f, pixel);
        return paths_.accumulate;
    }

    template <class D, class P>
    void fetch_accumulated(const SampleMask<D>& coverage, P& pixel) const {
        for_samples(coverage, options_.hardware_samples, [&](int s) {
            pixel.fetch_if(coverage.test(s), surfaces_.depth, s);
            if (!options_.accumulator_per_sample) return;
            pixel.fetch_if(coverage.test(s), surfaces_.accumulated, s);
            if (options_.merged) pixel.fetch_if(coverage.test(s), surfaces_.weight, s);
        });
        if (options_.accumulator_per_sample) return;
        pixel.fetch_all(surfaces_.accumulated, 1);
        if (options_.merged) pixel.fetch_all(surfaces_.weight, 1);
    }

    template <class D, class P>
    void add_to_pixel(const SampleMask<D>& visible, const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        const auto count = count_samples(visible, options_.hardware_samples);
        const int used = chooser_.used_samples(value_of(f.pixel_constant));
        const float share = static_cast<float>(value_of(count)) / static_cast<float>(used);
        Real visibility = share;
        if constexpr (D::kCharged) visibility.ready = Ledger::active().charge(Unit::kTable, count.ready);
        const Rgb<D> sum = pixel.load_rgb(surfaces_.accumulated);
        pixel.write(surfaces_.accumulated);
        pixel.put_rgb(surfaces_.accumulated, 0,
                      {sum.r + visibility * f.premultiplied.r, sum.g + visibility * f.premultiplied.g,
                       sum.b + visibility * f.premultiplied.b});
        if (!options_.has_total()) return;  // nothing to divide by is kept
        if (options_.merged) pixel.write(surfaces_.weight);
        pixel.put(surfaces_.weight, 0, 0, pixel.load(surfaces_.weight) + visibility * f.a);
    }
    template <class D, class P>
    void add_to_samples(const SampleMask<D>& visible, const FragmentInput<D>& f, P& pixel) const {
        for_samples(visible, options_.hardware_samples, [&](int s) {
            const auto seen = visible.test(s);
            const Rgb<D> sum = pixel.load_rgb(surfaces_.accumulated, s);
            pixel.write_if(seen, surfaces_.accumulated, s);
            pixel.put_rgb_if(
                seen, surfaces_.accumulated, s,
                {sum.r + f.premultiplied.r, sum.g + f.premultiplied.g, sum.b + f.premultiplied.b});
            if (!options_.has_total()) return;
            if (options_.merged) pixel.write_if(seen, surfaces_.weight, s);
            pixel.put_if(seen, surfaces_.weight, s, 0, pixel.load(surfaces_.weight, s) + f.a);
        });
    }

    SampleSurfaces surfaces_;
    SamplePaths paths_;
    std::vector<SamplePass> kinds_;
    SampleResolver resolver_;
    SampleRounds rounds_;
};

}  // namespace ropsim
