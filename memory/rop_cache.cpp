// The tag store: look-up, replacement, sectors, dirty bytes.
#include "memory/rop_cache.h"

#include "base/error.h"

#include <algorithm>

namespace ropsim {
namespace {
constexpr std::uint64_t kNoTag = ~std::uint64_t{0};
constexpr int kWayBits = 20;  // and 44 of uses: days of simulation
}  // namespace

void check_cache_config(const RopCacheConfig& c) {
    const auto require = [](bool holds, const std::string& what) {
        if (!holds) throw UserError("rop_cache", what);
    };
    require(std::has_single_bit(c.line_bytes) && c.line_bytes >= 64 && c.line_bytes <= 256,
            fmt::format("line_bytes {} must be 64, 128 or 256", c.line_bytes));
    require(std::has_single_bit(c.sector_bytes) && c.sector_bytes >= 8 && c.sector_bytes <= c.line_bytes,
            fmt::format("sector_bytes {} must be a power of two from 8 to line_bytes", c.sector_bytes));
    require(c.ways >= 1 && c.size_bytes != 0 && c.size_bytes % (c.line_bytes * c.ways) == 0,
            fmt::format("size_bytes {} must be a multiple of ways x line_bytes = {} x {}", c.size_bytes,
                        c.ways, c.line_bytes));
    require(c.ways < 1u << kWayBits, fmt::format("ways {} must be below {}", c.ways, 1u << kWayBits));
    std::uint64_t sections = 0;
    for (const std::uint32_t bytes : c.section_bytes) {
        sections += bytes;
        require(bytes % (c.line_bytes * c.ways) == 0,
                fmt::format("a section of {} bytes must be a multiple of ways x line_bytes = {} x {}", bytes,
                            c.ways, c.line_bytes));
    }
    require(sections == 0 || c.section_bytes[0] != 0, "section 0 must have bytes");
    require(sections == 0 || sections == c.size_bytes,
            fmt::format("sections of {} bytes in all do not make size_bytes {}", sections, c.size_bytes));
}

LineMask LineMask::range(std::uint32_t first, std::uint32_t count) {
    LineMask mask;
    const std::uint32_t end = first + count;
    for (std::uint32_t w = 0; w < 4; ++w) {
        const std::uint32_t low = std::max(first, w * 64);
        const std::uint32_t high = std::min(end, w * 64 + 64);
        if (low >= high) continue;
        mask.word[w] = (~std::uint64_t{0} >> (64 - (high - low))) << (low - w * 64);
    }
    return mask;
}

LineMask LineMask::part(std::uint32_t first, std::uint32_t count) const {
    LineMask moved = range(0, count);
    const std::uint32_t words = first / 64;
    const std::uint32_t bits = first % 64;
    for (std::uint32_t w = 0; w < 4; ++w) {
        const std::uint64_t low = w + words < 4 ? word[w + words] : 0;
        const std::uint64_t high = w + words + 1 < 4 && bits != 0 ? word[w + words + 1] << (64 - bits) : 0;
        moved.word[w] &= low >> bits | high;
    }
    return moved;
}

LineMask LineMask::raised(std::uint32_t by) const {
    LineMask moved;
    const std::uint32_t words = by / 64;
    const std::uint32_t bits = by % 64;
    for (std::uint32_t w = words; w < 4; ++w) {
        const std::uint64_t low = bits != 0 && w > words ? word[w - words - 1] >> (64 - bits) : 0;
        moved.word[w] = word[w - words] << bits | low;
    }
    return moved;
}

RopCache::RopCache(const RopCacheConfig& config) : config_(config) {
    check_cache_config(config);
    const std::uint32_t lines = config.size_bytes / config.line_bytes;
    line_shift_ = static_cast<std::uint32_t>(std::countr_zero(config.line_bytes));
    sector_shift_ = static_cast<std::uint32_t>(std::countr_zero(config.sector_bytes));
    all_sectors_ = ~0u >> (32 - config.line_bytes / config.sector_bytes);
    tags_.assign(lines, kNoTag);
    last_use_.assign(lines, 0);
    lines_.assign(lines, Line{});
    data_.assign(lines, Written{});
    std::size_t first_line = 0;
    const bool whole = config.section_bytes == decltype(config.section_bytes){};
    for (std::size_t s = 0; s < sections_.size(); ++s) {
        const std::uint32_t bytes = whole ? (s == 0 ? config.size_bytes : 0) : config.section_bytes[s];
        const std::uint32_t sets = bytes / config.line_bytes / config.ways;
        sections_[s] = {first_line, sets, std::has_single_bit(sets) ? sets - 1 : 0};
        first_line += std::size_t{sets} * config.ways;
    }
    section_of_.fill(sections_[0]);
}

void RopCache::set_section(std::uint8_t surface, int section) {
    CHECK(sections_[static_cast<std::size_t>(section)].sets != 0, "section {} has no bytes", section);
    section_of_[surface] = sections_[static_cast<std::size_t>(section)];
}

// The way that was used longest ago of those that are not held, or kMiss. The last use and the way in one
// word, all ones where the line is held: no branch, which way it is is as good as random.
template <std::uint32_t kWays>
inline int RopCache::victim(std::size_t first) const {
    const std::uint32_t ways = kWays != 0 ? kWays : config_.ways;
    std::uint64_t oldest = ~std::uint64_t{0};
    for (std::uint32_t way = 0; way < ways; ++way) {
        const Line& line = lines_[first + way];
        const std::uint64_t held =
            std::uint64_t{0} - static_cast<std::uint64_t>((line.pins | line.pending) != 0);
        oldest = std::min(oldest, (last_use_[first + way] << kWayBits | way) | held);
    }
    if (oldest == ~std::uint64_t{0}) return kMiss;
    return static_cast<int>(first + (oldest & ((std::uint64_t{1} << kWayBits) - 1)));
}

int RopCache::allocate(std::uint64_t line_address, std::uint8_t surface, Eviction* evicted) {
    CHECK((line_address & (config_.line_bytes - 1)) == 0, "address {:#x}", line_address);
    // Far away in the host's memory and used last: asked for first.
    const std::uint32_t clear = clear_sectors(line_address);
    const std::size_t first = first_way(line_address, surface);
    const int index = config_.ways == 4 ? victim<4>(first) : victim<0>(first);
    if (index == kMiss) return kMiss;
    const std::size_t line = at(index);
    if (tags_[line] != kNoTag) {
        write_back(index, *evicted);
        ++statistics_.line_evictions;
    } else {
        *evicted = Eviction{};
    }
    ++statistics_.line_allocations;
    tags_[line] = line_address;
    last_use_[line] = ++clock_;
    lines_[line] = {0, 0, clear, 0, surface};
    return index;
}

std::uint32_t RopCache::request_absent(Line& line, std::uint32_t read) {
    if (const std::uint32_t filled_on_chip = read & line.clear & ~line.valid; filled_on_chip != 0) {
        line.valid |= filled_on_chip;
        statistics_.fills_avoided += bits_set(filled_on_chip);
    }
    statistics_.sector_hits += bits_set(read & line.valid);
    const std::uint32_t absent = read & ~line.valid;
    statistics_.sector_merges += bits_set(absent & line.pending);
    const std::uint32_t fetch = absent & ~line.pending;
    statistics_.sector_misses += bits_set(fetch);
    line.pending |= fetch;
    return fetch;
}

std::uint32_t RopCache::request_rest(int index) {
    Line& line = lines_[at(index)];
    const std::uint32_t rest = all_sectors_ & ~(line.valid | line.pending);
    line.pending |= rest;
    return rest;
}

void RopCache::fill(int index, std::uint32_t sectors) {
    Line& line = lines_[at(index)];
    CHECK((sectors & ~line.pending) == 0, "sectors {:x} of {:x}", sectors, line.pending);
    line.pending &= ~sectors;
    line.valid |= sectors;
}

void RopCache::write(int index, const LineMask& bytes, std::uint32_t touched, std::uint64_t writer) {
    Line& line = lines_[at(index)];
    Written& data = data_[at(index)];
    data.writer = writer;
    data.dirty |= bytes;
    data.sectors |= touched;
    // A CLEAR sector gets the rest of its bytes on chip, without anybody having asked to read them.
    if ((touched & ~line.valid) != 0) line.valid |= (touched & line.clear) | covered_sectors(data.dirty);
}

// What the line would write back; it is clean then.
void RopCache::write_back(int index, Eviction& out) {
    Line& line = lines_[at(index)];
    Written& data = data_[at(index)];
    out.line_address = tags_[at(index)];
    out.surface = line.surface;
    out.writer = data.writer;
    out.sectors = data.sectors;
    out.resident_sectors = line.valid | line.clear;
    out.bytes = data.dirty;
    out.dirty_bytes = 0;
    if (out.sectors == 0) return;
    if (const std::uint32_t first_time = out.sectors & line.clear; first_time != 0) {
        out.bytes |= sector_bytes(first_time);
        materialise(out.line_address, first_time);
        line.clear &= ~first_time;
    }
    out.dirty_bytes = out.bytes.count();
    data.dirty = LineMask{};
    data.sectors = 0;
    statistics_.sectors_written_back += bits_set(out.sectors);
    statistics_.bytes_written_back += out.dirty_bytes;
}

Eviction RopCache::clean(int index) {
    CHECK(tags_[at(index)] != kNoTag, "line {} is empty", index);
    Eviction out;
    write_back(index, out);
    return out;
}

int RopCache::next_dirty(int from) const {
    for (std::size_t line = at(from); line < lines_.size(); ++line)
        if (data_[line].sectors != 0) return static_cast<int>(line);
    return kMiss;
}

void RopCache::invalidate() {
    for (std::size_t i = 0; i < lines_.size(); ++i) {
        CHECK(data_[i].sectors == 0 && lines_[i].pins == 0 && lines_[i].pending == 0, "line {} is in use", i);
        tags_[i] = kNoTag;
        last_use_[i] = 0;
        lines_[i] = Line{};
        data_[i] = Written{};
    }
}

std::uint32_t RopCache::sectors_of(std::uint32_t first_byte, std::uint32_t byte_count) const {
    if (byte_count == 0) return 0;
    const std::uint32_t first = first_byte >> sector_shift_;
    const std::uint32_t last = (first_byte + byte_count - 1) >> sector_shift_;
    return (~0u >> (31 - (last - first))) << first;
}

LineMask RopCache::sector_bytes(std::uint32_t sectors) const {
    LineMask mask;
    for (; sectors != 0; sectors &= sectors - 1) {
        const auto sector = static_cast<std::uint32_t>(std::countr_zero(sectors));
        mask |= LineMask::range(sector << sector_shift_, config_.sector_bytes);
    }
    return mask;
}

std::uint32_t RopCache::touched_sectors(const LineMask& bytes) const {
    std::uint32_t sectors = 0;
    if (config_.sector_bytes == 32) {  // the usual: without a branch
        for (std::uint32_t w = 0; w < 4; ++w) {
            sectors |= static_cast<std::uint32_t>((bytes.word[w] & 0xFFFFFFFFu) != 0) << (2 * w);
            sectors |= static_cast<std::uint32_t>(bytes.word[w] >> 32 != 0) << (2 * w + 1);
        }
        return sectors & all_sectors_;
    }
    for (std::uint32_t byte = 0, sector = 0; byte < config_.line_bytes;
         byte += config_.sector_bytes, ++sector) {
        if (config_.sector_bytes >= 64) {
            for (std::uint32_t w = byte / 64; w < (byte + config_.sector_bytes) / 64; ++w)
                if (bytes.word[w] != 0) sectors |= 1u << sector;
            continue;
        }
        const std::uint64_t ones = (std::uint64_t{1} << config_.sector_bytes) - 1;
        if ((bytes.word[byte / 64] >> (byte % 64) & ones) != 0) sectors |= 1u << sector;
    }
    return sectors;
}

std::uint32_t RopCache::covered_sectors(const LineMask& bytes) const {
    LineMask missing;
    for (std::size_t w = 0; w < 4; ++w) missing.word[w] = ~bytes.word[w];
    return all_sectors_ & ~touched_sectors(missing);
}

}  // namespace ropsim
