// Stratified stochastic transparency: Laine and Karras 2011, Figures 4 and 7, with surface tracking (section
// 2), the scrambled radical inverse (section 3) over a Hilbert pixel index, and sorting by stored depth
// (section 4). Left open by the paper and decided here: samples of equal stored depth are sorted by sample
// number; the reference is compared as an integer (x < alpha 2^32), so that alpha 1 always passes, where a
// rounded float would fail once in 2^25. The run's seed offsets the Hilbert index; seed 0 is the paper bit
// for bit.
#include "rop/hilbert.h"
#include "rop/sample_mean.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"

#include <array>

namespace ropsim {

class LaineKarras {
 public:
    static constexpr TechniqueInfo kInfo = {
        "laine_karras", "stratified stochastic transparency (Laine and Karras 2011)",
        "samples=8 (1..64, a multiple of the trace's)", true, "samples=8"};
    static constexpr int kMaxSamples = 64;

    LaineKarras(Parameters& parameters, const Screen& screen)
        : samples_(static_cast<int>(parameters.get_integer("samples", 8, 1, kMaxSamples))),
          spatial_samples_(screen.samples),
          hilbert_order_(hilbert_order(screen.width, screen.height)),
          seed_offset_(screen.seed == 0 ? 0 : static_cast<std::uint32_t>(mix64(screen.seed))) {
        if (samples_ % spatial_samples_ != 0)
            throw UserError(
                parameters.where("samples"),
                fmt::format("{} stored samples over a trace of {} samples a pixel; use a multiple of {}",
                            samples_, spatial_samples_, spatial_samples_));
        const TechniqueFormats formats(parameters);
        depth_ = declaration_.surface("depth", samples_, Layout::kPlanar, Initial::kOpaqueDepth,
                                      {FieldSpec::real(formats.of("depth", Format::kFloat32), 1, 1.0f)})[0];
        color_ = declaration_.surface("color", samples_, Layout::kPlanar, Initial::kOpaqueColor,
                                      {FieldSpec::real(formats.rgb("color", Format::kUnorm8), 4, 1.0f)})[0];
        const auto tracking =
            declaration_.surface("surface_tracking", 1, Layout::kInterleaved, Initial::kClear,
                                 {FieldSpec::integer(samples_, 0), FieldSpec::integer(32, 0)});
        covered_ = tracking[0];
        surface_id_ = tracking[1];
        declaration_.passes = {{"draw", Shading::kFull}};
        declaration_.paths = {"hidden", "draw", "resolve"};
        declaration_.ordering = Ordering::kRaster;
        // Coverage tracking sees a fragment of zero alpha: it may start a new surface.
        declaration_.zero_alpha_harmless = false;
        declaration_.uses_coverage = true;
        declaration_.random = true;
        declaration_.resolve_reads_background = false;
        declaration_.image_format = formats.image();
    }
    const Declaration& declaration() const { return declaration_; }

    std::uint32_t pixel_constant(int x, int y, glm::vec3) const {
        return hilbert_index(hilbert_order_, x, y) + seed_offset_;
    }

    template <class D, class P>
    int fragment(D& d, int, const FragmentInput<D>& f, P& pixel) const {
        using Uint = typename D::Uint;
        for (int s = 0; s < samples_; ++s) pixel.fetch_if(covers<D>(f.coverage, s), depth_, s);
        pixel.fetch_all(covered_, 1);
        Samples<D> all;
        typename D::Bool any = false;
        typename D::Bool conflict = false;
        std::array<Uint, 2> mask = {pixel.load_bits(covered_),
                                    samples_ > 32 ? pixel.load_bits(covered_, 0, 1) : Uint(0u)};
        for (int s = 0; s < samples_; ++s) {
            const auto k = static_cast<std::size_t>(s);
            all.depth[k] = pixel.load(depth_, s);
            // Line 2 of Fig. 7 removes a sample where the fragment is farther; equal depths stay.
            all.survives[k] = both(covers<D>(f.coverage, s), f.z <= all.depth[k]);
            any = either(any, all.survives[k]);
            conflict = either(conflict, both(all.survives[k], bit(mask[k / 32], s % 32)));
        }
        if (d.decide(inverse(any))) return kHidden;
        const Uint id = pixel.load_bits(surface_id_) + select(conflict, Uint(1u), Uint(0u));
        mask[0] = select(conflict, Uint(0u), mask[0]);
        Uint drawn = population_count(mask[0]);
        if (samples_ > 32) {
            mask[1] = select(conflict, Uint(0u), mask[1]);
            drawn = drawn + population_count(mask[1]);
        }
        draw<D>(f, pixel, all, drawn, id);
        for (int s = 0; s < samples_; ++s) {
            const auto k = static_cast<std::size_t>(s);
            mask[k / 32] = mask[k / 32] | select(all.survives[k], Uint(1u << (s % 32)), Uint(0u));
        }
        pixel.write(covered_);
        pixel.put_bits(covered_, 0, 0, mask[0]);
        if (samples_ > 32) pixel.put_bits(covered_, 0, 1, mask[1]);
        pixel.put_bits(surface_id_, 0, 0, id);
        return kDraw;
    }

    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>&, P& pixel, int& path) const {
        path = kResolve;
        pixel.fetch_all(color_, samples_);
        return mean_of_samples<D>(pixel, color_, samples_);
    }

 private:
    enum Path { kHidden, kDraw, kResolve };

    template <class D>
    struct Samples {
        std::array<typename D::Real, kMaxSamples> depth;
        std::array<typename D::Bool, kMaxSamples> survives;
    };
    // Sample numbers in order of stored depth; the first `count` are survivors.
    template <class D>
    struct Order {
        std::array<typename D::Uint, kMaxSamples> sample;
        std::array<typename D::Bool, kMaxSamples> valid;
        int count;
    };

    template <class D>
    typename D::Bool covers(const typename D::Uint& coverage, int sample) const {
        return bit(coverage, sample % spatial_samples_);
    }

    // Fig. 7, lines 9 to 17: the k-th survivor gets the reference of index drawn + k.
    template <class D, class P>
    void draw(const FragmentInput<D>& f, P& pixel, const Samples<D>& all, const typename D::Uint& drawn,
              const typename D::Uint& id) const {
        using Uint = typename D::Uint;
        const Order<D> order = sorted<D>(all);
        const Uint first = drawn + f.pixel_constant * Uint(static_cast<std::uint32_t>(samples_));
        // alpha 2^32 is exact in double; a reference below its ceiling is one below alpha.
        const auto threshold =
            static_cast<std::uint64_t>(std::ceil(static_cast<double>(value_of(f.a)) * 0x1p32));
        for (int k = 0; k < order.count; ++k) {
            const auto rank = static_cast<std::size_t>(k);
            const Uint reference = alpha_reference<D>(first + Uint(static_cast<std::uint32_t>(k)), id);
            const auto pass = both(order.valid[rank], below<D>(reference, threshold));
            const int s = static_cast<int>(value_of(order.sample[rank]));
            const auto routed = route<D>(pass, order.sample[rank]);
            pixel.write_if(routed, depth_, s);
            pixel.write_if(routed, color_, s);
            pixel.put_if(routed, depth_, s, 0, f.z);
            pixel.put_rgb_if(routed, color_, s, f.straight);
        }
    }

    // CalcAlphaRef, Fig. 4, without the final scaling to [0, 1].
    template <class D>
    static typename D::Uint alpha_reference(const typename D::Uint& index, const typename D::Uint& surface) {
        using Uint = typename D::Uint;
        Uint x = reverse_bits(index) + surface;
        x = x ^ (x * Uint(0x6C50B47Cu));
        x = x ^ (x * Uint(0xB82F1E52u));
        x = x ^ (x * Uint(0xC7AFE638u));
        x = x ^ (x * Uint(0x8D22F6E6u));
        return x;
    }
    template <class D>
    static typename D::Bool below(const typename D::Uint& reference, std::uint64_t threshold) {
        const bool result = value_of(reference) < threshold;
        if constexpr (D::kCharged)
            return {result, Ledger::active().charge(Unit::kComparator, reference.ready)};
        else
            return result;
    }
    // The pass bit goes back from its place in the sorted order to its sample: one selector a sample.
    template <class D>
    static typename D::Bool route(const typename D::Bool& pass, const typename D::Uint& sample) {
        if constexpr (D::kCharged)
            return {pass.value, Ledger::active().charge(Unit::kMux, std::max(pass.ready, sample.ready))};
        else
            return pass;
    }

    // Software sorts the survivors; hardware sorts all samples in Batcher's odd-even merge network, those
    // removed last.
    template <class D>
    Order<D> sorted(const Samples<D>& all) const {
        Order<D> order;
        if constexpr (D::kCharged) {
            sort_network(all, order);
        } else {
            order.count = 0;
            for (int s = 0; s < samples_; ++s) {
                if (!all.survives[static_cast<std::size_t>(s)]) continue;
                int at = order.count++;
                for (; at > 0; --at) {
                    const auto before = order.sample[static_cast<std::size_t>(at - 1)];
                    if (all.depth[before] <= all.depth[static_cast<std::size_t>(s)]) break;
                    order.sample[static_cast<std::size_t>(at)] = before;
                }
                order.sample[static_cast<std::size_t>(at)] = static_cast<std::uint32_t>(s);
            }
            order.valid.fill(true);
        }
        return order;
    }

    void sort_network(const Samples<ChargedDatapath>& all, Order<ChargedDatapath>& order) const {
        std::array<Wire<float>, kMaxSamples> depth = all.depth;
        order.valid = all.survives;
        order.count = samples_;
        for (int s = 0; s < samples_; ++s)
            order.sample[static_cast<std::size_t>(s)] = static_cast<std::uint32_t>(s);
        const auto size = static_cast<int>(std::bit_ceil(static_cast<unsigned>(samples_)));
        for (int p = 1; p < size; p *= 2)
            for (int k = p; k >= 1; k /= 2)
                for (int j = k % p; j + k < size; j += 2 * k)
                    for (int i = 0; i < k; ++i) {
                        const int a = i + j;
                        const int b = i + j + k;
                        if (b < samples_ && a / (2 * p) == b / (2 * p)) exchange(depth, order, a, b);
                    }
    }
    static void exchange(std::array<Wire<float>, kMaxSamples>& depth, Order<ChargedDatapath>& order,
                         int first, int second) {
        const auto a = static_cast<std::size_t>(first);
        const auto b = static_cast<std::size_t>(second);
        const bool behind = std::make_tuple(!order.valid[b].value, depth[b].value, order.sample[b].value) <
                            std::make_tuple(!order.valid[a].value, depth[a].value, order.sample[a].value);
        const int ready =
            std::max({depth[a].ready, depth[b].ready, order.valid[a].ready, order.valid[b].ready});
        const Wire<bool> swap = {behind, Ledger::active().charge(Unit::kComparator, ready)};
        const auto pick = [&](auto& x, auto& y) {
            const auto low = select(swap, y, x);
            y = select(swap, x, y);
            x = low;
        };
        pick(depth[a], depth[b]);
        pick(order.sample[a], order.sample[b]);
        pick(order.valid[a], order.valid[b]);
    }

    int samples_;
    int spatial_samples_;
    int hilbert_order_;
    std::uint32_t seed_offset_;
    Declaration declaration_;
    Field depth_;
    Field color_;
    Field covered_;
    Field surface_id_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(laine_karras, LaineKarras)
