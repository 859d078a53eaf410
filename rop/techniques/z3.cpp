// Z3: Jouppi and Chang 1999. A pixel keeps a few fragments, each a coverage mask, a central depth, the slopes
// of its depth plane and a colour with alpha; where there are too many, the two of closest depth are merged.
// Depth order is found sample by sample from the planes when the pixel is displayed, so that surfaces may
// cross inside a pixel. That much is in the paper's abstract, and no more of it was at hand. Decided here:
//   Bits. Mask: one a spatial sample of the trace, none with one sample. Depth: float32 or, with
// depth_format=unorm24, 24 bits. Slopes: 8 bits each (rop/nodes/small_slope.h), or 16 or 32; none with one
// sample. Colour: RGBA8, premultiplied, with the fragment's own transmittance in the place of alpha.
//   Fragments are kept in the order of their central depths, of equal ones the earlier arrival nearer, and of
// equal depths at a sample the one kept earlier.
//   Two fragments become one over both masks. Its colour is what its samples show on average: the nearer's,
// the farther's, or the nearer's over the farther's where both cover. Its plane is that of the fragment which
// covers more, the nearer's if they are equal. Of several closest pairs the nearest is merged.
#include "rop/nodes/least_pair.h"
#include "rop/nodes/merged_coverage.h"
#include "rop/nodes/small_slope.h"
#include "rop/nodes/stored_words.h"
#include "rop/nodes/unordered_layers.h"
#include "rop/technique_formats.h"
#include "traces/sample_positions.h"

#include <array>
#include <string>
#include <vector>

namespace ropsim {

class Z3 {
 public:
    static constexpr TechniqueInfo kInfo = {
        "z3", "Z3: few fragments with coverage and depth slopes, the closest merged (Jouppi and Chang 1999)",
        "fragments=3 (2..8), slope_bits=8|16|32", false, ""};
    static constexpr int kMostFragments = 8;

    Z3(Parameters& parameters, const Screen& screen)
        : fragments_(static_cast<int>(parameters.get_integer("fragments", 3, 2, kMostFragments))),
          samples_(screen.samples) {
        const TechniqueFormats formats(parameters);
        const FieldSpec color =
            FieldSpec::real(formats.rgb("color", Format::kUnorm8), 3, 0.0f, ValueRange::kColor);
        const FieldSpec own =
            FieldSpec::real(formats.of("transmittance", Format::kUnorm8), 1, 1.0f, ValueRange::kUnit);
        const FieldSpec slope = slope_spec(parameters);
        std::vector<FieldSpec> specs = {
            FieldSpec::real(formats.of("depth", Format::kFloat32), 1, kEmptyDepth, ValueRange::kUnit), color,
            own};
        if (samples_ > 1) specs.insert(specs.end(), {slope, slope, FieldSpec::integer(samples_, 0)});
        const auto field =
            declaration_.surface("fragments", fragments_, Layout::kInterleaved, Initial::kClear, specs);
        depth_ = field[0];
        color_ = field[1];
        transmittance_ = field[2];
        const int color_bits = color.bits() + own.bits();
        moved_ = StoredFields({color_, transmittance_}, color_bits);
        if (samples_ > 1) {
            slope_ = {field[3], field[4]};
            mask_ = field[5];
            moved_ = StoredFields({color_, transmittance_, slope_[0], slope_[1], mask_},
                                  color_bits + 2 * slope.bits() + samples_);
        }
        depths_ = NodeDepths(depth_.format);
        declaration_.passes = {{"merge", Shading::kFull}};
        declaration_.paths = {"insert", "insert_merge", "resolve"};
        declaration_.ordering = Ordering::kRaster;
        declaration_.zero_alpha_harmless = false;  // it takes a place, and others are merged for it
        declaration_.uses_coverage = true;
        declaration_.image_format = formats.image();
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D& d, int, const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        pixel.fetch_all(depth_, fragments_);
        const Real z = depths_.kept<D>(pixel, depth_, f.z);
        const Moved<D> incoming_words = incoming<D>(f, pixel);
        List<D> old;
        NodesInFront<D> front;
        std::array<typename D::Bool, kMostFragments> real{};
        for (int i = 0; i < fragments_; ++i) {
            const auto k = static_cast<std::size_t>(i);
            old.depth[k] = pixel.load(depth_, i);
            old.words[k] = moved_.load<D>(pixel, i);
            front[k] = old.depth[k] <= z;
            real[k] = old.depth[k] < Real(depths_.empty);
        }
        List<D> list;
        for (int i = 0; i <= fragments_; ++i) {
            const auto own = static_cast<std::size_t>(std::min(i, fragments_ - 1));
            const auto before = static_cast<std::size_t>(std::max(i - 1, 0));
            const auto k = static_cast<std::size_t>(i);
            list.depth[k] = after_insertion<D>(front, fragments_, i, old.depth[own], old.depth[before], z);
            list.words[k] =
                after_insertion<D>(front, fragments_, i, old.words[own], old.words[before], incoming_words);
        }
        if (d.decide(real[static_cast<std::size_t>(fragments_) - 1])) return merge<D>(list, front, pixel);
        for (int i = 0; i < fragments_; ++i) {
            const auto k = static_cast<std::size_t>(i);
            // Empty places that only move into one another are not written.
            const auto filled = i == 0 ? typename D::Bool(true) : either(front[k - 1], real[k - 1]);
            put(pixel, both(inverse(front[k]), filled), i, list.depth[k], list.words[k]);
        }
        return kInsert;
    }

    // Sample by sample: each fragment's colour under the product of the transmittances of those in front of
    // it there.
    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>& background, P& pixel, int& path) const {
        path = kResolve;
        pixel.fetch_all(depth_, fragments_);
        std::array<Rgb<D>, kMaxSpatialSamples> sample;
        for (int m = 0; m < samples_; ++m) {
            const auto at = at_sample<D>(pixel, m);
            const auto k = static_cast<std::size_t>(m);
            sample[k] = at.over(samples_ == 1 ? background.mean : background.sample[k], fragments_);
        }
        const Rgb<D> total = tree_sum(sample, samples_);
        return samples_ == 1 ? total : scaled<D>(1.0f / static_cast<float>(samples_), total);
    }

    // As the display composites: of equal depths the fragment kept earlier is nearer, so a further one would
    // stand behind.
    void visibility(PlainPixel& pixel, std::span<const float> depths, std::span<float> values) const {
        for (float& value : values) value = 0.0f;
        for (int m = 0; m < samples_; ++m) {
            const auto at = at_sample<PlainDatapath>(pixel, m);
            for (std::size_t k = 0; k < depths.size(); ++k) {
                float seen = 1.0f;
                for (int i = 0; i < fragments_; ++i) {
                    const auto n = static_cast<std::size_t>(i);
                    if (at.depth[n] <= depths[k]) seen *= at.transmittance[n];
                }
                values[k] += seen / static_cast<float>(samples_);
            }
        }
    }

 private:
    enum Path { kInsert, kInsertMerge, kResolve };
    // Of the words that move: the colour's three come first.
    enum Word : std::size_t { kTransmittanceWord = 3, kSlopeWord = 4, kMaskWord = 6 };

    // Fragments in the order of their central depths, at most one too many.
    template <class D>
    struct List {
        std::array<typename D::Real, kMostFragments + 1> depth;
        std::array<Moved<D>, kMostFragments + 1> words;
    };
    static FieldSpec slope_spec(Parameters& parameters) {
        const bool exact = parameters.get_string("format", "paper") == "float32";
        const std::string bits = parameters.get_choice("slope_bits", exact ? "32" : "8", {"8", "16", "32"});
        if (bits == "8") return FieldSpec::integer(8, 0);
        return FieldSpec::real(bits == "16" ? Format::kFloat16 : Format::kFloat32, 1, 0.0f,
                               ValueRange::kSignedSum);
    }

    template <class D>
    typename D::Real own_transmittance(const Moved<D>& words) const {
        return StoredFields::value<D>(words, kTransmittanceWord, transmittance_.format);
    }

    template <class D, class P>
    Moved<D> incoming(const FragmentInput<D>& f, P& pixel) const {
        Moved<D> words{};
        moved_.set_rgb<D>(words, 0, pixel, color_, f.premultiplied);
        moved_.set_value<D>(words, kTransmittanceWord, pixel, transmittance_, typename D::Real(1.0f) - f.a);
        if (samples_ == 1) return words;
        const std::array<float, 2> slopes = {f.slope.dx, f.slope.dy};
        for (std::size_t axis = 0; axis < 2; ++axis) {
            if (slope_[axis].format == Format::kBits)
                moved_.set<D>(words, kSlopeWord + axis, slope_code(typename D::Real(slopes[axis])));
            else
                moved_.set_value<D>(words, kSlopeWord + axis, pixel, slope_[axis], slopes[axis]);
        }
        moved_.set<D>(words, kMaskWord, f.coverage & typename D::Uint((1u << samples_) - 1u));
        return words;
    }
    template <class D, class P>
    int merge(const List<D>& list, const NodesInFront<D>& front, P& pixel) const {
        using Uint = typename D::Uint;
        std::array<Ranked<D>, kMostFragments + 1> ranked;
        for (int j = 1; j <= fragments_; ++j) {
            const auto k = static_cast<std::size_t>(j);
            ranked[k - 1] = {list.depth[k] - list.depth[k - 1], static_cast<std::uint32_t>(j)};
        }
        const Uint j = number_of_least(ranked, fragments_);
        const Uint i = j - Uint(1u);
        List<D> pair;
        pair.words[0] = selected<D>(list.words, fragments_, i);
        pair.words[1] = selected<D>(list.words, fragments_ + 1, j);
        pair.depth[0] = selected_value<D>(list.depth, fragments_, i);
        if (samples_ > 1) pair.depth[1] = selected_value<D>(list.depth, fragments_ + 1, j);
        const Merged<D> one = samples_ == 1 ? merged_whole<D>(pair, pixel) : merged_parts<D>(pair, pixel);
        const MergedPlaces<D> places(fragments_, j);
        for (int p = 0; p < fragments_; ++p) {
            const auto k = static_cast<std::size_t>(p);
            put(pixel, places.changed(p, front[k]), p,
                places.at(p, list.depth[k], list.depth[k + 1], one.depth),
                places.at(p, list.words[k], list.words[k + 1], one.words));
        }
        return kInsertMerge;
    }
    template <class D>
    struct Merged {
        typename D::Real depth;
        Moved<D> words;
    };

    template <class D, class P>
    Merged<D> merged_whole(const List<D>& pair, P& pixel) const {
        const auto t = own_transmittance<D>(pair.words[0]);
        const Rgb<D> near = StoredFields::rgb<D>(pair.words[0], 0, color_.format);
        const Rgb<D> far = StoredFields::rgb<D>(pair.words[1], 0, color_.format);
        Moved<D> words{};
        moved_.set_rgb<D>(words, 0, pixel, color_, plus<D>(near, scaled<D>(t, far)));
        moved_.set_value<D>(words, kTransmittanceWord, pixel, transmittance_,
                            t * own_transmittance<D>(pair.words[1]));
        return {pair.depth[0], words};
    }

    template <class D, class P>
    Merged<D> merged_parts(const List<D>& pair, P& pixel) const {
        const MergedCoverage<D> part(StoredFields::bits<D>(pair.words[0], kMaskWord),
                                     StoredFields::bits<D>(pair.words[1], kMaskWord),
                                     own_transmittance<D>(pair.words[0]));
        const Rgb<D> near = StoredFields::rgb<D>(pair.words[0], 0, color_.format);
        const Rgb<D> far = StoredFields::rgb<D>(pair.words[1], 0, color_.format);
        Moved<D> words = select(part.far_covers_more, pair.words[1], pair.words[0]);  // for its slopes
        moved_.set_rgb<D>(words, 0, pixel, color_,
                          plus<D>(scaled<D>(part.near, near), scaled<D>(part.far, far)));
        moved_.set_value<D>(words, kTransmittanceWord, pixel, transmittance_,
                            part.alone + part.far * own_transmittance<D>(pair.words[1]));
        moved_.set<D>(words, kMaskWord, part.mask);
        return {select(part.far_covers_more, pair.depth[1], pair.depth[0]), words};
    }

    template <class P, class B, class R, class M>
    void put(P& pixel, const B& changed, int i, const R& z, const M& words) const {
        pixel.write_if(changed, depth_, i);
        pixel.put(depth_, i, 0, z);
        moved_.put<typename P::D>(pixel, i, words);
    }

    // The stored fragments as one sample has them: those that do not cover it are clear.
    template <class D, class P>
    UnorderedLayers<D, kMostFragments> at_sample(P& pixel, int m) const {
        using Real = typename D::Real;
        UnorderedLayers<D, kMostFragments> at;
        for (int i = 0; i < fragments_; ++i) {
            const auto k = static_cast<std::size_t>(i);
            const auto words = moved_.load<D>(pixel, i);
            at.depth[k] = pixel.load(depth_, i);
            at.color[k] = StoredFields::rgb<D>(words, 0, color_.format);
            at.transmittance[k] = own_transmittance<D>(words);
            if (samples_ == 1) continue;
            const SamplePosition position = sample_positions(samples_)[static_cast<std::size_t>(m)];
            at.depth[k] = at.depth[k] + (stored_slope<D>(words, 0) * Real(position.x()) +
                                         stored_slope<D>(words, 1) * Real(position.y()));
            const auto covers = bit(StoredFields::bits<D>(words, kMaskWord), m);
            const Real none(0.0f);
            at.color[k] = {select(covers, at.color[k].r, none), select(covers, at.color[k].g, none),
                           select(covers, at.color[k].b, none)};
            at.transmittance[k] = select(covers, at.transmittance[k], Real(1.0f));
        }
        return at;
    }
    template <class D>
    typename D::Real stored_slope(const Moved<D>& words, std::size_t axis) const {
        if (slope_[axis].format != Format::kBits)
            return StoredFields::value<D>(words, kSlopeWord + axis, slope_[axis].format);
        return slope_of(StoredFields::bits<D>(words, kSlopeWord + axis));
    }

    int fragments_;
    int samples_;
    NodeDepths depths_;
    Declaration declaration_;
    Field depth_;
    Field color_;
    Field transmittance_;
    std::array<Field, 2> slope_;
    Field mask_;
    StoredFields moved_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(z3, Z3)
