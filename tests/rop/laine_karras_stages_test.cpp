// The stages of Laine and Karras 2011, section 4, one at a time: Figure 5's two layers of alpha 1/2 over 16
// samples. The nearer takes 8; of the farther 4 should be left.
#include "tests/rop/pixel_moments.h"

namespace ropsim {
namespace {

constexpr int kSide = 128;

// Samples of the farther layer in each pixel: moments, and whether the nearer has 8 in all.
test::Moments far_samples(const std::string& technique, bool near_first) {
    const Fragment near = test::fragment_at(0, 0, 0.25f, 0.5f, {1, 0, 0}, 0);
    const Fragment far = test::fragment_at(0, 0, 0.75f, 0.5f, {0, 1, 0}, 1);
    const auto image = test::image_of_layers(
        technique + ",samples=16,format=float32",
        near_first ? std::vector<Fragment>{near, far} : std::vector<Fragment>{far, near}, {0, 0, 1}, kSide,
        0);
    std::vector<std::pair<double, double>> counts;
    for (std::size_t i = 0; i < image.size(); i += 3) {
        EXPECT_EQ(image[i], 0.5f) << "nearer";
        counts.emplace_back(16 * image[i + 1], 1.0 / (kSide * kSide));
    }
    return test::moments_of(counts);
}
void expect_four(const std::string& technique, bool near_first) {
    const test::Moments m = far_samples(technique, near_first);
    EXPECT_EQ(m.mean, 4.0) << technique << " near first: " << near_first;
    EXPECT_EQ(m.variance, 0.0) << technique << " near first: " << near_first;
}
// Within 4 standard errors of a distribution over the pixels, which the hash does not make independent: the
// deviation gets 0.06 in all cases.
void expect_spread(const std::string& technique, bool near_first, double deviation) {
    const test::Moments m = far_samples(technique, near_first);
    EXPECT_NEAR(m.mean, 4, 4 * deviation / kSide) << technique << " near first: " << near_first;
    EXPECT_NEAR(m.deviation(), deviation, 0.06) << technique << " near first: " << near_first;
}

// Figure 5d: with everything on exactly 4 in every pixel, in both orders, whatever the hash.
TEST(FigureFiveStages, EverythingOnIsExactInBothOrders) {
    for (const char* hash : {"paper", "improved"})
        for (const char* index : {"hilbert", "morton"})
            for (const bool near_first : {true, false})
                expect_four(std::string("laine_karras:hash=") + hash + ",index=" + index, near_first);
}

// Figure 5a: without compaction the mean is 4 and nothing more, in both orders. A random Owen scramble halves
// each of 8 pairs of samples by itself: spread sqrt(8) / 2 = 1.41, as hash=improved has it. In Figure 4's
// hash, bit 1 of the index does not reach the highest bit of the result, so that fours go together: 4 x
// {0, 2}, spread 2, 1.98 in 65,536 pixels.
TEST(FigureFiveStages, WithoutCompactionTheFarLayerIsNoisy) {
    for (const bool near_first : {true, false}) {
        expect_spread("laine_karras:compaction=false", near_first, 2);
        expect_spread("laine_karras:compaction=false,hash=improved", near_first, std::sqrt(2.0));
    }
}

// Figures 5b and 5c: compaction alone is exact from near to far, and as noisy as nothing from far to near.
TEST(FigureFiveStages, CompactionAloneIsExactFromNearToFar) {
    for (const char* hash : {"paper", "improved"})
        expect_four(std::string("laine_karras:sort=false,hash=") + hash, true);
    expect_spread("laine_karras:sort=false", false, 2);
    expect_spread("laine_karras:sort=false,hash=improved", false, std::sqrt(2.0));
}

// The paper's comparison method, Enderton et al. with the depth test first (section 5): 8 of the 16 samples
// at random. Near to far, half of the 8 survivors: 4. Far to near, hypergeometric: 8 of 16, 8 marked,
// variance 8/4 x 8/15 = 1.067, spread 1.033. With the depth test last it is that in both orders.
TEST(FigureFiveStages, ComparisonMethod) {
    expect_four("stochastic:depth_test=first", true);
    const double deviation = std::sqrt(16.0 / 15);
    expect_spread("stochastic:depth_test=first", false, deviation);
    expect_spread("stochastic:depth_test=last", true, deviation);
    expect_spread("stochastic:depth_test=last", false, deviation);
}

// "We group surfaces together": sorting is by the depths stored before, not by drawing order or sample
// number. Four opaque quarters of a pixel at different depths, drawn in any order, and a layer of alpha 1/2
// over them takes two of each quarter's four samples.
TEST(Sorting, AStoredSurfaceKeepsItsShare) {
    test::Random random(81);
    const TraceHeader header = test::header_of(16, 16, 4, {0, 0, 0});
    std::vector<Fragment> fragments;
    for (int i = 0; i < 256; ++i) {
        std::vector<int> order = {0, 1, 2, 3};
        random.shuffle(order);
        const float first = random.real(0.4, 0.6);
        for (const int quarter : order) {
            Fragment f = test::fragment_at(
                i % 16, i / 16, first + 0.1f * static_cast<float>(quarter), 1,
                {quarter == 0 ? 1.0f : 0, quarter == 1 ? 1.0f : 0, quarter == 2 ? 1.0f : 0});
            f.coverage = static_cast<std::uint16_t>(1 << quarter);
            fragments.push_back(f);
        }
    }
    const auto veil = test::everywhere(header, {test::fragment_at(0, 0, 0.2f, 0.5f, {0, 0, 0}, 9)});
    fragments.insert(fragments.end(), veil.begin(), veil.end());
    const auto quarters = [&](const std::string& sort) {
        return test::image_of("laine_karras:samples=16,format=float32,sort=" + sort, header, fragments, 0);
    };
    for (const float share : quarters("true")) ASSERT_EQ(share, 2.0f / 16);
    EXPECT_GT(test::moments_of(quarters("false"), 0).deviation(), 0.02);
}

}  // namespace
}  // namespace ropsim
