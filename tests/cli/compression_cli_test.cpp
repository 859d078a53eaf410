// `ropsim compression` as a user meets it.
#include "tests/cli/cli_driver.h"

namespace ropsim {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

class CompressionCli : public Cli {
 protected:
    Arguments study(const Arguments& more) const {
        Arguments all = {"compression", path("trace"), "-o", path("out/deep")};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
};

TEST_F(CompressionCli, WritesTwoFilesAndTables) {
    const Arguments arguments = study({"--technique", "alpha_blend", "--technique", "adaptive:nodes=4"});
    const std::string table = expect_done(arguments);
    for (const char* word : {"trace: ", "whole frame", "planes/delta/delta, saved %", "% kept raw",
                             "nodes used_delta", "color delta", "states, MB"})
        EXPECT_THAT(table, HasSubstr(word));
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(path("out/deep")),
                            std::filesystem::directory_iterator()),
              2);
    const std::string text = read_file(path("out/deep/compression.json"));
    const json all = json::parse(text);
    std::ptrdiff_t surfaces = 0;
    for (const json& run : all["scenes"][0]["runs"])
        surfaces += static_cast<std::ptrdiff_t>(run["surfaces"].size());
    const std::string csv = read_file(path("out/deep/compression.csv"));
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 5 * surfaces);

    Arguments again = arguments;
    again.insert(again.end(), {"--threads", "3", "--json"});
    EXPECT_EQ(expect_done(again), text);
}

std::uint64_t moved(const json& causes, const std::vector<std::string>& names, const std::string& direction) {
    std::uint64_t sum = 0;
    for (const std::string& name : names)
        if (causes.contains(name)) sum += causes[name]["pin_" + direction + "_bytes"].get<std::uint64_t>();
    return sum;
}

// Every setup against the run with its keys, the one without compression included. Elements of one byte leave
// tiles that blocks of 256 pad and lines of 64 do not; a pool starts clear only where it compresses.
TEST_F(CompressionCli, NumbersAreThoseOfRun) {
    for (const std::string technique :
         {"adaptive:nodes=4", "a_buffer", "stochastic:samples=4", "weighted_blended"}) {
        const Arguments machine = {"--technique", technique,
                                   "--seed",      "5",
                                   "--hardware",  "mobile",
                                   "--set",       "cache.kibibytes=2",
                                   "--set",       "cache.line_bytes=64"};
        Arguments arguments = study(machine);
        arguments.insert(arguments.end(), {"--metadata", "1", "--json"});
        const json all = expect_json(arguments);
        const json& of_study = all["scenes"][0]["runs"][0];
        const json& setups = all["configuration"]["setups"];
        ASSERT_EQ(setups.size(), 5u);
        for (std::size_t i = 0; i < setups.size(); ++i) {
            Arguments one = {"run", path("trace"), "--fidelity", "cached", "-o", path("run")};
            one.insert(one.end(), machine.begin(), machine.end());
            for (const json& setting : setups[i]["settings"]) one.insert(one.end(), {"--set", setting});
            expect_done(one);
            const json run = json::parse(read_file(path("run/run.json")));
            const json& total = run["traffic"]["total"];
            EXPECT_EQ(
                of_study["frame"][i]["pins"]["sum"].get<std::uint64_t>(),
                total["pin_read_bytes"].get<std::uint64_t>() + total["pin_write_bytes"].get<std::uint64_t>())
                << technique << " " << setups[i];
            for (const auto& [surface, entry] : of_study["surfaces"].items()) {
                if (!run["traffic"].contains(surface)) continue;
                const json& causes = run["traffic"][surface]["causes"];
                const json& pins = entry["outcomes"][i]["pins"];
                EXPECT_EQ(pins["fill"], moved(causes, {"fill", "copy", "resolve"}, "read")) << surface;
                EXPECT_EQ(pins["write"], moved(causes, {"write_back", "flush"}, "write")) << surface;
                EXPECT_EQ(pins["repack"], moved(causes, {"repack"}, "read")) << surface;
                EXPECT_EQ(pins["metadata"],
                          moved(causes, {"metadata"}, "read") + moved(causes, {"metadata"}, "write"))
                    << surface;
                if (i == 0) continue;
                const json& counts = run["compression"]["surfaces"][surface];
                EXPECT_EQ(entry["outcomes"][i]["blocks"], counts["blocks"]) << surface;
                EXPECT_EQ(entry["outcomes"][i]["repacks"], counts["repacks"]) << surface;
                EXPECT_EQ(entry["outcomes"][i]["stored_bytes"], counts["stored_bytes"]) << surface;
            }
        }
    }
}

TEST_F(CompressionCli, WrongInputIsRefused) {
    const auto with = [&](const Arguments& more) {
        Arguments all = study({"--technique", "alpha_blend"});
        all.insert(all.end(), more.begin(), more.end());
        return all;
    };
    expect_refused(with({"--set", "compression.color=delta"}),
                   {"--set", "compression.color", "leave it out"});
    expect_refused(with({"--set", "metadata.kibibytes=8"}), {"--set", "metadata.kibibytes"});
    expect_refused(with({"--set", "compression.colour=delta"}), {"compression.colour"});
    expect_refused(with({"--set", "compression.block_bytes=64"}), {"compression.levels", "64"});
    expect_refused(with({"--metadata", "1", "--set", "metadata.ways=64"}),
                   {"--metadata", "metadata.kibibytes=1", "64 x 64"});
    expect_refused(with({"--hardware", "desk"}), {"--hardware", "'desk'", "desktop"});
    expect_refused(with({"--technique", "alpha_blend"}), {"--technique", "twice"});
    expect_refused(with({"--technique", "alpha_bland"}), {"alpha_bland"});
    expect_refused({"compression", path("none"), "--technique", "alpha_blend", "-o", path("out")},
                   {path("none")});
    write_trace(path("empty"), random_header({}), {});
    expect_refused({"compression", path("empty"), "--technique", "alpha_blend", "-o", path("out")},
                   {"empty", "no fragments"});
    expect_refused({"compression", path("trace"), "--technique", "alpha_blend", "-o", path("trace/out")},
                   {path("trace")});
    EXPECT_FALSE(exists("out"));
    expect_misused(study({}));
    expect_misused({"compression", "--technique", "alpha_blend", "-o", path("out")});
    expect_misused({"compression", path("trace"), "--technique", "alpha_blend"});
    expect_misused(with({"--metadata", "0"}));
    std::filesystem::copy_file(path("trace"), path("compression.json"));
    expect_refused({"compression", path("compression.json"), "--technique", "alpha_blend", "-o", path("")},
                   {"compression.json"});
}

}  // namespace
}  // namespace ropsim
