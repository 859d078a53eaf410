// Fast clear: one bit a sector says that memory was not written since the surface was cleared.
#include "base/error.h"
#include "memory/rop_cache.h"

#include <algorithm>

namespace ropsim {

void RopCache::set_clear_range(std::uint64_t first, std::uint64_t bytes) {
    const std::uint64_t begin = (first + config_.sector_bytes - 1) >> sector_shift_;
    const std::uint64_t end = (first + bytes) >> sector_shift_;
    if (begin >= end) return;
    ClearRange range;
    range.first = begin << sector_shift_;
    range.bytes = (end - begin) << sector_shift_;
    auto same = ranges_.begin();
    for (; same != ranges_.end(); ++same) {
        if (same->first == range.first && same->bytes == range.bytes) break;
        CHECK(same->first + same->bytes <= range.first || range.first + range.bytes <= same->first,
              "clear ranges at {:#x} and {:#x} overlap", same->first, range.first);
    }
    if (same == ranges_.end()) same = ranges_.insert(ranges_.end(), range);
    same->clear.assign((end - begin + 63) / 64, ~std::uint64_t{0});
    for (std::size_t i = 0; i < lines_.size(); ++i) {
        if (tags_[i] == ~std::uint64_t{0} || tags_[i] + config_.line_bytes <= range.first ||
            tags_[i] >= range.first + range.bytes)
            continue;
        CHECK(data_[i].sectors == 0 && lines_[i].pending == 0, "line {:#x} is in use", tags_[i]);
        lines_[i].clear = clear_sectors(tags_[i]);
    }
}

bool RopCache::is_clear(std::uint64_t address) const {
    for (const ClearRange& range : ranges_) {
        if (address < range.first || address - range.first >= range.bytes) continue;
        const std::uint64_t sector = (address - range.first) >> sector_shift_;
        return (range.clear[sector / 64] >> (sector % 64) & 1) != 0;
    }
    return false;
}

std::uint32_t RopCache::known_sectors(std::uint64_t line_address, std::uint8_t surface) const {
    const int line = probe(line_address, surface);
    return line == kMiss ? clear_sectors(line_address) : lines_[at(line)].valid | lines_[at(line)].clear;
}

void RopCache::forget_clear(std::uint64_t line_address, std::uint8_t surface) {
    if (const std::uint32_t clear = clear_sectors(line_address); clear != 0) materialise(line_address, clear);
    if (const int index = probe(line_address, surface); index != kMiss) {
        Line& line = lines_[at(index)];
        line.valid |= line.clear;  // filled on chip while it is known what with
        line.clear = 0;
    }
}

std::uint32_t RopCache::clear_sectors(std::uint64_t line_address) const {
    if (ranges_.empty()) return 0;
    std::uint32_t sectors = 0;
    const std::uint32_t count = config_.line_bytes >> sector_shift_;
    for (const ClearRange& range : ranges_) {
        if (line_address + config_.line_bytes <= range.first || line_address >= range.first + range.bytes)
            continue;
        if (line_address >= range.first && line_address + config_.line_bytes <= range.first + range.bytes) {
            const std::uint64_t bit = (line_address - range.first) >> sector_shift_;
            const std::uint64_t* word = &range.clear[bit / 64];
            std::uint64_t bits = word[0] >> (bit % 64);
            if (bit % 64 + count > 64) bits |= word[1] << (64 - bit % 64);
            return static_cast<std::uint32_t>(bits) & all_sectors_;
        }
        for (std::uint32_t s = 0; s < count; ++s) {
            const std::uint64_t address = line_address + (std::uint64_t{s} << sector_shift_);
            if (address < range.first || address - range.first >= range.bytes) continue;
            const std::uint64_t bit = (address - range.first) >> sector_shift_;
            sectors |= static_cast<std::uint32_t>(range.clear[bit / 64] >> (bit % 64) & 1) << s;
        }
    }
    return sectors;
}

void RopCache::materialise(std::uint64_t line_address, std::uint32_t sectors) {
    for (; sectors != 0; sectors &= sectors - 1) {
        const std::uint64_t address =
            line_address + (static_cast<std::uint64_t>(std::countr_zero(sectors)) << sector_shift_);
        for (ClearRange& range : ranges_) {
            if (address < range.first || address - range.first >= range.bytes) continue;
            const std::uint64_t bit = (address - range.first) >> sector_shift_;
            range.clear[bit / 64] &= ~(std::uint64_t{1} << (bit % 64));
        }
    }
}

}  // namespace ropsim
