// Sentences of engine `shader`: shares of all places for quads, the bottleneck first.
#include "tests/model/tiled_driver.h"

#include <numeric>

namespace ropsim {
namespace {

class InterlockBottlenecks : public ModelTest {
 protected:
    // Fragments of `pixels` pixels of as many quads, `layers` each.
    std::vector<CycleCause> found(int pixels, int layers, Settings settings) const {
        std::vector<Fragment> fragments;
        for (int i = 0; i < pixels * layers; ++i)
            fragments.push_back(fragment_at(i % pixels % 32 * 2, i % pixels / 32 * 2,
                                            0.9f - 1e-5f * static_cast<float>(i / pixels),
                                            static_cast<std::uint32_t>(i)));
        settings.push_back("rop.partitions=1");
        const RunResult r = run_with(write(plain_header(64, 64), fragments), "alpha_blend", Engine::kShader,
                                     Fidelity::kTimed, settings);
        const std::vector<CycleCause>& causes = r.machine->observation.bottlenecks;
        EXPECT_NEAR(std::accumulate(causes.begin(), causes.end(), 0.0,
                                    [](double sum, const CycleCause& c) { return sum + c.share; }),
                    1.0, 1e-9);
        EXPECT_EQ(r.machine->bottleneck, causes.front().text);
        return causes;
    }
};

TEST_F(InterlockBottlenecks, OnePixel) {
    const auto causes = found(1, 600, {"shader.quads_in_flight=64"});
    EXPECT_EQ(causes.front().cause, "interlock");
    EXPECT_GT(causes.front().share, 0.8);
}

TEST_F(InterlockBottlenecks, SpinningSaysItsTries) {
    const auto causes = found(1, 200, {"shader.quads_in_flight=64", "interlock.mode=spin"});
    EXPECT_EQ(causes.front().cause, "interlock");
    EXPECT_NE(causes.front().text.find("tries an operation"), std::string::npos);
}

TEST_F(InterlockBottlenecks, ThePort) {
    const auto causes =
        found(1024, 6,
              {"shader.quads_in_flight=1024", "interlock.memory_latency=0", "interlock.begin_cycles=0",
               "interlock.end_cycles=0", "interlock.instruction_latency=1", "shader.latency=0"});
    EXPECT_EQ(causes.front().cause, "port");
}

TEST_F(InterlockBottlenecks, TheLanes) {
    const auto causes = found(1024, 6, {"shader.quads_in_flight=1024", "shader.alu_lanes=16"});
    EXPECT_EQ(causes.front().cause, "front_end");
    EXPECT_NE(causes.front().text.find("(shader.alu_lanes = 16)"), std::string::npos);
}

}  // namespace
}  // namespace ropsim
