// What the program says when all is well: help, lists, JSON with its keys.
#include "rop/registry.h"
#include "tests/cli/cli_driver.h"

#include <cstring>
#include <set>

namespace ropsim {
namespace {

using nlohmann::json;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;

TEST_F(Cli, EveryCommandExplainsItself) {
    EXPECT_THAT(expect_done({"--version"}), HasSubstr("0."));
    const std::string all = expect_done({"--help"});
    for (const char* command :
         {"capture", "list", "trace", "run", "compare", "convergence", "reference", "diff", "cost"}) {
        EXPECT_THAT(all, HasSubstr(command));
        EXPECT_GT(expect_done({command, "--help"}).size(), 100u) << command;
    }
    for (const char* command : {"info", "import", "export", "cut", "order", "stress"})
        EXPECT_THAT(expect_done({"trace", command, "--help"}), HasSubstr("-h,--help"));
    const std::string run = expect_done({"run", "--help"});
    for (const char* text : {"--seed", "--threads", "--set", "--technique"})
        EXPECT_THAT(run, HasSubstr(text));
    // CLI11 writes a default as =X or [X], depending on its version.
    for (const char* fallback : {"[=[]desktop", "[=[]timed", "[=[]rop", "[=[]trace", "[=[]0"})
        EXPECT_THAT(run, ContainsRegex(fallback));
    EXPECT_THAT(expect_done({"capture", "--help"}), ContainsRegex("mostly 1280x720"));
    EXPECT_THAT(expect_done({"cost", "--help"}), ContainsRegex("[=[]desktop"));
}

TEST_F(Cli, ListsAreJsonWithNameAndSummary) {
    for (const char* what : {"techniques", "scenes", "hardware", "formats"}) {
        const json list = expect_json({"list", what, "--json"});
        ASSERT_TRUE(list.is_array()) << what;
        std::set<std::string> names;
        for (const json& entry : list) {
            EXPECT_FALSE(entry["name"].get<std::string>().empty());
            EXPECT_FALSE(entry["summary"].get<std::string>().empty());
            EXPECT_TRUE(names.insert(entry["name"]).second) << entry["name"];
            EXPECT_THAT(expect_done({"list", what}), HasSubstr(entry["name"].get<std::string>()));
        }
        EXPECT_GE(names.size(), 2u) << what;
    }
    EXPECT_EQ(expect_json({"list", "techniques", "--json"}).size(), technique_list().size());
}

TEST_F(Cli, CostIsJson) {
    for (const TechniqueInfo& t : technique_list()) {
        const json cost = expect_json({"cost", std::string(t.name), "--json"});
        EXPECT_EQ(cost["technique"], t.name);
        EXPECT_GT(cost["storage_bits_per_pixel"].get<int>(), 0);
        ASSERT_FALSE(cost["paths"].empty());
        EXPECT_GT(cost["operation_worst_case_bytes_per_fragment"]["write"].get<int>(), 0);
        for (const json& p : cost["paths"])
            for (const char* key : {"path", "pass", "latency_cycles", "interval_cycles", "units",
                                    "worst_case_read_bytes", "worst_case_write_bytes"})
                EXPECT_TRUE(p.contains(key)) << t.name << " " << key;
        EXPECT_THAT(expect_done({"cost", std::string(t.name)}),
                    HasSubstr(cost["paths"][0]["path"].get<std::string>()));
    }
    // A budget of one multiplier makes a blend's four take four cycles.
    const json narrow = expect_json({"cost", "alpha_blend", "--json", "--set", "rop.multipliers=1"});
    EXPECT_EQ(narrow["paths"][0]["units"]["multiplier"], 4);
    EXPECT_EQ(narrow["paths"][0]["interval_cycles"], 4);
}

// Dotted keys that scripts read, whatever the fidelity; those that it does not measure are null.
TEST_F(Cli, RunJsonHasEveryKey) {
    const std::vector<std::string> always = {"/technique",
                                             "/trace/file",
                                             "/trace/hash",
                                             "/trace/width",
                                             "/trace/height",
                                             "/trace/samples",
                                             "/trace/fragments",
                                             "/hardware",
                                             "/fidelity",
                                             "/engine",
                                             "/seed",
                                             "/threads",
                                             "/fragments/input",
                                             "/fragments/depth_culled",
                                             "/fragments/zero_alpha",
                                             "/fragments/operated",
                                             "/storage_bits_per_pixel",
                                             "/traffic/color/worst_case_read_bytes",
                                             "/traffic/color/worst_case_write_bytes",
                                             "/traffic/color/read_bytes",
                                             "/traffic/color/write_bytes",
                                             "/traffic/total/read_bytes",
                                             "/traffic/total/worst_case_write_bytes",
                                             "/bytes_per_fragment",
                                             "/bits_per_pixel_write",
                                             "/operation/blend/count",
                                             "/operation/blend/latency_cycles",
                                             "/operation/blend/interval_cycles",
                                             "/operation/blend/units/multiplier",
                                             "/error/rmse8",
                                             "/error/rmse8_covered",
                                             "/error/psnr_db",
                                             "/error/max_abs",
                                             "/error/mean_signed8",
                                             "/error/ssim",
                                             "/error/flip",
                                             "/host/seconds",
                                             "/host/processor_seconds",
                                             "/host/fragments_per_second",
                                             "/host/peak_rss_bytes"};
    const std::vector<std::string> cached = {"/cycles",
                                             "/seconds",
                                             "/traffic/color/pin_read_bytes",
                                             "/traffic/color/pin_write_bytes",
                                             "/traffic/total/pin_read_bytes",
                                             "/rop_cache/hits",
                                             "/rop_cache/misses",
                                             "/dram/read_bytes",
                                             "/dram/write_bytes"};
    const std::vector<std::string> timed = {
        "/dram/row_hits",         "/dram/row_misses",     "/dram/row_conflicts",        "/dram/utilisation",
        "/stages/front_end/busy", "/stages/rop_tag/idle", "/stages/rop_operation/stall"};
    for (const auto& [fidelity, level] : {std::pair{"count", 0}, {"cached", 1}, {"timed", 2}}) {
        expect_done(run_of("trace", {"--fidelity", fidelity, "--seed", "7", "--threads", "2"}));
        const json run = json::parse(read_file(path("out/run.json")));
        const auto measured = [&](const std::string& key) {
            const json::json_pointer pointer(key);
            return run.contains(pointer) && !run.at(pointer).is_null();
        };
        for (const std::string& key : always) EXPECT_TRUE(measured(key)) << fidelity << " " << key;
        for (const std::string& key : cached) EXPECT_EQ(measured(key), level >= 1) << fidelity << " " << key;
        for (const std::string& key : timed) EXPECT_EQ(measured(key), level >= 2) << fidelity << " " << key;
        for (const char* key : {"cycles", "seconds", "rop_cache", "dram", "stages"})
            EXPECT_TRUE(run.contains(key)) << fidelity << " " << key;
        EXPECT_EQ(run["fidelity"], fidelity);
        EXPECT_EQ(run["seed"], 7);
        EXPECT_EQ(run["threads"], 2);
        EXPECT_EQ(run["trace"]["fragments"], 500);
        EXPECT_EQ(run["trace"]["hash"], expect_json({"trace", "info", path("trace"), "--json"})["hash"]);
        std::filesystem::remove_all(path("out"));
    }
}

TEST_F(Cli, AMisspeltRunLeavesAnEarlierOnesResults) {
    expect_done(run_of("trace", {"--fidelity", "count"}));
    const std::string before = read_file(path("out") + "/run.json");
    for (const Arguments& wrong :
         {Arguments{"--technique", "alpha_blemd"}, Arguments{"--technique", "adaptive:nodes=1000"},
          Arguments{"--technique", "alpha_blend", "--set", "cache.kibibites=4"}}) {
        Arguments arguments = {"run", path("trace"), "-o", path("out")};
        arguments.insert(arguments.end(), wrong.begin(), wrong.end());
        expect_refused(arguments, {});
        EXPECT_EQ(read_file(path("out") + "/run.json"), before) << spelled(arguments);
    }
}

TEST_F(Cli, TraceInfoHasItsKeys) {
    const json info = expect_json({"trace", "info", path("trace"), "--json"});
    EXPECT_EQ(info["width"], 32);
    EXPECT_EQ(info["height"], 32);
    EXPECT_EQ(info["samples"], 1);
    EXPECT_EQ(info["fragments"], 500);
    EXPECT_TRUE(info["fragments"].is_number_integer());
    EXPECT_EQ(info["draws"], 2);
    for (const char* key : {"mean", "max", "histogram"})
        EXPECT_TRUE(info["depth_complexity"].contains(key)) << key;
    EXPECT_GT(info["bytes_per_fragment"].get<double>(), 0.0);
    EXPECT_EQ(info["hash"].get<std::string>().size(), 16u);
    EXPECT_THAT(expect_done({"trace", "info", path("trace")}), HasSubstr(info["hash"].get<std::string>()));
}

TEST_F(Cli, ReferenceOfATraceDiffersFromItselfByNothing) {
    expect_done({"reference", path("trace"), "-o", path("a.exr")});
    expect_done({"reference", path("trace"), "-o", path("b.exr"), "--threads", "1"});
    expect_done({"reference", path("trace"), "-o", path("c.png")});
    EXPECT_THAT(read_file(path("c.png")), ::testing::StartsWith("\x89PNG"));
    EXPECT_EQ(read_file(path("a.exr")), read_file(path("b.exr")));
    const json diff = expect_json({"diff", path("a.exr"), path("b.exr"), "--json"});
    for (const char* key : {"rmse8", "rmse8_covered", "max_abs", "mean_signed8", "flip"})
        EXPECT_EQ(diff[key], 0.0) << key;
    EXPECT_EQ(diff["ssim"], 1.0);
    EXPECT_TRUE(diff["psnr_db"].is_null());  // infinite
    EXPECT_THAT(expect_done({"diff", path("a.exr"), path("b.exr")}), HasSubstr("RMSE"));
}

TEST_F(Cli, CsvGoesThereAndBack) {
    RandomFragments options;
    options.count = 300;
    options.draws = 2;
    write_trace(path("plain"), random_header(options), random_fragments(options));
    expect_done({"trace", "export", path("plain"), "-o", path("f.csv")});
    expect_done({"trace", "import", path("f.csv"), "-o", path("back")});
    const std::vector<Fragment> before = read_fragments(path("plain"));
    const std::vector<Fragment> after = read_fragments(path("back"));
    ASSERT_EQ(before.size(), after.size());
    EXPECT_EQ(std::memcmp(before.data(), after.data(), before.size() * sizeof(Fragment)), 0);
}

}  // namespace
}  // namespace ropsim
