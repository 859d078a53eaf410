// The bytes that the tiled engine moves: closed forms, what spills, what more tile memory saves.
#include "tests/model/tiled_driver.h"

#include <algorithm>

namespace ropsim {
namespace {

// Bytes of a surface on the pins.
ReadWriteBytes pins(const RunResult& r, const std::string& surface) {
    const auto at = static_cast<std::size_t>(std::ranges::find(r.surfaces, surface) - r.surfaces.begin());
    ReadWriteBytes sum;
    for (const CauseBytes& cause : r.machine->pins.at(at)) {
        sum.read += cause.read;
        sum.write += cause.write;
    }
    return sum;
}

std::uint64_t all_pins(const RunResult& r) {
    std::uint64_t sum = 0;
    for (const std::string& s : r.surfaces) sum += pins(r, s).read + pins(r, s).write;
    return sum;
}

// What moves when everything fits: the opaque layer and the finished image once, the bins there and back.
TEST_F(TiledEngineTest, BytesAreTheClosedForms) {
    constexpr int kWidth = 160;
    constexpr int kHeight = 96;
    constexpr std::uint64_t kPixels = kWidth * kHeight;
    constexpr std::uint64_t kLayers = 5;
    const std::string trace = write_full(kWidth, kHeight, kLayers, true);
    for (const char* technique : {"alpha_blend", "adaptive:nodes=4", "weighted_blended", "depth_peeling"}) {
        for (const std::uint64_t side : {8u, 16u, 32u}) {
            const RunResult r = run_with(trace, technique, Engine::kTiled, Fidelity::kCached,
                                         {fmt::format("tiled.tile={}", side), "tiled.kibibytes=512",
                                          "tiled.entry_bytes=32", "tiled.primitive_bytes=64"});
            const std::uint64_t entries = kPixels / (side * side) * kLayers;
            EXPECT_EQ(r.tiled->bin_entries, entries);
            EXPECT_EQ(r.tiled->primitives, kLayers);
            EXPECT_EQ(r.tiled->tiles, kPixels / (side * side));
            const ReadWriteBytes depth = pins(r, "opaque_depth");
            EXPECT_EQ(depth.read, kPixels * 4) << technique << side;
            EXPECT_EQ(depth.write, 0u);
            const bool target = !r.declaration.resolves;
            const std::string colour = target ? r.surfaces[0] : "opaque_color";
            const std::string image = target ? r.surfaces[0] : "image";
            EXPECT_EQ(pins(r, colour).read, kPixels * 8) << technique << side;
            EXPECT_EQ(pins(r, image).write, kPixels * 8) << technique << side;
            EXPECT_EQ(r.tiled->loaded, kPixels * 12);
            EXPECT_EQ(r.tiled->stored, kPixels * 8);
            for (std::size_t s = target ? 1 : 0; s < r.declaration.surfaces.size(); ++s) {
                EXPECT_EQ(pins(r, r.surfaces[s]).read + pins(r, r.surfaces[s]).write, 0u) << r.surfaces[s];
                EXPECT_GT(r.traffic[s].read + r.traffic[s].write, 0u) << "touched all the same";
            }
            const auto passes = static_cast<std::uint64_t>(r.passes);
            EXPECT_EQ(r.tiled->bin_written, entries * 32 + kLayers * 64);
            EXPECT_EQ(r.tiled->bin_read, passes * entries * (32 + 64));
            // Written once; of what is read some is still in the cache.
            EXPECT_EQ(pins(r, "bins").write, r.tiled->bin_written);
            EXPECT_LE(pins(r, "bins").read, r.tiled->bin_read);
            EXPECT_EQ(r.traffic.back().read, r.tiled->bin_read);
        }
    }
}

TEST_F(TiledEngineTest, OnlyTilesWithPrimitivesAreLoadedAndStored) {
    const std::string trace =
        write(plain_header(100, 50), {fragment_at(3, 3, 0.5f, 0), fragment_at(99, 49, 0.5f, 1)});
    const RunResult r = run_with(trace, "adaptive", Engine::kTiled, Fidelity::kCached);
    EXPECT_EQ(r.tiled->tiles, 2u);
    // Of the second tile, at the corner, 8 x 8 pixels' worth of tiles are on the screen.
    const std::uint64_t pixels = 16 * 16 + 8 * 8;
    EXPECT_EQ(r.tiled->stored, pixels * 8);
    EXPECT_EQ(pins(r, "image").write, pixels * 8);
    EXPECT_EQ(r.tiled->loaded, 0u) << "the background is a constant";
}

// A surface spills exactly when the bytes up to it are more than there is room for.
TEST_F(TiledEngineTest, SurfacesSpillWhenTheyDoNotFit) {
    const std::string trace = write_full(64, 64, 3, true);
    const RunResult whole = run_with(trace, "adaptive:nodes=8", Engine::kTiled, Fidelity::kCount);
    TraceReader reader(trace);
    const Declaration& declared = whole.declaration;
    for (const std::uint32_t bytes : {4095u, 4096u, 65535u, 65536u}) {
        for (const bool shrink : {false, true}) {
            TiledConfig config;
            config.memory_bytes = bytes;
            config.shrink = shrink;
            const TilePlan plan = plan_tiles(config, declared, reader.header());
            const auto pixels = static_cast<std::uint64_t>(plan.side * plan.side);
            std::uint64_t used = 4 * pixels;  // opaque depth
            bool fits = used <= bytes;
            EXPECT_EQ(plan.on_chip[declared.surfaces.size()] != 0, fits);
            for (std::size_t s = 0; s < declared.surfaces.size(); ++s) {
                used += plan.pixel_bytes[s] * pixels;
                fits = fits && used <= bytes;
                EXPECT_EQ(plan.on_chip[s] != 0, fits) << bytes << " " << s;
            }
            used += 8 * pixels;
            EXPECT_EQ(plan.on_chip.back() != 0, fits && used <= bytes);
            EXPECT_EQ(plan.wanted_bytes, used);
            EXPECT_TRUE(shrink || plan.side == 16);
            EXPECT_TRUE(!shrink || plan.side == 8 || used <= bytes);
            EXPECT_TRUE(plan.side == 16 || 4 * used > bytes) << "shrunk too far";
            EXPECT_LE(plan.state_bytes, bytes);
        }
    }
    // And what spills is seen on the pins.
    const RunResult spilled = run_with(trace, "adaptive:nodes=8", Engine::kTiled, Fidelity::kCached,
                                       {"tiled.kibibytes=1", "tiled.shrink=false", "cache.fast_clear=false"});
    EXPECT_GT(pins(spilled, spilled.surfaces[0]).write, 0u);
    EXPECT_GT(pins(spilled, "opaque_depth").read, 0u);
}

TEST_F(TiledEngineTest, ListsLieInMemoryAndTheirHeadsOnChip) {
    const RunResult r = run_with(write_full(64, 64, 4, true), "a_buffer", Engine::kTiled, Fidelity::kCached);
    for (std::size_t s = 0; s < r.declaration.surfaces.size(); ++s) {
        const bool pool = r.declaration.surfaces[s].layout == Layout::kPool;
        EXPECT_EQ(r.tiled->plan.on_chip[s] == 0, pool);
        EXPECT_EQ(pins(r, r.surfaces[s]).write > 0, pool) << r.surfaces[s];
    }
    EXPECT_EQ(r.pool_nodes_overflowed, 0u);
}

// Of a screen full of tiles, without changing the tile's size: what is on chip grows, what moves does not.
TEST_F(TiledEngineTest, MoreTileMemoryMovesNoMoreBytes) {
    RandomFragments scene;
    scene.width = 96;
    scene.height = 64;
    scene.count = 30000;
    scene.opaque = true;
    const std::string trace = write_random(scene);
    for (const char* technique : {"adaptive:nodes=8", "stochastic:samples=8", "slab", "moment_based"}) {
        std::uint64_t before = ~std::uint64_t{0};
        for (const int kibibytes : {0, 1, 2, 3, 5, 8, 13, 21, 34, 55}) {
            const RunResult r = run_with(
                trace, technique, Engine::kTiled, Fidelity::kCached,
                {fmt::format("tiled.kibibytes={}", kibibytes), "tiled.shrink=false", "cache.kibibytes=4",
                 // What is loaded is loaded whole, though ranges and depth units would read less of it.
                 "hiz.enabled=false", "depth.test=late"});
            EXPECT_LE(all_pins(r), before) << technique << " " << kibibytes;
            before = all_pins(r);
        }
    }
}

TEST_F(TiledEngineTest, BadValuesAreRefused) {
    for (const char* setting : {"tiled.tile=12", "tiled.tile=64", "tiled.kibibytes=-1", "tiled.entry_bytes=0",
                                "tiled.bytes_per_cycle=0", "tiled.shrink=2"})
        EXPECT_THROW(configured({setting}), UserError) << setting;
}

}  // namespace
}  // namespace ropsim
