// `ropsim sweep` as a user meets it.
#include "tests/cli/cli_driver.h"

#include <fmt/format.h>

namespace ropsim {
namespace {

using ::testing::HasSubstr;

class SweepCli : public Cli {
 protected:
    Arguments sweep(const Arguments& more) const {
        Arguments all = {"sweep",       path("trace"),
                         "--technique", "alpha_blend",
                         "--technique", "adaptive:nodes=4",
                         "-o",          path("out"),
                         "--threads",   "1"};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
};

TEST_F(SweepCli, ARowAPointAndAPicture) {
    const Arguments arguments = sweep({"--set", "cache.kibibytes=2,4,8", "--fidelity", "cached,timed"});
    const std::string table = expect_done(arguments);
    EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 1 + 12);
    EXPECT_EQ(read_file(path("out/sweep.txt")), table);
    EXPECT_THAT(read_file(path("out/sweep.png")), ::testing::StartsWith("\x89PNG\r\n"));
    const std::string csv = read_file(path("out/sweep.csv"));
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 12);
    // A point is a run of `ropsim run`.
    expect_done({"run", path("trace"), "--technique", "adaptive:nodes=4", "--set", "cache.kibibytes=4", "-o",
                 path("run")});
    const nlohmann::json run = nlohmann::json::parse(read_file(path("run/run.json")));
    EXPECT_THAT(csv, HasSubstr(fmt::format("\nTRACE,adaptive:nodes=4,timed,4,{},", run["cycles"].get<int>())
                                   .replace(1, 5, path("trace"))));
    // Nothing is run again, and the rows are the same, host seconds included.
    const ProgramResult again = run_program(arguments);
    EXPECT_EQ(again.status, 0);
    EXPECT_THAT(again.err, HasSubstr("12 of 12 points are there already"));
    EXPECT_EQ(read_file(path("out/sweep.csv")), csv);
}

TEST_F(SweepCli, APointThatCannotBeIsARow) {
    const ProgramResult result =
        run_program(sweep({"--set", "cache.kibibytes=2,4", "--set", "cache.ways=4,64"}));
    EXPECT_EQ(result.status, 1);
    EXPECT_THAT(result.err, HasSubstr("4 of 8 points failed"));
    EXPECT_TRUE(exists("out/sweep.csv"));
    EXPECT_TRUE(exists("out/sweep.png"));
}

TEST_F(SweepCli, WrongInputIsRefused) {
    expect_refused(sweep({"--set", "cache.kibibytes=2,,4"}), {"empty value"});
    expect_refused(sweep({"--set", "cache.kibbles=2,4"}), {"cache.kibbles"});
    expect_refused(sweep({"--hardware", "laptop"}), {"laptop"});
    expect_refused(sweep({"--fidelity", "cached,timd"}),
                   {"--fidelity", "'timd' is none of count, cached, timed"});
    expect_misused({"sweep", path("trace"), "-o", path("out")});
    EXPECT_FALSE(exists("out"));
}

}  // namespace
}  // namespace ropsim
