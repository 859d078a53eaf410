// Bytes and fetches of filtering a stochastic shadow map: counted tap by tap, and at the sizes of McGuire and
// Mara 2017, whose "15x net bandwidth reduction" (section 8.1) and 10x (abstract) they are held against.
#include "rop/shadow/filter_cost.h"
#include "rop/shadow/variance_shadow_map.h"

#include <numbers>
#include <set>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

struct Walked {
    std::uint64_t fetches = 0;
    std::uint64_t distinct = 0;
};
// One axis of a pass, texel by texel.
Walked walk(int size, int taps, int first, int step, int outputs) {
    Walked walked;
    std::set<int> read;
    for (int i = 0; i < outputs; ++i)
        for (int t = 0; t < taps; ++t) {
            ++walked.fetches;
            const int at = step * i + first + t;
            if (at >= 0 && at < size) read.insert(at);
        }
    walked.distinct = read.size();
    return walked;
}

TEST(FilterCost, PassesAreCountedTapByTap) {
    const MapShape map{52, 40, 2, 3, 4};
    for (const Reduction reduction : {Reduction::kKept, Reduction::kMean}) {
        VarianceOptions options;
        options.tent = 7;
        options.reduction = reduction;
        const AxisKernel kernel = conversion_kernel(options);
        const auto taps = static_cast<int>(kernel.weights.size());
        const Walked across = walk(52, taps, kernel.first, 4, 13);
        const Walked down = walk(40, taps, kernel.first, 4, 10);
        const std::vector<ConversionPass> passes = conversion_passes(map, options);
        ASSERT_EQ(passes.size(), 3u);
        EXPECT_EQ(passes[0].read_bytes, 3u * 52 * 40 * 2 * 4);
        EXPECT_EQ(passes[0].write_bytes, 3u * 52 * 40 * 8);
        EXPECT_EQ(passes[1].fetches, 3 * across.fetches * 40);
        EXPECT_EQ(passes[1].read_bytes, 8 * passes[1].fetches);
        EXPECT_EQ(passes[1].distinct_bytes, 24 * across.distinct * 40);
        EXPECT_EQ(passes[1].write_bytes, 3u * 13 * 40 * 8);
        EXPECT_EQ(passes[2].fetches, 3 * down.fetches * 13);
        EXPECT_EQ(passes[2].distinct_bytes, 24 * down.distinct * 13);
        EXPECT_EQ(passes[2].write_bytes, 3u * 13 * 10 * 8);
        options.passes = ConversionPasses::kFused;
        const std::vector<ConversionPass> fused = conversion_passes(map, options);
        ASSERT_EQ(fused.size(), 2u);
        EXPECT_EQ(fused[0].fetches, 2 * passes[1].fetches) << "both samples of every tap";
        EXPECT_EQ(fused[0].read_bytes, 4 * fused[0].fetches);
        EXPECT_EQ(fused[0].distinct_bytes, 3 * across.distinct * 40 * 2 * 4);
        EXPECT_EQ(fused[1].read_bytes, passes[2].read_bytes);
        options.passes = ConversionPasses::kSeparate;
        const std::vector<ConversionPass> separate = conversion_passes(map, options);
        ASSERT_EQ(separate.size(), 4u);
        for (const std::size_t tent : {1, 2}) {
            EXPECT_EQ(separate[tent].fetches, 3u * 52 * 40 * 7);
            EXPECT_EQ(separate[tent].distinct_bytes, 3u * 52 * 40 * 8);
            EXPECT_EQ(separate[tent].write_bytes, 3u * 52 * 40 * 8);
        }
        EXPECT_EQ(separate[3].fetches, 3u * 13 * 10 * (reduction == Reduction::kMean ? 16 : 1));
        EXPECT_EQ(separate[3].write_bytes, 3u * 13 * 10 * 8);
    }
}

TEST(FilterCost, AThinKernelLeavesTexelsUnread) {
    VarianceOptions options;
    options.tent = 1;
    const std::vector<ConversionPass> passes = conversion_passes({16, 16, 1, 1, 4}, options);
    EXPECT_EQ(passes[1].distinct_bytes, 4u * 16 * 8);
    EXPECT_EQ(passes[2].distinct_bytes, 4u * 4 * 8);
}

// "Around 176 texture fetches for the 15 x 15 tent filter".
TEST(FilterCost, TheDiscInTheTentHas177Texels) {
    EXPECT_EQ(disc_texels(15), 177);
    EXPECT_NEAR(std::numbers::pi * 7.5 * 7.5, 176.7, 0.05);
    EXPECT_EQ(disc_texels(1), 1);
    EXPECT_EQ(disc_texels(3), 9);
}

// Section 7: maps of 4096^2 texels filtered down to 1024^2, pictures of 1920 x 1080.
constexpr MapShape kPaper{4096, 4096, 1, 1, 4};
constexpr double kPicture = 1920.0 * 1080.0;
constexpr double kFetches = 176;

double conversion_bytes(ConversionPasses passes, bool cached) {
    VarianceOptions options;
    options.passes = passes;
    return filter_saving(kPaper, options, 0, kFetches, cached, true).conversion_bytes;
}

TEST(FilterCost, OfThePapersConversionAWavelength) {
    constexpr double kTexels = 4096.0 * 4096.0;
    // Behind a perfect cache, bytes a texel: moments 4 + 8; each tent 8 + 8, or what is left of it at a
    // quarter of the columns, then rows; the last texels.
    EXPECT_EQ(conversion_bytes(ConversionPasses::kSeparate, true), kTexels * (12 + 16 + 16 + 0.5 + 0.5));
    EXPECT_EQ(conversion_bytes(ConversionPasses::kReduced, true), kTexels * (12 + 8 + 2 + 2 + 0.5));
    EXPECT_EQ(conversion_bytes(ConversionPasses::kFused, true), kTexels * (4 + 2 + 2 + 0.5));
    // Without caches each tent fetches 15 times.
    EXPECT_EQ(conversion_bytes(ConversionPasses::kSeparate, false), kTexels * (12 + 128 + 128 + 1));
    EXPECT_EQ(conversion_bytes(ConversionPasses::kReduced, false), kTexels * (12 + 30 + 2 + 7.5 + 0.5));
    // Table 1 converts a wavelength in 1.55 ms on a GPU of 224 GB/s: 347 MB at most. Neither passes at the
    // map's size nor moments stored at it fit; fused passes do.
    constexpr double kMoved = 1.55e-3 * 224e9;
    EXPECT_GT(conversion_bytes(ConversionPasses::kSeparate, true), 2 * kMoved);
    EXPECT_GT(conversion_bytes(ConversionPasses::kReduced, true), kMoved);
    EXPECT_LT(conversion_bytes(ConversionPasses::kFused, true), 0.42 * kMoved);
}

// 176 fetches of 4 bytes against one of 8: 88 times fewer bytes at most, less what conversion costs. Where
// the ratio is 10 and where 15 depends on how many look-ups a pixel share it.
TEST(FilterCost, SavingsOfTenAndFifteenTakeSoManyLookupsAPixel) {
    const auto lookups_a_pixel = [](ConversionPasses passes, double ratio) {
        VarianceOptions options;
        options.passes = passes;
        const double lookups = lookups_for_saving(kPaper, options, ratio, kFetches, true, true);
        EXPECT_NEAR(filter_saving(kPaper, options, lookups, kFetches, true, true).ratio(), ratio, 1e-9);
        return lookups / kPicture;
    };
    EXPECT_NEAR(lookups_a_pixel(ConversionPasses::kFused, 10), 1.102, 5e-4);
    EXPECT_NEAR(lookups_a_pixel(ConversionPasses::kFused, 15), 1.766, 5e-4);
    EXPECT_NEAR(lookups_a_pixel(ConversionPasses::kReduced, 10), 3.1767, 5e-4);
    EXPECT_NEAR(lookups_a_pixel(ConversionPasses::kReduced, 15), 5.0914, 5e-4);
    EXPECT_NEAR(lookups_a_pixel(ConversionPasses::kSeparate, 10), 5.8348, 5e-4);
    EXPECT_NEAR(lookups_a_pixel(ConversionPasses::kSeparate, 15), 9.3516, 5e-4);
    VarianceOptions options;
    options.passes = ConversionPasses::kFused;
    // One look-up a pixel.
    EXPECT_NEAR(filter_saving(kPaper, options, kPicture, kFetches, true, true).ratio(), 9.17, 5e-3);
    // Counted in fetches a look-up alone, as the sentence before does, it would be 176; no number of look-ups
    // makes 88 of it in bytes.
    EXPECT_LT(lookups_for_saving(kPaper, options, 88, kFetches, true, true), 0);
    // Four texels for a bilinear fetch: 22 at most.
    EXPECT_LT(lookups_for_saving(kPaper, options, 22, kFetches, true, false), 0);
}

}  // namespace
}  // namespace ropsim
