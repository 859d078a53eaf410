// Stratified stochastic transparency: Laine and Karras 2011, Figures 4 and 7: surface tracking (section 2),
// the scrambled radical inverse (3) over a Hilbert pixel index, compaction by early depth and sorting by
// stored depth (4), each to be switched off. Feeds the passes of Enderton et al. 2011 too (section 6 leaves
// that open). Left open by the paper and decided here: samples of equal stored depth are sorted by sample
// number; the reference is compared as an integer (x < alpha 2^32), so that alpha 1 always passes, where a
// rounded float would fail once in 2^25. The run's seed offsets the pixel index; seed 0 is the paper bit for
// bit. Several rounds go on in the pixel's span of references, or, with strata=pass, take another surface's.
#include "rop/hilbert.h"
#include "rop/sampling/opacity_reference.h"
#include "rop/sampling/pixel_order.h"
#include "rop/sampling/sorting_network.h"
#include "rop/sampling/stored_samples.h"

#include <array>
#include <string>

namespace ropsim {

namespace {

class SurfaceChooser {
 public:
    static constexpr const char* kNothing = "hidden";
    static constexpr const char* kWrite = "draw";

    SurfaceChooser(Parameters& parameters, const Screen& screen, const SamplingOptions& options)
        : options_(&options),
          hilbert_order_(hilbert_order(screen.width, screen.height)),
          seed_offset_(screen.seed == 0 ? 0 : static_cast<std::uint32_t>(mix64(screen.seed))) {
        tracks_ = parameters.get_flag("tracking", true);
        compacts_ = parameters.get_flag("compaction", true);
        sorts_ = parameters.get_flag("sort", compacts_);
        if (sorts_ && !compacts_)
            throw UserError(parameters.where("sort"),
                            "gives numbers in order of depth to the samples that compaction leaves; use "
                            "sort=false, or compaction=true");
        morton_ = parameters.get_choice("index", "hilbert", {"hilbert", "morton"}) == "morton";
        const std::string hash =
            parameters.get_choice("hash", "paper", {"paper", "radical_inverse", "sobol", "improved"});
        hash_ = hash == "paper"             ? OpacityHash::kPaper
                : hash == "radical_inverse" ? OpacityHash::kRadicalInverse
                : hash == "sobol"           ? OpacityHash::kSobol
                                            : OpacityHash::kImproved;
    }

    void declare(Declaration& declaration, std::vector<int>& restored) {
        restored.push_back(static_cast<int>(declaration.surfaces.size()));
        std::vector<FieldSpec> fields = {FieldSpec::integer(32, 0)};
        if (tracks_) fields.insert(fields.begin(), FieldSpec::integer(options_->hardware_samples, 0));
        const auto tracking =
            declaration.surface("surface_tracking", 1, Layout::kInterleaved, Initial::kClear, fields);
        covered_ = tracking.front();
        surface_id_ = tracking.back();
    }
    void declare_order(Declaration& declaration) const {
        declaration.ordering = Ordering::kRaster;
        // Coverage tracking sees a fragment of zero alpha: it may start a new surface.
        declaration.zero_alpha_harmless = false;
    }
    static bool samples_vary() { return false; }
    int used_samples(std::uint32_t) const { return options_->hardware_samples; }

    std::uint32_t pixel_index(int x, int y) const {
        return (morton_ ? morton_index(x, y) : hilbert_index(hilbert_order_, x, y)) + seed_offset_;
    }

    // Fig. 7.
    template <class D, class P>
    SampleChoice<D> choose(D& d, const ChoiceInput<D, P>& in) const {
        using Uint = typename D::Uint;
        const int samples = options_->hardware_samples;
        const auto coverage = mask_at<D>(in.covered, 0);
        for (int s = 0; s < samples; ++s)
            in.pixel.fetch_if(in.whole_pixel ? typename D::Bool(true) : coverage.test(s), in.depth, s);
        in.pixel.fetch_all(surface_id_, 1);
        // Line 2 removes a sample where the fragment is farther; equal depths stay.
        const SampleMask<D> survivors = surviving<D>(in);
        if (d.decide(inverse(any_sample(survivors, samples)))) return {true, {}};
        // Without compaction the numbers are the samples' own, and hidden samples count as covered.
        const SampleMask<D>& drawn = compacts_ ? survivors : coverage;
        Uint id = in.pixel.load_bits(surface_id_);
        Uint first = 0u;
        if (tracks_)
            track<D>(in, drawn, id, first);
        else
            id = id + Uint(1u);  // every fragment is a surface of its own
        if (!compacts_) first = 0u;
        in.pixel.write(surface_id_);
        in.pixel.put_bits(surface_id_, 0, 0, id);
        return {false, passing<D>(in, survivors, first, id)};
    }

 private:
    template <class D, class P>
    SampleMask<D> surviving(const ChoiceInput<D, P>& in) const {
        return compared<DepthCompare::kLessEqual, D>(mask_at<D>(in.covered, 0), in.depths, in.pixel, in.depth,
                                                     options_->hardware_samples);
    }

    // Lines 4 to 8 and 18: a sample drawn twice means a new surface. `first`: samples drawn of this one
    // before.
    template <class D, class P>
    void track(const ChoiceInput<D, P>& in, const SampleMask<D>& drawn, typename D::Uint& id,
               typename D::Uint& first) const {
        using Uint = typename D::Uint;
        const int samples = options_->hardware_samples;
        const int words = samples > 32 ? 2 : 1;
        std::array<Uint, 2> before;
        for (int w = 0; w < words; ++w)
            before[static_cast<std::size_t>(w)] = in.pixel.load_bits(covered_, 0, w);
        // Each word's conflict is one row of gates and a tree; a comparison with 0 stands for both.
        typename D::Bool conflict = false;
        for (int w = 0; w < words; ++w) {
            const auto twice = before[static_cast<std::size_t>(w)] & word_of(drawn, samples, w);
            const auto any = Uint(0u) < twice;
            conflict = w == 0 ? any : either(conflict, any);
        }
        id = id + select(conflict, Uint(1u), Uint(0u));
        for (int w = 0; w < words; ++w) {
            Uint word = select(conflict, Uint(0u), before[static_cast<std::size_t>(w)]);
            const Uint count = population_count(word);
            first = w == 0 ? count : first + count;
            word = word | word_of(drawn, samples, w);
            in.pixel.put_bits(covered_, 0, w, word);
        }
    }

    // A power of two shifts: wiring.
    template <class D>
    static typename D::Uint times(const typename D::Uint& x, std::uint32_t factor) {
        if constexpr (D::kCharged)
            if (std::has_single_bit(factor)) return {x.value * factor, x.ready};
        return x * typename D::Uint(factor);
    }

    // Lines 9 to 17: which survivors are written. The k-th gets the reference of index first + k.
    template <class D, class P>
    SampleMask<D> passing(const ChoiceInput<D, P>& in, const SampleMask<D>& survivors,
                          const typename D::Uint& drawn, const typename D::Uint& id) const {
        using Uint = typename D::Uint;
        const FragmentInput<D>& f = in.fragment;
        const int samples = options_->hardware_samples;
        const bool across = options_->strata_across_rounds;
        const auto span = static_cast<std::uint32_t>(across ? options_->samples : samples);
        const Uint skipped = static_cast<std::uint32_t>(across ? f.round * samples : 0);
        const Uint first = drawn + (times<D>(f.pixel_constant, span) + skipped);
        const std::uint64_t threshold = alpha_threshold(value_of(f.a));
        const Uint surface = across || options_->rounds() == 1
                                 ? id
                                 : id + Uint(static_cast<std::uint32_t>(f.round) * 0x10000u);
        const Uint seed = surface_seed<D>(hash_, surface);
        SampleMask<D> result;
        const auto take = [&](const Uint& number, const typename D::Bool& valid, const Uint& sample) {
            const Uint reference = seeded_reference<D>(hash_, first + number, seed);
            const bool pass = value_of(reference) < threshold && value_of(valid);
            const auto s = static_cast<std::size_t>(value_of(sample));
            if constexpr (D::kCharged) {
                const int compared = Ledger::active().charge(Unit::kComparator, reference.ready);
                // The pass bit goes back from its place in the order to its sample: a selector a sample.
                const int ready = std::max({compared, valid.ready, sample.ready});
                result.wires[s] = {pass, charge_selector(compacts_ ? samples : 1, ready)};
            } else {
                result.bits |= static_cast<std::uint64_t>(pass) << s;
            }
        };
        if (!compacts_) {
            for_samples(survivors, samples, [&](int s) {
                take(Uint(static_cast<std::uint32_t>(s)), survivors.test(s),
                     Uint(static_cast<std::uint32_t>(s)));
            });
            return result;
        }
        const auto order =
            sorted_samples(survivors, samples, sorts_, [&](int s) { return in.pixel.load(in.depth, s); });
        for (int k = 0; k < order.count; ++k) {
            const auto rank = static_cast<std::size_t>(k);
            typename D::Bool valid = true;
            if constexpr (D::kCharged) valid = order.valid[rank];
            take(Uint(static_cast<std::uint32_t>(k)), valid, order.sample[rank]);
        }
        return result;
    }

    const SamplingOptions* options_;
    int hilbert_order_;
    std::uint32_t seed_offset_;
    bool tracks_ = true;
    bool compacts_ = true;
    bool sorts_ = true;
    bool morton_ = false;
    OpacityHash hash_ = OpacityHash::kPaper;
    Field covered_;
    Field surface_id_;
};

}  // namespace

class LaineKarras : public StoredSamples<SurfaceChooser> {
 public:
    static constexpr TechniqueInfo kInfo = {
        "laine_karras", "stratified stochastic transparency (Laine and Karras 2011)",
        "tracking=true, compaction=true, sort=true, index=hilbert|morton, "
        "hash=paper|radical_inverse|sobol|improved, samples=8 (1..64, a multiple of the trace's), "
        "method=basic|depth_based, correction=none|coverage|accumulated, total_alpha=pixel|sample, "
        "accumulator=pixel|sample, passes=separate|merged, hardware_samples=0 (of one round; 0: all), "
        "strata=all|pass, filter=box|gaussian, early_termination=false, adaptive_error=0, adaptive_rounds=4, "
        "cross_filter=0, "
        "cross_sigma=0.05",
        true, "samples=8"};
    using StoredSamples::StoredSamples;

    std::uint32_t pixel_constant(int x, int y, glm::vec3) const { return chooser().pixel_index(x, y); }
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(laine_karras, LaineKarras)
