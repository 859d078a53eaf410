// Stack distances against a list searched from its front, and traffic of all sizes against a ROP cache of one
// set for each of them.
#include "memory/lru_traffic.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

std::vector<std::uint32_t> counted_up_to(std::uint32_t last) {
    std::vector<std::uint32_t> capacities(last);
    for (std::uint32_t c = 0; c < last; ++c) capacities[c] = c + 1;
    return capacities;
}

// Mostly recent lines, so that every distance occurs.
std::vector<std::uint32_t> stream(std::uint32_t lines, std::size_t length, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<std::uint32_t> uses;
    while (uses.size() < length) {
        const std::size_t back = 1 + random() % 40;
        uses.push_back(random() % 4 != 0 && back <= uses.size() ? uses[uses.size() - back]
                                                                : random() % lines);
    }
    return uses;
}

TEST(LruStack, DistancesAreThoseOfAList) {
    for (const std::uint32_t lines : {1u, 2u, 7u, 100u, 400u}) {
        LruStack every(counted_up_to(150));
        LruStack coarse({3, 4, 10, 64, 399, 400});
        std::vector<std::uint32_t> list;  // most recent first
        for (const std::uint32_t line : stream(lines, 5000, lines)) {
            const auto found = std::find(list.begin(), list.end(), line);
            const auto distance = static_cast<std::uint32_t>(found - list.begin()) + 1;  // if it is there
            const bool is_new = found == list.end();
            ASSERT_EQ(every.use(line), is_new ? 150 : static_cast<int>(std::min(distance - 1, 150u)));
            int level = 0;
            while (level < 6 && (is_new || coarse.capacities()[static_cast<std::size_t>(level)] < distance))
                ++level;
            ASSERT_EQ(coarse.use(line), level) << "distance " << distance;
            if (!is_new) list.erase(found);
            list.insert(list.begin(), line);
        }
        EXPECT_EQ(every.lines(), list.size());
    }
}

struct Use {
    std::uint64_t line_address;
    std::uint32_t read_sectors;
    LineMask write_bytes;
    std::uint8_t surface;
};

struct Shape {
    std::uint32_t line_bytes, sector_bytes;
};

// Two surfaces, the second of which starts cleared. Writes of whole and half sectors.
std::vector<Use> uses_of(const Shape& shape, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<Use> uses;
    for (const std::uint32_t line : stream(90, 20000, seed)) {
        Use use{std::uint64_t{line} * shape.line_bytes, 0, {}, static_cast<std::uint8_t>(line >= 40)};
        const std::uint32_t sectors = shape.line_bytes / shape.sector_bytes;
        if (random() % 3 != 0) use.read_sectors = random() & (~0u >> (32 - sectors));
        if (random() % 3 != 0) {
            const std::uint32_t unit = shape.sector_bytes / 2;
            const std::uint32_t first = random() % (shape.line_bytes / unit);
            const std::uint32_t count = 1 + random() % (shape.line_bytes / unit - first);
            use.write_bytes = LineMask::range(first * unit, count * unit);
        }
        uses.push_back(use);
    }
    return uses;
}

struct Sectors {
    std::uint64_t fills = 0, write_backs = 0;
};

std::vector<Sectors> by_cache(const std::vector<Use>& uses, const Shape& shape, std::uint32_t lines) {
    RopCache cache({lines * shape.line_bytes, lines, shape.line_bytes, shape.sector_bytes});
    cache.set_clear_range(std::uint64_t{40} * shape.line_bytes, std::uint64_t{50} * shape.line_bytes);
    std::vector<Sectors> moved(2);
    const auto leave = [&](const Eviction& e) {
        moved[e.surface].write_backs += static_cast<std::uint64_t>(std::popcount(e.sectors));
    };
    for (const Use& use : uses) {
        int line = cache.probe(use.line_address, 0);
        if (line == RopCache::kMiss) {
            Eviction e;
            line = cache.allocate(use.line_address, use.surface, &e);
            leave(e);
        }
        cache.touch(line);
        const std::uint32_t missing = cache.request_sectors(line, use.read_sectors);
        moved[use.surface].fills += static_cast<std::uint64_t>(std::popcount(missing));
        cache.fill(line, missing);
        if (use.write_bytes.any()) cache.write(line, use.write_bytes);
    }
    cache.flush(leave);
    return moved;
}

TEST(LruTraffic, IsThatOfAFullyAssociativeCacheOfEachSize) {
    const std::vector<std::uint32_t> capacities{1, 2, 5, 16, 31, 64, 89};
    for (const Shape& shape : {Shape{128, 32}, Shape{64, 64}, Shape{256, 8}}) {
        const std::vector<Use> uses = uses_of(shape, shape.line_bytes);
        LruTraffic all(shape.line_bytes, shape.sector_bytes, capacities, 2);
        all.set_clear_range(std::uint64_t{40} * shape.line_bytes, std::uint64_t{50} * shape.line_bytes);
        for (const Use& use : uses) all.use(use.line_address, use.read_sectors, use.write_bytes, use.surface);
        for (std::size_t level = 0; level <= capacities.size(); ++level) {
            // 90 lines are used: a cache of 90 is one that never evicts.
            const std::uint32_t lines = level < capacities.size() ? capacities[level] : 90;
            const std::vector<Sectors> one = by_cache(uses, shape, lines);
            for (int surface = 0; surface < 2; ++surface) {
                const Sectors& expected = one[static_cast<std::size_t>(surface)];
                EXPECT_GT(expected.write_backs, 0u);
                EXPECT_EQ(all.fills(surface, level), expected.fills)
                    << lines << " lines of " << shape.line_bytes << " bytes, surface " << surface;
                EXPECT_EQ(all.write_backs(surface, level), expected.write_backs)
                    << lines << " lines of " << shape.line_bytes << " bytes, surface " << surface;
            }
        }
        EXPECT_EQ(all.lines(), 90u);
    }
}

// Inclusion: what a cache holds, every larger one holds too.
TEST(LruTraffic, LargerIsNeverWorse) {
    const Shape shape{128, 32};
    LruTraffic all(shape.line_bytes, shape.sector_bytes, counted_up_to(100), 2);
    for (const Use& use : uses_of(shape, 3))
        all.use(use.line_address, use.read_sectors, use.write_bytes, use.surface);
    for (std::size_t level = 0; level < 100; ++level) {
        for (int surface = 0; surface < 2; ++surface) {
            EXPECT_GE(all.fills(surface, level), all.fills(surface, level + 1)) << level;
            EXPECT_GE(all.write_backs(surface, level), all.write_backs(surface, level + 1)) << level;
        }
        EXPECT_LE(all.line_hit_share(level), all.line_hit_share(level + 1)) << level;
    }
    EXPECT_GT(all.fills(0, 0), all.fills(0, 99));
    // Lines 0..89 all fit into the last sizes, and each is new once.
    EXPECT_DOUBLE_EQ(all.line_hit_share(100), 1 - 90.0 / static_cast<double>(all.uses()));
    EXPECT_DOUBLE_EQ(all.line_hit_share(90), all.line_hit_share(100));
}

}  // namespace
}  // namespace ropsim
