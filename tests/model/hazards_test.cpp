// Hazards of a ROP partition: what operations on one pixel, one quad, one tile, and results for one line
// cost, by the formula.
#include "base/isolated_call.h"
#include "model/timed_machine.h"
#include "tests/model/machine_driver.h"

#include <sstream>
#include <utility>

namespace ropsim {
namespace {

constexpr double kBlend = 2 + 2 + 2 + 1;  // cycles of the pipeline: two adders, multiplier, converter
constexpr double kWrite = 1;
constexpr int kCount = 6000;

class HazardsTest : public ModelTest {
 protected:
    // Cycles on one partition, and lines whose write a later result joined.
    struct Outcome {
        double cycles = 0;
        int joined = 0;
    };
    Outcome run_on_one(const std::vector<Fragment>& fragments, const std::string& technique,
                       Settings settings, int side = 8) const {
        settings.emplace_back("rop.partitions=1");
        settings.emplace_back("rop.rate.bits_64=1");
        const std::string trace = write(plain_header(side, side), fragments);
        const MachineConfig config = configured(settings);
        const std::string numbers = call_isolated(trace, {.cpu_seconds = 60, .wait_seconds = 60}, [&] {
            TraceReader reader(trace);
            const auto operation = operation_for(technique, reader.header());
            Frame frame(reader, *operation, config, 1, true);
            const MachineResult result = run_timed_machine(frame, config, 1);
            return fmt::format("{} {}", result.rop_cycles, result.writes_coalesced);
        });
        Outcome outcome;
        std::istringstream(numbers) >> outcome.cycles >> outcome.joined;
        return outcome;
    }
    // Cycles of alpha blending on one partition, by fragment.
    double each(const std::vector<Fragment>& fragments, Settings settings, int side = 8) const {
        return run_on_one(fragments, "alpha_blend", std::move(settings), side).cycles /
               static_cast<double>(fragments.size());
    }
    static void expect_about(double measured, double formula) {
        EXPECT_NEAR(measured, formula, 0.02 * formula + 800.0 / kCount);
    }
};

// Fragments that visit `quads` quads of the first tile in turn, always at their first pixel.
std::vector<Fragment> in_turn(int quads) {
    std::vector<Fragment> fragments;
    for (int i = 0; i < kCount; ++i) {
        const int quad = i % quads;
        fragments.push_back(fragment_at(quad % 4 * 2, quad / 4 * 2, 0.5f, static_cast<std::uint32_t>(i)));
    }
    return fragments;
}

TEST_F(HazardsTest, ForwardingTakesWriteAndCacheOutOfTheLoop) {
    for (const int hit : {0, 4, 11}) {
        const std::string latency = fmt::format("cache.hit_latency={}", hit);
        expect_about(each(in_turn(1), {latency}), kBlend + kWrite + hit);
        expect_about(each(in_turn(1), {latency, "rop.forwarding=result"}), kBlend);
        // Three quads in turn share the time of one.
        expect_about(each(in_turn(3), {latency, "rop.forwarding=result"}), kBlend / 3);
    }
}

// Pixels that the earlier operation does not have are not forwarded: at the quad's granularity they wait for
// its result and no longer; their own operands have been here since.
TEST_F(HazardsTest, ForwardingCoversThePixelsOfTheEarlierOperation) {
    std::vector<Fragment> spread;
    for (int i = 0; i < kCount; ++i)
        spread.push_back(fragment_at(i % 2, i / 2 % 2, 0.5f, static_cast<std::uint32_t>(i)));
    expect_about(each(spread, {"rop.forwarding=result"}), kBlend);
    expect_about(each(spread, {"rop.forwarding=result", "rop.interlock=pixel"}), kBlend / 4);
}

// Every earlier quad of the tile must be written first.
TEST_F(HazardsTest, ATileInterlockSerialisesTheTile) {
    const double alone = kBlend + kWrite + 4;
    expect_about(each(in_turn(16), {"rop.interlock=quad"}), 1);
    expect_about(each(in_turn(16), {"rop.interlock=tile"}), alone);
    expect_about(each(in_turn(16), {"rop.interlock=tile", "rop.forwarding=result"}), alone);
    std::vector<Fragment> tiles;  // one quad of each of four tiles in turn
    for (int i = 0; i < kCount; ++i)
        tiles.push_back(fragment_at(i % 2 * 8, i / 2 % 2 * 8, 0.5f, static_cast<std::uint32_t>(i)));
    expect_about(each(tiles, {"rop.interlock=tile"}, 16), alone / 4);
}

// Tags pass lines as fast as they are written, so nothing is joined until results are held up together; what
// is joined then saves cycles and changes nothing else. The twin says that they are the right ones.
TEST_F(HazardsTest, ResultsHeldUpTogetherShareTheWritesOfTheirLines) {
    std::vector<Fragment> fragments;
    for (int i = 0; i < kCount; ++i)
        fragments.push_back(fragment_at(i % 32 * 2, i / 32 % 32 * 2, 0.5f, static_cast<std::uint32_t>(i)));
    const auto joining = [&](const std::string& technique, int lines) {
        return run_on_one(
            fragments, technique,
            {"layout.elements=planar", "cache.kibibytes=4", fmt::format("rop.write_coalescing={}", lines)},
            64);
    };
    const Outcome without = joining("stochastic:samples=8", 0);
    const Outcome with = joining("stochastic:samples=8", 8);
    EXPECT_EQ(without.joined, 0);
    EXPECT_GT(with.joined, 100);
    EXPECT_LT(with.cycles, without.cycles);
    // One line a quad: there is never a queue.
    EXPECT_EQ(joining("alpha_blend", 8).joined, 0);
}

}  // namespace
}  // namespace ropsim
