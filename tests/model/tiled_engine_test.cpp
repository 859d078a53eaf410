// The tiled engine: the image of the fixed-function engine, bit for bit, and the bytes that closed forms
// give.
#include "model/run.h"
#include "tests/model/machine_driver.h"

#include <algorithm>
#include <random>

namespace ropsim {
namespace {

RunResult run_with(const std::string& trace, const std::string& technique, Engine engine, Fidelity fidelity,
                   const Settings& settings = {}, int threads = 1) {
    RunOptions options;
    options.trace = trace;
    options.technique = technique;
    options.settings = settings;
    options.fidelity = fidelity;
    options.engine = engine;
    options.threads = threads;
    options.error = false;
    return run_simulation(options);
}

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

class TiledEngineTest : public ModelTest {
 protected:
    std::string write_random(const RandomFragments& scene, const std::string& name = "trace") const {
        TraceWriter writer(path(name), random_header(scene));
        writer.append(random_chunk(scene));
        writer.finish();
        return path(name);
    }
    // A screen of which every pixel is covered `layers` times, each layer one primitive, over an opaque
    // layer.
    std::string write_full(int width, int height, int layers, bool opaque) const {
        TraceHeader header = plain_header(width, height);
        if (opaque) {
            const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
            header.opaque =
                OpaqueLayer{std::vector<float>(3 * pixels, 0.5f), std::vector<float>(pixels, 0.9f)};
        }
        std::vector<Fragment> fragments;
        for (int layer = 0; layer < layers; ++layer)
            for (int y = 0; y < height; y += 2)
                for (int x = 0; x < width; x += 2)
                    for (const auto& [u, v] : {std::pair{0, 0}, {1, 0}, {0, 1}, {1, 1}})
                        fragments.push_back(fragment_at(x + u, y + v,
                                                        0.8f - 0.01f * static_cast<float>(layer),
                                                        static_cast<std::uint32_t>(layer)));
        return write(header, fragments, "full");
    }
};

class TiledTechniqueTest : public TiledEngineTest, public ::testing::WithParamInterface<std::string> {};

// Over an opaque layer and several samples; all on chip, nothing on chip, some of it, with one thread and
// two.
TEST_P(TiledTechniqueTest, ImageIsTheFixedFunctionEngines) {
    const std::string& technique = GetParam();
    for (const int samples : {1, 4}) {
        RandomFragments scene;
        scene.seed = 7;
        scene.width = 150;  // more than a region of the trace, and no whole tiles
        scene.height = 44;
        scene.samples = samples;
        scene.partial_coverage = samples > 1;
        scene.count = 5000;
        scene.draws = 3;
        scene.opaque = true;
        scene.slopes = true;
        const std::string trace = write_random(scene);
        const RunResult rop = run_with(trace, technique, Engine::kRop, Fidelity::kCount);
        for (const Settings& settings :
             {Settings{}, Settings{"tiled.kibibytes=0"},
              Settings{"tiled.tile=32", "tiled.kibibytes=12", "tiled.shrink=false"}}) {
            for (const Fidelity fidelity : {Fidelity::kCount, Fidelity::kCached}) {
                const int threads = fidelity == Fidelity::kCount ? 1 : 2;
                const RunResult tiled =
                    run_with(trace, technique, Engine::kTiled, fidelity, settings, threads);
                EXPECT_EQ(rop.image.values, tiled.image.values) << fmt::format("{}", settings);
                EXPECT_EQ(rop.counts.operated, tiled.counts.operated);
                EXPECT_EQ(rop.counts.input, tiled.counts.input);
                EXPECT_EQ(rop.touched_tiles, tiled.touched_tiles);
                EXPECT_EQ(rop.passes, tiled.passes);
            }
        }
    }
}

INSTANTIATE_TEST_SUITE_P(All, TiledTechniqueTest, ::testing::ValuesIn(technique_names()),
                         [](const auto& info) { return info.param; });

TEST_F(TiledEngineTest, TechniquesThatReadAroundRunToo) {
    RandomFragments scene;
    scene.width = 90;
    scene.height = 40;
    scene.count = 4000;
    scene.samples = 4;
    scene.opaque = true;
    scene.materials = true;
    const std::string trace = write_random(scene);
    for (const char* technique :
         {"stochastic:samples=4,filter=gaussian", "phenomenological", "phenomenological:low_resolution=2"}) {
        const RunResult rop = run_with(trace, technique, Engine::kRop, Fidelity::kCount);
        const RunResult tiled = run_with(trace, technique, Engine::kTiled, Fidelity::kCached);
        EXPECT_EQ(rop.image.values, tiled.image.values) << technique;
        EXPECT_FALSE(tiled.tiled->plan.tiled_resolve) << technique;
        EXPECT_EQ(tiled.tiled->plan.state_bytes, 0u) << technique;
        EXPECT_GT(tiled.tiled->bin_read, 0u) << technique;
    }
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
            if (!shrink) EXPECT_EQ(plan.side, 16);
            if (shrink && plan.side > 8) EXPECT_LE(used, bytes);
            if (shrink && plan.side < 16) EXPECT_GT(4 * used, bytes) << "shrunk too far";
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
                {fmt::format("tiled.kibibytes={}", kibibytes), "tiled.shrink=false", "cache.kibibytes=4"});
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

// Each fidelity in a process of its own: same image, same bytes where the order of misses is the same, and
// the program's own checks of conservation.
TEST_F(TiledEngineTest, TimedRunsAgreeWithCachedOnes) {
    const std::string trace = write_full(96, 64, 4, true);
    for (const char* technique : {"alpha_blend", "adaptive:nodes=8", "a_buffer", "depth_peeling"}) {
        const nlohmann::json timed =
            run(trace, technique, {}, {"--engine", "tiled", "--fidelity", "timed"}, "timed");
        const nlohmann::json cached =
            run(trace, technique, {}, {"--engine", "tiled", "--fidelity", "cached"}, "cached");
        const nlohmann::json rop = run(trace, technique, {}, {}, "rop");
        EXPECT_EQ(timed["engine"], "tiled");
        EXPECT_EQ(read_file(path("timed") + "/image.exr"), read_file(path("cached") + "/image.exr"));
        EXPECT_EQ(read_file(path("timed") + "/image.exr"), read_file(path("rop") + "/image.exr"));
        EXPECT_EQ(timed["traffic"]["image"]["pins"], cached["traffic"]["image"]["pins"]);
        EXPECT_EQ(timed["tiled"], cached["tiled"]);
        EXPECT_EQ(rop.count("tiled"), 0u);
        EXPECT_GT(timed["cycles"].get<std::uint64_t>(),
                  timed["tiled"]["bin_entries"].get<std::uint64_t>() / 8);
    }
}

// Random machines on random traces: the conservation checks at the end of a run hold, and the image stays.
TEST_F(TiledEngineTest, RandomMachinesKeepTheImage) {
    std::mt19937 random(3);
    const auto one_of = [&](std::initializer_list<const char*> list) {
        return std::string(list.begin()[random() % list.size()]);
    };
    for (int i = 0; i < 6; ++i) {
        RandomFragments scene;
        scene.seed = 100 + static_cast<std::uint64_t>(i);
        scene.width = 20 + static_cast<int>(random() % 150);
        scene.height = 20 + static_cast<int>(random() % 60);
        scene.count = 3000;
        scene.opaque = random() % 2 == 0;
        scene.samples = random() % 2 == 0 ? 1 : 4;
        const std::string trace = write_random(scene);
        const std::string technique =
            one_of({"adaptive:nodes=4", "a_buffer", "depth_peeling", "stochastic:samples=4"});
        const Settings settings = {"tiled.tile=" + one_of({"8", "16", "32"}),
                                   "tiled.kibibytes=" + one_of({"0", "2", "16", "64"}),
                                   "tiled.shrink=" + one_of({"true", "false"}),
                                   "tiled.entry_bytes=" + one_of({"3", "8", "64"}),
                                   "tiled.primitive_bytes=" + one_of({"0", "20", "300"}),
                                   "tiled.overlap_binning=" + one_of({"true", "false"}),
                                   "rop.partitions=" + one_of({"1", "3", "8"}),
                                   "cache.ways=" + one_of({"1", "4"}),
                                   "compression.color=" + one_of({"none", "delta"}),
                                   "compression.nodes=" + one_of({"none", "delta"}),
                                   "l2.kibibytes=" + one_of({"0", "64"})};
        const nlohmann::json tiled = run(trace, technique, settings, {"--engine", "tiled"}, "tiled");
        const nlohmann::json rop = run(trace, technique, settings, {"--fidelity", "count"}, "rop");
        EXPECT_EQ(read_file(path("tiled") + "/image.exr"), read_file(path("rop") + "/image.exr"))
            << technique << fmt::format(" {}", settings);
    }
}

}  // namespace
}  // namespace ropsim
