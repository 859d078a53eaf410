// `ropsim convergence` as a user meets it.
#include "tests/cli/cli_driver.h"

#include <cstdlib>

namespace ropsim {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

class ConvergenceCli : public Cli {
 protected:
    Arguments convergence(const Arguments& more) const {
        Arguments all = {"convergence", path("trace"), "-o", path("out/deep")};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
};

TEST_F(ConvergenceCli, WritesFourFilesAndATable) {
    const Arguments arguments =
        convergence({"--technique", "stochastic", "--technique", "laine_karras:format=float32", "--values",
                     "4,8,16", "--seeds", "2", "--threads", "1"});
    const std::string table = expect_done(arguments);
    for (const char* word : {"technique", "samples", "RMSE", "B/frag", "bit/px", "to first",
                             "stochastic: RMSE = ", "laine_karras:format=float32: RMSE = ", "95% from seeds"})
        EXPECT_THAT(table, HasSubstr(word));
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(path("out/deep")),
                            std::filesystem::directory_iterator()),
              4);
    EXPECT_THAT(read_file(path("out/deep/convergence.png")), ::testing::StartsWith("\x89PNG\r\n"));
    EXPECT_THAT(read_file(path("out/deep/convergence.svg")), HasSubstr("</svg>"));
    const std::string csv = read_file(path("out/deep/convergence.csv"));
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 2 * 3 * 2);
    const std::string text = read_file(path("out/deep/convergence.json"));
    const json study = json::parse(text);
    EXPECT_EQ(study["trace"]["hash"].get<std::string>().size(), 16u);
    EXPECT_EQ(study["configuration"]["key"], "samples");
    EXPECT_EQ(study["configuration"]["values"], json({4, 8, 16}));
    EXPECT_EQ(study["configuration"]["fidelity"], "count");
    ASSERT_EQ(study["techniques"].size(), 2u);
    const json& second = study["techniques"][1];
    EXPECT_EQ(second["technique_parameters"]["format"], "\"float32\"");
    EXPECT_LT(second["fit"]["slope"].get<double>(), 0);
    EXPECT_LT(second["fit"]["slope_ci95"][0], second["fit"]["slope_ci95"][1]);
    EXPECT_GT(second["values"][2]["rmse8_ratio_to_first"]["sd"].get<double>(), 0);
    for (const auto& [key, unit] : study["units"].items())
        EXPECT_FALSE(unit.get<std::string>().empty()) << key;
    for (const auto& [key, measured] : second["values"][0]["runs"][0].items())
        EXPECT_TRUE(key == "seed" || study["units"].contains(key)) << key;

    Arguments again = arguments;
    again.back() = "3";
    again.emplace_back("--json");
    EXPECT_EQ(expect_done(again), text);
}

// A run of a study is the run of `ropsim run`.
TEST_F(ConvergenceCli, RunsAreThoseOfRun) {
    const json study = expect_json(
        convergence({"--technique", "stochastic:format=float32", "--values", "8", "--seeds", "2", "--json"}));
    EXPECT_TRUE(study["techniques"][0]["fit"]["slope"].is_null());
    const json& at = study["techniques"][0]["values"][0];
    expect_done({"run", path("trace"), "--technique", "stochastic:format=float32,samples=8", "--seed", "2",
                 "--fidelity", "count", "-o", path("run")});
    const json run = json::parse(read_file(path("run/run.json")));
    const json& measured = at["runs"][1];
    for (const char* key : {"rmse8", "rmse8_covered", "mean_signed8"})
        EXPECT_EQ(measured[key], run["error"][key]) << key;
    EXPECT_EQ(measured["touched_bytes_per_fragment"], run["bytes_per_fragment"]);
    const json& total = run["traffic"]["total"];
    EXPECT_DOUBLE_EQ(
        measured["worst_case_bytes_per_fragment"].get<double>() * run["fragments"]["input"].get<double>(),
        total["worst_case_read_bytes"].get<double>() + total["worst_case_write_bytes"].get<double>());
    EXPECT_EQ(at["storage_bits_per_pixel"], run["storage_bits_per_pixel"]);
}

TEST_F(ConvergenceCli, WrongInputIsRefused) {
    expect_refused(convergence({"--technique", "stochastic:samples=8"}),
                   {"--technique", "samples", "leave it out"});
    expect_refused(convergence({"--technique", "stochastic", "--key", "knots"}),
                   {"stochastic:knots=4", "samples"});
    expect_refused(convergence({"--technique", "stochastic", "--values", "4,eight,16"}),
                   {"--values", "'eight'"});
    expect_refused(convergence({"--technique", "stochastic", "--values", "4,8,65"}),
                   {"stochastic:samples=65", "64"});
    expect_refused({"convergence", path("none"), "--technique", "stochastic", "-o", path("out")},
                   {path("none")});
    write_file(path("file"), "x");
    expect_refused(
        {"convergence", path("trace"), "--technique", "stochastic", "--values", "4", "-o", path("file")},
        {path("file")});
    EXPECT_EQ(read_file(path("file")), "x");
    expect_misused(convergence({"--technique", "stochastic", "--seeds", "0"}));
    expect_misused(convergence({}));
    EXPECT_FALSE(exists("out"));
}

TEST_F(ConvergenceCli, AMissingGnuplotIsMissedBeforeTheRuns) {
    const char* const now = std::getenv("PATH");
    ASSERT_NE(now, nullptr);
    const std::string before = now;
    ASSERT_EQ(setenv("PATH", path("empty").c_str(), 1), 0);
    expect_refused(convergence({"--technique", "stochastic", "--values", "4,8,16"}),
                   {"gnuplot", "gnuplot-nox"});
    ASSERT_EQ(setenv("PATH", before.c_str(), 1), 0);
    EXPECT_FALSE(exists("out"));
}

TEST_F(ConvergenceCli, NothingToPlotIsSaid) {
    TraceHeader header;
    header.width = 8;
    header.height = 8;
    header.draws.resize(1);
    write_trace(path("trace"), header, {});
    const ProgramResult r = run_program(convergence({"--technique", "stochastic", "--values", "4,8,16"}));
    EXPECT_EQ(r.status, 0) << r.err;
    EXPECT_THAT(r.out, HasSubstr("no slope: the error is 0"));
    EXPECT_THAT(r.err, HasSubstr("no plot"));
    EXPECT_FALSE(exists("out/deep/convergence.png"));
    EXPECT_TRUE(exists("out/deep/convergence.json"));
}

}  // namespace
}  // namespace ropsim
