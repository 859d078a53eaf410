// Stochastic layered alpha blending against stochastic transparency: in what sense the one becomes the other
// where there are as many coverage bits as layers (Wyman 2016, section 2), and where it does not.
#include "tests/rop/pixel_moments.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

enum class Arrival { kRandom, kNearToFar, kFarToNear };
constexpr int kSide = 24;

// `count` layers a pixel of random depth, colour and alpha below `most`.
std::vector<Fragment> random_layers(Arrival arrival, std::uint32_t count, double most = 1) {
    Random random(31);
    std::vector<Fragment> all;
    for (int i = 0; i < kSide * kSide; ++i) {
        std::vector<Fragment> own;
        for (std::uint32_t l = 0; l < count; ++l)
            own.push_back(test::fragment_at(i % kSide, i / kSide, random.real(0, 1), random.real(0, most),
                                            {random.real(0, 1), random.real(0, 1), random.real(0, 1)}, l));
        if (arrival == Arrival::kNearToFar) std::ranges::sort(own, {}, &Fragment::z);
        if (arrival == Arrival::kFarToNear) std::ranges::sort(own, std::greater<>(), &Fragment::z);
        all.insert(all.end(), own.begin(), own.end());
    }
    return all;
}

// Pixels whose colours differ by more than rounding.
int different_pixels(const std::string& a, const std::string& b, std::span<const Fragment> fragments) {
    const TraceHeader header = test::header_of(kSide, kSide);
    const auto left = test::image_of(a + ",format=float32", header, fragments);
    const auto right = test::image_of(b + ",format=float32", header, fragments);
    int count = 0;
    for (std::size_t i = 0; i < left.size(); i += 3) {
        double worst = 0;
        for (std::size_t c = 0; c < 3; ++c)
            worst = std::max(worst, std::abs(static_cast<double>(left[i + c]) - right[i + c]));
        count += worst > 1e-5 ? 1 : 0;
    }
    return count;
}

// With masks, and as many bits as layers, near to far: pixel for pixel the image of stochastic transparency
// with so many samples. A mask with a bit left takes at least one, so no more than b layers are ever stored.
TEST(SlabAndStochastic, SameImageNearToFar) {
    const auto fragments = random_layers(Arrival::kNearToFar, 30);
    for (const int n : {1, 4, 8, 33}) {
        const std::string slab = fmt::format("slab:coverage=discrete,layers={},bits={}", n, n);
        const std::string stochastic = fmt::format("stochastic:samples={}", n);
        EXPECT_EQ(different_pixels(slab, stochastic, fragments), 0) << n;
        EXPECT_EQ(
            different_pixels(slab + ",composite=normalised", stochastic + ",method=depth_based", fragments),
            0)
            << n;
        EXPECT_EQ(
            different_pixels(slab + ",probability=non_stratified", stochastic + ",masks=coin", fragments), 0)
            << n;
    }
}

// In any order, if the list never overflows: layers that came first and are now hidden cost room, not colour.
// With as many layers as bits they push visible ones out, where layers are thin and near ones come late.
TEST(SlabAndStochastic, SameImageInAnyOrderWithRoom) {
    for (const Arrival arrival : {Arrival::kRandom, Arrival::kFarToNear}) {
        const auto fragments = random_layers(arrival, 30, 0.3);
        const auto different = [&](int layers) {
            return different_pixels(fmt::format("slab:coverage=discrete,layers={},bits=8", layers),
                                    "stochastic:samples=8", fragments);
        };
        EXPECT_EQ(different(30), 0);
        EXPECT_GT(different(8), kSide * kSide / 4);
    }
}

// Two layers of alpha 1/2, 4 bits. Stochastic transparency shows the far one in 5 of 6 pixels whatever the
// order. So do masks; but far to near they have it in the list every time.
TEST(SlabAndStochastic, FarLayerShowsInFiveOfSix) {
    constexpr int kWide = 256;
    constexpr double kPixels = kWide * kWide;
    constexpr double p = 5.0 / 6.0;
    const TraceHeader header = test::header_of(kWide, kWide, 1, {0, 0, 1});
    const Fragment near = test::fragment_at(0, 0, 0.25f, 0.5f, {1, 0, 0}, 0);
    const Fragment far = test::fragment_at(0, 0, 0.75f, 0.5f, {0, 1, 0}, 1);
    for (const bool near_first : {true, false}) {
        const auto layers = near_first ? std::vector{near, far} : std::vector{far, near};
        const auto fragments = test::everywhere(header, layers);
        for (const char* technique : {"stochastic:samples=4", "slab:coverage=discrete,layers=4,bits=4"}) {
            const auto image =
                test::image_of(technique + std::string(",format=float32"), header, fragments, 6);
            double shown = 0;
            for (std::size_t i = 1; i < image.size(); i += 3) shown += image[i] > 0 ? 1 : 0;
            EXPECT_NEAR(shown, kPixels * p, 4 * std::sqrt(kPixels * p * (1 - p))) << technique;
        }
        TestFrame frame("slab:coverage=discrete,layers=4,bits=4", header, 6);
        frame.draw(fragments);
        const auto stored = static_cast<double>(frame.log().path_count(
                                static_cast<std::size_t>(frame.declaration().path("insert")))) -
                            kPixels;
        EXPECT_NEAR(stored, near_first ? kPixels * p : kPixels,
                    near_first ? 4 * std::sqrt(kPixels * p * (1 - p)) : 0);
    }
}

// With alphas instead of masks, far to near, every fragment of at least half a bit is inserted, however few
// bits there are: a k-buffer of those fragments.
TEST(SlabAndKBuffer, FarToNearItIsAKBufferForEveryNumberOfBits) {
    auto fragments = random_layers(Arrival::kFarToNear, 30);
    for (const int bits : {1, 2, 8, 16, 100}) {
        std::vector<Fragment> kept;
        for (const Fragment& f : fragments)
            if (std::floor(f.a * static_cast<float>(bits) + 0.5f) >= 1) kept.push_back(f);
        EXPECT_LT(kept.size(), fragments.size());
        const TraceHeader header = test::header_of(kSide, kSide);
        const auto slab =
            test::image_of(fmt::format("slab:layers=8,bits={},format=float32", bits), header, fragments);
        EXPECT_EQ(slab, test::image_of("k_buffer:layers=8,format=float32", header, kept)) << bits;
    }
}

// Unbiased as stochastic transparency is: the mean over pixels is exact compositing, at any number of bits,
// as long as nothing overflows; deviations are those of its masks.
TEST(SlabAndStochastic, MasksAreUnbiased) {
    const std::vector<Fragment> layers = {test::fragment_at(0, 0, 0.7f, 0.3f, {0.2f, 1, 0.4f}, 0),
                                          test::fragment_at(0, 0, 0.2f, 0.55f, {1, 0.5f, 0}, 1),
                                          test::fragment_at(0, 0, 0.5f, 0.05f, {0, 0, 1}, 2)};
    const auto exact = test::composited(layers, 0, 0, {0.25, 0.5, 0.75});
    for (const char* bits : {"3", "8", "48"}) {
        const auto image =
            test::image_of_layers(fmt::format("slab:coverage=discrete,layers=3,bits={},format=float32", bits),
                                  layers, {0.25f, 0.5f, 0.75f});
        for (std::size_t c = 0; c < 3; ++c) {
            const test::Moments m = test::moments_of(image, c);
            EXPECT_NEAR(m.mean, exact[c], 4 * m.deviation() / 256) << bits;
        }
    }
}

}  // namespace
}  // namespace ropsim
