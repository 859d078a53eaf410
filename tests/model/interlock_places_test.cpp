// Engine `shader`: a warp keeps its place in the core through its critical section.
#include "tests/model/tiled_driver.h"

namespace ropsim {
namespace {

constexpr std::uint64_t kQuads = 120;
constexpr std::uint64_t kBegin = 2000;  // cycles: what a section takes, but for some hundreds

class InterlockPlaces : public ModelTest, public ::testing::WithParamInterface<std::uint64_t> {};

TEST_P(InterlockPlaces, BoundTheSectionsAtATime) {
    std::vector<Fragment> fragments;
    for (int i = 0; i < static_cast<int>(kQuads); ++i)
        fragments.push_back(
            fragment_at(i % 12 * 2, i / 12 * 2, 0.5f, static_cast<std::uint32_t>(i)));  // a quad each
    const RunResult r =
        run_with(write(plain_header(32, 32), fragments), "alpha_blend", Engine::kShader, Fidelity::kTimed,
                 {"shader.cores=1", "shader.warp_quads=1", fmt::format("shader.warps={}", GetParam()),
                  "shader.latency=0", "shader.quads_in_flight=4096",
                  fmt::format("interlock.begin_cycles={}", kBegin)});
    const std::uint64_t rounds = kQuads / GetParam();
    EXPECT_GE(r.machine->rop_cycles, rounds * kBegin);
    EXPECT_LE(r.machine->rop_cycles, rounds * (kBegin + 600) + 5000);
}

// The second pass reads what the first wrote, anywhere: it begins when nothing of the first is left, though
// places fall free while the last pixel's layers go one after the other.
TEST_F(ModelTest, APassBeginsWhenTheOneBeforeItIsDone) {
    constexpr std::uint64_t kPlaces = 8;
    constexpr std::uint64_t kLayers = 8;        // of the last pixel
    constexpr std::uint64_t kSection = 20'000;  // cycles, so that little else counts
    std::vector<Fragment> fragments;
    std::uint32_t primitive = 0;
    for (int i = 0; i < static_cast<int>(kPlaces * kLayers); ++i, ++primitive)
        fragments.push_back(fragment_at(i % 8 * 2, i / 8 * 2, 0.5f, primitive));  // a quad each
    for (std::uint64_t i = 0; i < kLayers; ++i, ++primitive)
        fragments.push_back(fragment_at(30, 30, 0.5f, primitive));
    const RunResult r = run_with(
        write(plain_header(32, 32), fragments), "adaptive:nodes=4", Engine::kShader, Fidelity::kTimed,
        {"shader.cores=1", "shader.warp_quads=1", fmt::format("shader.warps={}", kPlaces), "shader.latency=0",
         "shader.quads_in_flight=4096", fmt::format("interlock.begin_cycles={}", kSection)});
    ASSERT_EQ(r.passes, 2);
    // A pass: all places in turn, then one after the other.
    EXPECT_GE(r.machine->rop_cycles, 2 * (kLayers + kLayers) * kSection);
}

INSTANTIATE_TEST_SUITE_P(Warps, InterlockPlaces, ::testing::Values(1, 4, 12));

}  // namespace
}  // namespace ropsim
