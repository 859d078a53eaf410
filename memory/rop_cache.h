// The ROP cache as a tag store: which sectors and dirty bytes it holds, not their values and not its timing.
#pragma once

#include "base/error.h"
#include "memory/bit_count.h"
#include "memory/memory_cause.h"

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

namespace ropsim {

inline constexpr int kCacheSections = 3;

struct RopCacheConfig {
    std::uint32_t size_bytes = 16384;
    std::uint32_t ways = 4;
    std::uint32_t line_bytes = 128;   // power of two, 64..256
    std::uint32_t sector_bytes = 32;  // power of two, 8..line_bytes, at most 32 sectors a line
    // Separate caches in one store: bytes of each section, which add up to size_bytes. All 0: one cache.
    std::array<std::uint32_t, kCacheSections> section_bytes{};
};

// Throws UserError("rop_cache", ...) on sizes that do not fit together.
void check_cache_config(const RopCacheConfig& config);

// One bit a byte of a line, bit 0 the first.
struct LineMask {
    std::array<std::uint64_t, 4> word{};

    static LineMask range(std::uint32_t first, std::uint32_t count);
    // Bits [first, first + count), moved to the start.
    LineMask part(std::uint32_t first, std::uint32_t count) const;
    // Moved up by `by` bits; those that leave at the top are lost.
    LineMask raised(std::uint32_t by) const;
    std::uint32_t count() const {
        if ((word[2] | word[3]) == 0) return bits_set(word[0], word[1], 0, 0);  // most lines are no longer
        return bits_set(word[0], word[1], word[2], word[3]);
    }
    bool any() const { return (word[0] | word[1] | word[2] | word[3]) != 0; }
    LineMask& operator|=(LineMask other) {  // a value, which is not *this: for vectors of words
        for (std::size_t w = 0; w < word.size(); ++w) word[w] |= other.word[w];
        return *this;
    }
    friend bool operator==(const LineMask&, const LineMask&) = default;
};

// Bytes that must be written to memory because their line leaves the cache (or is flushed).
struct Eviction {
    std::uint64_t line_address = 0;
    std::uint8_t surface = 0;
    std::uint32_t sectors = 0;           // sectors with dirty bytes; 0: nothing to write
    std::uint32_t resident_sectors = 0;  // sectors whose bytes are all known: valid, or CLEAR in memory
    std::uint32_t dirty_bytes = 0;       // bytes in `bytes`
    LineMask bytes;                      // byte enables
    std::uint64_t writer = 0;            // of the line's last write(), if there is something to write
};

// Counts since construction, in sectors unless said otherwise.
struct RopCacheStatistics {
    std::uint64_t sector_hits = 0;       // read sectors that were here (valid, or cleared on chip)
    std::uint64_t sector_misses = 0;     // read sectors that had to be fetched
    std::uint64_t sector_merges = 0;     // read sectors that were already being fetched
    std::uint64_t line_allocations = 0;  // lines
    std::uint64_t line_evictions = 0;    // lines that left for another, clean or dirty
    std::uint64_t sectors_written_back = 0;
    std::uint64_t bytes_written_back = 0;  // enabled bytes
    std::uint64_t fills_avoided = 0;       // read sectors filled on chip with the clear value

    void add(const RopCacheStatistics& other) {
        sector_hits += other.sector_hits;
        sector_misses += other.sector_misses;
        sector_merges += other.sector_merges;
        line_allocations += other.line_allocations;
        line_evictions += other.line_evictions;
        sectors_written_back += other.sectors_written_back;
        bytes_written_back += other.bytes_written_back;
        fills_avoided += other.fills_avoided;
    }
};

// Set-associative, write-back, allocate on write without fetch, true LRU, sectors with a valid bit, a dirty
// bit a byte. Addresses are bytes; a line address is a multiple of line_bytes. A "line" is an index into the
// store that allocate() returned and stays meaningful while the line is pinned or until the next allocate().
//
// Sections are caches of their own that share ways, line and sector size: a surface's lines live in the sets
// of its section. A line belongs to one surface.
//
// Fast clear: sectors inside a clear range are CLEAR until first written back; reading one needs no fetch,
// and writing one back writes all of it, because memory holds nothing usable below.
class RopCache {
 public:
    static constexpr int kMiss = -1;

    // Throws as check_cache_config().
    explicit RopCache(const RopCacheConfig& config);

    // Puts a surface into a section that has bytes, before any line of it is used. All start in section 0.
    void set_section(std::uint8_t surface, int section);
    // The line of this surface that holds this address, or kMiss. Does not touch the LRU order.
    int probe(std::uint64_t line_address, std::uint8_t surface) const {
        const std::size_t first = first_way(line_address, surface);
        return config_.ways == 4 ? way_of<4>(line_address, first) : way_of<0>(line_address, first);
    }
    // Marks a line as most recently used.
    void touch(int line) { last_use_[at(line)] = ++clock_; }
    // Takes the least recently used line of the set that is not pinned and not being filled, and gives it to
    // `line_address` (which must not be present). *evicted tells what to write back (sectors == 0: nothing).
    // Returns kMiss when every way is taken; *evicted is untouched then.
    int allocate(std::uint64_t line_address, std::uint8_t surface, Eviction* evicted);
    // Of the sectors in `read`, those that must be fetched now: not valid, not CLEAR, not already on their
    // way. They are marked as on their way until fill(). Counts hits, merges and misses; CLEAR ones become
    // valid.
    std::uint32_t request_sectors(int index, std::uint32_t read) {
        Line& line = lines_[at(index)];
        if ((line.valid | line.pending | line.clear) == 0) {  // mostly it is new
            statistics_.sector_misses += bits_set(read);
            return line.pending = read;
        }
        if ((read & ~line.valid) != 0) return request_absent(line, read);
        statistics_.sector_hits += bits_set(read);
        return 0;
    }
    // Marks all sectors that are neither here nor on their way as on their way: memory delivers the line
    // whole. Counts nothing.
    std::uint32_t request_rest(int line);
    // Of the sectors in `read`, those on their way.
    std::uint32_t pending_sectors(int line, std::uint32_t read) const {
        return lines_[at(line)].pending & read;
    }
    // Sectors arrived from memory: valid below whatever was written since.
    void fill(int line, std::uint32_t sectors);
    // Bytes were written. A sector whose bytes are all dirty is valid. `writer`: the caller's, kept for the
    // line's eviction.
    void write(int line, const LineMask& bytes, std::uint64_t writer = 0) {
        write(line, bytes, touched_sectors(bytes), writer);
    }
    // `sectors`: those that the bytes touch.
    void write(int line, const LineMask& bytes, std::uint32_t sectors, std::uint64_t writer);
    void write(int line, std::uint32_t first_byte, std::uint32_t byte_count) {
        write(line, LineMask::range(first_byte, byte_count));
    }

    // A pinned line is not evicted. Pins nest.
    void pin(int line) { ++lines_[at(line)].pins; }
    void unpin(int line) {
        CHECK(lines_[at(line)].pins != 0, "line {} is not pinned", line);
        --lines_[at(line)].pins;
    }
    bool pinned(int line) const { return lines_[at(line)].pins != 0; }

    // What the line would write back now; the line becomes clean and stays valid.
    Eviction clean(int line);
    // The first line >= `from` with dirty bytes, or kMiss. Lines run from 0 to line_count() - 1, set by set.
    int next_dirty(int from) const;
    // Calls visit(Eviction) for every dirty line, set by set, and marks it clean: the end-of-frame flush.
    template <class Visit>
    void flush(Visit&& visit) {
        for (int line = next_dirty(0); line != kMiss; line = next_dirty(line + 1)) visit(clean(line));
    }
    // Drops every line without writing back. No line may be pinned or dirty.
    void invalidate();

    // Sectors wholly inside [first, first + bytes) are CLEAR from now on. A range with the same `first` and
    // `bytes` starts over; other ranges must not overlap it. Lines of it that are in the cache must not be
    // dirty.
    void set_clear_range(std::uint64_t first, std::uint64_t bytes);
    // Whether this sector of memory was never written since it was cleared.
    bool is_clear(std::uint64_t address) const;
    // Sectors of a line, here or not, whose bytes are known without a fetch: valid, or CLEAR.
    std::uint32_t known_sectors(std::uint64_t line_address, std::uint8_t surface) const;
    // Memory now holds all of this line: none of it is CLEAR any more.
    void forget_clear(std::uint64_t line_address, std::uint8_t surface);
    std::uint32_t all_sectors() const { return all_sectors_; }

    std::uint64_t line_address(int line) const { return tags_[at(line)]; }
    std::uint8_t surface(int line) const { return lines_[at(line)].surface; }
    std::uint32_t valid_sectors(int line) const { return lines_[at(line)].valid; }
    const LineMask& dirty_bytes(int line) const { return data_[at(line)].dirty; }
    int line_count() const { return static_cast<int>(lines_.size()); }
    const RopCacheConfig& config() const { return config_; }
    const RopCacheStatistics& statistics() const { return statistics_; }
    // Sectors that bytes [first_byte, first_byte + byte_count) of a line touch.
    std::uint32_t sectors_of(std::uint32_t first_byte, std::uint32_t byte_count) const;

 private:
    // What every look-up and every choice of a victim needs, apart from what only writes do.
    struct Line {
        std::uint32_t valid = 0;
        std::uint32_t pending = 0;  // sectors on their way
        std::uint32_t clear = 0;    // sectors that memory holds as CLEAR
        std::uint16_t pins = 0;
        std::uint8_t surface = 0;
    };
    struct Written {
        LineMask dirty;
        std::uint64_t writer = 0;
        std::uint32_t sectors = 0;  // with dirty bytes
    };
    struct ClearRange {
        std::uint64_t first = 0;
        std::uint64_t bytes = 0;
        std::vector<std::uint64_t> clear;  // one bit a sector
    };
    // A section's sets: a power of two of them is chosen by a mask, any other number by division.
    struct Section {
        std::size_t first_line = 0;
        std::uint32_t sets = 0;
        std::uint32_t mask = 0;  // sets - 1; 0: not a power of two, or one set
    };
    static std::size_t at(int line) { return static_cast<std::size_t>(line); }
    std::size_t first_way(std::uint64_t line_address, std::uint8_t surface) const {
        const Section& section = section_of_[surface];
        const std::uint64_t number = line_address >> line_shift_;
        const std::uint64_t set = section.mask != 0 ? number & section.mask : number % section.sets;
        return section.first_line + set * config_.ways;
    }
    // Four ways, the usual number, or if kWays is 0 as many as there are. Without a branch on what is found:
    // it is as good as random.
    template <std::uint32_t kWays>
    int way_of(std::uint64_t line_address, std::size_t first) const {
        const std::uint64_t* tags = &tags_[first];
        int found = kMiss;
        const auto look_at = [&](std::uint32_t way) {
            found = tags[way] == line_address ? static_cast<int>(first + way) : found;
        };
        if constexpr (kWays == 4) {  // as a loop it would stay one
            look_at(0);
            look_at(1);
            look_at(2);
            look_at(3);
        } else {
            for (std::uint32_t way = 0; way < config_.ways; ++way) look_at(way);
        }
        return found;
    }
    template <std::uint32_t kWays>
    int victim(std::size_t first) const;
    std::uint32_t request_absent(Line& line, std::uint32_t read);
    std::uint32_t clear_sectors(std::uint64_t line_address) const;
    void materialise(std::uint64_t line_address, std::uint32_t sectors);
    LineMask sector_bytes(std::uint32_t sectors) const;
    std::uint32_t touched_sectors(const LineMask& bytes) const;
    std::uint32_t covered_sectors(const LineMask& bytes) const;
    void write_back(int line, Eviction& out);

    RopCacheConfig config_;
    std::array<Section, kCacheSections> sections_{};
    std::array<Section, kMaxSurfaces> section_of_{};  // by surface
    std::uint32_t line_shift_ = 0;
    std::uint32_t sector_shift_ = 0;
    std::uint32_t all_sectors_ = 0;
    std::uint64_t clock_ = 0;
    std::vector<std::uint64_t> tags_;      // kNoTag: empty
    std::vector<std::uint64_t> last_use_;  // clock_ then
    std::vector<Line> lines_;
    std::vector<Written> data_;
    std::vector<ClearRange> ranges_;
    RopCacheStatistics statistics_;
};

}  // namespace ropsim
