// Multi-layer alpha blending: Salvi and Vaidyanathan 2014. One pass keeps k sorted layers, each a depth and a
// premultiplied colour with the layer's own transmittance; a fragment that finds them full is inserted all
// the same and two neighbours become one layer at the nearer one's depth. The paper merges the last two
// (merge=tail). Known from its published descriptions and from public code (PixelSyncOIT's MLABGather), which
// also settle what is decided here: a fragment is rounded to the stored format before it is inserted, and of
// equal depths the later arrival is nearer (ties=oldest turns that round). Resolve composites premultiplied
// and divides by nothing; the public code divides by total alpha, which is 0 / 0 where all of it rounds away.
// Other choices of what to merge are in rop/nodes/merge_choice.h.
#include "rop/nodes/least_pair.h"
#include "rop/nodes/merge_choice.h"
#include "rop/nodes/sorted_insertion.h"
#include "rop/nodes/stored_words.h"
#include "rop/technique_formats.h"

#include <array>

namespace ropsim {

class Mlab {
 public:
    static constexpr TechniqueInfo kInfo = {
        "mlab", "multi-layer alpha blending (Salvi and Vaidyanathan 2014)",
        "layers=8 (1..64), merge=tail|closest|least_error|transmittance|opacity, ties=newest|oldest", false,
        ""};

    Mlab(Parameters& parameters, const Screen&)
        : layers_(static_cast<int>(parameters.get_integer("layers", 8, 1, kMaxNodes))),
          merge_(parameters, layers_),
          equal_(parameters.get_choice("ties", "newest", {"newest", "oldest"}) == "newest"
                     ? EqualDepth::kFragmentInFront
                     : EqualDepth::kFragmentBehind) {
        const TechniqueFormats formats(parameters);
        const FieldSpec color =
            FieldSpec::real(formats.rgb("color", Format::kUnorm8), 3, 0.0f, ValueRange::kColor);
        const FieldSpec own =
            FieldSpec::real(formats.of("transmittance", Format::kUnorm8), 1, 1.0f, ValueRange::kUnit);
        const auto layer = declaration_.surface(
            "layers", layers_, Layout::kInterleaved, Initial::kClear,
            {FieldSpec::real(formats.of("depth", Format::kFloat32), 1, kEmptyDepth, ValueRange::kUnit), color,
             own});
        depth_ = layer[0];
        color_ = layer[1];
        transmittance_ = layer[2];
        moved_ = StoredFields({color_, transmittance_}, color.bits() + own.bits());
        depths_ = NodeDepths(depth_.format);
        declaration_.passes = {{"blend", Shading::kFull}};
        declaration_.paths = {"insert", "insert_merge", "resolve"};
        declaration_.ordering = Ordering::kRaster;
        declaration_.zero_alpha_harmless = false;  // it takes a layer, and others are merged for it
        declaration_.image_format = formats.image();
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D& d, int, const FragmentInput<D>& f, P& pixel) const {
        pixel.fetch_all(depth_, layers_);
        if constexpr (D::kCharged)
            return insert(d, f, pixel);
        else
            return insert_in_place(f, pixel);
    }

    // Front to back by "over", which is associative: a tree.
    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>& background, P& pixel, int& path) const {
        path = kResolve;
        pixel.fetch_all(depth_, layers_);
        std::array<Rgb<D>, kMaxNodes> sum;
        std::array<typename D::Real, kMaxNodes> t;
        for (int i = 0; i < layers_; ++i) {
            sum[static_cast<std::size_t>(i)] = pixel.load_rgb(color_, i);
            t[static_cast<std::size_t>(i)] = pixel.load(transmittance_, i);
        }
        for (int stride = 1; stride < layers_; stride *= 2) {
            for (int i = 0; i + stride < layers_; i += 2 * stride) {
                const auto near = static_cast<std::size_t>(i);
                const auto far = static_cast<std::size_t>(i + stride);
                sum[near] = over<D>(sum[near], t[near], sum[far]);
                t[near] = t[near] * t[far];
            }
        }
        return over<D>(sum[0], t[0], background.mean);
    }

    // A fragment at a layer's own depth is composited on the side that `ties` says.
    void visibility(PlainPixel& pixel, std::span<const float> depths, std::span<float> values) const {
        for (std::size_t k = 0; k < depths.size(); ++k) {
            const float z = PlainPixel::as_stored(depth_, depths[k]);
            values[k] = 1.0f;
            for (int i = 0; i < layers_ && stays_in_front(pixel.load(depth_, i), z); ++i)
                values[k] *= pixel.load(transmittance_, i);
        }
    }

 private:
    enum Path { kInsert, kInsertMerge, kResolve };
    // Of the words that move: the colour's three come first.
    static constexpr std::size_t kTransmittanceWord = 3;

    // The layers with the fragment among them, N + 1 of them.
    template <class D>
    struct List {
        std::array<typename D::Real, kMaxNodes + 1> depth;
        std::array<Moved<D>, kMaxNodes + 1> layer;
    };

    template <class D>
    static Rgb<D> over(const Rgb<D>& near, const typename D::Real& t, const Rgb<D>& far) {
        return {near.r + t * far.r, near.g + t * far.g, near.b + t * far.b};
    }

    template <class D, class P>
    Moved<D> incoming(const FragmentInput<D>& f, P& pixel) const {
        Moved<D> layer{};
        moved_.set_rgb<D>(layer, 0, pixel, color_, f.premultiplied);
        moved_.set_value<D>(layer, kTransmittanceWord, pixel, transmittance_, typename D::Real(1.0f) - f.a);
        return layer;
    }
    template <class D, class P>
    Moved<D> merged(P& pixel, const Moved<D>& near, const Moved<D>& far) const {
        const auto t = own_transmittance<D>(near);
        Moved<D> layer{};
        moved_.set_rgb<D>(layer, 0, pixel, color_,
                          over<D>(StoredFields::rgb<D>(near, 0, color_.format), t,
                                  StoredFields::rgb<D>(far, 0, color_.format)));
        moved_.set_value<D>(layer, kTransmittanceWord, pixel, transmittance_, t * own_transmittance<D>(far));
        return layer;
    }
    template <class D>
    typename D::Real own_transmittance(const Moved<D>& layer) const {
        return StoredFields::value<D>(layer, kTransmittanceWord, transmittance_.format);
    }

    template <class D, class P>
    int insert(D& d, const FragmentInput<D>& f, P& pixel) const {
        using Bool = typename D::Bool;
        const auto z = depths_.kept<D>(pixel, depth_, f.z);
        const Moved<D> fragment = incoming<D>(f, pixel);
        List<D> old;
        NodesInFront<D> front;
        std::array<Bool, kMaxNodes> real;
        for (int i = 0; i < layers_; ++i) {
            const auto k = static_cast<std::size_t>(i);
            old.depth[k] = pixel.load(depth_, i);
            old.layer[k] = moved_.load<D>(pixel, i);
            front[k] = stays_in_front(old.depth[k], z);
            real[k] = old.depth[k] < typename D::Real(depths_.empty);
        }
        List<D> list;
        for (int i = 0; i <= layers_; ++i) {
            const auto own = static_cast<std::size_t>(std::min(i, layers_ - 1));
            const auto before = static_cast<std::size_t>(std::max(i - 1, 0));
            const auto k = static_cast<std::size_t>(i);
            list.depth[k] = after_insertion<D>(front, layers_, i, old.depth[own], old.depth[before], z);
            list.layer[k] =
                after_insertion<D>(front, layers_, i, old.layer[own], old.layer[before], fragment);
        }
        const auto last = static_cast<std::size_t>(layers_) - 1;
        if (d.decide(real[last])) return merge<D>(list, front, pixel);
        for (int i = 0; i < layers_; ++i) {
            const auto k = static_cast<std::size_t>(i);
            // Empty layers that only move into one another are not written.
            const Bool changed =
                i == 0 ? inverse(front[k]) : both(inverse(front[k]), either(front[k - 1], real[k - 1]));
            put(pixel, changed, i, list.depth[k], list.layer[k]);
        }
        return kInsert;
    }

    template <class D, class P>
    int merge(const List<D>& list, const NodesInFront<D>& front, P& pixel) const {
        if (merge_.is_tail()) {
            const auto last = static_cast<std::size_t>(layers_) - 1;
            for (std::size_t k = 0; k < last; ++k)
                put(pixel, inverse(front[k]), static_cast<int>(k), list.depth[k], list.layer[k]);
            put(pixel, typename D::Bool(true), layers_ - 1, list.depth[last],
                merged<D>(pixel, list.layer[last], list.layer[last + 1]));
            return kInsertMerge;
        }
        const auto j = merge_.farther_of_pair<D>(
            [&](int i) { return list.depth[static_cast<std::size_t>(i)]; },
            [&](int i) { return own_transmittance<D>(list.layer[static_cast<std::size_t>(i)]); });
        const Moved<D> pair = merged<D>(pixel, selected<D>(list.layer, layers_, j - typename D::Uint(1u)),
                                        selected<D>(list.layer, layers_ + 1, j));
        const MergedPlaces<D> places(layers_, j);
        for (int i = 0; i < layers_; ++i) {
            const auto k = static_cast<std::size_t>(i);
            put(pixel, places.changed(i, front[k]), i,
                places.at(i, list.depth[k], list.depth[k + 1], list.depth[k]),
                places.at(i, list.layer[k], list.layer[k + 1], pair));
        }
        return kInsertMerge;
    }

    template <class P, class B, class R, class M>
    void put(P& pixel, const B& changed, int i, const R& z, const M& layer) const {
        pixel.write_if(changed, depth_, i);
        pixel.put(depth_, i, 0, z);
        moved_.put<typename P::D>(pixel, i, layer);
    }

    // What insert computes, as a processor does it: layers that stay where they are are not touched. Held
    // against insert bit for bit by the conformance tests.
    int insert_in_place(const FragmentInput<PlainDatapath>& f, PlainPixel& pixel) const {
        const float z = depths_.kept<PlainDatapath>(pixel, depth_, f.z);
        const StoredWords fragment = incoming<PlainDatapath>(f, pixel);
        int at = 0;  // the fragment's place
        while (at < layers_ && stays_in_front(pixel.load(depth_, at), z)) ++at;
        const bool full = pixel.load(depth_, layers_ - 1) < depths_.empty;
        if (!full) {
            if (at == layers_) return kInsert;  // at the depth of empty layers
            int end = at;
            while (pixel.load(depth_, end) < depths_.empty) ++end;
            for (int i = end; i > at; --i) move(pixel, i - 1, i);
            put(pixel, true, at, z, fragment);
            return kInsert;
        }
        const auto old = [at](int i) { return i < at ? i : i - 1; };  // place before the insertion
        const auto depth = [&](int i) { return i == at ? z : pixel.load(depth_, old(i)); };
        const auto layer = [&](int i) {
            return i == at ? fragment : moved_.load<PlainDatapath>(pixel, old(i));
        };
        int j = layers_;
        if (!merge_.is_tail())
            j = static_cast<int>(merge_.farther_of_pair<PlainDatapath>(
                depth, [&](int i) { return own_transmittance<PlainDatapath>(layer(i)); }));
        const float pair_depth = depth(j - 1);
        const StoredWords pair = merged<PlainDatapath>(pixel, layer(j - 1), layer(j));
        for (int i = j - 2; i > at; --i) move(pixel, i - 1, i);
        for (int i = j; i < at - 1; ++i) move(pixel, i + 1, i);
        if (at < j - 1) put(pixel, true, at, z, fragment);
        if (at > j) put(pixel, true, at - 1, z, fragment);
        put(pixel, true, j - 1, pair_depth, pair);
        return kInsertMerge;
    }
    template <class R>
    auto stays_in_front(const R& stored, const R& z) const -> decltype(stored < z) {
        return equal_ == EqualDepth::kFragmentInFront ? stored < z : stored <= z;
    }
    void move(PlainPixel& pixel, int from, int to) const {
        put(pixel, true, to, pixel.load(depth_, from), moved_.load<PlainDatapath>(pixel, from));
    }

    int layers_;
    MergeChoice merge_;
    EqualDepth equal_;
    NodeDepths depths_;
    Declaration declaration_;
    Field depth_;
    Field color_;
    Field transmittance_;
    StoredFields moved_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(mlab, Mlab)
