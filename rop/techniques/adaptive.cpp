// Adaptive transparency: Salvi, Montgomery and Lefohn 2011, fixed memory in the framebuffer (sections 3 and
// 4). Pass 1 builds the compressed visibility function, pass 2 composites with it (equation 2). Left open by
// the paper and decided here: a fragment at a node's own depth is inserted in front of it; removal considers
// every node but the first (equation 7; the zeroth, implicit node has no transmittance to underestimate), and
// of equal errors the nearest is removed. Removal underestimates (section 3.2).
#include "rop/accumulated_color.h"
#include "rop/nodes/vector_insertion.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"

#include <array>

namespace ropsim {

class Adaptive {
 public:
    static constexpr TechniqueInfo kInfo = {"adaptive",
                                            "adaptive transparency, fixed memory (Salvi et al. 2011)",
                                            "nodes=8 (2..64)", true, "nodes=8"};
    static constexpr int kMaxNodes = 64;

    Adaptive(Parameters& parameters, const Screen&)
        : nodes_(static_cast<int>(parameters.get_integer("nodes", 8, 2, kMaxNodes))) {
        const TechniqueFormats formats(parameters);
        const auto node =
            declaration_.surface("nodes", nodes_, Layout::kInterleaved, Initial::kClear,
                                 {FieldSpec::real(formats.of("depth", Format::kFloat32), 1, kEmpty),
                                  FieldSpec::real(formats.of("transmittance", Format::kFloat32), 1, 1.0f)});
        depth_ = node[0];
        transmittance_ = node[1];
        empty_depth_ = stored_value(depth_.format, kEmpty);
        color_ = declaration_.surface("accumulated_color", 1, Layout::kInterleaved, Initial::kClear,
                                      {FieldSpec::real(formats.rgb("color", Format::kFloat16), 4, 0.0f)})[0];
        declaration_.passes = {{"visibility", Shading::kAlphaOnly}, {"composite", Shading::kFull}};
        declaration_.paths = {"insert", "insert_compress", "composite", "resolve"};
        declaration_.ordering = Ordering::kRaster;
        // A node of transmittance 1 in front of all others is never removed and leaves one node less for the
        // rest.
        declaration_.zero_alpha_harmless = false;
        declaration_.image_format = formats.image();
    }
    const Declaration& declaration() const { return declaration_; }

    template <class D, class P>
    int fragment(D& d, int pass, const FragmentInput<D>& f, P& pixel) const {
        if (pass == 1) return composite<D>(f, pixel);
        pixel.fetch_all(depth_, nodes_);
        if constexpr (D::kCharged)
            return insert(d, f, pixel);
        else
            return insert_in_place(f, pixel);
    }

    // The transmittance of everything: the last node holds it even while nodes are empty, because insertion
    // multiplies every node behind the fragment, empty ones too.
    template <class D, class P>
    Rgb<D> resolve(D&, const Background<D>& background, P& pixel, int& path) const {
        path = kResolve;
        pixel.fetch_all(depth_, nodes_);
        pixel.fetch_all(color_, 1);
        const auto total = pixel.load(transmittance_, nodes_ - 1);
        const Rgb<D> sum = pixel.load_rgb(color_);
        return {sum.r + total * background.mean.r, sum.g + total * background.mean.g,
                sum.b + total * background.mean.b};
    }

 private:
    enum Path { kInsert, kInsertCompress, kComposite, kResolve };
    static constexpr float kEmpty = 1e30f;  // depth of an unused node, before its format rounds it

    template <class D>
    struct Curve {
        std::array<typename D::Real, kMaxNodes + 1> depth;
        std::array<typename D::Real, kMaxNodes + 1> transmittance;
        // Node i of the old curve is in front of the fragment: unless compression reaches it, its bytes stay.
        std::array<typename D::Bool, kMaxNodes> nearer;
    };

    // The curve with the fragment inserted: N + 1 nodes, each choosing between its own old value, its
    // predecessor's multiplied by the fragment's transmittance, and the fragment.
    template <class D, class P>
    Curve<D> inserted(const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        using Bool = typename D::Bool;
        const Real t = Real(1.0f) - f.a;
        Curve<D> out;
        Bool previous_nearer = true;
        Real previous_depth = f.z;
        Real previous_product = t;
        for (int i = 0; i < nodes_; ++i) {
            const auto k = static_cast<std::size_t>(i);
            const Real z = pixel.load(depth_, i);
            const Real v = pixel.load(transmittance_, i);
            const Bool nearer = z < f.z;
            out.nearer[k] = nearer;
            out.depth[k] = select(nearer, z, i == 0 ? f.z : select(previous_nearer, f.z, previous_depth));
            out.transmittance[k] = select(nearer, v, previous_product);
            previous_nearer = nearer;
            previous_depth = z;
            previous_product = v * t;
        }
        const auto last = static_cast<std::size_t>(nodes_);
        out.depth[last] = select(previous_nearer, f.z, previous_depth);
        out.transmittance[last] = previous_product;
        return out;
    }

    template <class D, class P>
    int insert(D& d, const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        const Curve<D> curve = inserted<D>(f, pixel);
        // Full when the last of the N + 1 nodes is a real one.
        if (!d.decide(curve.depth[static_cast<std::size_t>(nodes_)] < Real(empty_depth_))) {
            for (int i = 0; i < nodes_; ++i) {
                const auto k = static_cast<std::size_t>(i);
                put_node(pixel, inverse(curve.nearer[k]), i, curve.depth[k], curve.transmittance[k]);
            }
            return kInsert;
        }
        const auto removed = least_error_node<D>(curve);
        typename D::Bool at_or_behind = false;  // node 0 is never removed
        for (int i = 0; i < nodes_; ++i) {
            // Node i moves down when it stands at or behind the removed one; the node before the removed one
            // takes its transmittance (the underestimate).
            const auto k = static_cast<std::size_t>(i);
            const typename D::Bool takes_next = inverse(index_less<D>(i + 1, removed));
            const Real z = i == 0 ? curve.depth[0] : select(at_or_behind, curve.depth[k + 1], curve.depth[k]);
            const Real v = select(takes_next, curve.transmittance[k + 1], curve.transmittance[k]);
            put_node(pixel, either(inverse(curve.nearer[k]), takes_next), i, z, v);
            at_or_behind = takes_next;
        }
        return kInsertCompress;
    }

    // What insert computes, as a processor does it: nodes in front of the fragment and of the removed node
    // stay where they are. Held against insert bit for bit by the conformance tests.
    template <class P>
    int insert_in_place(const FragmentInput<PlainDatapath>& f, P& pixel) const {
#if defined(__SSE2__)
        if (nodes_ == 8 && depth_.format == Format::kFloat32 && transmittance_.format == Format::kFloat32) {
            const VectorInsertion done = insert_four_at_a_time<2>(pixel.element_words(depth_, 0),
                                                                  pixel.element_words(transmittance_, 0), f.z,
                                                                  1.0f - f.a, empty_depth_);
            pixel.write_from(depth_, done.first_changed, 8);
            return done.compressed ? kInsertCompress : kInsert;
        }
#endif
        // Copies, so that stores to the pixel need not be assumed to change them.
        const Field depth = depth_;
        const Field transmittance = transmittance_;
        const int nodes = nodes_;
        const float t = 1.0f - f.a;
        std::array<float, kMaxNodes + 1> z;
        std::array<float, kMaxNodes + 1> v;
        float before = 1.0f;
        int at = 0;
        for (; at < nodes; ++at) {
            const auto k = static_cast<std::size_t>(at);
            z[k] = pixel.load(depth, at);
            if (!(z[k] < f.z)) break;
            v[k] = before = pixel.load(transmittance, at);
        }
        z[static_cast<std::size_t>(at)] = f.z;
        v[static_cast<std::size_t>(at)] = before * t;
        for (int i = at; i < nodes; ++i) {
            z[static_cast<std::size_t>(i) + 1] = pixel.load(depth, i);
            v[static_cast<std::size_t>(i) + 1] = pixel.load(transmittance, i) * t;
        }
        const bool full = z[static_cast<std::size_t>(nodes)] < empty_depth_;
        int removed = nodes;
        if (full) {
            removed = 1;
            float least = (v[0] - v[1]) * (z[1] - z[0]);
            for (int j = 2; j <= nodes; ++j) {
                const auto k = static_cast<std::size_t>(j);
                const float error = (v[k - 1] - v[k]) * (z[k] - z[k - 1]);
                removed = error < least ? j : removed;
                least = error < least ? error : least;
            }
            v[static_cast<std::size_t>(removed) - 1] = v[static_cast<std::size_t>(removed)];
        }
        for (int i = full ? std::min(at, removed - 1) : at; i < nodes; ++i) {
            const std::size_t from = static_cast<std::size_t>(i) + (i >= removed ? 1 : 0);
            pixel.write(depth, i);
            pixel.put(depth, i, 0, z[from]);
            pixel.put(transmittance, i, 0, v[from]);
        }
        return full ? kInsertCompress : kInsert;
    }

    // Equation 7 over nodes 1..N: a tree of comparators that keeps the nearer of equal errors. The index
    // travels with the error as a thermometer-free binary number; its muxes are charged with the error's.
    template <class D>
    typename D::Uint least_error_node(const Curve<D>& curve) const {
        using Real = typename D::Real;
        using Uint = typename D::Uint;
        std::array<Real, kMaxNodes> error;
        std::array<Uint, kMaxNodes> index;
        for (int j = 1; j <= nodes_; ++j) {
            const auto k = static_cast<std::size_t>(j);
            error[k - 1] =
                (curve.transmittance[k - 1] - curve.transmittance[k]) * (curve.depth[k] - curve.depth[k - 1]);
            index[k - 1] = static_cast<std::uint32_t>(j);
        }
        for (int count = nodes_; count > 1; count = (count + 1) / 2) {
            for (int i = 0; i + 1 < count; i += 2) {
                const auto a = static_cast<std::size_t>(i);
                const auto smaller = error[a + 1] < error[a];
                error[a / 2] = select(smaller, error[a + 1], error[a]);
                index[a / 2] = select(smaller, index[a + 1], index[a]);
            }
            if (count % 2 == 1) {
                error[static_cast<std::size_t>(count / 2)] = error[static_cast<std::size_t>(count - 1)];
                index[static_cast<std::size_t>(count / 2)] = index[static_cast<std::size_t>(count - 1)];
            }
        }
        return index[0];
    }

    // Whether constant i < index: one line of the index's decoder, a gate.
    template <class D>
    static typename D::Bool index_less(int i, const typename D::Uint& index) {
        const bool less = static_cast<std::uint32_t>(i) < value_of(index);
        if constexpr (D::kCharged)
            return {less, Ledger::active().charge(Unit::kLogic, index.ready)};
        else
            return less;
    }

    template <class P, class B, class R>
    void put_node(P& pixel, const B& changed, int i, const R& z, const R& v) const {
        pixel.write_if(changed, depth_, i);
        pixel.put(depth_, i, 0, z);
        pixel.put(transmittance_, i, 0, v);
    }

    template <class D, class P>
    int composite(const FragmentInput<D>& f, P& pixel) const {
        using Real = typename D::Real;
        pixel.fetch_all(depth_, nodes_);
        pixel.fetch_all(color_, 1);
        const Real visibility = visibility_at<D>(f.z, pixel);
        accumulate_rgb<D>(pixel, color_, visibility, f.premultiplied);
        return kComposite;
    }

    // vis(z): transmittance of the last node strictly in front, 1 where there is none. Nodes are sorted, so
    // of two groups the farther one answers if its first node is in front: a tree of muxes.
    template <class D, class P>
    typename D::Real visibility_at(const typename D::Real& z, P& pixel) const {
        if constexpr (!D::kCharged) {
            const Field depth = depth_;
#if defined(__SSE2__)
            if (nodes_ == 8) {
                const int n = count_in_front<2>(pixel.element_words(depth_, 0), z);
                return n == 0 ? 1.0f : pixel.load(transmittance_, n - 1);
            }
#endif
            int nearer_nodes = 0;
            while (nearer_nodes < nodes_ && pixel.load(depth, nearer_nodes) < z) ++nearer_nodes;
            return nearer_nodes == 0 ? 1.0f : pixel.load(transmittance_, nearer_nodes - 1);
        }
        std::array<typename D::Real, kMaxNodes> value;
        std::array<typename D::Bool, kMaxNodes> nearer;
        for (int i = 0; i < nodes_; ++i) {
            const auto k = static_cast<std::size_t>(i);
            nearer[k] = pixel.load(depth_, i) < z;
            value[k] = pixel.load(transmittance_, i);
        }
        for (int stride = 1; stride < nodes_; stride *= 2) {
            for (int i = 0; i + stride < nodes_; i += 2 * stride) {
                const auto a = static_cast<std::size_t>(i);
                const auto b = static_cast<std::size_t>(i + stride);
                value[a] = select(nearer[b], value[b], value[a]);
            }
        }
        return select(nearer[0], value[0], typename D::Real(1.0f));
    }

    int nodes_;
    float empty_depth_;
    Declaration declaration_;
    Field depth_;
    Field transmittance_;
    Field color_;
};

}  // namespace ropsim

ROPSIM_TECHNIQUE(adaptive, Adaptive)
