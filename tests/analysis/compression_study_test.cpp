// What a study of compression derives from its counts, on counts made by hand, and how it shows losses.
#include "analysis/compression_study.h"

#include "analysis/compression_output.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// By setup; in setup `i` the fill shrinks or grows by `step` bytes each.
StudiedSurface surface(const std::string& name, SurfaceClass surface_class, std::int64_t step) {
    StudiedSurface s{name, surface_class, 4, 1, {}};
    for (std::int64_t i = 0; i < 5; ++i) {
        SurfaceOutcome outcome;
        outcome.pins = {static_cast<std::uint64_t>(1'000'000 + i * step), 500'000,
                        i == 0 ? 0 : std::uint64_t{10'000}, i == 4 ? std::uint64_t{20'000} : 0};
        if (i > 0) outcome.blocks = {{1, 2, 3}, 4, 10, 5, 2560, 1024};
        s.outcomes.push_back(outcome);
    }
    return s;
}

CompressionStudy study_by_hand() {
    CompressionStudy study;
    study.setups = compression_setups(4);
    CompressionScene scene{"a.trace", "a", "by hand", "0123456789abcdef", 8, 8, 1, 1000, {{}, {}}};
    scene.runs[0].technique = "alpha_blend";
    scene.runs[0].surfaces = {surface("gains", SurfaceClass::kColor, -200'000),
                              surface("costs", SurfaceClass::kDepth, 100'000)};
    scene.runs[1].technique = "z3";
    scene.runs[1].failure = "takes no such trace";
    study.scenes.push_back(scene);
    return study;
}

TEST(CompressionStudy, SetupsTakeEveryCodec) {
    const std::vector<CompressionSetup> setups = compression_setups(7);
    ASSERT_EQ(setups.size(), 5u);
    EXPECT_TRUE(setups[0].off());
    EXPECT_EQ(setups[4].settings(),
              (std::vector<std::string>{"compression.depth=best", "compression.color=delta",
                                        "compression.nodes=used_delta", "metadata.kibibytes=7"}));
    const std::vector<std::vector<std::string>> all = {
        {"planes", "delta", "best"}, {"delta"}, {"delta", "used", "used_delta"}};
    for (std::size_t c = 0; c < all.size(); ++c)
        for (const std::string& codec : all[c])
            EXPECT_TRUE(std::ranges::any_of(setups, [&](const auto& s) { return s.codecs[c] == codec; }));
}

TEST(CompressionStudy, BothRatiosFollowFromTheCounts) {
    const CompressionStudy study = study_by_hand();
    const StudiedSurface& costs = study.scenes[0].runs[0].surfaces[1];
    EXPECT_DOUBLE_EQ(storage_ratio(costs.outcomes[3].blocks), 2.5);
    EXPECT_EQ(storage_ratio(costs.outcomes[0].blocks), 0);
    // 1.5 MB become 1.81, and 1.93 with states in memory.
    EXPECT_NEAR(saved_share(costs.outcomes[0].pins, costs.outcomes[3].pins), -0.31 / 1.5, 1e-12);
    EXPECT_NEAR(saved_share(costs.outcomes[0].pins, costs.outcomes[4].pins), -0.43 / 1.5, 1e-12);
    EXPECT_EQ(study.scenes[0].runs[0].pins(3).sum(),
              400'000u + 500'000 + 10'000 + 1'300'000 + 500'000 + 10'000);
}

TEST(CompressionOutput, LossesComeFirstAndAreMarked) {
    const CompressionStudy study = study_by_hand();
    const std::string table = compression_table(study);
    EXPECT_THAT(table, HasSubstr("z3: takes no such trace\n"));
    EXPECT_THAT(table, HasSubstr("loses -20.7"));
    EXPECT_THAT(table, Not(HasSubstr("loses 3")));
    // A row for each codec of depth, one for colour's, in order of what they save.
    const std::size_t best = table.find("depth best");
    const std::size_t delta = table.find("depth delta");
    const std::size_t planes = table.find("depth planes");
    const std::size_t color = table.find("color delta");
    EXPECT_LT(best, delta);
    EXPECT_LT(delta, planes);
    EXPECT_LT(planes, color);
    EXPECT_EQ(table.find("color delta", color + 1), std::string::npos);
    const nlohmann::json json = nlohmann::json::parse(compression_json(study));
    const nlohmann::json& run = json["scenes"][0]["runs"][0];
    EXPECT_EQ(run["surfaces"]["costs"]["outcomes"][3]["blocks"]["of_128_bytes"], 3);
    EXPECT_LT(run["surfaces"]["costs"]["outcomes"][3]["pins"]["saved_share"], 0);
    EXPECT_GT(run["frame"][3]["pins"]["saved_share"], 0);
    EXPECT_EQ(json["scenes"][0]["runs"][1]["why_null"], "takes no such trace");
}

}  // namespace
}  // namespace ropsim
