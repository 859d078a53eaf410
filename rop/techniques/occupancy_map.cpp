// Occupancy maps: Sintorn and Assarsson 2009, as Salvi et al. 2011, section 2, describe them for
// transparency. Between a pixel's nearest and furthest fragment lie as many slabs as the map has bits; a
// fragment sets the bit of its slab. All fragments are taken to have one alpha, so that visibility is (1 -
// alpha) to the power of the fragments in front, whose number the bits tell: those set in front, of all set,
// times the fragments counted.
//
// Only the abstract of the original and others' words on it were at hand. Its maps are of 128 bits, a render
// target of four 32-bit channels with a logical OR; its slab map counts the fragments of larger slabs, which
// `counts=slab` takes to be one count for each word of 32 bits (`pixel`: one for all). Its second algorithm,
// which sorts fragments by what the map says, is left out. Decided here: fragments in one slab do not dim
// each other; a word that has the bit already is not written, where a blend unit's OR would write all four;
// the common alpha is the pixel's mean (`alpha=mean`), that of the mean absorbance, with which
// all of the pixel's fragments together have the exact total transmittance (`geometric`), or given
// (`constant`, as for one head of hair); weights are scaled to the exact total alpha, for which the paper has
// a pass of its own and here the composite's second target.
#include "rop/visibility/absorbance.h"
#include "rop/visibility/map_passes.h"

#include <fmt/format.h>

namespace ropsim {

class OccupancyBits {
 public:
    static constexpr bool kAddressed = false;
    static constexpr bool kInRegisters = false;
    static constexpr bool kZeroAlphaHarmless = false;  // it sets a bit and counts
    static constexpr int kMostWords = 4;

    OccupancyBits(Parameters& parameters, const MapOptions& options)
        : samples_(options.spatial_samples),
          absorbance_(static_cast<float>(parameters.get_real("least_transmittance", 1e-5, 1e-9, 0.5))) {
        const auto bits =
            static_cast<int>(parameters.get_integer("bits", 128, 32, std::int64_t{32} * kMostWords));
        if (bits % 32 != 0)
            throw UserError(parameters.where("bits"), "a map is of whole words: take 32, 64, 96 or 128 bits");
        words_ = bits / 32;
        by_slab_ = parameters.get_choice("counts", "pixel", {"pixel", "slab"}) == "slab";
        const std::string alpha = parameters.get_choice("alpha", "mean", {"mean", "geometric", "constant"});
        alpha_ = alpha == "mean" ? Alpha::kMean : alpha == "geometric" ? Alpha::kGeometric : Alpha::kConstant;
        if (alpha_ == Alpha::kConstant)
            constant_ = static_cast<float>(parameters.get_real("constant_alpha", 0.3, 0.0, 1.0));
        if (samples_ * words_ > kMaxElements)
            throw UserError(
                parameters.context(),
                fmt::format("{} words for each of the trace's {} spatial samples are more than the "
                            "{} elements a pixel's surface has: take bits={}",
                            words_, samples_, kMaxElements, 32 * (kMaxElements / samples_)));
    }
    void declare(Declaration& declaration, const TechniqueFormats& formats) {
        const Layout layout = Layout::kInterleaved;
        occupancy_ = declaration.surface("occupancy", samples_ * words_, layout, Initial::kClear,
                                         {FieldSpec::integer(32, 0)})[0];
        counts_ = declaration.surface("counts", samples_ * counts(), layout, Initial::kClear,
                                      {FieldSpec::integer(16, 0)})[0];
        if (alpha_ != Alpha::kConstant)
            sum_ = declaration.surface(
                "alpha_sum", samples_, layout, Initial::kClear,
                {FieldSpec::real(formats.of("alpha_sum", Format::kFloat32), 1, 0.0f, ValueRange::kSum)})[0];
    }

    // The slab that a fragment is in.
    template <class D>
    struct Place {
        typename D::Uint index;
    };
    template <class D>
    Place<D> place(const typename D::Real& share) const {
        using Uint = typename D::Uint;
        const Uint last(static_cast<std::uint32_t>(32 * words_ - 1));
        const Uint index = floor_to_uint(share * typename D::Real(static_cast<float>(32 * words_)));
        return {select(last < index, last, index)};
    }
    // What is summed of each fragment.
    template <class D>
    typename D::Real amount(const typename D::Real& alpha) const {
        return alpha_ == Alpha::kGeometric ? absorbance_.of<D>(alpha) : alpha;
    }

    template <class P>
    void fetch(P& pixel, int m, const typename P::D::Bool& covered) const {
        for (int w = 0; w < words_; ++w) pixel.fetch_if(covered, occupancy_, m * words_ + w);
        for (int c = 0; c < counts(); ++c) pixel.fetch_if(covered, counts_, m * counts() + c);
        if (alpha_ != Alpha::kConstant) pixel.fetch_if(covered, sum_, m);
    }
    template <class P>
    struct Cells {
        P& pixel;
        int m;
    };
    template <class P>
    Cells<P> cells(P& pixel, int m) const {
        return {pixel, m};
    }

    template <class D, class P>
    void add(const Cells<P>& cells, const typename D::Bool& covered, const Place<D>& at,
             const typename D::Real& amount) const {
        using Uint = typename D::Uint;
        P& pixel = cells.pixel;
        for (int w = 0; w < words_; ++w) {
            const int word = cells.m * words_ + w;
            const Uint before = pixel.load_bits(occupancy_, word);
            const Uint after = before | bit_in<D>(at, w);
            const auto sets = both(covered, inverse(before == after));
            pixel.write_if(sets, occupancy_, word);
            pixel.put_bits(occupancy_, word, 0, select(sets, after, before));
        }
        for (int c = 0; c < counts(); ++c) {
            const int count = cells.m * counts() + c;
            const Uint before = pixel.load_bits(counts_, count);
            // The largest count stays.
            const Uint after = before + select(before == Uint(kMostCounted), Uint(0u), Uint(1u));
            const auto counted = by_slab_ ? both(covered, in_word<D>(at, c)) : covered;
            pixel.write_if(counted, counts_, count);
            pixel.put_bits(counts_, count, 0, select(counted, after, before));
        }
        if (alpha_ == Alpha::kConstant) return;
        pixel.write_if(covered, sum_, cells.m);
        pixel.put_if(covered, sum_, cells.m, 0, storable(sum_.format, pixel.load(sum_, cells.m) + amount));
    }

    template <class D, class P>
    typename D::Real visibility(const Cells<P>& cells, const Place<D>& at) const {
        using Real = typename D::Real;
        P& pixel = cells.pixel;
        const Tally<D> tally = tallied<D>(cells, at);
        if (alpha_ == Alpha::kConstant)
            return exponential(negative(tally.in_front * Real(absorbance_.of<PlainDatapath>(constant_))));
        const Real mean = pixel.load(sum_, cells.m) / maximum(tally.all, Real(1.0f));
        const Real absorbance = alpha_ == Alpha::kGeometric ? mean : absorbance_.of<D>(mean);
        return exponential(negative(tally.in_front * absorbance));
    }

 private:
    enum class Alpha : std::uint8_t { kMean, kGeometric, kConstant };
    static constexpr std::uint32_t kMostCounted = 0xFFFF;

    int counts() const { return by_slab_ ? words_ : 1; }

    // What a place's decoder says of word w, a gate each: the bit set in it, the bits in front of that, and
    // whether it is there at all.
    template <class D, class T>
    static auto decoded(const T& value, const Place<D>& at) {
        if constexpr (D::kCharged)
            return Wire<T>(value, Ledger::active().charge(Unit::kLogic, at.index.ready));
        else
            return value;
    }
    template <class D>
    static typename D::Bool in_word(const Place<D>& at, int w) {
        return decoded<D>(static_cast<int>(value_of(at.index) / 32) == w, at);
    }
    template <class D>
    static typename D::Uint bit_in(const Place<D>& at, int w) {
        const std::uint32_t index = value_of(at.index);
        return decoded<D>(static_cast<int>(index / 32) == w ? 1u << (index % 32) : 0u, at);
    }
    template <class D>
    static typename D::Uint bits_in_front(const Place<D>& at, int w) {
        const std::uint32_t index = value_of(at.index);
        const int word = static_cast<int>(index / 32);
        return decoded<D>(w < word ? ~0u : w == word ? (1u << (index % 32)) - 1u : 0u, at);
    }

    // `part` of `whole` bits, times `count`; nothing of nothing.
    template <class D>
    static typename D::Real of_count(const typename D::Uint& part, const typename D::Uint& whole,
                                     const typename D::Uint& count) {
        using Real = typename D::Real;
        return to_real(part) * to_real(count) / maximum(to_real(whole), Real(1.0f));
    }

    // Fragments of the pixel, by the counts and by the bits.
    template <class D>
    struct Tally {
        typename D::Real in_front;
        typename D::Real all;
    };
    template <class D, class P>
    Tally<D> tallied(const Cells<P>& cells, const Place<D>& at) const {
        using Real = typename D::Real;
        using Uint = typename D::Uint;
        std::array<Uint, kMostWords> set;
        std::array<Uint, kMostWords> in_front;
        for (int w = 0; w < words_; ++w) {
            const auto k = static_cast<std::size_t>(w);
            const Uint bits = cells.pixel.load_bits(occupancy_, cells.m * words_ + w);
            set[k] = population_count(bits);
            in_front[k] = population_count(bits & bits_in_front<D>(at, w));
        }
        if (!by_slab_) {
            const Uint count = cells.pixel.load_bits(counts_, cells.m);
            return {of_count<D>(sum_of(in_front), sum_of(set), count), to_real(count)};
        }
        std::array<Real, kMostWords> terms;
        std::array<Uint, kMostWords> count;
        for (int w = 0; w < words_; ++w) {
            const auto k = static_cast<std::size_t>(w);
            count[k] = cells.pixel.load_bits(counts_, cells.m * words_ + w);
            terms[k] = of_count<D>(in_front[k], set[k], count[k]);
        }
        return {sum_of(terms), to_real(sum_of(count))};
    }
    template <class T>
    T sum_of(const std::array<T, kMostWords>& terms) const {
        if (words_ == 1) return terms[0];
        if (words_ == 2) return terms[0] + terms[1];
        if (words_ == 3) return terms[0] + terms[1] + terms[2];
        return (terms[0] + terms[1]) + (terms[2] + terms[3]);
    }

    int samples_;
    Absorbance absorbance_;
    int words_ = kMostWords;
    bool by_slab_ = false;
    Alpha alpha_ = Alpha::kMean;
    float constant_ = 0.0f;
    Field occupancy_;
    Field counts_;
    Field sum_;
};

class OccupancyMap : public MapPasses<OccupancyBits> {
 public:
    static constexpr TechniqueInfo kInfo = {
        "occupancy_map", "occupancy maps as transparency (Sintorn and Assarsson 2009)",
        "bits=128 (32, 64, 96 or 128), counts=pixel|slab, alpha=mean|geometric|constant, "
        "constant_alpha=0.3 (0 to 1), bounds=pixel|frame, composite=normalised|plain, "
        "least_transmittance=1e-5 (1e-9 to 0.5)",
        false, ""};

    OccupancyMap(Parameters& parameters, const Screen& screen)
        : MapPasses(parameters, map_options(parameters, screen.samples, "normalised")) {}
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(occupancy_map, OccupancyMap)
