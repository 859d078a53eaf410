// Nodes of per-pixel lists: one partition's fixed share of the pool, handed out in arrival order.
#pragma once

#include "base/error.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace ropsim {

inline constexpr std::uint32_t kNoNode = 0xFFFFFFFFu;

// Index, address and overflow are functions of trace order alone: a partition's fragments take its nodes one
// after the other, whatever the threads do. Words are allocated in chunks as they are used.
class NodePool {
 public:
    NodePool(int words_per_node, std::uint64_t capacity)
        : words_per_node_(static_cast<std::size_t>(words_per_node)), capacity_(capacity) {
        CHECK(capacity < kNoNode, "{} nodes", capacity);
    }

    // The next node, or kNoNode (counted) when the share is used up.
    std::uint32_t allocate() {
        if (used_ == capacity_) {
            ++overflowed_;
            return kNoNode;
        }
        if (used_ % kChunk == 0)
            chunks_.push_back(std::make_unique<std::uint32_t[]>(kChunk * words_per_node_));
        return static_cast<std::uint32_t>(used_++);
    }
    std::uint32_t* words(std::uint32_t node) {
        return &chunks_[node / kChunk][(node % kChunk) * words_per_node_];
    }
    std::uint64_t used() const { return used_; }  // the high-water mark: nodes are never returned
    std::uint64_t overflowed() const { return overflowed_; }
    std::uint64_t capacity() const { return capacity_; }

    // Order in which the current operation visited nodes, for the timing of list walks.
    void visit(std::uint32_t node) { visited_.push_back(node); }
    std::vector<std::uint32_t>& visited() { return visited_; }

 private:
    static constexpr std::size_t kChunk = 4096;
    std::size_t words_per_node_;
    std::uint64_t capacity_;
    std::uint64_t used_ = 0;
    std::uint64_t overflowed_ = 0;
    std::vector<std::unique_ptr<std::uint32_t[]>> chunks_;
    std::vector<std::uint32_t> visited_;
};

}  // namespace ropsim
