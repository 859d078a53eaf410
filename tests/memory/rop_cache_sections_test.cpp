// Sections of a ROP cache are caches of their own; writes allocate without a fetch and merge with one.
#include "base/error.h"
#include "base/random.h"
#include "memory/rop_cache.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

constexpr std::uint32_t kWays = 2, kLine = 128, kSector = 32;

RopCacheConfig split(std::uint32_t first, std::uint32_t second, std::uint32_t third) {
    return {first + second + third, kWays, kLine, kSector, {first, second, third}};
}

// One access; what it fetched and wrote back.
struct Moved {
    std::uint64_t fetched = 0;  // sectors
    std::uint64_t written = 0;  // bytes
};
Moved access(RopCache& cache, std::uint64_t address, std::uint8_t surface, bool write) {
    Moved moved;
    const std::uint64_t base = address / kLine * kLine;
    int line = cache.probe(base, surface);
    if (line == RopCache::kMiss) {
        Eviction out;
        line = cache.allocate(base, surface, &out);
        moved.written += out.dirty_bytes;
    }
    cache.touch(line);
    const auto offset = static_cast<std::uint32_t>(address - base);
    if (write) {
        cache.write(line, offset, 4);
        return moved;
    }
    const std::uint32_t fetch = cache.request_sectors(line, cache.sectors_of(offset, 4));
    moved.fetched = static_cast<std::uint64_t>(std::popcount(fetch));
    cache.fill(line, fetch);
    return moved;
}

TEST(RopCacheSections, BehaveLikeSeparateCaches) {
    // Sets of a section: a power of two, one that is not, and one.
    const std::array<std::uint32_t, 3> bytes = {4 * kWays * kLine, 3 * kWays * kLine, kWays * kLine};
    RopCache whole(split(bytes[0], bytes[1], bytes[2]));
    std::vector<RopCache> apart;
    for (std::uint8_t s = 0; s < 3; ++s) {
        whole.set_section(s, s);
        apart.emplace_back(RopCacheConfig{bytes[s], kWays, kLine, kSector, {}});
    }
    for (std::uint32_t i = 0; i < 20000; ++i) {
        const std::uint64_t r = mix64(i);
        const auto surface = static_cast<std::uint8_t>(r % 3);
        const std::uint64_t address = surface * 65536 + ((r >> 8) % 24) * kLine + ((r >> 20) % 32) * 4;
        const bool write = (r >> 40 & 1) != 0;
        const Moved one = access(whole, address, surface, write);
        const Moved other = access(apart[surface], address, 0, write);
        ASSERT_EQ(one.fetched, other.fetched) << i;
        ASSERT_EQ(one.written, other.written) << i;
    }
    std::uint64_t flushed = 0, flushed_apart = 0;
    whole.flush([&](const Eviction& e) { flushed += e.dirty_bytes; });
    for (RopCache& cache : apart) cache.flush([&](const Eviction& e) { flushed_apart += e.dirty_bytes; });
    EXPECT_EQ(flushed, flushed_apart);
    EXPECT_GT(flushed, 0u);
}

TEST(RopCacheSections, MustMakeTheWhole) {
    RopCacheConfig c = split(1024, 1024, 0);
    EXPECT_NO_THROW(RopCache{c});
    c.size_bytes = 4096;
    EXPECT_THROW(RopCache{c}, UserError);
    EXPECT_THROW(RopCache{split(0, 1024, 1024)}, UserError);
    EXPECT_THROW(RopCache{split(1024 + 128, 1024 - 128, 0)}, UserError);
}

// No byte of the sector is asked for until somebody reads it; then what was written stays above what comes.
TEST(RopCacheWrites, PartOfASectorIsFetchedOnlyWhenRead) {
    RopCache cache({kWays * kLine, kWays, kLine, kSector, {}});
    Eviction out;
    const int line = cache.allocate(0, 7, &out);
    cache.write(line, 4, 8);
    cache.write(line, 32, 32);
    EXPECT_EQ(cache.statistics().sector_misses, 0u);
    EXPECT_EQ(cache.valid_sectors(line), 2u);
    EXPECT_EQ(cache.request_sectors(line, 1u << 1), 0u);  // written whole: nothing to fetch
    EXPECT_EQ(cache.request_sectors(line, 1u << 0), 1u);
    cache.write(line, 12, 4);  // while the fill is under way
    cache.fill(line, 1u);
    EXPECT_EQ(cache.valid_sectors(line), 3u);
    EXPECT_EQ(cache.dirty_bytes(line).count(), 8u + 4u + 32u);
    // Evicted by two others of the set: exactly the bytes written, by surface.
    cache.allocate(kLine, 1, &out);
    cache.touch(cache.probe(kLine, 1));
    cache.allocate(2 * kLine, 1, &out);
    EXPECT_EQ(out.surface, 7);
    EXPECT_EQ(out.sectors, 3u);
    LineMask expected = LineMask::range(4, 12);
    const LineMask second = LineMask::range(32, 32);
    for (std::size_t w = 0; w < 4; ++w) expected.word[w] |= second.word[w];
    EXPECT_EQ(out.bytes, expected);
}

TEST(RopCacheWrites, UnreadPartialSectorsLeaveWithTheirMaskAtTheFlush) {
    RopCache cache({4 * kLine, 4, kLine, kSector, {}});
    Eviction out;
    for (std::uint64_t l = 0; l < 3; ++l) {
        const int line = cache.allocate(l * kLine, 0, &out);
        if (l != 1) cache.write(line, static_cast<std::uint32_t>(l) + 30, 5);
    }
    std::vector<Eviction> flushed;
    cache.flush([&](const Eviction& e) { flushed.push_back(e); });
    ASSERT_EQ(flushed.size(), 2u);
    EXPECT_EQ(flushed[0].bytes, LineMask::range(30, 5));
    EXPECT_EQ(flushed[1].bytes, LineMask::range(32, 5));
    EXPECT_EQ(cache.statistics().sector_misses, 0u);
    cache.flush([](const Eviction&) { ADD_FAILURE() << "flushed twice"; });
}

TEST(LineMasks, PartsAndRaises) {
    LineMask all;
    for (std::uint32_t w = 0; w < 4; ++w) all.word[w] = mix64(w);
    const auto bit = [](const LineMask& m, std::uint32_t b) { return (m.word[b / 64] >> (b % 64) & 1) != 0; };
    for (std::uint32_t first = 0; first < 256; first += 7) {
        const LineMask part = all.part(first, 50);
        const LineMask raised = all.raised(first);
        for (std::uint32_t b = 0; b < 256; ++b) {
            ASSERT_EQ(bit(part, b), b < 50 && first + b < 256 && bit(all, first + b)) << first << " " << b;
            ASSERT_EQ(bit(raised, b), b >= first && bit(all, b - first)) << first << " " << b;
        }
    }
}

}  // namespace
}  // namespace ropsim
