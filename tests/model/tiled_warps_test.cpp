// Warps of the tiled engine: each partition fills its own, from the tile that it draws.
#include "tests/model/tiled_driver.h"

#include <map>
#include <random>
#include <tuple>

namespace ropsim {
namespace {

constexpr int kWidth = 112;
constexpr int kHeight = 96;
constexpr int kDraws = 12;

struct Scene {
    std::vector<Fragment> fragments;
    // Quads by tile of 16 x 16 pixels and draw.
    std::map<std::tuple<int, int, int>, std::uint64_t> quads;
};

// Each draw covers some quads of some tiles, so that partitions are soon in different draws.
Scene random_draws(std::uint32_t seed) {
    std::mt19937 random(seed);
    Scene scene;
    for (int d = 0; d < kDraws; ++d) {
        for (int y = 0; y < kHeight; y += 2) {
            for (int x = 0; x < kWidth; x += 2) {
                const bool tile_drawn = ((x / 16 * 7 + y / 16 * 3 + d * 5) % 4) != 0;
                if (!tile_drawn || random() % 3 == 0) continue;
                ++scene.quads[{x / 16, y / 16, d}];
                Fragment f =
                    fragment_at(x, y, 0.8f - 0.01f * static_cast<float>(d), static_cast<std::uint32_t>(d));
                f.draw = static_cast<std::uint16_t>(d);
                scene.fragments.push_back(f);
            }
        }
    }
    return scene;
}

TEST_F(TiledEngineTest, WarpsAreOfOneTileDrawAndPass) {
    for (const std::uint32_t seed : {1u, 2u}) {
        const Scene scene = random_draws(seed);
        const std::string trace = write(plain_header(kWidth, kHeight, kDraws), scene.fragments);
        for (const int size : {3, 8}) {
            std::uint64_t warps = 0;
            std::uint64_t quads = 0;
            for (const auto& [where, count] : scene.quads) {
                warps += (count + static_cast<std::uint64_t>(size) - 1) / static_cast<std::uint64_t>(size);
                quads += count;
            }
            const Settings settings = {fmt::format("shader.warp_quads={}", size)};
            for (const char* technique : {"alpha_blend", "adaptive:nodes=4", "moment_based"}) {
                const RunResult r = run_with(trace, technique, Engine::kTiled, Fidelity::kCached, settings);
                const auto passes = static_cast<std::uint64_t>(r.passes);
                EXPECT_EQ(passes, std::string(technique) == "alpha_blend" ? 1u : 2u);
                EXPECT_EQ(r.machine->front_end.warps, passes * warps) << technique << " " << size;
                EXPECT_EQ(r.machine->front_end.shaded_quads, passes * quads);
                const RunResult all = run_with(trace, technique, Engine::kRop, Fidelity::kCached, settings);
                EXPECT_EQ(all.machine->front_end.shaded_quads, passes * quads);
                EXPECT_LE(all.machine->front_end.warps, r.machine->front_end.warps)
                    << "the ROP engine packs whole draws";
            }
        }
    }
}

// With time to wait for its next quad a warp is what it is without a clock.
TEST_F(TiledEngineTest, TimedWarpsAreTheUntimedOnes) {
    const Scene scene = random_draws(3);
    const std::string trace = write(plain_header(kWidth, kHeight, kDraws), scene.fragments);
    const Settings patient = {"shader.pack_timeout=65536"};
    const auto untimed = run_with(trace, "adaptive:nodes=4", Engine::kTiled, Fidelity::kCached, patient);
    const auto timed = run_with(trace, "adaptive:nodes=4", Engine::kTiled, Fidelity::kTimed, patient);
    EXPECT_EQ(timed.machine->front_end.warps, untimed.machine->front_end.warps);
    EXPECT_EQ(timed.machine->front_end.shaded_quads, untimed.machine->front_end.shaded_quads);
}

}  // namespace
}  // namespace ropsim
