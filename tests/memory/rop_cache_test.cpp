// The ROP cache against a brute-force model that keeps every byte's state in maps.
#include "memory/rop_cache.h"

#include "base/error.h"
#include "base/random.h"

#include <list>
#include <map>
#include <ostream>
#include <set>

#include <gtest/gtest.h>

namespace ropsim {

void PrintTo(const RopCacheConfig& config, std::ostream* out) {
    *out << config.size_bytes;
}

namespace {

TEST(RopCache, RefusesSizesThatDoNotFit) {
    EXPECT_THROW(RopCache({16384, 4, 96, 32}), UserError);
    EXPECT_THROW(RopCache({16384, 4, 128, 256}), UserError);
    EXPECT_THROW(RopCache({16000, 4, 128, 32}), UserError);
    EXPECT_NO_THROW(RopCache({12288, 3, 128, 32}));
}

TEST(RopCache, MasksAndSectors) {
    const RopCache cache({});
    for (std::uint32_t first = 0; first < 256; ++first)
        for (std::uint32_t count = 0; first + count <= 256; ++count) {
            const LineMask mask = LineMask::range(first, count);
            ASSERT_EQ(mask.count(), count);
            for (std::uint32_t i = 0; i < 256; i += 13)
                ASSERT_EQ((mask.word[i / 64] >> (i % 64) & 1) != 0, i >= first && i < first + count);
        }
    EXPECT_EQ(cache.sectors_of(0, 1), 1u);
    EXPECT_EQ(cache.sectors_of(31, 2), 3u);
    EXPECT_EQ(cache.sectors_of(0, 128), 15u);
    EXPECT_EQ(cache.sectors_of(96, 32), 8u);
    EXPECT_EQ(cache.sectors_of(5, 0), 0u);
}

TEST(RopCache, FullWritesNeedNoFetchPartialOnesKeepMasks) {
    RopCache cache({});
    Eviction out;
    const int line = cache.allocate(0x1000, 3, &out);
    cache.write(line, 0, 32);
    cache.write(line, 40, 8);
    EXPECT_EQ(cache.valid_sectors(line), 1u);
    EXPECT_EQ(cache.request_sectors(line, 3), 2u);  // the second is only partly here
    EXPECT_EQ(cache.request_sectors(line, 3), 0u);  // on its way
    EXPECT_EQ(cache.pending_sectors(line, 3), 2u);
    cache.fill(line, 2);
    EXPECT_EQ(cache.valid_sectors(line), 3u);
    const Eviction written = cache.clean(line);
    EXPECT_EQ(written.line_address, 0x1000u);
    EXPECT_EQ(written.surface, 3);
    EXPECT_EQ(written.sectors, 3u);
    EXPECT_EQ(written.dirty_bytes, 40u);
    EXPECT_EQ(cache.clean(line).sectors, 0u);
    EXPECT_EQ(cache.statistics().sector_hits, 2u);
    EXPECT_EQ(cache.statistics().sector_misses, 1u);
    EXPECT_EQ(cache.statistics().sector_merges, 1u);
}

TEST(RopCache, PinnedAndFillingLinesStay) {
    RopCache cache({4 * 128, 4, 128, 32});
    Eviction out;
    for (std::uint64_t i = 0; i < 4; ++i) ASSERT_EQ(cache.allocate(i * 128, 0, &out), static_cast<int>(i));
    cache.pin(0);
    cache.pin(0);
    cache.unpin(0);
    cache.request_sectors(1, 1);
    cache.pin(2);
    cache.pin(3);
    EXPECT_EQ(cache.allocate(0x1000, 0, &out), RopCache::kMiss);
    cache.unpin(2);
    EXPECT_EQ(cache.allocate(0x1000, 0, &out), 2);
    EXPECT_EQ(cache.allocate(0x2000, 0, &out), 2);
    cache.fill(1, 1);
    cache.unpin(0);
    EXPECT_EQ(cache.allocate(0x3000, 0, &out), 0);  // least recently used
    EXPECT_EQ(cache.allocate(0x4000, 0, &out), 1);
}

TEST(RopCache, ClearSectorsNeedNoFetchUntilWrittenBack) {
    RopCache cache({2 * 128, 1, 128, 32});
    cache.set_clear_range(0, 4096);
    Eviction out;
    int line = cache.allocate(256, 0, &out);
    EXPECT_EQ(cache.request_sectors(line, 0xf), 0u);
    EXPECT_EQ(cache.statistics().fills_avoided, 4u);
    cache.write(line, 4, 4);
    EXPECT_TRUE(cache.is_clear(256));
    line = cache.allocate(0, 0, &out);  // same set
    EXPECT_EQ(out.sectors, 1u);
    EXPECT_EQ(out.dirty_bytes, 32u);  // memory has nothing below
    EXPECT_FALSE(cache.is_clear(256));
    EXPECT_TRUE(cache.is_clear(256 + 32));
    line = cache.allocate(256, 0, &out);
    EXPECT_EQ(out.sectors, 0u);
    EXPECT_EQ(cache.request_sectors(line, 0xf), 1u);
    cache.fill(line, 1);
    cache.set_clear_range(0, 4096);
    EXPECT_TRUE(cache.is_clear(256));
    EXPECT_FALSE(cache.is_clear(4096));
}

// Bytes as maps; LRU as lists; memory as the set of bytes ever written back.
class ReferenceCache {
 public:
    ReferenceCache(const RopCacheConfig& config, std::uint64_t clear_bytes)
        : c_(config), clear_bytes_(clear_bytes) {}

    struct Line {
        std::set<std::uint32_t> valid_sectors;
        std::set<std::uint32_t> dirty;
    };
    std::uint64_t fetched_sectors = 0, avoided = 0, written_bytes = 0, written_sectors = 0;

    void access(std::uint64_t address, std::uint32_t bytes, bool read, bool write) {
        const std::uint64_t base = address / c_.line_bytes * c_.line_bytes;
        Line& line = get(base);
        const auto offset = static_cast<std::uint32_t>(address - base);
        for (std::uint32_t b = offset; read && b < offset + bytes; ++b) {
            const std::uint32_t s = b / c_.sector_bytes;
            if (!line.valid_sectors.insert(s).second) continue;
            ++(clear(base, s) ? avoided : fetched_sectors);
        }
        if (!write) return;
        for (std::uint32_t b = offset; b < offset + bytes; ++b) {
            line.dirty.insert(b);
            const std::uint32_t s = b / c_.sector_bytes;
            if (clear(base, s)) line.valid_sectors.insert(s);
        }
        for (std::uint32_t s = 0; s < c_.line_bytes / c_.sector_bytes; ++s) {
            bool all = true;
            for (std::uint32_t b = 0; b < c_.sector_bytes; ++b)
                all &= line.dirty.count(s * c_.sector_bytes + b) != 0;
            if (all) line.valid_sectors.insert(s);
        }
    }
    void flush() {
        for (auto& [set, order] : order_)
            for (const std::uint64_t base : order) write_back(base);
    }

 private:
    bool clear(std::uint64_t base, std::uint32_t sector) const {
        const std::uint64_t a = base + sector * c_.sector_bytes;
        return a + c_.sector_bytes <= clear_bytes_ && materialised_.count(a) == 0;
    }
    Line& get(std::uint64_t base) {
        std::list<std::uint64_t>& order =
            order_[base / c_.line_bytes % (c_.size_bytes / c_.line_bytes / c_.ways)];
        order.remove(base);
        order.push_front(base);
        if (order.size() > c_.ways) {
            write_back(order.back());
            lines_.erase(order.back());
            order.pop_back();
        }
        return lines_[base];
    }
    void write_back(std::uint64_t base) {
        std::set<std::uint32_t> sectors;
        for (const std::uint32_t b : lines_[base].dirty) sectors.insert(b / c_.sector_bytes);
        for (const std::uint32_t s : sectors) {
            std::uint64_t bytes = 0;
            for (std::uint32_t b = 0; b < c_.sector_bytes; ++b)
                bytes += lines_[base].dirty.count(s * c_.sector_bytes + b);
            written_bytes += clear(base, s) ? c_.sector_bytes : bytes;
            if (base + s * c_.sector_bytes < clear_bytes_) materialised_.insert(base + s * c_.sector_bytes);
        }
        written_sectors += sectors.size();
        lines_[base].dirty.clear();
    }
    RopCacheConfig c_;
    std::uint64_t clear_bytes_;
    std::map<std::uint64_t, Line> lines_;
    std::map<std::uint64_t, std::list<std::uint64_t>> order_;
    std::set<std::uint64_t> materialised_;
};

class RopCacheRandom : public testing::TestWithParam<RopCacheConfig> {};
INSTANTIATE_TEST_SUITE_P(Shapes, RopCacheRandom,
                         testing::Values(RopCacheConfig{2048, 4, 128, 32}, RopCacheConfig{1536, 3, 64, 8},
                                         RopCacheConfig{4096, 2, 256, 64}, RopCacheConfig{1024, 1, 128, 128},
                                         RopCacheConfig{1024, 4, 256, 256}),
                         [](const auto& shape) {
                             return fmt::format("{}x{}x{}x{}", shape.param.size_bytes, shape.param.ways,
                                                shape.param.line_bytes, shape.param.sector_bytes);
                         });

TEST_P(RopCacheRandom, AgreesWithAMapOfBytes) {
    const RopCacheConfig config = GetParam();
    const std::uint64_t clear_bytes = 8192;
    RopCache cache(config);
    cache.set_clear_range(0, clear_bytes);
    ReferenceCache reference(config, clear_bytes);
    std::uint64_t fetched = 0, written_bytes = 0, written_sectors = 0;
    const auto count = [&](const Eviction& out) {
        written_bytes += out.dirty_bytes;
        written_sectors += static_cast<std::uint64_t>(std::popcount(out.sectors));
        EXPECT_EQ(out.bytes.count(), out.dirty_bytes);
    };
    for (std::uint32_t i = 0; i < 30000; ++i) {
        const std::uint64_t r = mix64(i);
        const std::uint64_t base = (r & 127) * config.line_bytes;
        const auto offset = static_cast<std::uint32_t>((r >> 16) % config.line_bytes);
        auto bytes = static_cast<std::uint32_t>(1 + (r >> 32) % (config.line_bytes - offset));
        if ((r >> 50 & 1) != 0) bytes = std::min(bytes, 8u);
        const bool write = (r >> 51 & 1) != 0, read = !write || (r >> 52 & 1) != 0;
        int line = cache.probe(base, 1);
        if (line == RopCache::kMiss) {
            Eviction out;
            line = cache.allocate(base, 1, &out);
            ASSERT_NE(line, RopCache::kMiss);
            count(out);
        }
        cache.touch(line);
        if (read) {
            const std::uint32_t sectors = cache.request_sectors(line, cache.sectors_of(offset, bytes));
            fetched += static_cast<std::uint64_t>(std::popcount(sectors));
            cache.fill(line, sectors);
        }
        if (write) cache.write(line, offset, bytes);
        reference.access(base + offset, bytes, read, write);
        ASSERT_EQ(fetched, reference.fetched_sectors) << i;
        ASSERT_EQ(written_bytes, reference.written_bytes) << i;
        ASSERT_EQ(written_sectors, reference.written_sectors) << i;
        ASSERT_EQ(cache.statistics().fills_avoided, reference.avoided) << i;
    }
    cache.flush(count);
    reference.flush();
    EXPECT_EQ(written_bytes, reference.written_bytes);
    EXPECT_EQ(written_sectors, reference.written_sectors);
    EXPECT_EQ(cache.next_dirty(0), RopCache::kMiss);
    EXPECT_EQ(cache.statistics().bytes_written_back, written_bytes);
    cache.invalidate();
    EXPECT_EQ(cache.probe(0, 1), RopCache::kMiss);
}

}  // namespace
}  // namespace ropsim
