#include "memory/compressed_memory.h"

#include "base/error.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

namespace ropsim {

namespace {
constexpr std::uint32_t kLargestBlock = 256;
}

void CompressionCounts::add(const CompressionCounts& other) {
    by_level.resize(std::max(by_level.size(), other.by_level.size()));
    for (std::size_t l = 0; l < other.by_level.size(); ++l) by_level[l] += other.by_level[l];
    raw += other.raw;
    kept_raw += other.kept_raw;
    repacks += other.repacks;
    block_bytes += other.block_bytes;
    stored_bytes += other.stored_bytes;
}

CompressedMemory::CompressedMemory(std::uint32_t block_bytes, const InitialContents& initial)
    : block_bytes_(block_bytes), initial_(initial) {
    CHECK(std::has_single_bit(block_bytes) && block_bytes <= kLargestBlock, "{} bytes", block_bytes);
}

void CompressedMemory::add(const SurfaceBlocks& blocks, BlockCodec codec) {
    CHECK(blocks.first % block_bytes_ == 0 && blocks.tile_bytes % block_bytes_ == 0 && blocks.tile_bytes != 0,
          "surface {} at {:#x}", blocks.surface, blocks.first);
    const auto place = static_cast<std::size_t>(blocks.surface);
    if (surfaces_.size() <= place) surfaces_.resize(place + 1);
    const auto count = static_cast<std::size_t>((blocks.bytes + block_bytes_ - 1) / block_bytes_);
    Stored stored{blocks, std::move(codec), {}, {}, {}};
    stored.state.assign(count, kUnknown);
    stored.pages.resize((count + kPageBlocks - 1) / kPageBlocks);
    stored.counts.by_level.resize(stored.codec.levels().size());
    surfaces_[place].emplace(std::move(stored));
}

std::size_t CompressedMemory::number(const Stored& stored, std::uint64_t address) const {
    CHECK(address >= stored.place.first && address - stored.place.first < stored.state.size() * block_bytes_,
          "{:#x} of surface {}", address, stored.place.surface);
    return static_cast<std::size_t>((address - stored.place.first) / block_bytes_);
}

std::uint8_t* CompressedMemory::bytes_of(Stored& stored, std::size_t block) {
    auto& page = stored.pages[block / kPageBlocks];
    if (page == nullptr) {
        page = std::make_unique_for_overwrite<std::uint8_t[]>(std::size_t{kPageBlocks} * block_bytes_);
        const std::size_t first = block / kPageBlocks * kPageBlocks;
        const std::size_t count = std::min<std::size_t>(kPageBlocks, stored.state.size() - first);
        for (std::size_t b = 0; b < count; ++b)
            initial_.fill(stored.place.surface, (first + b) * block_bytes_, block_bytes_,
                          page.get() + b * block_bytes_);
    }
    return page.get() + block % kPageBlocks * block_bytes_;
}

// A block that another pass left here was stored as it compressed.
std::uint8_t& CompressedMemory::state_of(Stored& stored, std::size_t block) {
    std::uint8_t& state = stored.state[block];
    if (state == kUnknown)
        state = stored.place.starts_unwritten ? kUnwrittenState
                                              : packed_state(stored, block, bytes_of(stored, block));
    return state;
}

std::uint8_t CompressedMemory::packed_state(const Stored& stored, std::size_t block,
                                            const std::uint8_t* bytes) const {
    std::array<std::uint8_t, kLargestBlock> packed{};
    const auto offset = static_cast<std::uint32_t>(block * block_bytes_ % stored.place.tile_bytes);
    const std::uint32_t size = stored.codec.compress(bytes, offset, packed.data());
    if (size == block_bytes_) return kRawState;
    std::array<std::uint8_t, kLargestBlock> unpacked{};
    stored.codec.decompress(packed.data(), size, offset, unpacked.data());
    CHECK(std::memcmp(unpacked.data(), bytes, block_bytes_) == 0,
          "block {} of surface {} does not decompress", block, stored.place.surface);
    const auto& levels = stored.codec.levels();
    const auto level = std::ranges::find(levels, size) - levels.begin();
    return static_cast<std::uint8_t>(kFirstLevel + level);
}

std::uint32_t CompressedMemory::padding(int surface, std::uint64_t line_address, std::uint32_t line_bytes,
                                        std::uint32_t sector_bytes) const {
    const SurfaceBlocks& place = surfaces_[static_cast<std::size_t>(surface)]->place;
    const std::uint64_t in_tile = (line_address - place.first) % place.tile_bytes;
    if (in_tile + line_bytes <= place.used_bytes) return 0;
    std::uint32_t sectors = 0;
    for (std::uint32_t s = 0; s < line_bytes / sector_bytes; ++s)
        if (in_tile + std::uint64_t{s} * sector_bytes >= place.used_bytes) sectors |= 1u << s;
    return sectors;
}

void CompressedMemory::write(int surface, std::uint64_t line_address, const LineMask& bytes,
                             const std::uint8_t* values) {
    Stored& stored = at(surface);
    state_of(stored, number(stored, line_address));  // what was here before decides how it is stored
    std::uint8_t* to = bytes_of(stored, number(stored, line_address)) + line_address % block_bytes_;
    for (std::size_t w = 0; w < bytes.word.size(); ++w) {
        for (std::uint64_t mask = bytes.word[w]; mask != 0;) {
            const auto first = static_cast<unsigned>(std::countr_zero(mask));
            const auto length = static_cast<unsigned>(std::countr_one(mask >> first));
            std::memcpy(to + 64 * w + first, values + 64 * w + first, length);
            mask = first + length >= 64 ? 0 : mask >> (first + length) << (first + length);
        }
    }
}

void CompressedMemory::read(int surface, std::uint64_t address, std::uint32_t bytes, std::uint8_t* out) {
    Stored& stored = at(surface);
    for (std::uint32_t done = 0; done < bytes;) {
        const std::uint64_t from = address + done;
        const auto here =
            std::min(bytes - done, static_cast<std::uint32_t>(block_bytes_ - from % block_bytes_));
        std::memcpy(out + done, bytes_of(stored, number(stored, from)) + from % block_bytes_, here);
        done += here;
    }
}

CompressedMemory::State CompressedMemory::state(int surface, std::uint64_t address) {
    Stored& stored = at(surface);
    const std::uint8_t state = state_of(stored, number(stored, address));
    if (state >= kFirstLevel) return State::kCompressed;
    return state == kRawState ? State::kRaw : State::kUnwritten;
}

std::uint32_t CompressedMemory::stored_bytes(int surface, std::uint64_t address) {
    Stored& stored = at(surface);
    const std::uint8_t state = state_of(stored, number(stored, address));
    return state >= kFirstLevel ? stored.codec.levels()[static_cast<std::size_t>(state - kFirstLevel)]
                                : block_bytes_;
}

std::uint32_t CompressedMemory::pack(int surface, std::uint64_t address) {
    Stored& stored = at(surface);
    const std::size_t block = number(stored, address);
    std::uint8_t& state = state_of(stored, block);
    state = packed_state(stored, block, bytes_of(stored, block));
    CompressionCounts& counts = stored.counts;
    const std::uint32_t size = stored_bytes(surface, address);
    ++(state == kRawState ? counts.raw : counts.by_level[static_cast<std::size_t>(state - kFirstLevel)]);
    counts.block_bytes += block_bytes_;
    counts.stored_bytes += size;
    return size;
}

void CompressedMemory::keep_raw(int surface, std::uint64_t address) {
    Stored& stored = at(surface);
    state_of(stored, number(stored, address)) = kRawState;
    ++stored.counts.kept_raw;
}

}  // namespace ropsim
