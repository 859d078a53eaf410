// `ropsim bench` as a user meets it, at a tiny size.
#include "tests/cli/cli_driver.h"

namespace ropsim {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

class BenchCli : public Cli {
 protected:
    Arguments tiny(const std::string& out, const Arguments& more = {}) const {
        Arguments all = {"bench",       path("trace"), "--quick",   "--repeats", "1",
                         "--technique", "alpha_blend", "--largest", "1000",      "--fragments",
                         "1000",        "-o",          path(out)};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
};

TEST_F(BenchCli, MeasuresAllPartsAndComparesThem) {
    const std::string table = expect_done(tiny("first"));
    for (const char* word : {"alpha_blend", "timed 5%", "fragments, adaptive:nodes=8 timed", "speed-up"})
        EXPECT_THAT(table, HasSubstr(word));
    EXPECT_EQ(read_file(path("first/bench.txt")), table);
    for (const char* name : {"bench-techniques", "bench-simulator", "bench-scaling"})
        EXPECT_THAT(read_file(path(std::string("first/") + name + ".png")),
                    ::testing::StartsWith("\x89PNG\r\n"));
    const json bench = json::parse(read_file(path("first/bench.json")));
    EXPECT_EQ(bench["configuration"]["repeats"], 1);
    EXPECT_GT(bench["host"]["cores"], 0);
    for (const json& c : bench["cases"]) {
        EXPECT_TRUE(c["why_null"].is_null()) << c;
        EXPECT_EQ(c["repeats"].size(), 1) << c;
    }
    // What is simulated is that of `ropsim run`.
    expect_done(run_of("trace", {"--fidelity", "timed"}));
    const json run = json::parse(read_file(path("out/run.json")));
    const json& row = bench["plots"][0]["rows"][0];
    EXPECT_DOUBLE_EQ(row[2].get<double>(), 1e3 * run["seconds"].get<double>());
    EXPECT_EQ(row[6], run["error"]["rmse8_covered"]);
    for (const json& entry : bench["simulator"])
        EXPECT_TRUE(entry["mode"] != "timed" || entry["cycles_error"]["rms"] == 0) << entry;
    // Its own traces are gone.
    EXPECT_TRUE(std::filesystem::is_empty(path("first/traces")));

    // Against itself results are equal, and one repeat decides nothing about speed.
    const std::string again =
        expect_done(tiny("second", {"--against", path("first/baseline.json"), "--part", "techniques"}));
    EXPECT_THAT(again, HasSubstr("1 same, 0 regressed, 0 improved, 0 undecided, 0 changed"));
    std::string baseline = read_file(path("first/baseline.json"));
    const std::size_t digit = baseline.find("\"frame ms\":") + 11;
    baseline[digit] = baseline[digit] == '9' ? '8' : '9';
    write_file(path("other.json"), baseline);
    const ProgramResult changed =
        run_program(tiny("third", {"--against", path("other.json"), "--part", "techniques"}));
    EXPECT_EQ(changed.status, 1);
    EXPECT_THAT(changed.out, HasSubstr("changed"));
    EXPECT_THAT(changed.err, HasSubstr("1 have other results"));
    EXPECT_TRUE(exists("third/bench.json"));
}

TEST_F(BenchCli, FaultsAreALine) {
    expect_refused({"bench", path("missing"), "-o", path("out")}, {"missing"});
    expect_refused(tiny("out", {"--technique", "no_such"}), {"--technique", "no_such"});
    expect_refused(tiny("out", {"--against", path("trace")}), {"trace", "is not a baseline"});
    expect_refused(tiny("out", {"--against", path("missing")}), {"missing"});
    EXPECT_FALSE(exists("out"));
    for (const Arguments& more :
         {Arguments{"--part", "speed"}, {"--repeats", "0"}, {"--largest", "1"}, {"--least", "-1"}})
        expect_misused(tiny("out", more));
    // A baseline is not overwritten by what is compared with it.
    std::filesystem::create_directory(path("out"));
    write_file(path("out/baseline.json"),
               R"({"kind": "ropsim bench baseline", "ropsim": "1", "processor": "p", "entries": []})");
    expect_refused(tiny("out", {"--against", path("out/baseline.json")}), {"baseline.json"});
}

// Cycles, bytes and errors depend on the inputs alone, on any machine: the committed ones hold.
TEST_F(BenchCli, CommittedBaselineHolds) {
    const std::string baseline = ROPSIM_SOURCE_DIR "/tests/bench/baseline.json";
    const std::string told =
        expect_done({"bench", "--quick", "--part", "techniques", "--against", baseline, "-o", path("out")});
    EXPECT_THAT(told, HasSubstr("6 same, 0 regressed"));
    EXPECT_THAT(told, HasSubstr(" 0 changed"));
}

}  // namespace
}  // namespace ropsim
