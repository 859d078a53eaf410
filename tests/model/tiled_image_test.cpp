// The tiled engine's image is the fixed-function engine's, bit for bit.
#include "tests/model/tiled_driver.h"

#include <random>

#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {
namespace {

using TiledImageTest = TiledEngineTest;

class TiledTechniqueTest : public TiledEngineTest, public ::testing::WithParamInterface<std::string> {};

// Over an opaque layer and several samples; all on chip, nothing on chip, some of it, with one thread and
// two.
TEST_P(TiledTechniqueTest, ImageIsTheFixedFunctionEngines) {
    const std::string& technique = GetParam();
    const bool takes_samples = operation_for(technique, plain_header(8, 8))->declaration().uses_coverage;
    for (const int samples : {1, 4}) {
        if (samples > 1 && !takes_samples) continue;
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
                         [](const auto& technique) { return technique.param; });

TEST_F(TiledImageTest, TechniquesThatReadAroundRunToo) {
    RandomFragments scene;
    scene.width = 90;
    scene.height = 40;
    scene.count = 4000;
    scene.draws = 3;
    scene.opaque = true;
    scene.materials = true;
    TraceHeader header = random_header(scene);
    header.camera.emplace();
    header.camera->near_plane = 0.1f;
    header.camera->far_plane = 100;
    header.camera->fovy_degrees = 60;
    header.camera->projection = glm::perspective(glm::radians(60.0f), 90.0f / 40.0f, 0.1f, 100.0f);
    for (std::size_t d = 0; const char* name : {"glass", "smoke", "hair"}) header.draws[d++].name = name;
    TraceWriter writer(path("around"), header);
    writer.append(random_chunk(scene));
    writer.finish();
    for (const char* technique : {"stochastic:samples=4,filter=gaussian", "phenomenological",
                                  "phenomenological:low_resolution=2,low_draws=smoke"}) {
        const RunResult rop = run_with(path("around"), technique, Engine::kRop, Fidelity::kCount);
        const RunResult tiled = run_with(path("around"), technique, Engine::kTiled, Fidelity::kCached);
        EXPECT_EQ(rop.image.values, tiled.image.values) << technique;
        EXPECT_EQ(rop.counts.joined, tiled.counts.joined) << technique;
        EXPECT_FALSE(tiled.tiled->plan.tiled_resolve) << technique;
        EXPECT_EQ(tiled.tiled->plan.state_bytes, 0u) << technique;
        EXPECT_GE(tiled.tiled->bin_read, tiled.tiled->bin_entries * (8 + 32)) << technique;
    }
}

// Each fidelity in a process of its own: same image, same bytes where the order of misses is the same, and
// the program's own checks of conservation.
TEST_F(TiledImageTest, TimedRunsAgreeWithCachedOnes) {
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
        const std::string image = technique == std::string("alpha_blend") ? "color" : "image";
        EXPECT_EQ(timed["traffic"][image]["pin_write_bytes"], 96 * 64 * 8);
        EXPECT_EQ(cached["traffic"][image]["pin_write_bytes"], 96 * 64 * 8);
        EXPECT_EQ(timed["tiled"], cached["tiled"]);
        EXPECT_EQ(rop.count("tiled"), 0u);
        EXPECT_GT(timed["cycles"].get<std::uint64_t>(),
                  timed["tiled"]["bin_entries"].get<std::uint64_t>() / 8);
    }
}

// Random machines on random traces: the conservation checks at the end of a run hold, and the image stays.
TEST_F(TiledImageTest, RandomMachinesKeepTheImage) {
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
