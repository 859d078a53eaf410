// The tag store: look-up, replacement, sectors, dirty bytes.
#include "memory/rop_cache.h"

#include "base/error.h"

#include <algorithm>

namespace ropsim {
namespace {
constexpr std::uint64_t kNoTag = ~std::uint64_t{0};
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

std::uint32_t LineMask::count() const {
    int bits = 0;
    for (const std::uint64_t w : word) bits += std::popcount(w);
    return static_cast<std::uint32_t>(bits);
}

RopCache::RopCache(const RopCacheConfig& config) : config_(config) {
    check_cache_config(config);
    const std::uint32_t lines = config.size_bytes / config.line_bytes;
    line_shift_ = static_cast<std::uint32_t>(std::countr_zero(config.line_bytes));
    sector_shift_ = static_cast<std::uint32_t>(std::countr_zero(config.sector_bytes));
    all_sectors_ = ~0u >> (32 - config.line_bytes / config.sector_bytes);
    tags_.assign(lines, kNoTag);
    lines_.assign(lines, Line{});
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

int RopCache::probe(std::uint64_t line_address, std::uint8_t surface) const {
    const std::size_t first = first_way(line_address, surface);
    for (std::size_t line = first; line < first + config_.ways; ++line)
        if (tags_[line] == line_address) return static_cast<int>(line);
    return kMiss;
}

int RopCache::allocate(std::uint64_t line_address, std::uint8_t surface, Eviction* evicted,
                       std::uint64_t now) {
    CHECK((line_address & (config_.line_bytes - 1)) == 0, "address {:#x}", line_address);
    const std::size_t first = first_way(line_address, surface);
    std::size_t victim = lines_.size();
    for (std::size_t way = first; way < first + config_.ways; ++way) {
        CHECK(tags_[way] != line_address, "line {:#x} is present", line_address);
        const Line& line = lines_[way];
        if (line.pins != 0 || line.pending != 0 || line.pinned_until > now) continue;
        if (victim == lines_.size() || line.last_use < lines_[victim].last_use) victim = way;
    }
    if (victim == lines_.size()) return kMiss;
    const int index = static_cast<int>(victim);
    *evicted = Eviction{};
    if (tags_[victim] != kNoTag) {
        *evicted = write_back(index);
        ++statistics_.line_evictions;
    }
    ++statistics_.line_allocations;
    tags_[victim] = line_address;
    Line& line = lines_[victim];
    line = Line{};
    line.last_use = ++clock_;
    line.surface = surface;
    line.clear = clear_sectors(line_address);
    return index;
}

std::uint32_t RopCache::request_sectors(int index, std::uint32_t read) {
    Line& line = lines_[at(index)];
    const auto count = [](std::uint32_t sectors) {
        // Most are 0, and counting bits is a library call on a plain x86-64.
        return sectors == 0 ? std::uint64_t{0} : static_cast<std::uint64_t>(std::popcount(sectors));
    };
    const std::uint32_t filled_on_chip = read & line.clear & ~line.valid;
    line.valid |= filled_on_chip;
    statistics_.fills_avoided += count(filled_on_chip);
    statistics_.sector_hits += count(read & line.valid);
    const std::uint32_t absent = read & ~line.valid;
    statistics_.sector_merges += count(absent & line.pending);
    const std::uint32_t fetch = absent & ~line.pending;
    statistics_.sector_misses += count(fetch);
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

void RopCache::write(int index, const LineMask& bytes, std::uint64_t writer) {
    Line& line = lines_[at(index)];
    line.writer = writer;
    for (std::size_t w = 0; w < 4; ++w) line.dirty.word[w] |= bytes.word[w];
    const std::uint32_t touched = touched_sectors(bytes);
    // A CLEAR sector gets the rest of its bytes on chip, without anybody having asked to read them.
    line.valid |= (touched & line.clear) | covered_sectors(line.dirty);
}

void RopCache::unpin(int index) {
    Line& line = lines_[at(index)];
    CHECK(line.pins != 0, "line {} is not pinned", index);
    --line.pins;
}

void RopCache::pin_until(int index, std::uint64_t time) {
    Line& line = lines_[at(index)];
    line.pinned_until = std::max(line.pinned_until, time);
}

std::uint64_t RopCache::earliest_free(std::uint64_t line_address, std::uint8_t surface) const {
    const std::size_t first = first_way(line_address, surface);
    std::uint64_t earliest = ~std::uint64_t{0};
    for (std::size_t way = first; way < first + config_.ways; ++way) {
        const Line& line = lines_[way];
        if (line.pins == 0 && line.pending == 0) earliest = std::min(earliest, line.pinned_until);
    }
    return earliest;
}

Eviction RopCache::write_back(int index) {
    Line& line = lines_[at(index)];
    Eviction out;
    out.line_address = tags_[at(index)];
    out.surface = line.surface;
    out.writer = line.writer;
    out.sectors = touched_sectors(line.dirty);
    out.resident_sectors = line.valid | line.clear;
    if (out.sectors == 0) return out;
    out.bytes = line.dirty;
    if (const std::uint32_t first_time = out.sectors & line.clear; first_time != 0) {
        const LineMask whole = sector_bytes(first_time);
        for (std::size_t w = 0; w < 4; ++w) out.bytes.word[w] |= whole.word[w];
        materialise(out.line_address, first_time);
        line.clear &= ~first_time;
    }
    out.dirty_bytes = out.bytes.count();
    line.dirty = LineMask{};
    statistics_.sectors_written_back += static_cast<std::uint64_t>(std::popcount(out.sectors));
    statistics_.bytes_written_back += out.dirty_bytes;
    return out;
}

Eviction RopCache::clean(int index) {
    CHECK(tags_[at(index)] != kNoTag, "line {} is empty", index);
    return write_back(index);
}

int RopCache::next_dirty(int from) const {
    for (std::size_t line = at(from); line < lines_.size(); ++line)
        if (tags_[line] != kNoTag && lines_[line].dirty.any()) return static_cast<int>(line);
    return kMiss;
}

void RopCache::invalidate() {
    for (std::size_t i = 0; i < lines_.size(); ++i) {
        CHECK(!lines_[i].dirty.any() && lines_[i].pins == 0 && lines_[i].pending == 0, "line {} is in use",
              i);
        tags_[i] = kNoTag;
        lines_[i] = Line{};
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
        const LineMask one = LineMask::range(sector << sector_shift_, config_.sector_bytes);
        for (std::size_t w = 0; w < 4; ++w) mask.word[w] |= one.word[w];
    }
    return mask;
}

std::uint32_t RopCache::touched_sectors(const LineMask& bytes) const {
    std::uint32_t sectors = 0;
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
