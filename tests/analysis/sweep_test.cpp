// Sweeps: which points there are, what is not run again, rows and the picture, with a shell script for the
// program.
#include "analysis/sweep.h"

#include "base/atomic_file.h"
#include "base/error.h"
#include "tests/traces/scratch.h"
#include "traces/generators.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

class SweepRuns : public ScratchTest {
 protected:
    void SetUp() override {
        ScratchTest::SetUp();
        write_trace_of("one.trace", 1);
        // Plays `ropsim run TRACE --technique T ... --set key=value ... -o DIR --threads N`: 1000 cycles over
        // the KiB. A line in the log for each run.
        write_file(path("fake"), R"(#!/bin/sh
here=$(dirname "$0")
echo "$*" >> "$here/log"
kibibytes=16
ways=4
while [ $# -gt 0 ]; do
  case "$1" in
  --set) case "$2" in cache.kibibytes=*) kibibytes=${2#*=};; cache.ways=*) ways=${2#*=};; esac; shift;;
  -o) out=$2; shift;;
  esac
  shift
done
[ -e "$here/broken" ] && { echo "ropsim: --set: no $ways ways today" >&2; exit 1; }
mkdir -p "$out"
echo image > "$out/image.exr"
echo "{\"cycles\": $((1000 / kibibytes)), \"seconds\": 1e-6, \"bottleneck\": \"one, two\", \"traffic\": {\"total\": {
  \"pin_read_bytes\": $((ways * 100)), \"pin_write_bytes\": 5}}, \"error\": {\"rmse8\": 2.5}}" > "$out/run.json"
)");
        std::filesystem::permissions(path("fake"), std::filesystem::perms::owner_all);
        options_.program = path("fake");
        options_.directory = path("out");
        options_.traces = {path("one.trace")};
        options_.techniques = {"alpha_blend", "slab:layers=4,bits=8"};
        options_.settings = {"cache.kibibytes=8,16", "cache.ways=2,4", "rop.lanes=4"};
    }
    void write_trace_of(const std::string& name, std::uint64_t seed) const {
        RandomFragments options;
        options.count = 10;
        options.width = 20;
        options.height = 10;
        options.seed = seed;
        write_trace(path(name), random_header(options), random_fragments(options));
    }
    // Runs since the last call.
    std::size_t runs() {
        const std::string log = std::filesystem::exists(path("log")) ? read_file(path("log")) : "";
        const auto lines = static_cast<std::size_t>(std::count(log.begin(), log.end(), '\n'));
        std::filesystem::remove(path("log"));
        return lines;
    }
    SweepOptions options_;
};

TEST_F(SweepRuns, EveryCombinationIsAPoint) {
    const Sweep sweep = run_sweep(options_);
    EXPECT_EQ(runs(), 8u);
    ASSERT_EQ(sweep.points.size(), 8u);
    EXPECT_THAT(sweep.points[0].values, ElementsAre(path("one.trace"), "alpha_blend", "8", "2", "4"));
    EXPECT_THAT(sweep.points[1].values, ElementsAre(path("one.trace"), "alpha_blend", "8", "4", "4"));
    EXPECT_THAT(sweep.points[6].values,
                ElementsAre(path("one.trace"), "slab:layers=4,bits=8", "16", "2", "4"));
    std::set<std::vector<std::string>> different;
    std::set<std::string> directories;
    for (const SweepPoint& point : sweep.points) {
        different.insert(point.values);
        directories.insert(point.run.directory);
        EXPECT_EQ(point.run.cycles, point.values[2] == "8" ? 125 : 62);
        EXPECT_EQ(point.run.total.pin_read, point.values[3] == "2" ? 200 : 400);
        EXPECT_FALSE(std::filesystem::exists(point.run.directory + "/image.exr"));
    }
    EXPECT_EQ(different.size(), 8u);
    EXPECT_EQ(directories.size(), 8u);
}

TEST_F(SweepRuns, WhatIsThereIsNotRunAgain) {
    const std::string csv = sweep_csv(run_sweep(options_));
    EXPECT_EQ(runs(), 8u);
    // The same again, in another order: nothing to do.
    std::reverse(options_.settings.begin(), options_.settings.end());
    EXPECT_EQ(run_sweep(options_).points.size(), 8u);
    EXPECT_EQ(runs(), 0u);
    std::reverse(options_.settings.begin(), options_.settings.end());
    EXPECT_EQ(sweep_csv(run_sweep(options_)), csv);
    // More values: only theirs.
    options_.settings[0] = "cache.kibibytes=8,16,32";
    EXPECT_EQ(run_sweep(options_).points.size(), 12u);
    EXPECT_EQ(runs(), 4u);
    // A point that was cut short, or is damaged.
    Sweep sweep = run_sweep(options_);
    std::filesystem::remove(sweep.points[3].run.directory + "/run.json");
    write_file(sweep.points[5].run.directory + "/run.json", "{\"cycles\": 1");
    EXPECT_EQ(run_sweep(options_).points[5].run.cycles, sweep.points[5].run.cycles);
    EXPECT_EQ(runs(), 2u);
    // Another trace under the same name, another seed.
    write_trace_of("one.trace", 2);
    run_sweep(options_);
    EXPECT_EQ(runs(), 12u);
    options_.choices = {{"--seed", "7"}};
    run_sweep(options_);
    EXPECT_EQ(runs(), 12u);
}

TEST_F(SweepRuns, AHardwareFileIsKnownByWhatItSays) {
    options_.settings.clear();
    options_.choices = {{"--hardware", path("part.toml") + ",mobile"}};
    write_file(path("part.toml"), "[cache]\nkibibytes = 8\n");
    EXPECT_EQ(run_sweep(options_).points.size(), 4u);
    EXPECT_EQ(runs(), 4u);
    write_file(path("part.toml"), "[cache]\nkibibytes = 4\n");
    run_sweep(options_);
    EXPECT_EQ(runs(), 2u);
}

TEST_F(SweepRuns, AFailureIsARowAndTriedAgain) {
    write_file(path("broken"), "");
    const Sweep broken = run_sweep(options_);
    EXPECT_THAT(sweep_table(broken), HasSubstr("alpha_blend  8  2  --set: no 2 ways today"));
    EXPECT_THAT(sweep_csv(broken), HasSubstr("no 2 ways today"));
    EXPECT_FALSE(has_plot(broken));
    std::filesystem::remove(path("broken"));
    runs();
    run_sweep(options_);
    EXPECT_EQ(runs(), 8u);
}

TEST_F(SweepRuns, RowsHoldAxesAndResults) {
    const Sweep sweep = run_sweep(options_);
    const std::string csv = sweep_csv(sweep);
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 9);
    EXPECT_THAT(csv, testing::StartsWith(
                         "trace,technique,cache.kibibytes,cache.ways,rop.lanes,cycles,seconds,pin_bytes,"
                         "pin_read_bytes,pin_write_bytes,"));
    EXPECT_THAT(
        csv, HasSubstr(path("one.trace") + ",\"slab:layers=4,bits=8\",16,2,4,62,1e-06,205,200,5,,,,,,2.5,,,,"
                                           "\"one, two\",,"));
    const std::string table = sweep_table(sweep);
    EXPECT_THAT(table, HasSubstr("technique"));
    EXPECT_THAT(table, Not(HasSubstr("rop.lanes")));
    EXPECT_THAT(table, Not(HasSubstr("trace")));
}

TEST_F(SweepRuns, ThePictureHasALineForEachOtherCombination) {
    const Sweep sweep = run_sweep(options_);
    EXPECT_EQ(plotted_axis(sweep), 2u);
    ASSERT_TRUE(has_plot(sweep));
    const std::string script = sweep_plot_script(sweep, "a.svg", "a.png");
    // Two rows, four lines, drawn twice.
    const auto occurrences = [&](const std::string& text) {
        std::size_t count = 0;
        for (std::size_t at = script.find(text); at != std::string::npos; at = script.find(text, at + 1))
            ++count;
        return count;
    };
    EXPECT_EQ(occurrences("<< EOD"), 16u);
    EXPECT_EQ(occurrences("'alpha_blend, cache.ways=2'"), 2u);
    EXPECT_THAT(script, HasSubstr("8 0.000125\n16 6.2e-05\n"));
    write_sweep_plot(sweep, options_.directory);
    EXPECT_THAT(read_file(path("out/sweep.png")), testing::StartsWith("\x89PNG\r\n"));
}

TEST_F(SweepRuns, WrongValuesAreRefusedBeforeTheRuns) {
    const auto refused = [&](const SweepOptions& options, const std::string& why) {
        try {
            run_sweep(options);
            ADD_FAILURE() << why;
        } catch (const UserError& error) {
            EXPECT_THAT(std::string(error.where()) + ": " + error.what(), HasSubstr(why));
        }
    };
    SweepOptions wrong = options_;
    wrong.settings = {"cache.kibibytes=8,,16"};
    refused(wrong, "empty value");
    wrong.settings = {"cache.kibibytes=8,8"};
    refused(wrong, "'8' twice");
    wrong.settings = {"cache.kibibytes=8", "cache.kibibytes=16"};
    refused(wrong, "given twice");
    wrong.settings = {"cache.kibibytes"};
    refused(wrong, "key=value");
    wrong.settings = {"cache.kilobytes=8,16"};
    refused(wrong, "cache.kilobytes");
    wrong = options_;
    wrong.techniques = {"alpha_blend", "alpha_blend"};
    refused(wrong, "twice");
    wrong.techniques = {"alpha_blond"};
    refused(wrong, "alpha_blond");
    EXPECT_EQ(runs(), 0u);
}

}  // namespace
}  // namespace ropsim
