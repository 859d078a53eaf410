// What fully associative caches of many sizes would move, in one pass: the ROP cache without its sets.
#pragma once

#include "memory/lru_stack.h"
#include "memory/rop_cache.h"

#include <array>
#include <cstdint>
#include <vector>

namespace ropsim {

// Sectors, lines with a dirty bit a byte, allocation on write without a fetch and fast clear are those of
// RopCache with one set. Stack distances count lines; what becomes of a sector follows from the largest
// distance at which its line was used since (Thompson and Smith, ACM TOCS 1989, on sectors and write-back in
// stack simulation). Larger is never worse.
class LruTraffic {
 public:
    // `capacities` in lines, as of LruStack.
    LruTraffic(std::uint32_t line_bytes, std::uint32_t sector_bytes, std::vector<std::uint32_t> capacities,
               int surfaces);

    // As RopCache's, before any use.
    void set_clear_range(std::uint64_t first, std::uint64_t bytes);
    void use(std::uint64_t line_address, std::uint32_t read_sectors, const LineMask& write_bytes,
             std::uint8_t surface);

    // Of a cache of capacities()[level] lines that is flushed at the end, in sectors. With level ==
    // capacities().size(), for which nothing is ever evicted, the least that any size moves: what the stream
    // reads without having written, and each sector that it writes, once.
    std::uint64_t fills(int surface, std::size_t level) const;
    std::uint64_t write_backs(int surface, std::size_t level) const;
    // Share of the uses of lines that found their line, 0..1; 0 without uses.
    double line_hit_share(std::size_t level) const;

    const std::vector<std::uint32_t>& capacities() const { return stack_.capacities(); }
    // Different lines used, and uses.
    std::uint32_t lines() const { return stack_.lines(); }
    std::uint64_t uses() const { return uses_; }

 private:
    static constexpr std::uint8_t kNever = 255;
    static constexpr std::uint32_t kNoNumber = ~std::uint32_t{0};
    // Levels: the smallest capacity in which something has been kept since it came; capacities().size(): in
    // none of them. kNever: it never came.
    struct Sector {
        std::uint8_t read = kNever;   // fetched, or filled on chip
        std::uint8_t dirty = kNever;  // written
        std::uint8_t clear = kNever;  // without a write-back since the clear
    };
    struct ClearRange {
        std::uint64_t first;
        std::uint64_t bytes;
    };
    // By level, with one more for kNever.
    using Histogram = std::vector<std::uint64_t>;
    void count(Histogram& histogram, std::uint8_t level) const;
    std::uint32_t number_of(std::uint64_t line_address);
    void age(std::uint32_t line, std::uint8_t level);
    std::uint8_t written_level(std::uint32_t line, std::uint32_t sector) const;

    std::uint32_t line_bytes_;
    std::uint32_t sector_bytes_;
    std::uint32_t sectors_;  // of a line
    LruStack stack_;
    std::vector<ClearRange> clear_ranges_;
    std::vector<std::uint32_t> dense_;        // by line of the address space: its number
    std::vector<Sector> sector_;              // [number * sectors_ + sector]
    std::vector<std::uint8_t> byte_written_;  // [number * line_bytes_ + byte]: level
    std::vector<Histogram> fills_;            // [surface]
    std::vector<Histogram> writes_;           // [surface]: first writes of a sector since its write-back
    Histogram line_uses_;
    std::uint64_t uses_ = 0;
};

}  // namespace ropsim
