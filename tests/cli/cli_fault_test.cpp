// Faults as a user meets them: exit codes, one line that says what and where, nothing left behind.
#include "tests/cli/cli_driver.h"
#include "traces/image.h"
#include "traces/trace_layout.h"

namespace ropsim {
namespace {

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

// Before the runs, not after them.
TEST_F(Cli, InspectedPixelsOutsideTheImageAreRefused) {
    for (const char* pixel : {"9999,0", "0,9999", "-1,0", "1", "a,b", ""})
        expect_refused({"compare", path("trace"), "--inspect", pixel, "-o", path("out")},
                       {"--inspect", pixel});
    EXPECT_FALSE(exists("out"));
}

TEST_F(Cli, TechniquesAndHardwareThatAreNotAreRefused) {
    const auto with_technique = [&](const std::string& t) {
        return Arguments{"run", path("trace"), "--technique", t, "-o", path("out")};
    };
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

// No trace has so many samples.
TEST_F(Cli, SamplesThatNoTraceHasAreNotCosted) {
    for (const char* samples : {"0", "3", "-1", "17"})
        expect_misused({"cost", "adaptive:nodes=4", "--samples", samples});
}

}  // namespace
}  // namespace ropsim
