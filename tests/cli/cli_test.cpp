// The program as a user meets it: exit codes, one line for a fault, JSON that parses, nothing left after a failure.
#include <cstring>
#include <filesystem>
#include <set>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "base/atomic_file.h"
#include "rop/registry.h"
#include "tests/cli/program.h"
#include "tests/traces/scratch.h"
#include "traces/generators.h"
#include "traces/image.h"
#include "traces/trace_layout.h"

namespace ropsim {
namespace {

using nlohmann::json;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using Arguments = std::vector<std::string>;

class Cli : public ScratchTest {
   protected:
    void SetUp() override {
        ScratchTest::SetUp();
        RandomFragments options;
        options.count = 500;
        options.opaque = true;
        options.draws = 2;
        write_trace(path("trace"), random_header(options), random_fragments(options));
    }
    bool exists(const std::string& name) const { return std::filesystem::exists(path(name)); }

    // Exit 1 with one line "ropsim: ..." that holds each of `words`, nothing on stdout.
    void expect_refused(const Arguments& arguments, const std::vector<std::string>& words) const {
        const ProgramResult r = run_program(arguments);
        EXPECT_EQ(r.status, 1) << spelled(arguments) << "\n" << r.err;
        EXPECT_THAT(r.err, StartsWith("ropsim: ")) << spelled(arguments);
        EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << spelled(arguments) << "\n" << r.err;
        EXPECT_EQ(r.out, "") << spelled(arguments);
        for (const std::string& word : words) EXPECT_THAT(r.err, HasSubstr(word)) << spelled(arguments);
    }
    void expect_misused(const Arguments& arguments) const {
        const ProgramResult r = run_program(arguments);
        EXPECT_EQ(r.status, 2) << spelled(arguments) << "\n" << r.err;
        EXPECT_NE(r.err, "") << spelled(arguments);
        EXPECT_EQ(r.out, "") << spelled(arguments);
    }
    std::string expect_done(const Arguments& arguments) const {
        const ProgramResult r = run_program(arguments);
        EXPECT_EQ(r.status, 0) << spelled(arguments) << "\n" << r.err;
        return r.out;
    }
    json expect_json(const Arguments& arguments) const {
        const std::string out = expect_done(arguments);
        EXPECT_TRUE(json::accept(out)) << spelled(arguments) << "\n" << out;
        return json::parse(out, nullptr, false);
    }
    Arguments run_of(const std::string& trace, const Arguments& more = {}) const {
        Arguments all = {"run", path(trace), "--technique", "alpha_blend", "-o", path("out")};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
};

TEST_F(Cli, TracesThatAreNoTracesAreRefused) {
    const std::string good = read_file(path("trace"));
    write_file(path("truncated"), good.substr(0, good.size() / 2));
    std::string flipped = good;
    flipped[good.size() / 2] = static_cast<char>(flipped[good.size() / 2] ^ 0x10);
    write_file(path("corrupted"), flipped);
    std::string version = good;
    version[kTraceMagic.size()] = 99;
    write_file(path("version"), version);
    write_file(path("empty"), "");
    write_file(path("text"), "this is no trace\n");
    std::filesystem::create_directory(path("directory"));
    for (const char* bad : {"missing", "truncated", "corrupted", "version", "empty", "text", "directory"}) {
        expect_refused(run_of(bad), {path(bad)});
        expect_refused({"trace", "info", path(bad)}, {path(bad)});
        expect_refused({"trace", "export", path(bad), "-o", path("x.csv")}, {path(bad)});
        expect_refused({"reference", path(bad), "-o", path("x.exr")}, {path(bad)});
    }
    expect_refused({"trace", "info", path("version")}, {"version"});
    EXPECT_FALSE(exists("out"));
    EXPECT_FALSE(exists("x.csv"));
    EXPECT_FALSE(exists("x.exr"));
    EXPECT_EQ(entries(), 7u);  // the good one and the six bad: no temporary stays
}

TEST_F(Cli, TechniquesAndHardwareThatAreNotAreRefused) {
    const auto with_technique = [&](const std::string& t) { return Arguments{"run", path("trace"), "--technique", t, "-o", path("out")}; };
    expect_refused(with_technique("alpha"), {"--technique", "'alpha'", "alpha_blend"});
    expect_refused(with_technique("adaptive:knots=8"), {"knots", "nodes"});
    expect_refused(with_technique("adaptive:nodes=65"), {"nodes=65", "2 to 64"});
    expect_refused(with_technique("adaptive:nodes"), {"key=value"});
    expect_refused(with_technique("adaptive:nodes=2,nodes=3"), {"nodes", "twice"});
    expect_refused(with_technique(""), {"--technique"});
    expect_refused(run_of("trace", {"--hardware", "toaster"}), {"toaster", "desktop", "mobile"});
    expect_refused(run_of("trace", {"--hardware", path("none.toml")}), {"none.toml"});
    expect_refused(run_of("trace", {"--set", "rop.partition=2"}), {"--set: rop.partition", "rop.partitions"});
    expect_refused(run_of("trace", {"--set", "rop.partitions"}), {"--set", "key=value"});
    expect_refused(run_of("trace", {"--set", "rop.partitions=zero"}), {"rop.partitions=zero"});
    expect_refused(run_of("trace", {"--set", "rop.partitions=1000"}), {"1 to 64"});
    expect_refused(run_of("trace", {"--set", "dram.device=ddr9"}), {"ddr9"});
    expect_refused(run_of("trace", {"--set", "cache.ways=3"}), {"ways"});
    expect_refused(run_of("trace", {"--set", "cache.line_bytes=100"}), {"line_bytes"});
    expect_refused(run_of("trace", {"--set", "cache.line_bytes=100", "--fidelity", "count"}), {"line_bytes"});
    expect_refused(run_of("trace", {"--set", "cache.sector_bytes=256"}), {"sector_bytes"});
    EXPECT_FALSE(exists("out"));
    expect_refused({"cost", "beta_blend"}, {"beta_blend"});
    expect_refused({"cost", "adaptive:nodes=1"}, {"nodes=1"});
}

TEST_F(Cli, OutputThatCannotBeWrittenIsRefused) {
    write_file(path("file"), "x");
    expect_refused({"run", path("trace"), "--technique", "alpha_blend", "-o", path("file")}, {path("file")});
    expect_refused({"reference", path("trace"), "-o", path("no/where.exr")}, {path("no/where.exr")});
    expect_refused({"trace", "export", path("trace"), "-o", path("no/where.csv")}, {path("no/where.csv")});
    expect_refused({"trace", "export", path("trace"), "-o", path("x.txt")}, {"x.txt"});
    std::filesystem::create_directory(path("x.exr"));
    expect_refused({"reference", path("trace"), "-o", path("x.exr")}, {path("x.exr")});
    EXPECT_EQ(read_file(path("file")), "x");
}

TEST_F(Cli, AFailedRunTakesTheStaleResultAway) {
    std::filesystem::create_directories(path("out/image.exr"));
    write_file(path("out/run.json"), "{}");
    expect_refused(run_of("trace", {"--fidelity", "count"}), {"image.exr"});
    EXPECT_FALSE(exists("out/run.json"));
}

TEST_F(Cli, ScenesThatAreNotAreRefused) {
    expect_refused({"capture", "no_such_scene", "-o", path("t")}, {"no_such_scene"});
    expect_refused({"capture", "horse", "--size", "12by9", "-o", path("t")}, {"12by9"});
    EXPECT_FALSE(exists("t"));
}

TEST_F(Cli, CsvFaultsAreNamedByFileAndLine) {
    const auto refused = [&](const std::string& text, const std::string& place) {
        write_file(path("f.csv"), text);
        expect_refused({"trace", "import", path("f.csv"), "-o", path("t")}, {path("f.csv") + place});
        EXPECT_FALSE(exists("t"));
    };
    const std::string header = "x,y,z,r,g,b,a\n";
    refused(header + "1,2,0.5,1,1,1,0.5\n1,2,0.5,1,1,1\n", ":3");
    refused(header + "1,2,1.5,1,1,1,0.5\n", ":2");
    refused(header + "1,2,0.5,1,1,1,alpha\n", ":2");
    refused("x,y,depth\n", ":1");
    refused("", "");
    expect_refused({"trace", "import", path("none.csv"), "-o", path("t")}, {"none.csv"});
}

TEST_F(Cli, DiffRefusesWhatItCannotCompare) {
    write_exr(path("a.exr"), Image(4, 4, {"R", "G", "B"}));
    write_exr(path("b.exr"), Image(4, 5, {"R", "G", "B"}));
    write_exr(path("c.exr"), Image(4, 4, {"Y"}));
    write_file(path("d.exr"), "no picture");
    expect_refused({"diff", path("a.exr"), path("b.exr")}, {"4x4", "4x5"});
    expect_refused({"diff", path("a.exr"), path("c.exr")}, {"c.exr", "channel"});
    expect_refused({"diff", path("d.exr"), path("a.exr")}, {"d.exr"});
    expect_refused({"diff", path("a.exr"), path("e.exr")}, {"e.exr"});
    expect_refused({"diff", path("trace"), path("a.exr")}, {"trace"});
}

TEST_F(Cli, ACommandLineThatMakesNoSenseExitsWithTwo) {
    expect_misused({});
    expect_misused({"paint"});
    expect_misused({"run"});
    expect_misused({"run", path("trace"), "--technique", "alpha_blend"});  // no -o
    expect_misused({"run", path("trace"), "-o", path("out")});             // no --technique
    expect_misused(run_of("trace", {"--fidelity", "exact"}));
    expect_misused(run_of("trace", {"--threads", "0"}));
    expect_misused(run_of("trace", {"--seed", "tree"}));
    expect_misused(run_of("trace", {"--fast"}));
    expect_misused({"list", "colours"});
    expect_misused({"trace"});
    expect_misused({"trace", "look", path("trace")});
    expect_misused({"diff", path("a.exr")});
    expect_misused({"capture", "horse"});
    expect_misused({"cost"});
    EXPECT_EQ(entries(), 1u);
}

TEST_F(Cli, EveryCommandExplainsItself) {
    EXPECT_THAT(expect_done({"--version"}), HasSubstr("0."));
    const std::string all = expect_done({"--help"});
    for (const char* command : {"capture", "list", "trace", "run", "compare", "reference", "diff", "cost"}) {
        EXPECT_THAT(all, HasSubstr(command));
        EXPECT_GT(expect_done({command, "--help"}).size(), 100u) << command;
    }
    for (const char* command : {"info", "import", "export"}) EXPECT_THAT(expect_done({"trace", command, "--help"}), HasSubstr("-h,--help"));
    const std::string run = expect_done({"run", "--help"});
    for (const char* text : {"--seed", "--threads", "--set", "--technique"}) EXPECT_THAT(run, HasSubstr(text));
    // CLI11 writes a default as =X or [X], depending on its version.
    for (const char* fallback : {"[=[]desktop", "[=[]timed", "[=[]rop", "[=[]trace", "[=[]0"}) EXPECT_THAT(run, ContainsRegex(fallback));
    EXPECT_THAT(expect_done({"capture", "--help"}), ContainsRegex("[=[]1280x720"));
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
        for (const json& p : cost["paths"])
            for (const char* key : {"path", "pass", "latency_cycles", "interval_cycles", "units", "worst_case_read_bytes", "worst_case_write_bytes"})
                EXPECT_TRUE(p.contains(key)) << t.name << " " << key;
        EXPECT_THAT(expect_done({"cost", std::string(t.name)}), HasSubstr(cost["paths"][0]["path"].get<std::string>()));
    }
    // A budget of one multiplier makes a blend's four take four cycles.
    const json narrow = expect_json({"cost", "alpha_blend", "--json", "--set", "datapath.units.multiplier=1"});
    EXPECT_EQ(narrow["paths"][0]["units"]["multiplier"], 4);
    EXPECT_EQ(narrow["paths"][0]["interval_cycles"], 4);
}

// Dotted keys that scripts read, whatever the fidelity; those that it does not measure are null.
TEST_F(Cli, RunJsonHasEveryKey) {
    const std::vector<std::string> always = {
        "/technique", "/trace/file", "/trace/hash", "/trace/width", "/trace/height", "/trace/samples", "/trace/fragments", "/hardware",
        "/fidelity", "/engine", "/seed", "/threads", "/fragments/input", "/fragments/depth_culled", "/fragments/zero_alpha",
        "/fragments/operated", "/storage_bits_per_pixel", "/traffic/color/worst_case_read_bytes", "/traffic/color/worst_case_write_bytes",
        "/traffic/color/read_bytes", "/traffic/color/write_bytes", "/traffic/total/read_bytes", "/traffic/total/worst_case_write_bytes",
        "/bytes_per_fragment", "/bits_per_pixel_write", "/operation/blend/count", "/operation/blend/latency_cycles",
        "/operation/blend/interval_cycles", "/operation/blend/units/multiplier", "/error/rmse8", "/error/rmse8_covered", "/error/psnr_db",
        "/error/max_abs", "/error/mean_signed8", "/error/ssim", "/error/flip", "/host/seconds", "/host/fragments_per_second",
        "/host/peak_rss_bytes"};
    const std::vector<std::string> cached = {"/cycles", "/seconds", "/traffic/color/pin_read_bytes", "/traffic/color/pin_write_bytes",
                                             "/traffic/total/pin_read_bytes", "/rop_cache/hits", "/rop_cache/misses", "/dram/read_bytes",
                                             "/dram/write_bytes"};
    const std::vector<std::string> timed = {"/dram/row_hits", "/dram/row_misses", "/dram/row_conflicts", "/dram/utilisation",
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
        for (const char* key : {"cycles", "seconds", "rop_cache", "dram", "stages"}) EXPECT_TRUE(run.contains(key)) << fidelity << " " << key;
        EXPECT_EQ(run["fidelity"], fidelity);
        EXPECT_EQ(run["seed"], 7);
        EXPECT_EQ(run["threads"], 2);
        EXPECT_EQ(run["trace"]["fragments"], 500);
        EXPECT_EQ(run["trace"]["hash"], expect_json({"trace", "info", path("trace"), "--json"})["hash"]);
        std::filesystem::remove_all(path("out"));
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
    for (const char* key : {"mean", "max", "histogram"}) EXPECT_TRUE(info["depth_complexity"].contains(key)) << key;
    EXPECT_GT(info["bytes_per_fragment"].get<double>(), 0.0);
    EXPECT_EQ(info["hash"].get<std::string>().size(), 16u);
    EXPECT_THAT(expect_done({"trace", "info", path("trace")}), HasSubstr(info["hash"].get<std::string>()));
}

TEST_F(Cli, ReferenceOfATraceDiffersFromItselfByNothing) {
    expect_done({"reference", path("trace"), "-o", path("a.exr")});
    expect_done({"reference", path("trace"), "-o", path("b.exr"), "--threads", "1"});
    EXPECT_EQ(read_file(path("a.exr")), read_file(path("b.exr")));
    const json diff = expect_json({"diff", path("a.exr"), path("b.exr"), "--json"});
    for (const char* key : {"rmse8", "rmse8_covered", "max_abs", "mean_signed8", "flip"}) EXPECT_EQ(diff[key], 0.0) << key;
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
