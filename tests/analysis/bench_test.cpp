// The benchmark's parts: order of runs, rows from measurements made up, fits, its own traces, output.
#include "analysis/bench/bench.h"

#include "analysis/bench/bench_output.h"
#include "base/atomic_file.h"
#include "tests/traces/scratch.h"
#include "traces/generators.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

BenchRepeat repeat_of(double seconds, Measured cycles, Measured pins) {
    BenchRepeat r;
    r.processor_seconds = seconds;
    r.wall_seconds = 2 * seconds;
    r.calibration_seconds = 0.1;
    r.peak_rss_bytes = 1e6;
    r.cycles = cycles;
    r.pin_bytes = pins;
    return r;
}

BenchCase mode_of(const std::string& mode) {
    BenchCase c;
    c.part = "simulator";
    c.series = c.trace = "t";
    c.technique = "alpha_blend";
    c.mode = mode;
    return c;
}

// Noise that a repeat's runs share falls out of their ratios; errors and intervals by hand.
TEST(BenchSimulator, RowsByHand) {
    std::vector<BenchCase> cases{mode_of("count"), mode_of("cached"), mode_of("timed 5%"), mode_of("timed")};
    const std::vector<double> noise{1, 3, 0.5, 7, 1, 2};
    const std::vector<double> estimates{110, 90, 100, 100, 130, 80};
    for (std::size_t i = 0; i < noise.size(); ++i) {
        cases[0].repeats.push_back(repeat_of(0.5 * noise[i], {}, {}));
        cases[1].repeats.push_back(repeat_of(1 * noise[i], 80, 1000));
        BenchRepeat sample = repeat_of(0.25 * noise[i], estimates[i], 1010);
        sample.cycles_interval = {estimates[i] - 15, estimates[i] + 15};
        sample.pin_interval = {1005, 1015};
        cases[2].repeats.push_back(sample);
        cases[3].repeats.push_back(repeat_of(4 * noise[i], 100, 1000));
    }
    const std::vector<SimulatorRow> rows = simulator_rows(cases);
    ASSERT_EQ(rows.size(), 4u);
    for (const auto& [row, ratio] : {std::pair{0, 0.125}, {1, 0.25}, {2, 0.0625}, {3, 1.0}}) {
        const RankInterval& found = *rows[static_cast<std::size_t>(row)].processor_ratio;
        EXPECT_DOUBLE_EQ(found.low, ratio);
        EXPECT_DOUBLE_EQ(found.high, ratio);
        EXPECT_DOUBLE_EQ(found.confidence, 1 - 2.0 / 64);
    }
    EXPECT_FALSE(rows[0].cycles_rms.has_value());
    EXPECT_FALSE(rows[0].front);
    EXPECT_NEAR(*rows[1].cycles_rms, 0.2, 1e-12);
    EXPECT_EQ(*rows[1].pins_rms, 0);
    EXPECT_NEAR(*rows[2].cycles_rms, std::sqrt((0.01 + 0.01 + 0.09 + 0.04) / 6), 1e-12);
    EXPECT_NEAR(*rows[2].cycles_largest, 0.3, 1e-12);
    EXPECT_NEAR(*rows[2].pins_largest, 0.01, 1e-12);
    EXPECT_EQ(rows[2].intervals, 6);
    EXPECT_EQ(rows[2].cycles_held, 4);
    EXPECT_EQ(rows[2].pins_held, 0);
    EXPECT_FALSE(rows[1].front);  // the sample is faster and less wrong
    EXPECT_TRUE(rows[2].front);
    EXPECT_TRUE(rows[3].front);
}

TEST(BenchScaling, FitsPowerLawsOfEachLine) {
    std::vector<BenchCase> cases;
    for (const auto& [technique, exponent] : {std::pair{"a", 1.0}, {"b", 0.5}, {"c", 0.0}})
        for (const double x : {1e3, 1e4, 1e5, 1e6}) {
            BenchCase c;
            c.part = "scaling";
            c.series = "fragments";
            c.technique = technique;
            c.mode = "count";
            c.x = x;
            for (int i = 0; i < 3; ++i) c.repeats.push_back(repeat_of(2e-6 * std::pow(x, exponent), {}, {}));
            cases.push_back(c);
        }
    cases[11].repeats.clear();  // one that failed
    const std::vector<ScalingFit> fits = scaling_fits(cases);
    ASSERT_EQ(fits.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) {
        ASSERT_TRUE(fits[i].time.law.has_value());
        EXPECT_NEAR(fits[i].time.law->line.slope, 1 - 0.5 * static_cast<double>(i), 1e-9);
        EXPECT_NEAR(fits[i].time.law->coefficient, 2e-6, 1e-12);
        EXPECT_NEAR(fits[i].memory.law->line.slope, 0, 1e-12);
    }
}

TEST(BenchScaling, ThreadsAreComparedWithOneWithinARepeat) {
    std::vector<BenchCase> cases;
    for (const int threads : {1, 2, 4}) {
        BenchCase c;
        c.part = "scaling";
        c.series = "threads";
        c.mode = "count";
        c.threads = threads;
        for (const double noise : {1.0, 5.0, 2.0}) {
            BenchRepeat r = repeat_of(noise * (1 + 0.1 * (threads - 1)), {}, {});
            r.wall_seconds = noise / threads;
            c.repeats.push_back(r);
        }
        cases.push_back(c);
    }
    const std::vector<ThreadRow> rows = thread_rows(cases);
    ASSERT_EQ(rows.size(), 3u);
    EXPECT_DOUBLE_EQ(rows[2].speed_up.estimate, 4);
    EXPECT_DOUBLE_EQ(rows[2].speed_up.low, 4);
    EXPECT_DOUBLE_EQ(rows[2].processor_ratio.estimate, 1.3);
}

TEST(BenchScaling, EachSeriesVariesOneQuantityAlone) {
    BenchOptions options;
    options.fragments = 50000;
    options.largest = 100000000;
    std::set<std::string> series;
    for (const BenchGroup& group : scaling_groups(options)) {
        ASSERT_FALSE(group.cases.empty()) << group.name;
        const BenchCase& first = group.cases.front();
        series.insert(first.series);
        for (const BenchCase& c : group.cases) {
            const LayeredSize& size = *c.layers;
            EXPECT_EQ(c.fragments, static_cast<double>(size.fragments()));
            if (c.series == "fragments") {
                EXPECT_EQ(size.layers, first.layers->layers);
                EXPECT_EQ(size.image, size.covered);
                EXPECT_EQ(c.x, c.fragments);
            } else if (c.series == "pixels") {
                EXPECT_EQ(size.covered, first.layers->covered);
                EXPECT_EQ(c.x, static_cast<double>(size.image) * size.image);
            } else if (c.series == "depth complexity") {
                EXPECT_NEAR(c.fragments / static_cast<double>(options.fragments), 1, 0.05);
                EXPECT_EQ(size.layers, static_cast<int>(c.x));
                EXPECT_EQ(size.image, size.covered);
            } else {
                EXPECT_EQ(c.trace, first.trace);
            }
        }
        if (first.series == "fragments") {
            EXPECT_NEAR(first.x / 1e5, 1, 0.02);
            EXPECT_EQ(group.cases.size(), first.mode == "timed" ? 3u : 4u);
            if (first.mode == "count") {
                EXPECT_NEAR(group.cases.back().x / 1e8, 1, 0.01);
            }
        }
    }
    EXPECT_THAT(series, ElementsAre("depth complexity", "fragments", "pixels", "threads"));
}

class BenchRuns : public ScratchTest {
 protected:
    void SetUp() override {
        ScratchTest::SetUp();
        // Plays `ropsim run`; logs technique and sample.
        write_file(path("fake"), R"(#!/bin/sh
here=$(dirname "$0")
sample=all
while [ $# -gt 0 ]; do
  case "$1" in
  --technique) technique=$2; shift;;
  --sample-seed) sample=$2; shift;;
  -o) out=$2; shift;;
  esac
  shift
done
echo "$technique $sample" >> "$here/log"
[ "$technique" = broken ] && { echo "ropsim: --technique: not today" >&2; exit 1; }
mkdir -p "$out"
echo '{"cycles": {"value": 7, "ci95": [6, 9]}, "traffic": {"total": {
  "pin_read_bytes": {"value": 10, "ci95": [8, 12]}, "pin_write_bytes": {"value": 5, "ci95": [5, 6]}}},
  "host": {"seconds": 2, "processor_seconds": 1.5, "peak_rss_bytes": 1024}}' > "$out/run.json"
)");
        std::filesystem::permissions(path("fake"), std::filesystem::perms::owner_all);
    }
    std::vector<std::string> log() const {
        std::ifstream file(path("log"));
        std::vector<std::string> lines;
        for (std::string line; std::getline(file, line);) lines.push_back(line);
        return lines;
    }
};

TEST_F(BenchRuns, GoForwardsAndBackwards) {
    std::vector<BenchCase> cases(3);
    cases[0].technique = "a";
    cases[1].technique = "broken";
    cases[2].technique = "c";
    cases[2].sampled = true;
    int finished = 0;
    run_cases(cases, 3, path("fake"), path(""), [&](const BenchCase&) { ++finished; });
    EXPECT_THAT(log(), ElementsAre("a all", "broken all", "c 0", "c 1", "a all", "a all", "c 2"));
    EXPECT_EQ(finished, 9);
    EXPECT_EQ(cases[1].failure, "--technique: not today");
    EXPECT_TRUE(cases[1].repeats.empty());
    ASSERT_EQ(cases[2].repeats.size(), 3u);
    const BenchRepeat& r = cases[2].repeats[0];
    EXPECT_EQ(r.wall_seconds, 2);
    EXPECT_EQ(r.processor_seconds, 1.5);
    EXPECT_EQ(r.peak_rss_bytes, 1024);
    EXPECT_EQ(r.cycles, 7);
    EXPECT_EQ(r.pin_bytes, 15);
    EXPECT_EQ(r.pin_interval->low, 13);
    EXPECT_EQ(r.pin_interval->high, 18);
    EXPECT_GT(r.calibration_seconds, 0);
}

TEST_F(BenchRuns, TracesOfLayersLieInTheCorner) {
    const LayeredSize size{20, 3, 50};
    const std::string file = layered_trace(path(""), size);
    make_layered_trace(file, size);
    const TraceReader reader(file);
    EXPECT_EQ(reader.header().width, 50);
    EXPECT_EQ(reader.header().height, 50);
    EXPECT_EQ(reader.fragment_count(), size.fragments());
    std::vector<int> layers(50 * 50, 0);
    for (const Fragment& f : read_fragments(file)) ++layers[f.y * 50 + f.x];
    for (int y = 0; y < 50; ++y)
        for (int x = 0; x < 50; ++x)
            EXPECT_EQ(layers[static_cast<std::size_t>(y * 50 + x)], x < 20 && y < 20 ? 3 : 0);
}

TEST(BenchOutput, EveryPlotIsARectangle) {
    Bench bench;
    bench.options.repeats = 2;
    BenchCase c = mode_of("timed");
    c.repeats = {repeat_of(1, 100, 10), repeat_of(2, 100, 10)};
    bench.cases.push_back(c);
    c.part = "scaling";
    c.series = "pixels";
    c.x = 64;
    bench.cases.push_back(c);
    bench.simulator = simulator_rows(bench.cases);
    bench.fits = scaling_fits(bench.cases);
    const json out = json::parse(bench_json(bench, {}));
    ASSERT_EQ(out["plots"].size(), 2u);
    for (const json& plot : out["plots"]) {
        EXPECT_FALSE(plot["title"].get<std::string>().empty());
        ASSERT_FALSE(plot["rows"].empty());
        for (const json& row : plot["rows"]) EXPECT_EQ(row.size(), plot["columns"].size());
        for (const char* axis : {"x", "y"}) EXPECT_THAT(plot["columns"], testing::Contains(plot[axis]));
    }
    EXPECT_EQ(out["cases"][0]["repeats"][1]["processor_seconds"], 2);
    EXPECT_TRUE(out["against"].is_null());
    EXPECT_THAT(bench_tables(bench), HasSubstr("t alpha_blend timed"));
    EXPECT_THAT(bench_pictures(bench), ElementsAre("bench-simulator", "bench-scaling"));
}

}  // namespace
}  // namespace ropsim
