// Error against bytes: the Pareto front, figures of runs played by a shell script, tables and the picture.
#include "analysis/tradeoff.h"

#include "analysis/pareto_front.h"
#include "analysis/standard_techniques.h"
#include "analysis/tradeoff_output.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "tests/traces/scratch.h"
#include "traces/generators.h"

#include <cstdlib>
#include <filesystem>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

// The definition, point by point.
std::vector<bool> front_by_definition(const std::vector<CostAndError>& points) {
    std::vector<bool> front;
    for (const CostAndError& p : points) {
        bool beaten = false;
        for (const CostAndError& q : points)
            beaten =
                beaten || (q.cost <= p.cost && q.error <= p.error && (q.cost < p.cost || q.error < p.error));
        front.push_back(!beaten);
    }
    return front;
}

TEST(ParetoFront, IsThatOfTheDefinition) {
    std::mt19937 random(7);
    for (int round = 0; round < 400; ++round) {
        std::vector<CostAndError> points(random() % 30);
        // Few values: many ties in one quantity and in both.
        for (CostAndError& p : points)
            p = {static_cast<double>(random() % 8), static_cast<double>(random() % 8)};
        EXPECT_EQ(pareto_front(points), front_by_definition(points)) << "round " << round;
    }
    EXPECT_TRUE(pareto_front({}).empty());
}

TEST(ParetoFront, ByHand) {
    const std::vector<CostAndError> points{{10, 5}, {20, 5}, {10, 6}, {30, 1}, {40, 0}, {40, 0}, {50, 0}};
    EXPECT_THAT(pareto_front(points), ElementsAre(true, false, false, true, true, true, false));
}

class TradeoffRuns : public ScratchTest {
 protected:
    void SetUp() override {
        ScratchTest::SetUp();
        ASSERT_EQ(setenv("XDG_CACHE_HOME", path("").c_str(), 1), 0);
        RandomFragments options;
        options.count = 10;
        options.width = 20;
        options.height = 10;
        write_trace(path("one.trace"), random_header(options), random_fragments(options));
        options.samples = 4;
        write_trace(path("four.trace"), random_header(options), random_fragments(options));
        // Plays `ropsim run TRACE --technique T ... -o DIR --threads N`.
        write_file(path("fake"), R"(#!/bin/sh
trace=$2
technique=$4
arguments="$*"
while [ "$1" != -o ]; do shift; done
case "$technique $trace" in
*four.trace) echo "ropsim: technique 'x': works on one sample a pixel" >&2; exit 1;;
esac
mkdir -p "$2"
echo image > "$2/image.exr"
echo "$arguments" > "$2/arguments"
case $technique in
a_buffer) numbers='"error": {"rmse8": 0, "rmse8_covered": 0}, "storage_bits_per_pixel": 32,
  "pool": {"nodes_used": 400, "nodes_overflowed": 3, "node_bytes": 12}'; bytes=900;;
weighted_blended) numbers='"error": {"rmse8": 8, "rmse8_covered": 9}, "storage_bits_per_pixel": 64'; bytes=100;;
*) numbers='"error": {"rmse8": 8, "rmse8_covered": 9}, "storage_bits_per_pixel": 512'; bytes=200;;
esac
echo "{\"trace\": {\"width\": 20, \"height\": 10, \"fragments\": 10}, $numbers, \"traffic\": {\"total\": {
  \"read_bytes\": $bytes, \"write_bytes\": 50, \"worst_case_read_bytes\": 1000,
  \"worst_case_write_bytes\": $bytes, \"pin_read_bytes\": $((1000 - bytes))}}}" > "$2/run.json"
)");
        std::filesystem::permissions(path("fake"), std::filesystem::perms::owner_all);
        options_.program = path("fake");
        options_.directory = path("out");
        options_.traces = {path("one.trace")};
        options_.techniques = {"weighted_blended", "slab:layers=4", "a_buffer"};
    }
    TradeoffOptions options_;
};

TEST_F(TradeoffRuns, FiguresAreAFragmentOfTheTrace) {
    options_.run_options = {"--seed", "3"};
    const Tradeoff tradeoff = run_tradeoff(options_);
    ASSERT_EQ(tradeoff.scenes.size(), 1u);
    EXPECT_EQ(tradeoff.scenes[0].name, "one");
    ASSERT_EQ(tradeoff.techniques.size(), 3u);
    const TradeoffPoint& blend = tradeoff.techniques[0].at[0];
    EXPECT_EQ(blend.failure, "");
    EXPECT_EQ(blend.touched, 15);
    EXPECT_EQ(blend.worst_case, 110);
    EXPECT_EQ(blend.rmse8, 8);
    EXPECT_EQ(blend.storage_bits, 64);
    EXPECT_FALSE(blend.node_bits || blend.pool_bits || blend.dropped);
    const TradeoffPoint& lists = tradeoff.techniques[2].at[0];
    EXPECT_EQ(lists.node_bits, 96);
    EXPECT_EQ(lists.pool_bits, 400 * 96 / 200.0);
    EXPECT_EQ(lists.dropped, 3);
    // As much error as blending for more bytes is off the front; none at all for the most is on it.
    EXPECT_TRUE(blend.front);
    EXPECT_FALSE(tradeoff.techniques[1].at[0].front);
    EXPECT_TRUE(lists.front);
    // Lists apart, blending alone is not beaten.
    EXPECT_TRUE(blend.fixed_front);
    EXPECT_FALSE(tradeoff.techniques[1].at[0].fixed_front);
    EXPECT_FALSE(lists.fixed_front);
    EXPECT_TRUE(std::filesystem::exists(path("out/runs/a_buffer/run.json")));
    EXPECT_FALSE(std::filesystem::exists(path("out/runs/a_buffer/image.exr")));
    options_.keep_images = true;
    run_tradeoff(options_);
    EXPECT_TRUE(std::filesystem::exists(path("out/runs/a_buffer/image.exr")));
}

// By the bytes on the pins, of which the lists have the fewest here, they alone are on the front.
TEST_F(TradeoffRuns, TheFrontIsThatOfTheBytesAskedFor) {
    options_.bytes = TradeoffBytes::kPins;
    Tradeoff tradeoff = run_tradeoff(options_);
    EXPECT_EQ(tradeoff.techniques[2].at[0].pins, 10);
    EXPECT_TRUE(tradeoff.techniques[2].at[0].front);
    EXPECT_FALSE(tradeoff.techniques[0].at[0].front);
    EXPECT_TRUE(tradeoff.techniques[1].at[0].fixed_front);
    EXPECT_THAT(tradeoff_markdown(tradeoff), HasSubstr("| *8.000* | *80.0* |"));
    EXPECT_THAT(read_file(path("out/runs/a_buffer/arguments")), HasSubstr("--fidelity cached"));
    EXPECT_THAT(tradeoff_markdown(tradeoff), HasSubstr("one pins, B/fragment"));
    EXPECT_THAT(tradeoff_markdown(tradeoff), HasSubstr("| **0.000** | **10.0** |"));
    EXPECT_THAT(tradeoff_plot_script(tradeoff, "a.svg", "a.png"), HasSubstr("DRAM pins"));
    options_.bytes = TradeoffBytes::kWorstCase;
    tradeoff = run_tradeoff(options_);
    EXPECT_THAT(read_file(path("out/runs/a_buffer/arguments")), HasSubstr("--fidelity count"));
    EXPECT_TRUE(tradeoff.techniques[0].at[0].front);
    EXPECT_THAT(tradeoff_markdown(tradeoff), HasSubstr("| **8.000** | **110.0** |"));
}

TEST_F(TradeoffRuns, TablesSayWhatWasMeasuredAndWhatWasRefused) {
    options_.traces.push_back(path("four.trace"));
    const Tradeoff tradeoff = run_tradeoff(options_);
    const std::string table = tradeoff_markdown(tradeoff);
    EXPECT_THAT(
        table,
        HasSubstr("| technique | storage, bit/px | operation at worst, B/fragment | one RMSE, /255 | one "
                  "touched, B/fragment | four RMSE, /255 | four touched, B/fragment |"));
    EXPECT_THAT(table, HasSubstr("| weighted_blended | 64 | 18 | **8.000** | **15.0** | refused |  |"));
    EXPECT_THAT(table, HasSubstr("| slab:layers=4 | 512 | 64 | 8.000 | 25.0 | refused |  |"));
    // Lists take four samples: this run broke.
    EXPECT_THAT(table, HasSubstr("| a_buffer | 32 + 96/fragment | 20 | **0.000** | **95.0** | failed |  |"));
    EXPECT_THAT(table, HasSubstr("- a_buffer on four, failed: technique 'x': works on one sample a pixel"));
    EXPECT_THAT(table, HasSubstr("- a_buffer on one: the pool was full and dropped 3 fragments"));
    EXPECT_THAT(table, HasSubstr("- slab:layers=4 on four: technique 'x': works on one sample a pixel"));
    const std::string csv = tradeoff_csv(tradeoff);
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 2 * 3);
    EXPECT_THAT(
        csv,
        HasSubstr("\none,a_buffer,\"all fragments: lists, peeling\",20,0,0,95,190,10,32,96,192,3,,1,0,\n"));
    EXPECT_THAT(
        csv,
        HasSubstr("\nfour,weighted_blended,blending and weighted sums,,,,,,,,,,,,0,0,technique 'x': works "
                  "on one sample a pixel\n"));
    const std::string json = tradeoff_json(tradeoff, true);
    EXPECT_THAT(json, HasSubstr("\"why_null\": \"technique 'x': works on one sample a pixel\""));
    EXPECT_EQ(json, tradeoff_json(run_tradeoff(options_), true));
    // The others refuse four samples themselves; lists would take them.
    EXPECT_THAT(broken_runs(tradeoff), ElementsAre("four a_buffer"));
}

// What a technique stores and moves may depend on the spatial samples.
TEST_F(TradeoffRuns, OperationAndStorageAreThoseOfTheScene) {
    write_file(path("fake"), R"(#!/bin/sh
trace=$2
while [ "$1" != -o ]; do shift; done
mkdir -p "$2"
case $trace in *four.trace) bits=2624;; *) bits=640;; esac
echo "{\"trace\": {\"width\": 20, \"height\": 10, \"fragments\": 10}, \"error\": {\"rmse8\": 1},
  \"storage_bits_per_pixel\": $bits, \"traffic\": {\"total\": {\"read_bytes\": 100}}}" > "$2/run.json"
)");
    std::filesystem::permissions(path("fake"), std::filesystem::perms::owner_all);
    options_.techniques = {"a_buffer", "opacity_map:slices=16"};
    options_.traces.push_back(path("four.trace"));
    const Tradeoff tradeoff = run_tradeoff(options_);
    // A plane is 4 bytes, bounds 8, the accumulator 8. Bounds: all read, written. Map: bounds and planes
    // read, planes written. Composite: all read, the accumulator written.
    const std::vector<TradeoffPoint>& map = tradeoff.techniques[1].at;
    const double bytes = 8 + 8 + (8 + 64) + 64 + (8 + 64 + 8) + 8;
    EXPECT_EQ(map[0].operation_bytes, bytes);
    EXPECT_EQ(map[1].operation_bytes, 4 * bytes);
    const std::string table = tradeoff_markdown(tradeoff);
    EXPECT_THAT(table, HasSubstr("| opacity_map:slices=16 | 640 / 2,624 | 240 / 960 |"));
    EXPECT_THAT(table, HasSubstr("| a_buffer | 640 / 2,624 | 20 |"));
    const std::string csv = tradeoff_csv(tradeoff);
    EXPECT_THAT(csv, HasSubstr("one,opacity_map:slices=16,\"maps, series and moments\",240,"));
    EXPECT_THAT(csv, HasSubstr("four,opacity_map:slices=16,\"maps, series and moments\",960,"));
    const nlohmann::json json = nlohmann::json::parse(tradeoff_json(tradeoff, false));
    EXPECT_EQ(json["techniques"][1]["at"][0]["operation_worst_case_bytes_per_fragment"], 240);
    EXPECT_EQ(json["techniques"][1]["at"][1]["operation_worst_case_bytes_per_fragment"], 960);
}

// Paths need not be UTF-8; JSON must.
TEST_F(TradeoffRuns, APathThatIsNotUtf8) {
    std::filesystem::copy_file(path("one.trace"), path("\xff.trace"));
    options_.traces = {path("\xff.trace")};
    const std::string json = tradeoff_json(run_tradeoff(options_), false);
    EXPECT_TRUE(nlohmann::json::accept(json));
    EXPECT_THAT(json, HasSubstr("\uFFFD.trace"));
}

TEST_F(TradeoffRuns, ARunThatFailsWithoutReasonIsBroken) {
    options_.traces = {path("four.trace")};
    options_.techniques = {"stochastic:samples=8", "laine_karras:samples=8"};
    EXPECT_THAT(broken_runs(run_tradeoff(options_)),
                ElementsAre("four stochastic:samples=8", "four laine_karras:samples=8"));
}

TEST_F(TradeoffRuns, WhatCannotRunIsRefusedBeforeTheRuns) {
    const auto refused = [&](const std::vector<std::string>& techniques) -> std::string {
        options_.techniques = techniques;
        try {
            check_tradeoff(options_);
        } catch (const UserError& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_EQ(refused({"a_buffer"}), "");
    EXPECT_THAT(refused({"a_buffer", "a_buffer"}), HasSubstr("given twice"));
    EXPECT_THAT(refused({"nothing"}), testing::StartsWith("unknown technique"));
    EXPECT_THAT(refused({"slab:layers=900"}), HasSubstr("layers"));
    EXPECT_THAT(refused({"shadow_map"}), HasSubstr("no colour image"));
    options_.traces = {path("four.trace")};
    EXPECT_THAT(refused({"a_buffer", "weighted_blended"}), HasSubstr("one sample"));
    options_.traces.push_back(path("one.trace"));  // runs on one of them
    EXPECT_EQ(refused({"weighted_blended"}), "");
    options_.traces = {path("none.trace")};
    EXPECT_THROW(check_tradeoff(options_), UserError);
}

TEST_F(TradeoffRuns, ThePictureNamesTheFront) {
    options_.traces.push_back(path("four.trace"));
    const Tradeoff tradeoff = run_tradeoff(options_);
    ASSERT_TRUE(has_plot(tradeoff));
    const std::string script = tradeoff_plot_script(tradeoff, "a.svg", "a.png");
    EXPECT_THAT(script, HasSubstr("set label 'weighted_blended'"));
    EXPECT_THAT(script, HasSubstr("set label 'a_buffer'"));
    EXPECT_THAT(script, Not(HasSubstr("set label 'slab:layers=4'")));
    EXPECT_THAT(script, HasSubstr("set title 'one  (20\u00d710 pixels, 10 fragments)'"));
    EXPECT_THAT(script, Not(HasSubstr("four")));  // nothing ran there
    EXPECT_THAT(script, HasSubstr("'0' "));       // the error of 0 has a tic of its own on the floor
    write_tradeoff_plot(tradeoff, path("out"));
    EXPECT_THAT(read_file(path("out/tradeoff.png")), testing::StartsWith("\x89PNG\r\n"));
    const std::string svg = read_file(path("out/tradeoff.svg"));
    for (const char* text : {"weighted_blended", "a_buffer", "layers of colour", "none has less of both",
                             "RMSE over all pixels, 8-bit units", "</svg>"})
        EXPECT_TRUE(svg.find(text) != std::string::npos) << text;
    options_.traces = {path("four.trace")};
    options_.techniques = {"stochastic:samples=8"};
    EXPECT_FALSE(has_plot(run_tradeoff(options_)));
}

}  // namespace
}  // namespace ropsim
