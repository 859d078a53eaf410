// Spread over arrival orders: figures by closed form, and two fragments whose every order is known.
#include "analysis/order_sensitivity.h"

#include "base/error.h"
#include "tests/traces/scratch.h"
#include "traces/generators.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using testing::Each;
using testing::HasSubstr;

Image image_of(const std::vector<std::array<float, 3>>& pixels) {
    Image image(static_cast<int>(pixels.size()), 1, {"R", "G", "B", "layers"});
    for (std::size_t i = 0; i < pixels.size(); ++i)
        std::copy(pixels[i].begin(), pixels[i].end(), &image.values[4 * i]);
    return image;
}

TEST(ImageSpread, IsThatOfItsValues) {
    // The middle pixel takes no part.
    ImageSpread spread({0, 2});
    spread.add(image_of({{0, 0.5f, 0.2f}, {1, 1, 1}, {0.1f, 0.1f, 0.1f}}));
    spread.add(image_of({{1, 0.5f, 0.4f}, {0, 0, 0}, {0.1f, 0.1f, 0.1f}}));
    spread.add(image_of({{0.5f, 0.5f, 0.6f}, {1, 1, 1}, {0.1f, 0.1f, 0.1f}}));
    const SpreadFigures f = spread.figures();
    // Variances 0.25, 0, 0.04 and three of 0.
    EXPECT_NEAR(f.rms_sd8, 255 * std::sqrt((0.25 + 0.04) / 6), 1e-4);
    EXPECT_NEAR(f.mean_spread8, 255 * (1 + 0.4) / 6, 1e-4);
    EXPECT_EQ(f.max_spread8, 255);
    EXPECT_EQ(f.differing, 0.5);
}

TEST(ImageSpread, ClampsAsTheErrorDoes) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    ImageSpread spread({0});
    spread.add(image_of({{2, -1, nan}}));
    spread.add(image_of({{7, 0, 0}}));
    EXPECT_NEAR(spread.figures().max_spread8, 255, 0);
    EXPECT_NEAR(spread.figures().mean_spread8, 255 / 3.0, 1e-12);
    EXPECT_EQ(rmse8_over(image_of({{2, 0.5f, 0}}), image_of({{1, 0, nan}}), {0}),
              std::sqrt((0 + 127.5 * 127.5 + 255.0 * 255.0) / 3));
    EXPECT_TRUE(std::isnan(rmse8_over(image_of({{0, 0, 0}}), image_of({{0, 0, 0}}), {})));
}

class OrderSensitivityRuns : public ScratchTest {
 protected:
    void SetUp() override {
        ScratchTest::SetUp();
        ASSERT_EQ(setenv("XDG_CACHE_HOME", path("").c_str(), 1), 0);
        std::filesystem::create_directory(path("out"));
        options_.trace = path("t");
        options_.directory = path("out");
    }
    void write(const std::vector<Fragment>& fragments) {
        TraceHeader header;
        header.width = 8;
        header.height = 8;
        header.background = {0, 0, 1};
        header.draws.resize(1);
        write_trace(path("t"), header, fragments);
    }
    static Fragment fragment(float z, float a, float r, float g, std::uint32_t primitive) {
        return {z, a * r, a * g, 0, a, 3, 4, primitive, 1, 0};
    }
    OrderSensitivityOptions options_;
};

// Red of alpha 1/2 in front of green of alpha 1/4, over blue: drawn far to near (1/2, 1/8, 3/8), near to far
// (3/8, 1/4, 3/8).
TEST_F(OrderSensitivityRuns, TwoFragmentsByClosedForm) {
    write({fragment(0.25f, 0.5f, 1, 0, 0), fragment(0.5f, 0.25f, 0, 1, 1)});
    options_.techniques = {"alpha_blend:format=float32", "a_buffer:format=float32", "weighted_blended"};
    options_.orders = 12;
    const OrderSensitivity study = run_order_sensitivity(options_);
    EXPECT_EQ(study.covered_pixels, 1u);
    const OrderSensitivityOfTechnique& blend = study.techniques[0];
    const double wrong = 255 * std::sqrt((1.0 / 64 + 1.0 / 64) / 3);
    EXPECT_NEAR(blend.named_rmse8_covered[0], wrong, 1e-4);  // arrived near to far
    EXPECT_NEAR(blend.named_rmse8_covered[1], wrong, 1e-4);
    EXPECT_NEAR(blend.named_rmse8_covered[2], 0, 1e-4);
    ASSERT_EQ(blend.random_rmse8_covered.size(), 12u);
    int near_first = 0;
    for (const double error : blend.random_rmse8_covered) {
        EXPECT_TRUE(std::abs(error) < 1e-4 || std::abs(error - wrong) < 1e-4) << error;
        near_first += error > wrong / 2 ? 1 : 0;
    }
    ASSERT_GT(near_first, 0);
    ASSERT_LT(near_first, 12);
    // Two values 1/8 apart in red and green, k and 12 - k times.
    const double variance = near_first * (12 - near_first) / (12.0 * 11.0) / 64;
    EXPECT_NEAR(blend.spread.rms_sd8, 255 * std::sqrt(2 * variance / 3), 1e-4);
    EXPECT_NEAR(blend.spread.max_spread8, 255 / 8.0, 1e-4);
    EXPECT_NEAR(blend.spread.mean_spread8, 255 * 2 / 8.0 / 3, 1e-4);
    EXPECT_EQ(blend.spread.differing, 1);
    EXPECT_FALSE(blend.any_order);
    const OrderSensitivityOfTechnique& lists = study.techniques[1];
    EXPECT_EQ(lists.spread.max_spread8, 0);
    EXPECT_EQ(lists.spread.differing, 0);
    EXPECT_THAT(lists.random_rmse8_covered, Each(testing::Lt(1e-4)));
    EXPECT_TRUE(study.techniques[2].any_order);
    EXPECT_LT(study.techniques[2].spread.max_spread8, 0.3);  // float16 sums
    // No reordered trace is left.
    EXPECT_TRUE(std::filesystem::is_empty(path("out")));
}

// Draws and primitives stay with their fragments: a technique whose draws are keyed by them and whose result
// knows no order gives the same image in all.
TEST_F(OrderSensitivityRuns, RandomDrawsStayWithTheirFragments) {
    RandomFragments random;
    random.count = 400;
    random.width = random.height = 8;
    random.draws = 2;
    write_trace(path("t"), random_header(random), random_fragments(random));
    options_.techniques = {"stochastic:samples=8", "hashed_alpha:hash=primitive", "alpha_blend"};
    options_.orders = 3;
    const OrderSensitivity study = run_order_sensitivity(options_);
    EXPECT_EQ(study.techniques[0].spread.max_spread8, 0);
    EXPECT_GT(study.techniques[0].random_rmse8_covered[0], 1);
    EXPECT_TRUE(study.techniques[0].random);
    EXPECT_EQ(study.techniques[1].spread.max_spread8, 0);
    EXPECT_GT(study.techniques[2].spread.rms_sd8, 5);
    // The orders are seeded: the same again, others with another seed.
    EXPECT_EQ(order_sensitivity_json(study), order_sensitivity_json(run_order_sensitivity(options_)));
    options_.order_seed = 100;
    EXPECT_NE(study.techniques[2].random_rmse8_covered,
              run_order_sensitivity(options_).techniques[2].random_rmse8_covered);
}

TEST_F(OrderSensitivityRuns, OutputsHoldEveryFigure) {
    write({fragment(0.25f, 0.5f, 1, 0, 0), fragment(0.5f, 0.25f, 0, 1, 1)});
    options_.orders = 2;
    options_.techniques = {"alpha_blend", "slab:layers=4,bits=8"};
    const OrderSensitivity study = run_order_sensitivity(options_);
    const nlohmann::json json = nlohmann::json::parse(order_sensitivity_json(study));
    EXPECT_EQ(json["techniques"][1]["technique"], "slab:layers=4,bits=8");
    EXPECT_EQ(json["techniques"][0]["rmse8_covered"]["random"].size(), 2u);
    EXPECT_EQ(json["techniques"][0]["rmse8_covered"]["far_to_near"],
              study.techniques[0].named_rmse8_covered[2]);
    for (const char* key : {"rms_sd8", "mean_spread8", "max_spread8", "differing_share", "any_order"}) {
        EXPECT_TRUE(json["units"].contains(key)) << key;
        EXPECT_TRUE(json["techniques"][0].contains(key)) << key;
    }
    const std::string csv = order_sensitivity_csv(study);
    EXPECT_THAT(csv, HasSubstr("rmse8_covered_captured,rmse8_covered_near_to_far,rmse8_covered_far_to_near,"
                               "rmse8_covered_order_1,rmse8_covered_order_2,failure\n"));
    EXPECT_THAT(csv, HasSubstr("\n\"slab:layers=4,bits=8\",0,1,"));
    const std::string table = order_sensitivity_table(study);
    for (const char* word : {"captured", "near first", "far first", "raster", "1 pixels"})
        EXPECT_THAT(table, HasSubstr(word));
}

TEST_F(OrderSensitivityRuns, RefusalsOfDefaultsAreRowsAndOfNamedTechniquesErrors) {
    RandomFragments random;
    random.count = 50;
    random.width = random.height = 8;
    random.samples = 2;
    random.partial_coverage = true;
    write_trace(path("t"), random_header(random), random_fragments(random));
    options_.techniques = {"weighted_blended"};
    EXPECT_THROW(check_order_sensitivity(options_), UserError);
    options_.techniques = {"shadow_map"};
    EXPECT_THROW(check_order_sensitivity(options_), UserError);
    options_.techniques = {"stochastic", "stochastic"};
    EXPECT_THROW(check_order_sensitivity(options_), UserError);
    options_.techniques = {};
    EXPECT_NO_THROW(check_order_sensitivity(options_));
    options_.orders = 2;
    testing::internal::CaptureStderr();
    const OrderSensitivity study = run_order_sensitivity(options_);
    // Told once, not for each of five orders.
    const std::string told = testing::internal::GetCapturedStderr();
    const std::size_t first = told.find("weighted_blended failed");
    EXPECT_NE(first, std::string::npos) << told;
    EXPECT_EQ(told.find("weighted_blended failed", first + 1), std::string::npos) << told;
    const auto refused =
        std::ranges::find(study.techniques, "weighted_blended", [](const auto& of) { return of.technique; });
    ASSERT_NE(refused, study.techniques.end());
    EXPECT_THAT(refused->failure, HasSubstr("one sample"));
    EXPECT_THAT(order_sensitivity_table(study), testing::ContainsRegex("weighted_blended +refused: "));
    EXPECT_THAT(order_sensitivity_csv(study),
                HasSubstr("\nweighted_blended,,,,,,,,,,,,\"technique 'weighted_blended'"));
}

}  // namespace
}  // namespace ropsim
