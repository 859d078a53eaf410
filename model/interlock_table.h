// Who has the interlock of a quad's pixels and who waits for it, in fixed storage.
#pragma once

#include "base/error.h"

#include <bit>
#include <cstdint>
#include <vector>

namespace ropsim {

// Slots hang in lists by their quad, those that have the interlock first, then those that wait in order of
// arrival. Quads whose hash is the same share a list.
class InterlockTable {
 public:
    // `slots`: numbers from 0 to slots - 1 can be in the table, each once.
    explicit InterlockTable(std::uint32_t slots)
        : nodes_(slots), lists_(std::bit_ceil(std::uint64_t{2} * slots)) {}

    // The last to come for these pixels of the quad: `pixels` in bits 0..3, not 0.
    void add(std::uint32_t slot, std::uint32_t quad, std::uint32_t pixels) {
        nodes_[slot] = {kNone, kNone, quad, pixels, false};
        insert_before(kNone, slot);
    }
    // Whether somebody has one of the slot's pixels.
    bool held(std::uint32_t slot) const {
        const Node& own = nodes_[slot];
        for (std::uint32_t i = list(own.quad).first; i != kNone && nodes_[i].granted; i = nodes_[i].next)
            if (overlap(nodes_[i], own)) return true;
        return false;
    }
    // Whether somebody who came earlier has one of the slot's pixels or waits for it.
    bool preceded(std::uint32_t slot) const {
        const Node& own = nodes_[slot];
        for (std::uint32_t i = list(own.quad).first; i != slot; i = nodes_[i].next)
            if (overlap(nodes_[i], own)) return true;
        return false;
    }
    void grant(std::uint32_t slot) {
        unlink(slot);
        nodes_[slot].granted = true;
        insert_before(list(nodes_[slot].quad).first, slot);
    }
    // Takes the slot out; calls visit(slot) for those that nobody precedes any more and that are not granted.
    // visit() must not change the table.
    template <class Visit>
    void release(std::uint32_t slot, Visit&& visit) {
        unlink(slot);
        std::uint32_t taken = 0;
        for (std::uint32_t i = list(nodes_[slot].quad).first; i != kNone && taken != 0xF;
             i = nodes_[i].next) {
            if (nodes_[i].quad != nodes_[slot].quad) continue;
            if (!nodes_[i].granted && (nodes_[i].pixels & taken) == 0) visit(i);
            taken |= nodes_[i].pixels;
        }
    }
    // Calls visit(slot) for those that came for the same quad before this slot, which has not been granted,
    // and still wait.
    template <class Visit>
    void for_overtaken(std::uint32_t slot, Visit&& visit) const {
        for (std::uint32_t i = list(nodes_[slot].quad).first; i != slot; i = nodes_[i].next)
            if (!nodes_[i].granted && nodes_[i].quad == nodes_[slot].quad) visit(i);
    }

 private:
    static constexpr std::uint32_t kNone = ~0u;
    struct Node {
        std::uint32_t previous = kNone;
        std::uint32_t next = kNone;
        std::uint32_t quad = 0;
        std::uint32_t pixels = 0;
        bool granted = false;
    };
    struct List {
        std::uint32_t first = kNone;
        std::uint32_t last = kNone;
    };
    static bool overlap(const Node& a, const Node& b) {
        return a.quad == b.quad && (a.pixels & b.pixels) != 0;
    }
    std::size_t hash(std::uint32_t quad) const {
        return (quad * 0x9E3779B97F4A7C15ull) >> (64 - std::countr_zero(lists_.size()));
    }
    List& list(std::uint32_t quad) { return lists_[hash(quad)]; }
    const List& list(std::uint32_t quad) const { return lists_[hash(quad)]; }

    // kNone: at the end.
    void insert_before(std::uint32_t next, std::uint32_t slot) {
        List& of = list(nodes_[slot].quad);
        const std::uint32_t previous = next == kNone ? of.last : nodes_[next].previous;
        nodes_[slot].previous = previous;
        nodes_[slot].next = next;
        (previous == kNone ? of.first : nodes_[previous].next) = slot;
        (next == kNone ? of.last : nodes_[next].previous) = slot;
    }
    void unlink(std::uint32_t slot) {
        List& of = list(nodes_[slot].quad);
        const Node& n = nodes_[slot];
        (n.previous == kNone ? of.first : nodes_[n.previous].next) = n.next;
        (n.next == kNone ? of.last : nodes_[n.next].previous) = n.previous;
    }

    std::vector<Node> nodes_;
    std::vector<List> lists_;  // a power of two, at least 2
};

}  // namespace ropsim
