// Per sector and byte, the smallest cache that still holds it.
#include "memory/lru_traffic.h"

#include "base/error.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <utility>

namespace ropsim {

LruTraffic::LruTraffic(std::uint32_t line_bytes, std::uint32_t sector_bytes,
                       std::vector<std::uint32_t> capacities, int surfaces)
    : line_bytes_(line_bytes),
      sector_bytes_(sector_bytes),
      sectors_(line_bytes / sector_bytes),
      stack_(std::move(capacities)) {
    const Histogram empty(stack_.capacities().size() + 2);
    fills_.assign(static_cast<std::size_t>(surfaces), empty);
    writes_ = fills_;
    line_uses_ = empty;
}

void LruTraffic::set_clear_range(std::uint64_t first, std::uint64_t bytes) {
    CHECK(uses_ == 0);
    clear_ranges_.push_back({first, bytes});
}

void LruTraffic::count(Histogram& histogram, std::uint8_t level) const {
    ++histogram[level == kNever ? histogram.size() - 1 : level];
}

// Lines that are used get numbers without gaps, so that memory goes with them and not with the address space.
std::uint32_t LruTraffic::number_of(std::uint64_t line_address) {
    const std::uint64_t line = line_address / line_bytes_;
    if (line >= dense_.size()) dense_.resize(line + line / 2 + 1, kNoNumber);
    if (dense_[line] != kNoNumber) return dense_[line];
    dense_[line] = stack_.lines();
    for (std::uint32_t s = 0; s < sectors_; ++s) {
        const std::uint64_t first = line_address + std::uint64_t{s} * sector_bytes_;
        const bool clear = std::any_of(clear_ranges_.begin(), clear_ranges_.end(), [&](const ClearRange& r) {
            return first >= r.first && first + sector_bytes_ <= r.first + r.bytes;
        });
        sector_.push_back({kNever, kNever, clear ? std::uint8_t{0} : kNever});
    }
    byte_written_.resize(byte_written_.size() + line_bytes_, kNever);
    return dense_[line];
}

// The line was gone from every cache below `level`.
void LruTraffic::age(std::uint32_t line, std::uint8_t level) {
    for (std::uint32_t s = 0; s < sectors_; ++s) {
        Sector& sector = sector_[std::size_t{line} * sectors_ + s];
        sector.read = std::max(sector.read, level);
        if (sector.dirty == kNever) continue;  // a clear sector stays clear in memory until it is written
        sector.dirty = std::max(sector.dirty, level);
        sector.clear = std::max(sector.clear, level);
    }
    constexpr std::uint32_t kBlock = 64;  // lines are whole blocks
    std::uint8_t* bytes = &byte_written_[std::size_t{line} * line_bytes_];
    for (std::uint32_t block = 0; block < line_bytes_; block += kBlock)
        for (std::uint32_t b = 0; b < kBlock; ++b) bytes[block + b] = std::max(bytes[block + b], level);
}

std::uint8_t LruTraffic::written_level(std::uint32_t line, std::uint32_t sector) const {
    const auto first =
        byte_written_.begin() +
        static_cast<std::ptrdiff_t>(std::size_t{line} * line_bytes_ + std::size_t{sector} * sector_bytes_);
    return *std::max_element(first, first + sector_bytes_);
}

void LruTraffic::use(std::uint64_t line_address, std::uint32_t read_sectors, const LineMask& write_bytes,
                     std::uint8_t surface) {
    ++uses_;
    const std::uint32_t line = number_of(line_address);
    const bool is_new = line == stack_.lines();
    const auto level = static_cast<std::uint8_t>(stack_.use(line));
    count(line_uses_, is_new ? kNever : level);
    if (level > 0 && !is_new) age(line, level);
    Sector* const sectors = &sector_[std::size_t{line} * sectors_];
    for (std::uint32_t left = read_sectors; left != 0; left &= left - 1) {
        const auto s = static_cast<std::uint32_t>(std::countr_zero(left));
        // Here because it was fetched, or cleared on chip, or because every byte of it was written.
        std::uint8_t kept = std::min(sectors[s].read, sectors[s].clear);
        if (kept != 0) kept = std::min(kept, written_level(line, s));
        count(fills_[surface], kept);
        sectors[s].read = 0;
    }
    if (!write_bytes.any()) return;
    std::uint8_t* const bytes = &byte_written_[std::size_t{line} * line_bytes_];
    std::uint32_t touched = 0;
    for (std::uint32_t w = 0; w < line_bytes_ / 64; ++w) {
        for (std::uint64_t left = write_bytes.word[w]; left != 0; left &= left - 1) {
            const std::uint32_t byte = w * 64 + static_cast<std::uint32_t>(std::countr_zero(left));
            bytes[byte] = 0;
            touched |= 1u << (byte / sector_bytes_);
        }
    }
    for (; touched != 0; touched &= touched - 1) {
        Sector& sector = sectors[std::countr_zero(touched)];
        count(writes_[surface], sector.dirty);
        sector.dirty = 0;
    }
}

namespace {
std::uint64_t above(const std::vector<std::uint64_t>& histogram, std::size_t level) {
    return std::accumulate(histogram.begin() + static_cast<std::ptrdiff_t>(level) + 1, histogram.end(),
                           std::uint64_t{0});
}
}  // namespace

std::uint64_t LruTraffic::fills(int surface, std::size_t level) const {
    return above(fills_[static_cast<std::size_t>(surface)], level);
}

std::uint64_t LruTraffic::write_backs(int surface, std::size_t level) const {
    return above(writes_[static_cast<std::size_t>(surface)], level);
}

double LruTraffic::line_hit_share(std::size_t level) const {
    if (uses_ == 0) return 0;
    return 1 - static_cast<double>(above(line_uses_, level)) / static_cast<double>(uses_);
}

}  // namespace ropsim
