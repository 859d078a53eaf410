// The worst pixels that `ropsim stress --worst` found, kept: none gets worse, and none is no colour.
#include "analysis/stress/stress_moves.h"
#include "analysis/stress/stress_search.h"
#include "base/atomic_file.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

const std::vector<WorstPixel>& worst_pixels() {
    static const std::string path = std::string(ROPSIM_SOURCE_DIR) + "/tests/analysis/worst_pixels.json";
    static const std::vector<WorstPixel> pixels = read_worst_pixels(read_file(path), path);
    return pixels;
}

// The bits are the same on every machine. An error that falls is an improvement: search again and keep what
// is found (`ropsim stress --worst`).
TEST(WorstPixels, HaveTheErrorsTheyWereFoundWith) {
    std::set<std::string> techniques;
    for (const WorstPixel& worst : worst_pixels()) {
        StressedPixel stressed(worst.technique, 0);
        const auto goal = static_cast<std::size_t>(worst.goal);
        EXPECT_NEAR(stressed.error(worst.pixel, worst.goal), worst.error, 1e-6 * worst.error + 1e-12)
            << worst.technique << " " << kStressGoalNames[goal];
        EXPECT_TRUE(stressed.is_color(worst.pixel)) << worst.technique << " " << kStressGoalNames[goal];
        techniques.insert(worst.technique);
    }
    EXPECT_GE(techniques.size(), 22u);
}

// The search did better than random pixels of the same kind; how many more of them were held against it,
// docs/stability.md says.
TEST(WorstPixels, AreWorseThanTheFirstRandomPixels) {
    constexpr int kPixels = 200;
    for (const WorstPixel& worst : worst_pixels()) {
        StressedPixel stressed(worst.technique, 0);
        for (int i = 0; i < kPixels; ++i) {
            const PixelScene pixel = random_pixel(static_cast<std::uint64_t>(i), 199, false);
            ASSERT_LE(stressed.error(pixel, worst.goal), 1.1 * worst.error + 1e-12)
                << worst.technique << " " << kStressGoalNames[static_cast<std::size_t>(worst.goal)];
        }
    }
}

// The search finds what is known: blending in arrival order can be wrong by all there is, a sorted list by
// nothing but rounding.
TEST(StressSearch, FindsKnownWorstCases) {
    StressSearch search;
    search.techniques = {"alpha_blend", "a_buffer:format=float32"};
    search.evaluations = 2000;
    const std::vector<WorstPixel> found = search_worst_pixels(search);
    ASSERT_EQ(found.size(), 6u);
    EXPECT_GT(found[2].error, 0.9);
    EXPECT_LT(found[5].error, 1e-12);
    EXPECT_GT(found[4].error, 0.0);
    EXPECT_LT(found[4].error, 48 * 3 * 0x1p-24);
    // The same again, on two threads, and through the file.
    search.threads = 2;
    const std::vector<WorstPixel> again = search_worst_pixels(search);
    const std::vector<WorstPixel> read = read_worst_pixels(worst_pixels_json(found), "test");
    ASSERT_EQ(read.size(), found.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_EQ(found[i].error, again[i].error);
        EXPECT_EQ(found[i].error, read[i].error);
        StressedPixel stressed(read[i].technique, 0);
        EXPECT_EQ(stressed.error(read[i].pixel, read[i].goal), found[i].error);
    }
}

}  // namespace
}  // namespace ropsim
