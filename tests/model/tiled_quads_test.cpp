// What the tiled engine makes of a frame's quads: their order, the bins that it reads for them, the time that
// binning takes.
#include "model/tiled_quads.h"

#include "tests/model/machine_driver.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

namespace ropsim {
namespace {

struct TiledFrame {
    std::vector<QuadOperation> quads;  // `pass` filled in
    std::vector<std::vector<LineAccess>> lines;
    TiledReport report;
    TilePlan plan;
    int bins = 0;  // number of the surface
    Image image;
};

TiledFrame run_tiled(const std::string& path, const std::string& technique, const Settings& settings) {
    MachineConfig config = configured(settings);
    TraceReader trace(path);
    const auto operation = operation_for(technique, trace.header());
    const TileBins bins = prepare_tiled(trace, operation->declaration(), config);
    Frame frame(trace, *operation, config, 1, true);
    TiledQuads tiled(frame, trace, config, bins);
    TiledFrame result;
    result.lines.resize(config.partitions);
    QuadBatch batch;
    while (tiled.advance(batch)) {
        for (QuadOperation q : batch.quads) {
            q.first_line += static_cast<std::uint32_t>(result.lines[q.partition].size());
            q.pass = batch.source(q).pass;
            result.quads.push_back(q);
        }
        for (std::size_t p = 0; p < config.partitions; ++p)
            result.lines[p].insert(result.lines[p].end(), batch.lines[p].begin(), batch.lines[p].end());
    }
    result.report = tiled.report();
    result.plan = config.tiles;
    result.bins = frame.surfaces().bins();
    result.image = frame.image();
    return result;
}

class TiledQuadsTest : public ModelTest {
 protected:
    // Primitives one after the other, each of some pixels side by side.
    std::vector<Fragment> strips(int width, int height, int count) const {
        std::vector<Fragment> fragments;
        std::uint32_t state = 12345;
        const auto random = [&](int below) {
            state = state * 1664525u + 1013904223u;
            return static_cast<int>((state >> 8) % static_cast<std::uint32_t>(below));
        };
        for (int i = 0; i < count; ++i) {
            const int y = random(height / 2) * 2;
            const int x = random(width / 2) * 2;
            const int end = std::min(width, x + 2 + 2 * random(20));
            for (int u = x; u < end; u += 2)
                for (const auto& [dx, dy] : {std::pair{0, 0}, {1, 0}, {0, 1}, {1, 1}})
                    fragments.push_back(fragment_at(u + dx, y + dy, 0.001f * static_cast<float>(random(900)),
                                                    static_cast<std::uint32_t>(i)));
        }
        return fragments;
    }
};

bool drawn(const QuadOperation& q) {
    return q.kind == QuadKind::kDraw || q.kind == QuadKind::kCulled;
}

// In a partition quads come tile by tile, in a tile pass by pass, in a pass as in the trace.
TEST_F(TiledQuadsTest, QuadsComeByTilePassAndTrace) {
    const std::string trace = write(plain_header(200, 140), strips(200, 140, 600));
    const Settings settings = {"rop.partitions=4"};
    for (const char* technique : {"alpha_blend", "moment_based", "depth_peeling"}) {
        const TiledFrame tiled = run_tiled(trace, technique, settings);
        std::vector<std::set<std::size_t>> finished(4);
        std::vector<std::size_t> tile(4, ~std::size_t{0});
        std::map<std::size_t, std::vector<std::uint32_t>> passes;  // of a tile's quads
        std::map<std::tuple<std::size_t, int>, std::vector<std::uint32_t>> of_first_pass;
        for (const QuadOperation& q : tiled.quads) {
            if (!drawn(q) && q.kind != QuadKind::kResolve) continue;
            const std::size_t now = tiled.plan.tile_of(q.quad_id / 16);
            if (now != tile[q.partition]) {
                EXPECT_TRUE(finished[q.partition].insert(now).second) << "came back to tile " << now;
                tile[q.partition] = now;
            }
            if (q.kind == QuadKind::kResolve) {
                passes[now].push_back(1000);
                continue;
            }
            passes[now].push_back(q.pass);
            if (q.pass == 1) of_first_pass[{now, q.pass}].push_back(q.quad_id);
        }
        if (std::string(technique) != "depth_peeling") {  // whose rounds take turns
            for (const auto& [number, list] : passes) EXPECT_TRUE(std::ranges::is_sorted(list)) << number;
        }
        if (std::string(technique) != "alpha_blend") continue;  // of one pass
        const FrameResult rop = run_frame(trace, technique, configured(settings), 1, true);
        std::map<std::tuple<std::size_t, int>, std::vector<std::uint32_t>> expected;
        for (const QuadOperation& q : rop.quads)
            if (drawn(q)) expected[{tiled.plan.tile_of(q.quad_id / 16), 1}].push_back(q.quad_id);
        EXPECT_TRUE(of_first_pass == expected);
        EXPECT_EQ(tiled.image.values, rop.image.values);
    }
}

// Against sets of what touches each tile.
TEST_F(TiledQuadsTest, BinsHoldWhatTouchesTheTile) {
    const std::vector<Fragment> fragments = strips(200, 140, 900);
    const std::string trace = write(plain_header(200, 140), fragments);
    for (const int side : {8, 16, 32}) {
        MachineConfig config = configured(
            {fmt::format("tiled.tile={}", side), "tiled.kibibytes=512", "tiled.primitive_bytes=20"});
        TraceReader reader(trace);
        const auto operation = operation_for("alpha_blend", reader.header());
        const TileBins bins = prepare_tiled(reader, operation->declaration(), config);
        std::map<std::uint32_t, std::set<std::uint32_t>> expected;
        std::set<std::uint32_t> primitives;
        const int across = (200 + side - 1) / side;
        for (const Fragment& f : fragments) {
            expected[static_cast<std::uint32_t>(f.y / side * across + f.x / side)].insert(f.primitive);
            primitives.insert(f.primitive);
        }
        std::uint64_t entries = 0;
        for (const auto& [tile, set] : expected) {
            EXPECT_EQ(bins.tile_entries(tile), set.size());
            entries += set.size();
        }
        EXPECT_EQ(bins.entries(), entries);
        EXPECT_EQ(bins.primitives(), primitives.size());
        EXPECT_EQ(bins.written_bytes(), entries * 8 + primitives.size() * 20);
    }
}

// Every byte of the bins is written once, before any tile is drawn, and read in whole sectors that were
// written.
TEST_F(TiledQuadsTest, BinsAreWrittenThenRead) {
    const std::string trace = write(plain_header(200, 140), strips(200, 140, 900));
    const TiledFrame tiled = run_tiled(trace, "adaptive", {"tiled.primitive_bytes=48", "rop.partitions=3"});
    std::set<std::tuple<int, std::uint64_t, std::uint32_t>> written;  // partition, line, byte
    bool reading = false;
    std::uint64_t read_sectors = 0;
    for (const QuadOperation& q : tiled.quads) {
        reading = reading || drawn(q);
        for (std::uint32_t l = 0; l < q.line_count; ++l) {
            const LineAccess& line = tiled.lines[q.partition][q.first_line + l];
            if (line.surface != tiled.bins) continue;
            for (std::uint32_t byte = 0; byte < 128; ++byte) {
                const bool writes = (line.write_bytes.word[byte / 64] >> byte % 64 & 1) != 0;
                if (writes) {
                    EXPECT_FALSE(reading);
                    EXPECT_TRUE(written.insert({q.partition, line.line_address, byte}).second);
                }
            }
            for (std::uint32_t sector = 0; sector < 4; ++sector) {
                if ((line.read_sectors >> sector & 1) == 0) continue;
                ++read_sectors;
                EXPECT_TRUE(written.contains({q.partition, line.line_address, 32 * sector}));
            }
        }
    }
    EXPECT_EQ(written.size(), tiled.report.bin_written);
    EXPECT_GE(32 * read_sectors, tiled.report.bin_read / 2) << "neighbours share sectors";
    EXPECT_GT(read_sectors, 0u);
}

// The binner's cycles stand in front of every partition's tiles, or nowhere where it works ahead.
TEST_F(TiledQuadsTest, BinningTakesEntriesOverTheRate) {
    const std::string trace = write(plain_header(64, 64), strips(64, 64, 333));
    for (const int rate : {1, 7}) {
        for (const bool overlap : {false, true}) {
            const TiledFrame tiled =
                run_tiled(trace, "alpha_blend",
                          {fmt::format("tiled.bin_entries_per_cycle={}", rate), "rop.partitions=5",
                           fmt::format("tiled.overlap_binning={}", overlap)});
            const std::uint64_t entries = tiled.report.bin_entries;
            const std::uint64_t cycles =
                (entries + static_cast<std::uint64_t>(rate) - 1) / static_cast<std::uint64_t>(rate);
            std::vector<std::uint64_t> taken(5);
            for (const QuadOperation& q : tiled.quads) {
                if (drawn(q)) break;
                if (q.kind != QuadKind::kCopy || q.pass != 0) continue;
                taken[q.partition] += q.interval;
            }
            for (const std::uint64_t t : taken) EXPECT_EQ(t, overlap ? 0 : cycles);
        }
    }
}

// A tile that has nothing left to peel is not gone over again.
TEST_F(TiledQuadsTest, TilesStopPeelingOnTheirOwn) {
    std::vector<Fragment> fragments;
    std::uint32_t primitive = 0;
    for (int layer = 0; layer < 6; ++layer)
        fragments.push_back(fragment_at(4, 4, 0.1f * static_cast<float>(layer + 1), primitive++));
    fragments.push_back(fragment_at(40, 4, 0.5f, primitive++));
    const std::string trace = write(plain_header(64, 16), fragments);
    const Settings settings = {"rop.partitions=1"};
    const TiledFrame tiled = run_tiled(trace, "depth_peeling", settings);
    const FrameResult rop = run_frame(trace, "depth_peeling", configured(settings), 1, true);
    EXPECT_EQ(tiled.image.values, rop.image.values);
    const auto draws_at = [](const std::vector<QuadOperation>& quads, std::uint32_t tile) {
        return std::ranges::count_if(
            quads, [&](const QuadOperation& q) { return drawn(q) && q.quad_id / 16 == tile; });
    };
    EXPECT_EQ(draws_at(tiled.quads, 0), draws_at(rop.quads, 0));
    EXPECT_GT(draws_at(rop.quads, 5), draws_at(tiled.quads, 5));
    EXPECT_LE(draws_at(tiled.quads, 5), 4) << "one layer, and a round that finds no more";
}

// Pixel state passes through the ports of tile memory: read and written at once.
TEST_F(TiledQuadsTest, TileMemoryHasPorts) {
    std::vector<Fragment> fragments;
    for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {0, 1}, {1, 1}})
        fragments.push_back(fragment_at(x, y, 0.5f, 0));
    const std::string trace = write(plain_header(16, 16), fragments);
    for (const std::uint32_t width : {1u, 8u}) {
        const TiledFrame tiled =
            run_tiled(trace, "alpha_blend", {fmt::format("tiled.bytes_per_cycle={}", width)});
        for (const QuadOperation& q : tiled.quads)
            if (drawn(q)) {
                EXPECT_EQ(q.interval, 4 * 8 / width);  // four pixels of four halves
            }
    }
}

}  // namespace
}  // namespace ropsim
