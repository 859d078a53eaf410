// What a study of cache sizes derives from its counts, on curves made by hand, and its picture.
#include "analysis/cache_sizes.h"

#include "analysis/cache_sizes_output.h"

#include <gmock/gmock.h>

namespace ropsim {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// 1100 bytes without a cache, 100 with an endless one; by size of the ideal cache and of the real ones.
CacheSizesRun by_hand() {
    CacheSizesRun run;
    run.technique = "alpha_blend";
    run.worst_case = {400, 400};
    run.touched = {300, 200};
    run.uncached = {600, 500};
    run.surfaces = {"color"};
    for (const auto& [size, bytes] : std::vector<std::pair<std::uint64_t, std::uint64_t>>{
             {1024, 1100}, {2048, 700}, {4096, 600}, {8192, 106}, {16384, 105}, {0, 100}})
        run.sweep.ideal.push_back({size, {{bytes - 50, 50}}, 0.5});
    for (const auto& [size, bytes] :
         std::vector<std::pair<std::uint32_t, std::uint64_t>>{{4096, 900}, {8192, 208}, {16384, 200}}) {
        SweptCache cache{size, {}, BytesByCause(1), BytesByCause(1)};
        cache.pins[0][0] = {bytes / 2, 0, 0};
        cache.pins[0][1] = {0, bytes - bytes / 2, 0};
        run.sweep.caches.push_back(cache);
    }
    return run;
}

CacheSizes study_by_hand() {
    CacheSizes study;
    study.options.kibibytes = {4, 8, 16};
    study.options.techniques = {"alpha_blend", "z3"};
    study.ways = 4;
    CacheSizesScene scene{"a.trace", "a", "by hand", "0123456789abcdef", 8, 8, 1, 100, {by_hand(), {}}};
    scene.runs[1].technique = "z3";
    scene.runs[1].failure = "takes no such trace";
    study.scenes.push_back(scene);
    return study;
}

TEST(CacheSizesRun, WorkingSetsFollowFromTheCounts) {
    const CacheSizesRun run = by_hand();
    EXPECT_EQ(run.floor().sum(), 100u);
    EXPECT_EQ(run.pins(1).sum(), 208u);
    EXPECT_EQ(run.ideal_of(4096).sum(), 600u);
    EXPECT_DOUBLE_EQ(*run.saved_share(1024), 0.0);
    EXPECT_DOUBLE_EQ(*run.saved_share(2048), 0.4);
    EXPECT_DOUBLE_EQ(*run.saved_share(5000), 0.5);  // that of 4096
    EXPECT_EQ(run.half_saved(), 4096u);
    // 106 is 6% above 100, 105 is 5%; 208 is 4% above 200.
    EXPECT_EQ(run.near_floor(), 16384u);
    EXPECT_EQ(run.near_largest(), 8192u);
}

TEST(CacheSizesRun, NothingToSaveHasNoShare) {
    CacheSizesRun run = by_hand();
    for (IdealCache& ideal : run.sweep.ideal) ideal.surfaces[0] = run.uncached;
    EXPECT_FALSE(run.saved_share(4096));
    EXPECT_FALSE(run.half_saved());
    EXPECT_EQ(run.near_floor(), 1024u);
}

TEST(CacheSizesOutput, TableAndPictureLeaveOutWhatWasRefused) {
    const CacheSizes study = study_by_hand();
    const std::string table = cache_sizes_table(study);
    EXPECT_THAT(table, HasSubstr("alpha_blend"));
    EXPECT_THAT(table, HasSubstr("z3: takes no such trace\n"));
    const std::string script = cache_sizes_plot_script(study, "a.svg", "a.png");
    EXPECT_THAT(script, HasSubstr("$cache_0 << EOD\n2 9\n3 2.08\n4 2\nEOD"));
    EXPECT_THAT(script, HasSubstr("$ideal_0 << EOD\n2 6\n3 1.06\n4 1.05\nEOD"));
    EXPECT_THAT(script, Not(HasSubstr("$cache_1")));
    EXPECT_THAT(cache_sizes_json(study), HasSubstr("\"why_null\": \"takes no such trace\""));
}

}  // namespace
}  // namespace ropsim
