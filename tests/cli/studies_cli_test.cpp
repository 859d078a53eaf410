// `ropsim tradeoff`, `curve`, `order-sensitivity` and `trace opaque` as a user meets them.
#include "tests/cli/cli_driver.h"

#include <cstdlib>
#include <set>

#include <fmt/format.h>

namespace ropsim {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

class StudiesCli : public Cli {
 protected:
    std::ptrdiff_t files(const std::string& directory) const {
        return std::distance(std::filesystem::directory_iterator(path(directory)),
                             std::filesystem::directory_iterator());
    }
};

TEST_F(StudiesCli, TradeoffWritesTablesAndAPicture) {
    const Arguments arguments = {"tradeoff",    path("trace"),
                                 "--technique", "alpha_blend",
                                 "--technique", "a_buffer",
                                 "--technique", "slab:layers=4,bits=8",
                                 "--seed",      "2",
                                 "-o",          path("out/deep"),
                                 "--threads",   "1"};
    const std::string table = expect_done(arguments);
    EXPECT_THAT(table, HasSubstr("| a_buffer | 32 + 96/fragment |"));
    EXPECT_EQ(files("out/deep"), 6);  // with the directory of the runs
    EXPECT_EQ(read_file(path("out/deep/tradeoff.md")), table);
    EXPECT_THAT(read_file(path("out/deep/tradeoff.png")), ::testing::StartsWith("\x89PNG\r\n"));
    EXPECT_THAT(read_file(path("out/deep/tradeoff.svg")), HasSubstr("</svg>"));
    const std::string text = read_file(path("out/deep/tradeoff.json"));
    const json study = json::parse(text);
    // A run is that of `ropsim run`, its bytes those of run.json.
    const json run = json::parse(read_file(path("out/deep/runs/slab-layers-4-bits-8/run.json")));
    EXPECT_EQ(run["seed"], 2);
    EXPECT_EQ(run["fidelity"], "count");
    const json& at = study["techniques"][2]["at"][0];
    EXPECT_EQ(at["rmse8"], run["error"]["rmse8"]);
    EXPECT_DOUBLE_EQ(at["touched_bytes_per_fragment"].get<double>(), run["bytes_per_fragment"].get<double>());
    EXPECT_EQ(at["storage_bits_per_pixel"], run["storage_bits_per_pixel"]);
    for (const auto& [key, value] : at.items())
        EXPECT_TRUE(key == "scene" || key == "why_null" || study["units"].contains(key)) << key;
    Arguments again = arguments;
    again.back() = "2";
    again.emplace_back("--json");
    EXPECT_EQ(expect_done(again), text);
}

TEST_F(StudiesCli, TradeoffRunsEverythingByDefault) {
    RandomFragments options;
    options.count = 40;
    options.width = options.height = 8;
    write_trace(path("small"), random_header(options), random_fragments(options));
    const json study = expect_json({"tradeoff", path("small"), "--json", "-o", path("out")});
    std::set<std::string> names;
    for (const json& technique : study["techniques"]) {
        const std::string text = technique["technique"];
        names.insert(text.substr(0, text.find(':')));
        // A trace without a camera is the only thing to refuse here.
        const json& reason = technique["at"][0]["why_null"];
        if (!reason.is_null()) {
            EXPECT_THAT(reason.get<std::string>(), HasSubstr("camera")) << text;
        }
    }
    for (const json& technique : expect_json({"list", "techniques", "--json"})) {
        const std::string name = technique["name"];
        // Maps have no colour.
        EXPECT_NE(names.contains(name), name.ends_with("shadow_map")) << name;
    }
}

TEST_F(StudiesCli, OrderSensitivityWritesItsFiles) {
    const Arguments arguments = {
        "order-sensitivity",       path("trace"), "--technique", "alpha_blend", "--technique",
        "a_buffer:format=float32", "--orders",    "3",           "-o",          path("out")};
    const std::string table = expect_done(arguments);
    for (const char* word : {"technique", "near first", "alpha_blend", "raster", "3 random orders"})
        EXPECT_THAT(table, HasSubstr(word));
    EXPECT_EQ(files("out"), 2);
    const json study = json::parse(read_file(path("out/order-sensitivity.json")));
    EXPECT_GT(study["techniques"][0]["rms_sd8"], 1);
    EXPECT_LT(study["techniques"][1]["rms_sd8"], 0.01);
    // Errors are those of runs on reordered traces.
    expect_done(
        {"trace", "order", path("trace"), "--order", "shuffle", "--seed", "2", "-o", path("shuffled")});
    expect_done(
        {"run", path("shuffled"), "--technique", "alpha_blend", "--fidelity", "count", "-o", path("run")});
    const json run = json::parse(read_file(path("run/run.json")));
    EXPECT_NEAR(study["techniques"][0]["rmse8_covered"]["random"][1].get<double>(),
                run["error"]["rmse8_covered"].get<double>(), 1e-6);
}

TEST_F(StudiesCli, CurveWritesItsFiles) {
    const Arguments arguments = {"curve", path("trace"), "--technique", "stochastic:samples=16",
                                 "-o",    path("out")};
    EXPECT_THAT(expect_done(arguments), HasSubstr("stochastic:samples=16"));
    EXPECT_EQ(files("out"), 3);
    const std::string text = read_file(path("out/curve.json"));
    Arguments again = arguments;
    again.emplace_back("--json");
    EXPECT_EQ(expect_done(again), text);
    const json curve = json::parse(text);
    again.insert(again.end(), {"--pixel", fmt::format("{},{}", curve["pixel"]["x"].get<int>(),
                                                      curve["pixel"]["y"].get<int>())});
    EXPECT_EQ(expect_done(again), text);  // the deepest by name
}

TEST_F(StudiesCli, OpaqueLayerBecomesFragments) {
    expect_done({"trace", "opaque", path("trace"), "-o", path("opaque")});
    const json before = expect_json({"trace", "info", path("trace"), "--json"});
    const json after = expect_json({"trace", "info", path("opaque"), "--json"});
    EXPECT_GT(after["fragments"], before["fragments"]);
    expect_done({"reference", path("trace"), "-o", path("a.exr")});
    expect_done({"reference", path("opaque"), "-o", path("b.exr")});
    EXPECT_EQ(expect_json({"diff", path("a.exr"), path("b.exr"), "--json"})["rmse8"], 0);
    expect_refused({"trace", "opaque", path("opaque"), "-o", path("twice"), "--last"}, {"nothing opaque"});
    EXPECT_FALSE(exists("twice"));
}

TEST_F(StudiesCli, WrongInputIsRefusedAndLeavesNothing) {
    for (const char* command : {"tradeoff", "curve", "order-sensitivity"}) {
        expect_refused({command, path("none"), "--technique", "stochastic", "-o", path("out")},
                       {path("none")});
        expect_refused({command, path("trace"), "--technique", "nothing", "-o", path("out")},
                       {"ropsim: --technique: unknown technique 'nothing'"});
        expect_refused({command, path("trace"), "--technique", "stochastic", "--technique", "stochastic",
                        "-o", path("out")},
                       {"'stochastic' is given twice"});
        expect_misused({command, path("trace"), "--technique", "stochastic"});
        write_file(path("file"), "x");
        expect_refused({command, path("trace"), "--technique", "stochastic", "-o", path("file")},
                       {path("file")});
        EXPECT_EQ(read_file(path("file")), "x");
        EXPECT_THAT(expect_done({command, "--help"}), HasSubstr("--technique"));
    }
    expect_refused({"curve", path("trace"), "--pixel", "900,1", "-o", path("out")}, {"--pixel", "outside"});
    expect_refused({"curve", path("trace"), "--technique", "alpha_blend", "-o", path("out")},
                   {"represents no visibility", "stochastic"});
    expect_refused({"tradeoff", path("trace"), "--technique", "shadow_map", "-o", path("out")},
                   {"no colour"});
    expect_misused({"order-sensitivity", path("trace"), "--orders", "1", "-o", path("out")});
    EXPECT_FALSE(exists("out"));
}

TEST_F(StudiesCli, AMissingGnuplotIsMissedBeforeTheRuns) {
    const std::string before = std::getenv("PATH");
    ASSERT_EQ(setenv("PATH", path("empty").c_str(), 1), 0);
    for (const char* command : {"tradeoff", "curve"})
        expect_refused({command, path("trace"), "--technique", "stochastic", "-o", path("out")},
                       {"gnuplot-nox"});
    ASSERT_EQ(setenv("PATH", before.c_str(), 1), 0);
    EXPECT_FALSE(exists("out"));
}

// What an earlier study left does not stand beside a new one that failed.
TEST_F(StudiesCli, OldResultsGoFirst) {
    std::filesystem::create_directories(path("out/runs"));
    for (const char* name : {"tradeoff.json", "tradeoff.png"}) write_file(path("out/") + name, "old");
    write_file(path("out/runs/alpha_blend"), "where the run's directory should be");
    const ProgramResult r =
        run_program({"tradeoff", path("trace"), "--technique", "alpha_blend", "-o", path("out")});
    EXPECT_EQ(r.status, 1);
    EXPECT_THAT(r.err, HasSubstr("1 runs failed: trace alpha_blend"));
    EXPECT_THAT(r.out, HasSubstr("| failed |"));
    EXPECT_FALSE(exists("out/tradeoff.png"));  // nothing to show
    EXPECT_THAT(read_file(path("out/tradeoff.json")), HasSubstr("runs/alpha_blend"));
}

// A machine that no run would take is refused while they still stand.
TEST_F(StudiesCli, AWrongMachineLeavesOldResults) {
    std::filesystem::create_directory(path("out"));
    for (const char* command : {"tradeoff", "order-sensitivity"}) {
        const std::string old = path("out/") + command + ".json";
        write_file(old, "old");
        const Arguments wrong[] = {
            {"--set", "nothing.at.all=1"}, {"--set", "rop.lanes"}, {"--hardware", "toaster"}};
        for (const Arguments& more : wrong) {
            Arguments arguments = {command, path("trace"), "--technique", "alpha_blend", "-o", path("out")};
            arguments.insert(arguments.end(), more.begin(), more.end());
            expect_refused(arguments, {more[1].substr(0, more[1].find('='))});
            EXPECT_EQ(read_file(old), "old");
        }
    }
}

}  // namespace
}  // namespace ropsim
