// `ropsim cache-sizes` as a user meets it.
#include "tests/cli/cli_driver.h"

namespace ropsim {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

class CacheSizesCli : public Cli {
 protected:
    Arguments study(const Arguments& more) const {
        Arguments all = {"cache-sizes", path("trace"), "-o", path("out/deep")};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
};

TEST_F(CacheSizesCli, WritesFourFilesAndTables) {
    const Arguments arguments =
        study({"--technique", "alpha_blend", "--technique", "adaptive:nodes=4", "--kibibytes", "16,2"});
    const std::string table = expect_done(arguments);
    for (const char* word :
         {"trace: ", " fragments; 10 bytes a fragment are ", "worst case", "touched",
          "2 KiB  16 KiB  endless", "fully associative", "% saved by a doubling", "half at"})
        EXPECT_THAT(table, HasSubstr(word));
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(path("out/deep")),
                            std::filesystem::directory_iterator()),
              4);
    EXPECT_THAT(read_file(path("out/deep/cache-sizes.png")), ::testing::StartsWith("\x89PNG\r\n"));
    EXPECT_THAT(read_file(path("out/deep/cache-sizes.svg")), HasSubstr("</svg>"));
    const std::string text = read_file(path("out/deep/cache-sizes.json"));
    const json all = json::parse(text);
    EXPECT_EQ(all["configuration"]["kibibytes"], json({2, 16}));
    ASSERT_EQ(all["scenes"][0]["runs"].size(), 2u);
    const json& run = all["scenes"][0]["runs"][1];
    EXPECT_EQ(run["caches"][1]["kibibytes"], 16);
    EXPECT_TRUE(run["ideal"].back()["size_bytes"].is_null());
    EXPECT_EQ(run["ideal"].back()["saved_share"], 1.0);
    for (const json& ideal : run["ideal"])
        EXPECT_GE(ideal["miss_port"]["per_fragment"], run["ideal"].back()["miss_port"]["per_fragment"]);
    const std::string csv = read_file(path("out/deep/cache-sizes.csv"));
    // Three models without a cache, two caches, and as many ideal ones as JSON has.
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'),
              1 + 2 * (3 + 2 + static_cast<std::ptrdiff_t>(run["ideal"].size())));

    Arguments again = arguments;
    again.insert(again.end(), {"--threads", "3", "--json"});
    EXPECT_EQ(expect_done(again), text);
}

// What stands beside the curves is what `run` says.
TEST_F(CacheSizesCli, NumbersAreThoseOfRun) {
    const json all =
        expect_json(study({"--technique", "stochastic:samples=4", "--kibibytes", "4,32", "--seed", "5",
                           "--hardware", "mobile", "--set", "cache.ways=8", "--json"}));
    const json& scene = all["scenes"][0];
    const json& study_run = scene["runs"][0];
    for (std::size_t i = 0; i < 2; ++i) {
        const std::string size = std::to_string(study_run["caches"][i]["kibibytes"].get<int>());
        expect_done({"run", path("trace"), "--technique", "stochastic:samples=4", "--fidelity", "cached",
                     "--seed", "5", "--hardware", "mobile", "--set", "cache.ways=8", "--set",
                     "cache.kibibytes=" + size, "-o", path("run")});
        const json run = json::parse(read_file(path("run/run.json")));
        const json& total = run["traffic"]["total"];
        const json& pins = study_run["caches"][i]["pins"];
        EXPECT_EQ(pins["read"], total["pin_read_bytes"]);
        EXPECT_EQ(pins["write"], total["pin_write_bytes"]);
        EXPECT_DOUBLE_EQ(pins["per_fragment"].get<double>() * scene["fragments"].get<double>(),
                         pins["read"].get<double>() + pins["write"].get<double>());
        for (const auto& [surface, bytes] : study_run["caches"][i]["surfaces"].items())
            EXPECT_EQ(bytes["read"], run["traffic"][surface]["pin_read_bytes"]) << surface;
        EXPECT_EQ(study_run["touched"]["read"], total["read_bytes"]);
        EXPECT_EQ(study_run["touched"]["write"], total["write_bytes"]);
        EXPECT_EQ(study_run["worst_case"]["read"], total["worst_case_read_bytes"]);
        EXPECT_EQ(study_run["worst_case"]["write"], total["worst_case_write_bytes"]);
    }
}

TEST_F(CacheSizesCli, WrongInputIsRefused) {
    const Arguments blend = {"--technique", "alpha_blend"};
    const auto with = [&](const Arguments& more) {
        Arguments all = study(blend);
        all.insert(all.end(), more.begin(), more.end());
        return all;
    };
    expect_refused(with({"--kibibytes", "4,8,4"}), {"--kibibytes", "4", "twice"});
    expect_refused(with({"--kibibytes", "0"}), {"--kibibytes", "cache.kibibytes", "65536"});
    expect_refused(with({"--kibibytes", "4", "--set", "cache.ways=3"}),
                   {"--kibibytes", "cache.kibibytes=4", "3 x 128"});
    expect_refused(with({"--set", "cache.kibibytes=8"}), {"--set", "cache.kibibytes", "--kibibytes"});
    expect_refused(with({"--set", "cache.sise=8"}), {"cache.sise"});
    expect_refused(with({"--hardware", "desk"}), {"--hardware", "'desk'", "desktop"});
    expect_refused(with({"--technique", "alpha_blend"}), {"--technique", "twice"});
    expect_refused(with({"--technique", "alpha_bland"}), {"alpha_bland"});
    expect_refused({"cache-sizes", path("none"), "--technique", "alpha_blend", "-o", path("out")},
                   {path("none")});
    write_trace(path("cache-sizes.csv"), random_header({}), {});
    expect_refused({"cache-sizes", path("cache-sizes.csv"), "--technique", "alpha_blend", "-o", path("out")},
                   {"cache-sizes.csv", "no fragments"});
    EXPECT_FALSE(exists("out"));
    expect_misused(study({}));
    expect_misused(with({"--kibibytes", "four"}));
    expect_misused(with({"--threads", "-1"}));
    std::filesystem::copy_file(path("trace"), path("cache-sizes.json"));
    expect_refused({"cache-sizes", path("cache-sizes.json"), "--technique", "alpha_blend", "-o", path("")},
                   {"cache-sizes.json"});
}

}  // namespace
}  // namespace ropsim
