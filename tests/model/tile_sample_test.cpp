// Samples of a frame: what they estimate, how sure they are of it, and what is refused.
#include "model/tile_sample.h"

#include "base/random.h"
#include "model/cached_machine.h"
#include "model/tile_sample_squares.h"
#include "tests/model/machine_driver.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace ropsim {
namespace {

class TileSampleTest : public ModelTest {
 protected:
    std::string write_scene(int width, int height, int layers) const {
        return write_layers({.width = width, .height = height, .layers = layers, .cell = 24});
    }
    static TileSample sampled(const std::string& path, const std::string& technique, double percent,
                              std::uint64_t seed, SampledFidelity fidelity, const Settings& settings = {}) {
        TraceReader trace(path);
        const MachineConfig config = configured(settings);
        const auto operation = operation_for(technique, trace.header());
        Frame frame(trace, *operation, config, 1, true);
        return sample_frame(frame, trace, config, percent, seed, fidelity);
    }
    static double cached_bytes(const std::string& path, const std::string& technique) {
        TraceReader trace(path);
        const MachineConfig config = configured();
        const auto operation = operation_for(technique, trace.header());
        Frame frame(trace, *operation, config, 1, true);
        const MachineResult result = run_cached_machine(frame, config, 1);
        double bytes = 0;
        for (const auto& causes : result.pins)
            for (const CauseBytes& cause : causes) bytes += static_cast<double>(cause.read + cause.write);
        return bytes;
    }
};

TEST(StudentT, IsTheTablesQuantile) {
    EXPECT_NEAR(student_t_975(3), 3.182, 0.04);
    EXPECT_NEAR(student_t_975(5), 2.571, 0.01);
    EXPECT_NEAR(student_t_975(10), 2.228, 0.001);
    EXPECT_NEAR(student_t_975(30), 2.042, 0.001);
    EXPECT_NEAR(student_t_975(1e6), 1.960, 0.001);
}

TEST_F(TileSampleTest, PlansWholePartitionsAtRandom) {
    const std::string path = write_scene(640, 360, 1);
    TraceReader trace(path);
    const MachineConfig config = configured();
    const auto operation = operation_for("alpha_blend", trace.header());
    const Frame frame(trace, *operation, config, 1, true);
    const std::vector<std::uint64_t> many(trace.tile_fragments().size(), 1000);
    std::vector<int> chosen(8);
    for (std::uint64_t seed = 0; seed < 800; ++seed) {
        const SamplePlan plan = plan_sample(frame.surfaces(), many, config, 5, seed);
        ASSERT_EQ(plan.partitions.size(), 1u);
        EXPECT_DOUBLE_EQ(plan.timed, 0.4);
        ++chosen[static_cast<std::size_t>(plan.partitions[0])];
    }
    // 100 each; 5 standard deviations of a binomial with probability 1/8.
    for (const int times : chosen) EXPECT_NEAR(times, 100, 5 * std::sqrt(800 * 0.125 * 0.875));
    const SamplePlan large = plan_sample(frame.surfaces(), many, config, 50, 1);
    EXPECT_EQ(large.partitions.size(), 8u);
    EXPECT_DOUBLE_EQ(large.timed, 0.5);
    EXPECT_TRUE(
        plan_sample(frame.surfaces(), trace.tile_fragments(), config, 5, 1).whole());  // few fragments
}

TEST_F(TileSampleTest, StretchesBeginAtRandomWithoutOverlap) {
    SamplePlan plan;
    plan.timed = 0.25;
    plan.seed = 3;
    double sum = 0;
    for (std::uint64_t i = 0; i < 400; ++i) {
        const std::uint64_t first = plan.first_quad(2, i);
        EXPECT_GE(first, i * 4 * SamplePlan::kStretch);
        EXPECT_LE(first + SamplePlan::kStretch, (i + 1) * 4 * SamplePlan::kStretch);
        sum += static_cast<double>(first - i * 4 * SamplePlan::kStretch) / (3.0 * SamplePlan::kStretch);
    }
    EXPECT_NEAR(sum / 400, 0.5, 5 * std::sqrt(1.0 / 12 / 400));
    EXPECT_NE(plan.first_quad(2, 7), plan.first_quad(3, 7));
}

// What depends on a square's fragments and tiles alone is known without error.
TEST_F(TileSampleTest, FitsWhatIsKnownExactly) {
    const std::string path = write_scene(640, 360, 5);
    TraceReader trace(path);
    const MachineConfig config = configured();
    const auto operation = operation_for("alpha_blend", trace.header());
    const Frame frame(trace, *operation, config, 1, true);
    const SampleSquares squares(frame.surfaces(), trace, config.partition_tiles, {1, 6});
    std::vector<double> values(squares.size());
    double truth = 0;
    for (std::size_t tile = 0; tile < trace.tile_fragments().size(); ++tile) {
        const auto n = static_cast<double>(trace.tile_fragments()[tile]);
        const double value = 3 * n + (n > 0 ? 100 : 0);
        values[squares.square_of(tile)] += value;
        truth += value;
    }
    const Estimate e = squares.total(values);
    EXPECT_NEAR(e.value, truth, 1e-9 * truth);
    EXPECT_NEAR(e.high - e.low, 0, 1e-6 * truth);
}

// Independent noise by square: the interval holds the truth in 95 of 100 samples, and is no wider than it
// must be.
TEST_F(TileSampleTest, IntervalOfNoiseHolds) {
    const std::string path = write_scene(1280, 720, 1);
    TraceReader trace(path);
    const MachineConfig config = configured();
    const auto operation = operation_for("alpha_blend", trace.header());
    const Frame frame(trace, *operation, config, 1, true);
    int covered = 0;
    double width = 0;
    double squares_of_errors = 0;
    constexpr int kTrials = 200;
    for (int t = 0; t < kTrials; ++t) {
        const SampleSquares squares(frame.surfaces(), trace, config.partition_tiles, {t % 8});
        std::vector<double> values(squares.size());
        double truth = 0;
        for (std::size_t s = 0; s < values.size(); ++s) {
            values[s] =
                1000 + 100 * random_unit(static_cast<std::uint64_t>(t), static_cast<std::uint32_t>(s));
            truth += values[s];
        }
        const Estimate e = squares.total(values);
        covered += e.covers(truth) ? 1 : 0;
        width += (e.high - e.low) / 2 / kTrials;
        squares_of_errors += (e.value - truth) * (e.value - truth) / kTrials;
    }
    EXPECT_GE(covered, 0.95 * kTrials - 4 * std::sqrt(kTrials * 0.95 * 0.05));
    EXPECT_LT(width, 3 * std::sqrt(squares_of_errors));
}

TEST_F(TileSampleTest, CachedBytesAreCovered) {
    const std::string path = write_scene(640, 360, 6);
    const double truth = cached_bytes(path, "adaptive:nodes=4");
    std::set<int> partitions;
    int covered = 0;
    for (std::uint64_t seed = 0; seed < 16; ++seed) {
        const TileSample sample = sampled(path, "adaptive:nodes=4", 5, seed, SampledFidelity::kCached);
        partitions.insert(sample.plan.partitions[0]);
        const Estimate bytes = sample.pin_bytes();
        EXPECT_NEAR(bytes.value, truth, 0.05 * truth) << "seed " << seed;
        covered += bytes.covers(truth) ? 1 : 0;
    }
    EXPECT_GE(covered, 12);  // of 16: fewer happen in 1 of 100,000 where 95 % are covered
    EXPECT_GE(partitions.size(), 4u);
}

// Texels come from all partitions' channels; a sample's own quads stand for those of the others.
TEST_F(TileSampleTest, TexelsAreCountedToo) {
    TraceHeader header = plain_header(320, 192);
    header.draws[0].full = {16, 2, 16};
    std::vector<Fragment> fragments;
    for (std::uint32_t layer = 0; layer < 3; ++layer)
        for (int y = 0; y < header.height; ++y)
            for (int x = 0; x < header.width; ++x)
                fragments.push_back(fragment_at(
                    x, y, 0.5f, layer * 1000000 + static_cast<std::uint32_t>(y / 2 * 1000 + x / 2)));
    const std::string path = write(header, fragments);
    const double truth = cached_bytes(path, "alpha_blend");
    const TileSample sample = sampled(path, "alpha_blend", 10, 3, SampledFidelity::kCached);
    EXPECT_LT(sample.plan.partitions.size(), 8u);
    EXPECT_NEAR(sample.pin_bytes().value, truth, 0.25 * truth);
}

// All partitions: nothing is left to be estimated.
TEST_F(TileSampleTest, SampleOfEverythingIsExact) {
    const std::string path = write_scene(320, 200, 4);
    const double truth = cached_bytes(path, "alpha_blend");
    const TileSample sample = sampled(path, "alpha_blend", 60, 1, SampledFidelity::kCached);
    ASSERT_EQ(sample.plan.partitions.size(), 8u);
    const Estimate bytes = sample.pin_bytes();
    EXPECT_NEAR(bytes.value, truth, 1e-9 * truth);
    EXPECT_NEAR(bytes.low, truth, 1e-9 * truth);
}

TEST_F(TileSampleTest, KeptFragmentsAreThoseOfTheTrace) {
    const std::string path = write_scene(640, 360, 3);
    TraceReader trace(path);
    std::vector<std::uint8_t> tiles(trace.tile_fragments().size());
    for (std::size_t t = 0; t < tiles.size(); t += 5) tiles[t] = 1;
    trace.select_tiles(tiles);
    std::vector<std::vector<std::pair<int, int>>> passes;
    std::vector<std::uint64_t> decoded;
    for (int pass = 0; pass < 3; ++pass) {
        trace.rewind();
        passes.emplace_back();
        FragmentChunk chunk;
        while (trace.next(chunk))
            for (const Fragment& f : chunk.fragments) passes.back().emplace_back(f.x, f.y);
        decoded.push_back(trace.decoded_blocks());
    }
    EXPECT_FALSE(passes[0].empty());
    EXPECT_EQ(passes[1], passes[0]);
    EXPECT_EQ(passes[2], passes[0]);
    EXPECT_GT(decoded[0], 0u);
    EXPECT_EQ(decoded[2], decoded[0]);
    // Other tiles are decoded anew.
    std::rotate(tiles.begin(), tiles.begin() + 1, tiles.end());
    trace.select_tiles(tiles);
    trace.rewind();
    FragmentChunk chunk;
    ASSERT_TRUE(trace.next(chunk));
    EXPECT_GT(trace.decoded_blocks(), decoded[0]);
}

// In time, too: stretches of a partition, in a process of its own as every timed run.
TEST_F(TileSampleTest, TimedSampleComesNearTheWhole) {
    const std::string path = write_scene(640, 400, 2);
    const nlohmann::json sample = run(path, "adaptive:nodes=4", {"rop.partitions=4"},
                                      {"--sample-tiles", "10%", "--seed", "2"}, "sample");
    const nlohmann::json four = run(path, "adaptive:nodes=4", {"rop.partitions=4"}, {}, "four");
    ASSERT_FALSE(sample.is_null() || four.is_null());
    EXPECT_GT(sample["sample"]["stretches"], 4);
    const double truth = four["cycles"];
    EXPECT_NEAR(sample["cycles"]["value"], truth, 0.08 * truth);
    EXPECT_LE(sample["cycles"]["ci95"][0], truth);
    EXPECT_GE(sample["cycles"]["ci95"][1], truth);
    const double bytes = four["traffic"]["total"]["pin_read_bytes"];
    EXPECT_NEAR(sample["traffic"]["total"]["pin_read_bytes"]["value"], bytes, 0.05 * bytes);
    // What is known stays a plain number, what a sample cannot tell is null.
    EXPECT_EQ(sample["fragments"]["input"], four["fragments"]["input"]);
    EXPECT_EQ(sample["storage_bits_per_pixel"], four["storage_bits_per_pixel"]);
    EXPECT_TRUE(sample["error"]["rmse8"].contains("ci95"));
    EXPECT_TRUE(sample["error"]["ssim"].is_null());
    EXPECT_TRUE(sample["traffic_by_draw"].is_null());
    EXPECT_TRUE(sample["host"]["seconds"].is_number());
}

// In `compare`, too, where an estimate is told from a number.
TEST_F(TileSampleTest, ComparesSamples) {
    const std::string path = write_scene(640, 400, 2);
    const ProgramResult result =
        run_program({"compare", path, "--technique", "alpha_blend", "--fidelity", "cached", "--set",
                     "rop.partitions=4", "--sample-tiles", "10%", "-o", this->path("compared")});
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_NE(result.out.find("alpha_blend: estimated from "), std::string::npos) << result.out;
    EXPECT_NE(result.out.find(" % of the fragments; with 95 % confidence bytes read "), std::string::npos)
        << result.out;
}

TEST_F(TileSampleTest, RefusesWhatIsNoPercentage) {
    const std::string path = write_scene(64, 64, 1);
    for (const std::string wrong : {"0", "-1", "101%", "five", "5%%", "nan", ""}) {
        const ProgramResult result = run_program(
            {"run", path, "--technique", "alpha_blend", "--sample-tiles", wrong, "-o", this->path("out")});
        EXPECT_EQ(result.status, 1) << wrong;
        EXPECT_NE(result.err.find("--sample-tiles: "), std::string::npos) << result.err;
        EXPECT_EQ(std::ranges::count(result.err, '\n'), 1) << result.err;
    }
}

}  // namespace
}  // namespace ropsim
