// Per-pixel lists of fragments in a pool of nodes (Yang et al. 2010): what the A-buffer and the
// variable-memory forms of Salvi et al. 2011, section 4.1, capture before a pass over pixels works on it.
#pragma once

#include "rop/saturated.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ropsim {

// A node: premultiplied colour and alpha, depth, link: 12 bytes as the papers store them. Over traces of M >
// 1 spatial samples the coverage mask stands in the M lowest bits of the depth's mantissa (section 4.2),
// which costs depth, not bytes.
class FragmentLists {
 public:
    static constexpr int kMostSpatialSamples = 8;

    FragmentLists() = default;
    // Declares the surfaces "head" and "nodes". Throws UserError for more spatial samples than depth can
    // spare bits.
    FragmentLists(Declaration& declaration, const TechniqueFormats& formats, int spatial_samples);

    // Puts the fragment at the head of its pixel's list. False where the pool is full: a control path.
    template <class D, class P>
    bool append(D& d, const FragmentInput<D>& f, P& pixel) const {
        using Uint = typename D::Uint;
        pixel.fetch_all(head_, 1);
        const Uint index = pixel.allocate_node();
        if (d.decide(index == Uint(kNoNode))) return false;
        pixel.write_node(color_, index);
        auto node = pixel.node(index);
        node.put_rgb(color_, 0, saturated(color_, f.premultiplied));
        node.put(color_, 0, 3, f.a);
        if (mask_ == 0)
            node.put(depth_, 0, 0, f.z);
        else  // wires: the mask takes the place of the lowest bits
            node.put_bits(depth_, 0, 0,
                          (stored_word(value_of(f.z)) & ~mask_) | (value_of(f.coverage) & mask_));
        node.put_bits(next_, 0, 0, pixel.load_bits(head_));
        pixel.write(head_);
        pixel.put_bits(head_, 0, 0, index);
        return true;
    }

    // The pixel's nodes, latest arrival first: fetches the head, then each node once. Valid until the next
    // walk on this thread. While control paths are enumerated the list is empty: one step of each kind is
    // taken all the same, on node 0.
    template <class D, class P>
    const std::vector<std::uint32_t>& walk(const D& d, P& pixel) const {
        pixel.fetch_all(head_, 1);
        std::vector<std::uint32_t>& list = scratch();
        list.clear();
        std::uint32_t index = value_of(pixel.load_bits(head_));
        if (enumerating(d)) index = kNoNode;
        while (index != kNoNode) {
            pixel.fetch_node(index);
            list.push_back(index);
            index = value_of(pixel.node(index).load_bits(next_));
        }
        return list;
    }
    // Another traversal: every node is fetched once more, in the same order.
    template <class P>
    static void walk_again(P& pixel, const std::vector<std::uint32_t>& list) {
        for (const std::uint32_t node : list) pixel.fetch_node(node);
    }

    template <class D>
    struct Node {
        typename D::Real z;
        typename D::Real a;
        Rgb<D> premultiplied;
        typename D::Uint coverage;  // bit m: spatial sample m
    };
    // Depth of node i as the list keeps it, for what no unit is charged for.
    template <class P>
    float depth(P& pixel, const std::vector<std::uint32_t>& list, std::uint32_t i) const {
        auto node = node_of(pixel, list, i);
        return word_value(value_of(node.load_bits(depth_)) & ~mask_);
    }
    // Its coverage mask: bit m for spatial sample m; 1 where there is but one.
    template <class P>
    std::uint32_t coverage(P& pixel, const std::vector<std::uint32_t>& list, std::uint32_t i) const {
        if (mask_ == 0) return 1u;
        auto node = node_of(pixel, list, i);
        return value_of(node.load_bits(depth_)) & mask_;
    }
    // Node i of a list, or node 0 where there is none (see walk); charged as a step of it.
    template <class D, class P>
    Node<D> read(P& pixel, const std::vector<std::uint32_t>& list, std::uint32_t i) const {
        auto node = node_of(pixel, list, i);
        return {depth(pixel, list, i), node.load(color_, 0, 3), node.load_rgb(color_), coverage_of<D>(node)};
    }
    template <class D, class P>
    Node<D> read_without_color(P& pixel, const std::vector<std::uint32_t>& list, std::uint32_t i) const {
        auto node = node_of(pixel, list, i);
        return {depth(pixel, list, i), node.load(color_, 0, 3), {0.0f, 0.0f, 0.0f}, coverage_of<D>(node)};
    }

 private:
    static std::vector<std::uint32_t>& scratch() {
        static thread_local std::vector<std::uint32_t> list;
        return list;
    }
    static bool enumerating(const PlainDatapath&) { return false; }
    static bool enumerating(const ChargedDatapath& d) { return d.enumerating(); }
    template <class P>
    static P node_of(P& pixel, const std::vector<std::uint32_t>& list, std::uint32_t i) {
        return pixel.node(i < list.size() ? list[i] : 0);
    }
    template <class D, class P>
    typename D::Uint coverage_of(P& node) const {
        return mask_ == 0 ? 1u : value_of(node.load_bits(depth_)) & mask_;
    }

    std::uint32_t mask_ = 0;  // bits of the depth that hold the coverage
    Field head_;
    Field color_;
    Field depth_;
    Field next_;
};

}  // namespace ropsim
