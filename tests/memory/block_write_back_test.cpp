// Compressed blocks between ROP cache and memory, against a memory that really holds what was written: every
// fetch must give the bytes that were last written, and every block must be put together from what is known.
#include "memory/block_write_back.h"

#include "base/random.h"
#include "memory/metadata_cache.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

constexpr std::uint32_t kBlock = 256;
constexpr std::uint32_t kSector = 32;
constexpr std::uint64_t kBlocks = 48;
constexpr std::uint64_t kFirst = 4096;

// What an earlier pass left, or nothing.
struct Pattern : InitialContents {
    bool written = false;
    void fill(int, std::uint64_t offset, std::uint32_t bytes, std::uint8_t* out) const override {
        for (std::uint32_t i = 0; i < bytes; ++i)
            out[i] = written
                         ? static_cast<std::uint8_t>((offset + i) / kBlock % 2 == 0 ? 7 : mix64(offset + i))
                         : 0;
    }
};

BlockFormat rgba8() {
    BlockFormat format;
    format.block_bytes = kBlock;
    format.fields = {{0, 8, 4, FieldKind::kUnorm}};
    format.clear_element.assign(4, 0);
    return format;
}

struct Case {
    const char* name;
    std::uint32_t line_bytes;
    bool sticky;
    bool starts_unwritten;
};

class WriteBack : public testing::TestWithParam<Case> {
 protected:
    WriteBack()
        : cache({24 * GetParam().line_bytes, 6, GetParam().line_bytes, kSector, {}}),
          memory(kBlock, initial),
          codec(CodecKind::kColorDelta, rgba8(), {32, 64, 128}) {
        initial.written = !GetParam().starts_unwritten;
        memory.add(
            {0, kFirst, kBlocks * kBlock, kBlocks * kBlock, kBlocks * kBlock, GetParam().starts_unwritten},
            codec);
        if (GetParam().starts_unwritten) cache.set_clear_range(kFirst, kBlocks * kBlock);
        truth.resize(kBlocks * kBlock);
        initial.fill(0, 0, static_cast<std::uint32_t>(truth.size()), truth.data());
        dram.resize(truth.size());
        size.assign(kBlocks, 0);
        for (std::uint64_t b = 0; b < kBlocks && initial.written; ++b)
            store(b, memory.stored_bytes(0, kFirst + b * kBlock));
    }
    // The block's bytes as they are, compressed to `bytes`, or raw.
    void store(std::uint64_t block, std::uint32_t bytes) {
        size[block] = bytes;
        std::uint8_t* to = &dram[block * kBlock];
        if (bytes == kBlock)
            std::copy_n(&truth[block * kBlock], kBlock, to);
        else
            ASSERT_EQ(codec.compress(&truth[block * kBlock], static_cast<std::uint32_t>(block * kBlock), to),
                      bytes);
    }
    std::array<std::uint8_t, kBlock> read_block(std::uint64_t block) const {
        std::array<std::uint8_t, kBlock> out{};
        codec.decompress(&dram[block * kBlock], size[block], static_cast<std::uint32_t>(block * kBlock),
                         out.data());
        return out;
    }
    // Whether the cache, and the clear states, know all of a sector; a copy in the cache is the truth.
    void write_back(const Eviction& e) {
        if (e.sectors == 0) return;
        const std::uint64_t block = (e.line_address - kFirst) / kBlock;
        std::uint32_t unknown = 0;  // sectors of the block, but for the evicted line's dirty bytes
        for (std::uint32_t s = 0; s < kBlock / kSector; ++s) {
            const std::uint64_t at = kFirst + block * kBlock + s * kSector;
            const std::uint64_t line = at / cache.config().line_bytes * cache.config().line_bytes;
            const std::uint32_t in_line = static_cast<std::uint32_t>(at - line) / kSector;
            const std::uint32_t known =
                line == e.line_address ? e.resident_sectors : cache.known_sectors(line, 0);
            if ((known >> in_line & 1) == 0) unknown |= 1u << s;
        }
        const std::uint32_t before = size[block];
        const BlockWriteBack out = write_back_block(cache, memory, e, GetParam().sticky);
        if (out.repack_bytes != 0) {
            EXPECT_NE(unknown, 0u);
            EXPECT_EQ(out.repack_bytes, before);
        }
        if (out.write_bytes != 0) {
            EXPECT_TRUE(unknown == 0 || out.repack_bytes != 0) << "nobody knows the rest of the block";
            store(block, out.write_bytes);
            written_whole += out.write_bytes == kBlock ? 1 : 0;
            written_compressed += out.write_bytes < kBlock ? 1 : 0;
            return;
        }
        ASSERT_TRUE(before == 0 || before == kBlock) << "sectors written into a compressed block";
        size[block] = kBlock;
        for (std::uint32_t i = 0; i < cache.config().line_bytes; ++i)
            if ((e.bytes.word[i / 64] >> (i % 64) & 1) != 0)
                dram[e.line_address - kFirst + i] = truth[e.line_address - kFirst + i];
        ++written_sectors;
    }
    int present(std::uint64_t line_address) {
        int line = cache.probe(line_address, 0);
        if (line == RopCache::kMiss) {
            Eviction e;
            line = cache.allocate(line_address, 0, &e);
            write_back(e);
        }
        cache.touch(line);
        return line;
    }
    void read(std::uint64_t line_address, std::uint32_t sectors) {
        const int line = present(line_address);
        std::uint32_t missing = cache.request_sectors(line, sectors);
        if (missing == 0) return;
        const std::uint64_t block = (line_address - kFirst) / kBlock;
        const bool compressed = memory.state(0, line_address) == CompressedMemory::State::kCompressed;
        ASSERT_EQ(compressed, size[block] != 0 && size[block] < kBlock);
        if (compressed) missing |= cache.request_rest(line);
        const auto bytes = compressed ? read_block(block) : std::array<std::uint8_t, kBlock>{};
        for (std::uint32_t i = 0; i < cache.config().line_bytes; ++i) {
            const std::uint64_t at = line_address - kFirst + i;
            const bool dirty = (cache.dirty_bytes(line).word[i / 64] >> (i % 64) & 1) != 0;
            if ((missing >> (i / kSector) & 1) == 0 || dirty) continue;
            ASSERT_EQ(compressed ? bytes[at % kBlock] : dram[at], truth[at]) << "byte " << at;
        }
        cache.fill(line, missing);
    }
    void write(std::uint64_t line_address, std::uint32_t first, const std::vector<std::uint8_t>& bytes) {
        const int line = present(line_address);
        const LineMask mask = LineMask::range(first, static_cast<std::uint32_t>(bytes.size()));
        std::array<std::uint8_t, 256> values{};
        std::ranges::copy(bytes, values.begin() + first);
        std::ranges::copy(bytes, truth.begin() + static_cast<std::ptrdiff_t>(line_address - kFirst + first));
        cache.write(line, mask);
        memory.write(0, line_address, mask, values.data());
    }

    Pattern initial;
    RopCache cache;
    CompressedMemory memory;
    BlockCodec codec;
    std::vector<std::uint8_t> truth, dram;
    std::vector<std::uint32_t> size;  // of each block in memory; 0: nothing there
    int written_whole = 0, written_compressed = 0, written_sectors = 0;
};

INSTANTIATE_TEST_SUITE_P(Lines, WriteBack,
                         testing::Values(Case{"64", 64, false, true}, Case{"128", 128, false, true},
                                         Case{"256", 256, false, true}, Case{"128_sticky", 128, true, true},
                                         Case{"128_opaque", 128, false, false},
                                         Case{"256_opaque", 256, false, false}),
                         [](const auto& c) { return std::string("of_") + c.param.name; });

TEST_P(WriteBack, MemoryGivesBackWhatWasWritten) {
    const std::uint32_t line_bytes = GetParam().line_bytes;
    std::uint64_t draw = 0;
    const auto random = [&](std::uint64_t below) { return mix64(++draw) % below; };
    for (int i = 0; i < 40000; ++i) {
        // A line, or a block line after line; flat, smooth or noise, whole lines or some bytes: blocks of
        // every size, coming and going.
        const bool block = random(8) != 0;
        const std::uint64_t unit = block ? kBlock : line_bytes;
        const std::uint64_t begin = kFirst + random(truth.size() / unit) * unit;
        const bool reads = random(2) == 0;
        const auto kind = random(3);
        const std::uint64_t base = random(256);
        for (std::uint64_t line = begin; line < begin + unit; line += line_bytes) {
            if (reads) {
                read(line, 1u << random(line_bytes / kSector));
                continue;
            }
            const auto first = static_cast<std::uint32_t>(random(16) == 0 ? random(line_bytes) : 0);
            const auto count = random(16) == 0 ? 1 + random(line_bytes - first) : line_bytes - first;
            std::vector<std::uint8_t> bytes(count);
            for (std::size_t b = 0; b < bytes.size(); ++b)
                bytes[b] = static_cast<std::uint8_t>(kind == 0   ? base
                                                     : kind == 1 ? base + b / 32
                                                                 : random(256));
            write(line, first, bytes);
        }
        if (HasFatalFailure()) return;
    }
    cache.flush([this](const Eviction& e) { write_back(e); });
    for (std::uint64_t b = 0; b < kBlocks; ++b) {
        if (size[b] == 0) continue;  // still clear
        std::array<std::uint8_t, kBlock> now{};
        memory.read(0, kFirst + b * kBlock, kBlock, now.data());
        EXPECT_EQ(std::memcmp(now.data(), &truth[b * kBlock], kBlock), 0) << "block " << b;
        const auto stored = read_block(b);
        if (size[b] < kBlock) {
            EXPECT_EQ(std::memcmp(stored.data(), &truth[b * kBlock], kBlock), 0) << "block " << b;
        }
    }
    const CompressionCounts& counts = memory.counts(0);
    EXPECT_GT(written_sectors, 100);
    EXPECT_EQ(counts.raw + counts.kept_raw, static_cast<std::uint64_t>(written_sectors + written_whole));
    if (GetParam().sticky) return;  // all become raw and stay so
    EXPECT_GT(written_compressed, 50);
    if (line_bytes == kBlock) return;  // all of a block is here, or none
    EXPECT_GT(counts.repacks, 50u);
    EXPECT_GT(written_whole, 10);
}

TEST(StickyBlock, StaysRawOnceItIs) {
    Pattern initial;
    RopCache cache({2048, 2, 256, kSector, {}});
    CompressedMemory memory(kBlock, initial);
    memory.add({0, 0, kBlock, kBlock, kBlock, true},
               BlockCodec(CodecKind::kColorDelta, rgba8(), {32, 64, 128}));
    cache.set_clear_range(0, kBlock);
    Eviction e;
    const int line = cache.allocate(0, 0, &e);
    std::array<std::uint8_t, kBlock> values{};
    const auto write = [&](bool noise) {
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] = noise ? static_cast<std::uint8_t>(mix64(i)) : 5;
        cache.write(line, 0, kBlock);
        memory.write(0, 0, LineMask::range(0, kBlock), values.data());
        return write_back_block(cache, memory, cache.clean(line), true);
    };
    EXPECT_EQ(write(false).write_bytes, 32u);
    EXPECT_EQ(write(true).write_bytes, kBlock);
    EXPECT_EQ(write(false).write_bytes, 0u);
    EXPECT_EQ(memory.state(0, 0), CompressedMemory::State::kRaw);
}

// Of a tile of 64 bytes in a block of 256 the rest is padding: nobody has to read it to know it.
TEST(Padding, IsKnownWithoutARead) {
    for (const std::uint64_t used : {std::uint64_t{64}, std::uint64_t{kBlock}}) {
        Pattern initial;
        RopCache cache({2048, 2, 64, kSector, {}});
        CompressedMemory memory(kBlock, initial);
        memory.add({0, 0, 4 * kBlock, kBlock, used, false},
                   BlockCodec(CodecKind::kColorDelta, rgba8(), {32, 64, 128}));
        ASSERT_EQ(memory.stored_bytes(0, kBlock), 32u);
        EXPECT_EQ(memory.padding(0, kBlock, 64, kSector), 0u);
        EXPECT_EQ(memory.padding(0, kBlock + 64, 64, kSector), used == 64 ? 3u : 0u);
        Eviction e;
        const int line = cache.allocate(kBlock, 0, &e);
        std::array<std::uint8_t, kBlock> values{};
        values.fill(9);
        cache.write(line, 0, 64);
        memory.write(0, kBlock, LineMask::range(0, 64), values.data());
        const BlockWriteBack out = write_back_block(cache, memory, cache.clean(line), false);
        EXPECT_EQ(out.repack_bytes, used == 64 ? 0u : 32u);
        EXPECT_LT(out.write_bytes, kBlock);
        EXPECT_GT(out.write_bytes, 0u);
    }
}

// The states of 64 blocks of 256 bytes lie in a sector: a fetch for each 16 KiB of memory, once.
TEST(Metadata, OneFetchASectorAndOneWriteBack) {
    MetadataCache metadata({1024, 4, 4}, 1 << 20, kBlock);
    std::uint64_t read = 0, written = 0;
    const auto count = [&](const MetadataCache::Traffic& t) {
        read += t.read_bytes, written += t.write_bytes;
    };
    for (std::uint64_t at = 0; at < 64 * 1024; at += kBlock) count(metadata.look_up(at, at % 1024 == 0));
    EXPECT_EQ(read, 4u * 32);
    EXPECT_EQ(written, 0u);
    while (metadata.dirty()) count(metadata.write_back());
    EXPECT_EQ(written, 4u * 32);
}

TEST(Metadata, ClearedStatesNeedNoFetch) {
    MetadataCache metadata({256, 4, 4}, 1 << 20, kBlock);
    metadata.set_clear(0, 1 << 20);
    std::uint64_t read = 0, written = 0;
    const auto count = [&](const MetadataCache::Traffic& t) {
        read += t.read_bytes, written += t.write_bytes;
    };
    for (std::uint64_t at = 0; at < 1 << 20; at += kBlock) count(metadata.look_up(at, true));
    while (metadata.dirty()) count(metadata.write_back());
    EXPECT_EQ(read, 0u);
    EXPECT_EQ(written, (1u << 20) / kBlock / 2);
    // What was evicted has a state in memory now.
    EXPECT_EQ(metadata.look_up(0, false).read_bytes, 32u);
}

}  // namespace
}  // namespace ropsim
