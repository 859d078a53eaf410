// Intel's one-pass "adaptive order-independent transparency", as its public sample code has it (AOIT.hlsl and
// The Forge's port of it). In spite of the name it is not Salvi et al. 2011 (`adaptive`): there is no curve
// of which the least important node is removed; colours are kept with the nodes and an overflow merges the
// last two, as in multi-layer alpha blending (`mlab`), but transmittances are those of everything up to and
// with the node. A control word a pixel says whether anything has been stored: nodes need no clearing, and
// the first fragment, which sets every node's transmittance, reads none. Its fetch is a stage of its own.
//   As published: depth in 32 bits, premultiplied colour rounded to 8 bits a channel, transmittance truncated
// to 8 bits at each store but the first fragment's, which rounds; of equal depths the later arrival is
// nearer.
//   Not as published: the merge weighs the last node by the quotient of two transmittances, taken as 0 where
// both are 0 (the code multiplies by a reciprocal: 0 * inf, a NaN that HLSL's saturate turns into black; one
// that is not exact, too, so that a colour half-way between two codes may get the other there); two nodes do
// not share their depths' low mantissa bits with the transmittances.
#include "rop/nodes/sorted_insertion.h"
#include "rop/nodes/stored_words.h"
#include "rop/nodes/unordered_layers.h"
#include "rop/technique_formats.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ropsim {

class Aoit {
 public:
    static constexpr TechniqueInfo kInfo = {
        "aoit",
        "Intel's one-pass AOIT: the last two of a pixel's sorted nodes are merged (public sample code)",
        "nodes=8 (2..16), transmittance_rounding=down|nearest (down needs a UNORM format)", false, ""};
    static constexpr int kMostNodes = 16;

    Aoit(Parameters& parameters, const Screen&)
        : nodes_(static_cast<int>(parameters.get_integer("nodes", 8, 2, kMostNodes))) {
        const TechniqueFormats formats(parameters);
        const FieldSpec color =
            FieldSpec::real(formats.rgb("color", Format::kUnorm8), 3, 0.0f, ValueRange::kColor);
        const auto node = declaration_.surface(
            "nodes", nodes_, Layout::kInterleaved, Initial::kClear,
            {FieldSpec::real(formats.of("depth", Format::kFloat32), 1, kEmptyDepth, ValueRange::kUnit), color,
             FieldSpec::real(formats.of("transmittance", Format::kUnorm8), 1, 1.0f, ValueRange::kUnit)});
        depth_ = node[0];
        color_ = node[1];
        transmittance_ = node[2];
        control_ = declaration_.surface("control", 1, Layout::kInterleaved, Initial::kClear,
                                        {FieldSpec::integer(32, kClearBit)})[0];
        moved_ = StoredFields({color_}, color.bits());
        depths_ = NodeDepths(depth_.format);
        read_rounding(parameters);
        declaration_.passes = {{"blend", Shading::kFull}};
        declaration_.paths = {"first", "insert", "insert_merge", "resolve", "resolve_clear"};
        declaration_.ordering = Ordering::kRaster;
        declaration_.zero_alpha_harmless = false;  // it takes a node, and others are merged for it
        declaration_.image_format = formats.image();
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D& d, int, const FragmentInput<D>& f, P& pixel) const {
        pixel.fetch_all(control_, 1);
        const auto clear = is_clear<D>(pixel);
        if (d.decide(clear)) return first<D>(f, pixel);
        pixel.next_fetch_stage(clear);
        pixel.fetch_all(depth_, nodes_);
        if constexpr (D::kCharged)
            return insert(d, f, pixel);
        else
            return insert_in_place(f, pixel);
    }

    // Each node under the transmittance of the one in front of it.
    template <class D, class P>
    Rgb<D> resolve(D& d, const Background<D>& background, P& pixel, int& path) const {
        pixel.fetch_all(control_, 1);
        const auto clear = is_clear<D>(pixel);
        path = d.decide(clear) ? kResolveClear : kResolve;
        if (path == kResolveClear) return background.mean;
        pixel.next_fetch_stage(clear);
        pixel.fetch_all(depth_, nodes_);
        std::array<Rgb<D>, kMostNodes + 1> term{};
        for (int i = 0; i <= nodes_; ++i) {
            const Rgb<D> c = i == nodes_ ? background.mean : pixel.load_rgb(color_, i);
            term[static_cast<std::size_t>(i)] = i == 0 ? c : scaled<D>(pixel.load(transmittance_, i - 1), c);
        }
        return tree_sum(term, nodes_ + 1);
    }

    // A fragment at a node's own depth is inserted in front of it.
    void visibility(PlainPixel& pixel, std::span<const float> depths, std::span<float> values) const {
        const bool clear = is_clear<PlainDatapath>(pixel);
        for (std::size_t k = 0; k < depths.size(); ++k) {
            const float z = PlainPixel::as_stored(depth_, depths[k]);
            values[k] = 1.0f;
            for (int i = 0; i < nodes_ && !clear && pixel.load(depth_, i) < z; ++i)
                values[k] = pixel.load(transmittance_, i);
        }
    }

 private:
    enum Path { kFirst, kInsert, kInsertMerge, kResolve, kResolveClear };
    static constexpr std::uint32_t kClearBit = 1;

    template <class D>
    struct Nodes {
        std::array<typename D::Real, kMostNodes + 1> depth;
        std::array<typename D::Real, kMostNodes + 1> transmittance;  // in counts, not rounded yet
        std::array<Moved<D>, kMostNodes + 1> color;
        std::array<typename D::Bool, kMostNodes + 1> changed;
    };

    void read_rounding(Parameters& parameters) {
        const bool unorm =
            transmittance_.format == Format::kUnorm8 || transmittance_.format == Format::kUnorm16;
        const std::string name =
            parameters.get_choice("transmittance_rounding", unorm ? "down" : "nearest", {"down", "nearest"});
        if (name == "down" && !unorm)
            throw UserError(parameters.where("transmittance_rounding"),
                            "down needs transmittances of unorm8 or unorm16; leave one of the two out");
        if (name == "down") steps_ = transmittance_.format == Format::kUnorm8 ? 255.0f : 65535.0f;
    }

    template <class D, class P>
    typename D::Bool is_clear(P& pixel) const {
        return pixel.load_bits(control_) == typename D::Uint(kClearBit);
    }
    template <class D, class P>
    Moved<D> color_of(const FragmentInput<D>& f, P& pixel) const {
        Moved<D> color{};
        moved_.set_rgb<D>(color, 0, pixel, color_, f.premultiplied);
        return color;
    }

    template <class D, class P>
    int first(const FragmentInput<D>& f, P& pixel) const {
        const auto z = depths_.kept<D>(pixel, depth_, f.z);
        const auto t = typename D::Real(1.0f) - f.a;
        const Moved<D> color = color_of<D>(f, pixel);
        pixel.write(control_);
        pixel.put_bits(control_, 0, 0, 0u);
        for (int i = 0; i < nodes_; ++i) {
            pixel.write(depth_, i);
            pixel.put(depth_, i, 0, i == 0 ? z : typename D::Real(depths_.empty));
            moved_.put<D>(pixel, i, i == 0 ? color : Moved<D>{});
            pixel.put(transmittance_, i, 0, t);
        }
        return kFirst;
    }

    template <class D, class P>
    int insert(D& d, const FragmentInput<D>& f, P& pixel) const {
        const Nodes<D> old = loaded<D>(pixel);
        Nodes<D> list = inserted(old, f, pixel);
        const auto last = static_cast<std::size_t>(nodes_) - 1;
        const bool full = d.decide(old.depth[last] < typename D::Real(depths_.empty));
        if (full) {
            list.color[last] = merged<D>(pixel, list.color[last], list.color[last + 1],
                                         quotient<D>(list.transmittance[last], list.transmittance[last - 1]));
            list.transmittance[last] = list.transmittance[last + 1];
            list.changed[last] = true;
        }
        for (int i = 0; i < nodes_; ++i) {
            const auto k = static_cast<std::size_t>(i);
            put(pixel, list.changed[k], i, list.depth[k], list.transmittance[k], list.color[k]);
        }
        return full ? kInsertMerge : kInsert;
    }

    template <class D, class P>
    Nodes<D> loaded(P& pixel) const {
        Nodes<D> old;
        for (int i = 0; i < nodes_; ++i) {
            const auto k = static_cast<std::size_t>(i);
            old.depth[k] = pixel.load(depth_, i);
            old.transmittance[k] = counts(pixel.load(transmittance_, i));
            old.color[k] = moved_.load<D>(pixel, i);
        }
        return old;
    }

    // N + 1 nodes: those behind the fragment have moved a place back and are dimmed by it, empty ones too.
    // The fragment's own transmittance is that of the node in front of it, dimmed: what that node would leave
    // at the fragment's place if it moved.
    template <class D, class P>
    Nodes<D> inserted(const Nodes<D>& old, const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        const Real z = depths_.kept<D>(pixel, depth_, f.z);
        const Real t = Real(1.0f) - f.a;
        const Moved<D> color = color_of<D>(f, pixel);
        NodesInFront<D> front;
        for (int i = 0; i < nodes_; ++i)
            front[static_cast<std::size_t>(i)] = old.depth[static_cast<std::size_t>(i)] < z;
        Nodes<D> list;
        for (int i = 0; i <= nodes_; ++i) {
            const auto own = static_cast<std::size_t>(std::min(i, nodes_ - 1));
            const auto before = static_cast<std::size_t>(std::max(i - 1, 0));
            const auto k = static_cast<std::size_t>(i);
            list.depth[k] = after_insertion<D>(front, nodes_, i, old.depth[own], old.depth[before], z);
            list.color[k] = after_insertion<D>(front, nodes_, i, old.color[own], old.color[before], color);
            const Real dimmed = i == 0 ? counts_of_fragment(t) : old.transmittance[before] * t;
            list.transmittance[k] = i == nodes_ ? dimmed : select(front[own], old.transmittance[own], dimmed);
            list.changed[k] = inverse(front[own]);
        }
        return list;
    }

    // The last two nodes' colours: the farther one under the nearer one's own transmittance.
    template <class D, class P>
    Moved<D> merged(P& pixel, const Moved<D>& near, const Moved<D>& far,
                    const typename D::Real& own_transmittance) const {
        const Rgb<D> a = StoredFields::rgb<D>(near, 0, color_.format);
        const Rgb<D> b = StoredFields::rgb<D>(far, 0, color_.format);
        Moved<D> color{};
        moved_.set_rgb<D>(color, 0, pixel, color_, plus<D>(a, scaled<D>(own_transmittance, b)));
        return color;
    }
    // Where nothing gets as far as the nearer node, the farther adds nothing.
    template <class D>
    static typename D::Real quotient(const typename D::Real& through_near, const typename D::Real& in_front) {
        using Real = typename D::Real;
        return select(Real(0.0f) < in_front, through_near / in_front, Real(0.0f));
    }

    // What insert computes, as a processor does it: nodes in front of the fragment are not touched. Held
    // against insert bit for bit by the conformance tests.
    int insert_in_place(const FragmentInput<PlainDatapath>& f, PlainPixel& pixel) const {
        const float z = depths_.kept<PlainDatapath>(pixel, depth_, f.z);
        const float t = 1.0f - f.a;
        const StoredWords color = color_of<PlainDatapath>(f, pixel);
        const bool full = pixel.load(depth_, nodes_ - 1) < depths_.empty;
        int at = 0;
        while (at < nodes_ && pixel.load(depth_, at) < z) ++at;
        const auto stored = [&](int i) { return counts(pixel.load(transmittance_, i)); };
        // Entries of the list of N + 1.
        const auto depth = [&](int i) { return i == at ? z : pixel.load(depth_, i < at ? i : i - 1); };
        const auto transmittance = [&](int i) {
            if (i < at) return stored(i);
            return i == 0 ? counts_of_fragment(t) : stored(i - 1) * t;
        };
        const auto node_color = [&](int i) {
            return i == at ? color : moved_.load<PlainDatapath>(pixel, i < at ? i : i - 1);
        };
        const int last = std::min(nodes_, kMostNodes) - 1;  // which lint cannot know
        const float last_depth = depth(last);
        float last_transmittance = transmittance(last);
        StoredWords last_color = node_color(last);
        if (full) {
            last_color =
                merged<PlainDatapath>(pixel, last_color, node_color(nodes_),
                                      quotient<PlainDatapath>(last_transmittance, transmittance(last - 1)));
            last_transmittance = transmittance(nodes_);
        }
        for (int i = last - 1; i >= at; --i) put(pixel, true, i, depth(i), transmittance(i), node_color(i));
        if (full || at <= last) put(pixel, true, last, last_depth, last_transmittance, last_color);
        return full ? kInsertMerge : kInsert;
    }

    template <class P, class B, class R, class M>
    void put(P& pixel, const B& changed, int i, const R& z, const R& transmittance, const M& color) const {
        pixel.write_if(changed, depth_, i);
        pixel.put(depth_, i, 0, z);
        pixel.put(transmittance_, i, 0, rounded(transmittance));
        moved_.put<typename P::D>(pixel, i, color);
    }

    // A transmittance that is rounded down is computed with in counts of its last bit, as the code does it: a
    // product that is a whole count stays one. The conversions' scale: no unit of its own.
    template <class R>
    R counts(const R& stored) const {
        return in_counts(stored, std::floor(value_of(stored) * steps_ + 0.5f));
    }
    template <class R>
    R counts_of_fragment(const R& t) const {
        return in_counts(t, value_of(t) * steps_);
    }
    template <class R>
    R rounded(const R& counted) const {
        return in_counts(counted, std::floor(value_of(counted)) / steps_);
    }
    float in_counts(float value, float counted) const { return steps_ == 0.0f ? value : counted; }
    Wire<float> in_counts(const Wire<float>& value, float counted) const {
        return {steps_ == 0.0f ? value.value : counted, value.ready};
    }

    int nodes_;
    float steps_ = 0;  // counts of a transmittance that is rounded down; 0: rounded to nearest
    NodeDepths depths_;
    Declaration declaration_;
    Field depth_;
    Field color_;
    Field transmittance_;
    Field control_;
    StoredFields moved_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(aoit, Aoit)
