// LRU stack distances of a stream of lines, for caches of many sizes in one pass.
#pragma once

#include <cstdint>
#include <vector>

namespace ropsim {

// Mattson, Gecsei, Slutz and Traiger (IBM Systems Journal 1970): a fully associative LRU cache of C lines
// holds a line if and only if its stack distance, the different lines used since its last use, itself
// included, is at most C. Distances are told as levels between the capacities asked for, which one mark each
// in the list of lines keeps; a use costs a step for each level that its line has sunk by.
class LruStack {
 public:
    // `capacities` in lines, ascending, each above 0; at least 1, at most 254.
    explicit LruStack(std::vector<std::uint32_t> capacities);

    // The level of the line's distance: the index of the smallest capacity that still held it, capacities()
    // .size() when none did or it is new. The line is then the most recently used. Lines are numbered from
    // 0; memory is taken up to the largest number.
    int use(std::uint32_t line);

    const std::vector<std::uint32_t>& capacities() const { return capacities_; }
    // Different lines used so far.
    std::uint32_t lines() const { return count_; }

 private:
    static constexpr std::uint32_t kNone = ~std::uint32_t{0};
    struct Node {
        std::uint32_t newer = kNone;
        std::uint32_t older = kNone;
        int level = -1;  // -1: never used
    };
    void push_front(std::uint32_t line);
    void sink(std::size_t level);

    std::vector<std::uint32_t> capacities_;
    std::vector<std::uint32_t> last_of_level_;  // the line at the place of each capacity; kNone: list shorter
    std::vector<Node> nodes_;                   // by line
    std::uint32_t newest_ = kNone;
    std::uint32_t oldest_ = kNone;
    std::uint32_t count_ = 0;
};

}  // namespace ropsim
