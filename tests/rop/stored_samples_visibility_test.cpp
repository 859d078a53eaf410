// Techniques of stored samples say their visibility as their composite takes it: the colour that the
// depth-based method accumulates is rebuilt from it (Enderton et al. 2011, equation 4).
#include "tests/rop/random_fragments.h"

#include <gtest/gtest.h>

namespace ropsim::test {
namespace {

class SampleVisibility : public ::testing::TestWithParam<const char*> {};

TEST_P(SampleVisibility, RebuildsTheAccumulatedColour) {
    Random random(11);
    TraceHeader header = header_of(16, 8, 1, {0, 0, 0});
    header.draws.resize(4);
    FragmentOptions options;
    options.count = 1500;
    const std::vector<Fragment> fragments = random_fragments(header, options, random);
    TestFrame frame(std::string(GetParam()) + ":samples=16,method=depth_based,correction=none,format=float32",
                    header);
    ASSERT_TRUE(frame.operation().has_visibility());
    frame.draw(fragments);
    const std::vector<float> image = frame.image();
    for (int y = 0; y < header.height; ++y)
        for (int x = 0; x < header.width; ++x) {
            const std::vector<Fragment> own = nearest_first(fragments, x, y);
            std::vector<float> depths;
            for (const Fragment& f : own) depths.push_back(f.z);
            std::vector<float> visible(depths.size());
            frame.operation().visibility(frame.store(), x, y, depths, visible);
            std::array<double, 3> sum{};
            for (std::size_t i = 0; i < own.size(); ++i) {
                sum[0] += static_cast<double>(visible[i]) * static_cast<double>(own[i].r);
                sum[1] += static_cast<double>(visible[i]) * static_cast<double>(own[i].g);
                sum[2] += static_cast<double>(visible[i]) * static_cast<double>(own[i].b);
                if (i > 0) {
                    EXPECT_LE(visible[i], visible[i - 1]);
                }
                EXPECT_EQ(visible[i] * 16, std::floor(visible[i] * 16));
            }
            for (std::size_t c = 0; c < 3; ++c)
                EXPECT_NEAR(image[static_cast<std::size_t>(3 * (y * header.width + x)) + c], sum[c], 1e-5)
                    << x << "," << y;
        }
}

// The expected share is the product of the transmittances in front: 400 pixels with the same two fragments,
// independent draws, within 4.5 standard errors of a share of 16 coins (masks of floor(alpha S + xi) samples
// scatter less).
TEST_P(SampleVisibility, IsUnbiased) {
    TraceHeader header = header_of(20, 20, 1);
    header.draws.resize(1);
    std::vector<Fragment> fragments;
    for (int y = 0; y < 20; ++y)
        for (int x = 0; x < 20; ++x) {
            fragments.push_back(fragment_at(x, y, 0.5f, 0.3f, {1, 1, 1}, 1));
            fragments.push_back(fragment_at(x, y, 0.25f, 0.6f, {1, 1, 1}, 0));
        }
    for (Fragment& f : fragments) f.coverage = 1;
    for (const char* method : {"basic", "depth_based"}) {
        TestFrame frame(std::string(GetParam()) + ":samples=16,method=" + method, header);
        frame.draw(fragments);
        std::array<double, 3> mean{};
        for (int y = 0; y < 20; ++y)
            for (int x = 0; x < 20; ++x) {
                const std::array<float, 3> depths{0.25f, 0.5f, 0.75f};
                std::array<float, 3> visible{};
                frame.operation().visibility(frame.store(), x, y, depths, visible);
                for (std::size_t i = 0; i < 3; ++i) mean[i] += static_cast<double>(visible[i]) / 400;
            }
        EXPECT_NEAR(mean[0], 1, 1e-9);
        EXPECT_NEAR(mean[1], 0.4, 4.5 * std::sqrt(0.4 * 0.6 / 16 / 400));
        EXPECT_NEAR(mean[2], 0.28, 4.5 * std::sqrt(0.28 * 0.72 / 16 / 400));
    }
}

INSTANTIATE_TEST_SUITE_P(, SampleVisibility, ::testing::Values("stochastic", "laine_karras"));

}  // namespace
}  // namespace ropsim::test
