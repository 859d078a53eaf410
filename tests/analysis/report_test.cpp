// run.json, table and report from records made by hand.
#include "analysis/report/report.h"

#include "analysis/comparison_table.h"
#include "analysis/html.h"
#include "analysis/report/report_bars.h"
#include "analysis/report/report_pictures.h"
#include "base/atomic_file.h"
#include "base/error.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace ropsim {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr const char* kFull = R"({
  "technique": "slab", "hardware": "desktop", "fidelity": "timed", "seed": 7,
  "trace": {"file": "a.trace", "width": 16, "height": 9, "samples": 1, "fragments": 1000},
  "hardware_parameters": {"rop.lanes": "4", "dram": {"banks": 16}, "dram.device": "\"gddr6\"", "note": "<b>"},
  "technique_parameters": {"layers": "8"}, "passes": 2, "touched_tiles": 12,
  "cycles": 1234567, "seconds": {"value": 0.0025, "ci95": [0.002, 0.003]},
  "storage_bits_per_pixel": 128,
  "traffic": {
    "color": {"worst_case_read_bytes": 8000, "worst_case_write_bytes": 8000, "read_bytes": 4000, "write_bytes": 3000,
              "pin_read_bytes": 500, "pin_write_bytes": 250},
    "nodes": {"read_bytes": 1000, "write_bytes": null},
    "total": {"worst_case_read_bytes": 8000, "worst_case_write_bytes": 8000, "read_bytes": 5000, "write_bytes": 3000,
              "pin_read_bytes": 500, "pin_write_bytes": 250}},
  "stages": {"operation": {"busy": 600, "idle": 100, "stall": {"same_pixel": 250, "cache_miss": 50, "none": 0}}},
  "operation": {"insert": {"count": 900, "latency_cycles": 14, "interval_cycles": 1}, "culled": {"count": 0}},
  "rop_cache": {"hits": 75, "misses": 25},
  "dram": {"row_hits": 60, "row_misses": 30, "row_conflicts": 10, "utilisation": 0.5},
  "error": {"rmse8": 1.5, "rmse8_covered": null, "psnr_db": 44.61, "flip": 0.0123},
  "host": {"seconds": 0.5, "fragments_per_second": 2000000}
})";

RunRecord record_of(const std::string& technique, const std::string& json) {
    RunRecord run;
    run.technique = technique;
    run.command = {"ropsim", "run", "a trace.trace", "--technique", technique, "-o", "out/x"};
    read_run_json(run, json, "run.json");
    return run;
}

RunRecord failed_record(const std::string& technique, const std::string& why) {
    RunRecord run;
    run.technique = technique;
    run.command = {"ropsim", "run"};
    run.failure = why;
    return run;
}

TEST(RunJson, ReadsWhatIsThere) {
    const RunRecord run = record_of("slab", kFull);
    EXPECT_EQ(run.fragments, 1000);
    EXPECT_EQ(run.cycles, 1234567);
    EXPECT_EQ(run.seconds, 0.0025) << "an estimate gives its value";
    EXPECT_EQ(run.rmse8, 1.5);
    EXPECT_FALSE(run.rmse8_covered);
    EXPECT_FALSE(run.ssim);
    ASSERT_EQ(run.surfaces.size(), 2u);
    EXPECT_EQ(run.surfaces[0].pin_write, 250);
    EXPECT_FALSE(run.surfaces[1].write);
    EXPECT_EQ(run.total.read, 5000);
    ASSERT_EQ(run.stages.size(), 1u);
    EXPECT_EQ(run.stages[0].stalls.size(), 2u) << "reasons without cycles are left out";
    EXPECT_EQ(run.configuration.at("rop.lanes"), "4");
    EXPECT_EQ(run.configuration.at("dram.banks"), "16");
    EXPECT_EQ(run.configuration.at("dram.device"), "gddr6");
    EXPECT_EQ(run.configuration.at("technique.layers"), "8");
    EXPECT_EQ(run.configuration.at("fidelity"), "timed");
    EXPECT_EQ(run.configuration.count("touched_tiles"), 0u) << "a result";
    EXPECT_EQ(run.configuration.count("passes"), 0u) << "a result";
    EXPECT_EQ(run.configuration.count("error.rmse8"), 0u);
}

TEST(RunJson, ForgivesWhatIsMissingOrOfAnotherType) {
    for (const char* json :
         {"{}", R"({"trace": null, "traffic": 3, "stages": [], "operation": "x", "error": null})",
          R"({"traffic": {"color": null}, "stages": {"a": 5, "b": {"stall": 1}}})"}) {
        const RunRecord run = record_of("x", json);
        EXPECT_FALSE(run.rmse8);
        EXPECT_FALSE(run.fragments);
        EXPECT_TRUE(run.stages.empty());
        EXPECT_THAT(comparison_table({run}), HasSubstr("x"));
        EXPECT_EQ(traffic_bars({run}), "");
        EXPECT_EQ(stage_bars({run}), "");
    }
    EXPECT_THROW(record_of("x", "[1]"), UserError);
    EXPECT_THROW(record_of("x", "{\"a\": "), UserError);
}

TEST(RunJson, EstimatesSayHowSureTheyAre) {
    const RunRecord run = record_of(
        "x", R"({"cycles": {"value": 53847.2, "ci95": [51312.2, 56364.6]}, "sample": {"timed_share": 0.0962},
                 "traffic": {"total": {"pin_read_bytes": {"value": 2000, "ci95": [1500, 2500]}}}})");
    EXPECT_EQ(*run.cycles, 53847.2);
    EXPECT_EQ(
        run.sample,
        "estimated from 9.6 % of the fragments; with 95 % confidence cycles 51,312 to 56,365, bytes read "
        "1,500 to 2,500");
    EXPECT_THAT(comparison_table({run}), HasSubstr("x: " + run.sample + "\n"));
    EXPECT_EQ(record_of("x", R"({"cycles": 5, "sample": null})").sample, "");
}

TEST(RunJson, NoErrorMeansInfinitePsnr) {
    EXPECT_TRUE(std::isinf(*record_of("x", R"({"error": {"rmse8": 0, "psnr_db": null}})").psnr_db));
    EXPECT_FALSE(record_of("x", R"({"error": {"rmse8": 1, "psnr_db": null}})").psnr_db);
}

TEST(Numbers, AreFormatted) {
    EXPECT_EQ(format_measured(1234567.0, 0, ",", "-"), "1,234,567");
    EXPECT_EQ(format_measured(123456.789, 2, ",", "-"), "123,456.79");
    EXPECT_EQ(format_measured(-1234.5, 1, ",", "-"), "-1,234.5");
    EXPECT_EQ(format_measured(-123456.0, 0, ",", "-"), "-123,456");
    EXPECT_EQ(format_measured(-0.0001, 2, ",", "-"), "0.00");
    EXPECT_EQ(format_measured(999.0, 0, ",", "-"), "999");
    EXPECT_EQ(format_measured({}, 2, ",", "-"), "-");
    EXPECT_EQ(format_measured(std::numeric_limits<double>::infinity(), 2, ",", "-"), "inf");
}

TEST(Table, ColumnsAreAlignedAndFailuresSayWhy) {
    const std::string table = comparison_table(
        {record_of("slab", kFull), failed_record("broken:key=1", "no such key"), record_of("none", "{}")});
    std::vector<std::string> lines;
    std::istringstream stream(table);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    ASSERT_EQ(lines.size(), 6u);
    EXPECT_EQ(lines[1].size(), lines[3].size()) << "headings and numbers end in one column";
    EXPECT_EQ(lines[5].size(), lines[3].size());
    EXPECT_EQ(lines[1].find("RMSE") + 4, lines[3].find("1.500") + 5);
    EXPECT_THAT(lines[3], HasSubstr("1,234,567"));
    EXPECT_THAT(lines[3], HasSubstr("16.00"));  // worst case bytes per fragment
    EXPECT_THAT(lines[3], HasSubstr("8.00"));   // touched
    EXPECT_THAT(lines[3], HasSubstr("0.75"));   // pins
    EXPECT_THAT(lines[3], HasSubstr("2.500"));  // ms
    EXPECT_EQ(lines[4], "broken:key=1  failed: no such key");
}

TEST(Html, Escapes) {
    EXPECT_EQ(html_escape("<a href=\"x\">'&\x01\n"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;\n");
}

TEST(Html, DataUriIsAPng) {
    const std::string uri = data_uri({1, 1, {255, 0, 0}});
    EXPECT_TRUE(uri.starts_with("data:image/png;base64,iVBORw0KGgo")) << uri;
    EXPECT_EQ((uri.size() - 22) % 4, 0u);
}

Image constant(int width, int height, float value) {
    Image image(width, height, {"R", "G", "B"});
    std::fill(image.values.begin(), image.values.end(), value);
    return image;
}

TEST(Pictures, ReduceInLinearLight) {
    Image image = constant(3, 2, 0);
    std::fill_n(image.pixel(0, 0), 3, 1.0f);
    const Picture picture = image_picture(image, {0, 0, 3, 2}, 2);
    EXPECT_EQ(picture.width, 2);
    EXPECT_EQ(picture.height, 1);
    EXPECT_EQ(picture.rgb, (std::vector<std::uint8_t>{137, 137, 137, 0, 0, 0}));  // sRGB of 1/4 is .5371
}

TEST(Pictures, DifferenceIsSignedAroundGreyAndKeepsTheLargest) {
    const Image reference = constant(4, 2, .5f);
    Image image = reference;
    image.pixel(1, 1)[0] += 4 / 255.f;
    image.pixel(0, 0)[0] -= 1 / 255.f;
    image.pixel(3, 0)[2] -= 1.f;
    const Picture picture = difference_picture(image, reference, {0, 0, 4, 2}, 2);
    EXPECT_EQ(picture.rgb, (std::vector<std::uint8_t>{160, 128, 128, 128, 128, 0}));
}

TEST(Pictures, DetailLiesWhereTheErrorIs) {
    const Image reference = constant(640, 360, .5f);
    Image image = reference;
    image.pixel(500, 200)[1] = 1.f;
    const Region detail = detail_region({&image}, reference);
    EXPECT_GT(detail.width, 0);
    EXPECT_TRUE(500 >= detail.x && 500 < detail.x + detail.width && 200 >= detail.y &&
                200 < detail.y + detail.height);
    EXPECT_EQ(detail_region({&reference}, reference).width, 0) << "nothing differs";
    EXPECT_EQ(detail_region({&image}, constant(60, 30, 0)).width, 0) << "too small for a detail";
}

class Report : public testing::Test {
 protected:
    void SetUp() override {
        std::string pattern = testing::TempDir() + "ropsim_report_XXXXXX";
        ASSERT_NE(mkdtemp(pattern.data()), nullptr);
        directory_ = pattern;
        comparison_.name = "<scene>";
        comparison_.trace = "a trace.trace";
        comparison_.hash = "0123456789abcdef";
        comparison_.width = 16;
        comparison_.height = 9;
        comparison_.fragments = 1000;
        comparison_.reference = constant(16, 9, .5f);
    }
    void TearDown() override { std::filesystem::remove_all(directory_); }
    RunRecord with_image(const std::string& technique, const std::string& json) {
        RunRecord run = record_of(technique, json);
        run.directory = (directory_ / std::to_string(count_++)).string();
        std::filesystem::create_directories(run.directory);
        write_exr(run.directory + "/image.exr", constant(16, 9, .25f));
        return run;
    }
    std::filesystem::path directory_;
    ComparisonOfOneTrace comparison_;
    int count_ = 0;
};

std::size_t occurrences(const std::string& text, const std::string& what) {
    std::size_t count = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
    return count;
}

TEST_F(Report, HoldsNumbersPicturesBarsAndCommands) {
    comparison_.runs = {with_image("slab:layers=8", kFull), with_image("adaptive", kFull)};
    const std::string html = report_html({comparison_}, {"A & B"});
    EXPECT_THAT(html, HasSubstr("<title>A &amp; B</title>"));
    EXPECT_THAT(html, HasSubstr("<td>1.500</td>"));
    EXPECT_THAT(html, HasSubstr("<td>1\u202f234\u202f567</td>"));
    EXPECT_THAT(html, HasSubstr("<td>75.0</td>")) << "cache hits";
    EXPECT_THAT(html, HasSubstr("<td>60.0</td>")) << "row hits";
    EXPECT_EQ(occurrences(html, ">data:image/webp;base64,"), 5u)
        << "image and difference of each, one reference, for the viewer";
    EXPECT_EQ(occurrences(html, "src=\"data:image/webp;base64,"), 3u) << "a card each, one of the reference";
    EXPECT_THAT(html, HasSubstr("ropsim run &#39;a trace.trace&#39; --technique slab:layers=8 -o out/x"));
    EXPECT_THAT(html, HasSubstr("title=\"stall, same_pixel: 250 cycles, 25.0%\""));
    EXPECT_THAT(html, HasSubstr("style=\"width:60.000%\" title=\"busy: 600 cycles, 60.0%\""));
    EXPECT_THAT(html, HasSubstr("title=\"color: 4.00 B read, 3.00 B written per fragment\""));
    EXPECT_THAT(html, HasSubstr("<dt>rop.lanes</dt><dd>4</dd>"));
    EXPECT_THAT(html, HasSubstr(">insert</td><td>900</td><td>14</td><td>1</td>"));
    EXPECT_THAT(html, Not(HasSubstr("culled"))) << "paths never taken are left out";
}

TEST_F(Report, EscapesEverythingThatComesFromOutside) {
    comparison_.scene = "<script>alert(1)</script>";
    comparison_.runs = {with_image("<i>", kFull), failed_record("bad<", "what's <this>?")};
    const std::string html = report_html({comparison_}, {"<title>"});
    for (const char* raw : {"<script>alert", "<scene>", "<this>", "bad<", "<dd><b>", "\"<i>", "><i>"})
        EXPECT_THAT(html, Not(HasSubstr(raw)));
    EXPECT_THAT(html, HasSubstr("failed: what&#39;s &lt;this&gt;?"));
    EXPECT_THAT(html, HasSubstr("<h1>&lt;title&gt;</h1>"));
}

TEST_F(Report, NeedsNoNetwork) {
    comparison_.runs = {with_image("slab", kFull)};
    const std::string html = report_html({comparison_}, {});
    EXPECT_THAT(html, HasSubstr("content=\"default-src 'none';")) << "the browser refuses everything else";
    for (const char* fetched :
         {"src=\"http", "href=\"http", "url(", "@import", "<script src", "fetch(", "XMLHttp"})
        EXPECT_THAT(html, Not(HasSubstr(fetched)));
}

TEST_F(Report, SurvivesMissingResults) {
    comparison_.runs = {record_of("no_image", kFull), with_image("empty", "{}"),
                        failed_record("failed", "reason")};
    comparison_.runs[0].directory = (directory_ / "nowhere").string();
    const std::string path = (directory_ / "report.html").string();
    write_report({comparison_, comparison_}, {}, path);
    const std::string html = read_file(path);
    EXPECT_THAT(html, HasSubstr("nowhere/image.exr"));
    EXPECT_THAT(html, HasSubstr("failed: reason"));
    EXPECT_THAT(html, HasSubstr("id=\"trace-2\""));
    EXPECT_THAT(html, HasSubstr("href=\"#trace-2\""));
    comparison_.runs = {failed_record("a", "one"), failed_record("b", "two")};
    EXPECT_THAT(report_html({comparison_}, {}), HasSubstr("b: failed: two"));
}

}  // namespace
}  // namespace ropsim
