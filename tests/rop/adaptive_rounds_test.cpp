// adaptive_error: Enderton et al. 2011, section 6, "adaptively render more passes for pixels showing larger
// variance". A pixel stops once its standard error over the rounds is the one asked for.
#include "tests/rop/pixel_moments.h"

namespace ropsim {
namespace {

using test::TestFrame;

constexpr int kSide = 64;
constexpr int kPixels = kSide * kSide;
constexpr std::uint32_t kSettledBit = 0x80;

// White in front of black, .45 each: noise in every estimate.
std::vector<Fragment> two_layers() {
    return {test::fragment_at(0, 0, 0.3f, 0.45f, {1, 1, 1}, 0),
            test::fragment_at(0, 0, 0.6f, 0.45f, {0, 0, 0}, 1)};
}

struct Adapted {
    std::vector<float> image;
    std::vector<int> rounds;  // of each pixel
    std::vector<bool> settled;
    std::map<std::string, std::uint64_t> paths;
    double mean_rounds = 0;
    double rms = 0;  // of red, from .45
};
Adapted adapted(const std::string& technique, const TraceHeader& header,
                const std::vector<Fragment>& fragments) {
    TestFrame frame(technique + ",format=float32", header, 3, 1u << 20, /*record=*/false);
    frame.draw(fragments);
    Adapted result;
    for (std::size_t p = 0; p < frame.declaration().paths.size(); ++p)
        result.paths[frame.declaration().paths[p]] = frame.log().path_count(p);
    result.image = frame.image();
    const Surface& rounds = *std::ranges::find(frame.declaration().surfaces, "rounds", &Surface::name);
    for (int i = 0; i < kPixels; ++i) {
        const std::uint32_t word =
            frame.words(i % kSide, i / kSide)[static_cast<std::size_t>(rounds.first_word)];
        result.rounds.push_back(static_cast<int>(word & ~kSettledBit));
        result.settled.push_back((word & kSettledBit) != 0);
        result.mean_rounds += result.rounds.back() / static_cast<double>(kPixels);
        result.rms += std::pow(result.image[static_cast<std::size_t>(3 * i)] - 0.45, 2) / kPixels;
    }
    result.rms = std::sqrt(result.rms);
    return result;
}
TraceHeader black() {
    return test::header_of(kSide, kSide, 1, {0, 0, 0});
}

// One layer and the depth-based method have no variance: two rounds, which it takes to see that, and no pass
// after them.
TEST(AdaptiveRounds, EndWhenNoPixelGoesOn) {
    for (const char* technique : {"stochastic", "laine_karras"}) {
        const Adapted one =
            adapted(technique + std::string(":method=depth_based,samples=64,hardware_samples="
                                            "4,adaptive_error=1,adaptive_rounds=2"),
                    black(), test::everywhere(black(), {test::fragment_at(0, 0, 0.5f, 0.45f, {1, 1, 1})}));
        EXPECT_EQ(std::ranges::count(one.rounds, 2), kPixels) << technique;
        EXPECT_EQ(std::ranges::count(one.settled, true), kPixels);
        EXPECT_EQ(one.paths.at("go_on"), static_cast<std::uint64_t>(kPixels)) << "after the first";
        EXPECT_EQ(one.paths.at("settle"), static_cast<std::uint64_t>(kPixels));
        EXPECT_EQ(one.paths.at("settled"), 0u) << "no third round";
        EXPECT_EQ(one.paths.at("accumulate"), 2u * kPixels);
        EXPECT_LT(one.rms, 1e-6);
    }
}

// Pixels with noise run on, and those without pay a look at their word: left one layer, right two.
TEST(AdaptiveRounds, RunOnWhereThereIsNoise) {
    auto fragments = test::everywhere(black(), two_layers());
    std::erase_if(fragments, [](const Fragment& f) { return f.x < kSide / 2 && f.primitive == 1; });
    const Adapted half = adapted(
        "stochastic:method=depth_based,samples=64,hardware_samples=4,adaptive_error=5,adaptive_rounds=2",
        black(), fragments);
    double right = 0;
    for (int i = 0; i < kPixels; ++i) {
        if (i % kSide < kSide / 2) {
            ASSERT_EQ(half.rounds[static_cast<std::size_t>(i)], 2);
        } else {
            right += half.rounds[static_cast<std::size_t>(i)] / (kPixels / 2.0);
        }
    }
    EXPECT_GT(right, 6);
    EXPECT_EQ(*std::ranges::max_element(half.rounds), 16);
    // Each of the left's pixels has its layer turned away in each of the 14 rounds left.
    EXPECT_GT(half.paths.at("settled_write"), 14u * kPixels / 2);
    EXPECT_EQ(half.paths.at("settled_write"), half.paths.at("settled_accumulate"));
}

// Round for round: a pixel of n rounds has the colour that n rounds give without adapting, and n is the first
// of at least 2 whose standard error, worked out from those colours in double precision, is as asked.
TEST(AdaptiveRounds, StopAtTheStandardErrorAskedFor) {
    const auto fragments = test::everywhere(black(), two_layers());
    const double asked = 20 / 255.0;
    const Adapted got =
        adapted("stochastic:samples=64,hardware_samples=4,strata=pass,adaptive_error=20,adaptive_rounds=2",
                black(), fragments);
    std::vector<std::vector<float>> images(1);
    for (int n = 1; n <= 16; ++n)
        images.push_back(test::image_of(
            "stochastic:format=float32,hardware_samples=4,strata=pass,samples=" + std::to_string(4 * n),
            black(), fragments, 3));
    int different = 0;
    for (std::size_t p = 0; p < kPixels; ++p) {
        double sum = 0;
        double squares = 0;
        int n = 1;
        for (; n <= 16; ++n) {
            const auto at = [&](int round) {
                return static_cast<double>(images[static_cast<std::size_t>(round)][3 * p]);
            };
            const double x = n == 1 ? at(1) : n * at(n) - (n - 1) * at(n - 1);
            sum += x;
            squares += x * x;
            if (n >= 2 && (squares - sum * sum / n) / (n * (n - 1.0)) <= asked * asked) break;
        }
        if (got.rounds[p] != std::min(n, 16)) ++different;
        EXPECT_EQ(got.settled[p], got.rounds[p] < 16 || n == 16) << p;
        ASSERT_NEAR(got.image[3 * p], images[static_cast<std::size_t>(got.rounds[p])][3 * p], 1e-6);
    }
    EXPECT_LE(different, kPixels / 500) << "by rounding at the limit";
}

// The smaller the error asked for, the more rounds and the smaller the error.
TEST(AdaptiveRounds, FollowTheErrorAskedFor) {
    const auto fragments = test::everywhere(black(), two_layers());
    double rounds = 17;
    double rms = 0;
    for (const int asked : {2, 5, 10, 20}) {
        const Adapted got =
            adapted("stochastic:method=depth_based,samples=64,hardware_samples=4,adaptive_error=" +
                        std::to_string(asked),
                    black(), fragments);
        EXPECT_LT(got.mean_rounds, rounds) << asked;
        EXPECT_GT(got.rms, rms) << asked;
        rounds = got.mean_rounds;
        rms = got.rms;
        if (asked < 10) continue;
        EXPECT_LT(got.rms * 255, 1.2 * asked);
    }
}

// What an estimate from few rounds cannot know: rounds of 4 samples take few different values, and two that
// happen to agree have no spread. Of one layer of .45 with the basic method, R is 1 or 2 with probabilities
// .2 and .8: .68 of the pixels stop after two rounds whatever error is asked for, one in 17 of them at 1/4.
TEST(AdaptiveRounds, StopEarlyWhereTwoRoundsAgree) {
    const Adapted got =
        adapted("stochastic:samples=64,hardware_samples=4,strata=pass,adaptive_error=1,adaptive_rounds=2",
                black(), test::everywhere(black(), {test::fragment_at(0, 0, 0.5f, 0.45f, {1, 1, 1})}));
    double two = 0;
    double low = 0;
    for (std::size_t p = 0; p < kPixels; ++p) {
        if (got.rounds[p] != 2) continue;
        two += 1.0 / kPixels;
        if (got.image[3 * p] == 0.25f) low += 1.0 / kPixels;
    }
    EXPECT_NEAR(two, 0.68, 4 * std::sqrt(0.68 * 0.32 / kPixels));
    EXPECT_NEAR(low, 0.04, 4 * std::sqrt(0.04 * 0.96 / kPixels));
}

// The least number of rounds keeps pixels from stopping where the first two agree by accident: no pixel has
// fewer, and the error reached falls.
TEST(AdaptiveRounds, LeastRounds) {
    const auto fragments = test::everywhere(black(), two_layers());
    const std::string technique = "stochastic:samples=64,hardware_samples=4,adaptive_error=5";
    double last = 1;
    for (const int least : {2, 4, 8}) {
        const Adapted got =
            adapted(technique + ",adaptive_rounds=" + std::to_string(least), black(), fragments);
        EXPECT_EQ(*std::ranges::min_element(got.rounds), least);
        EXPECT_LT(got.rms, 0.9 * last) << least;
        last = got.rms;
    }
    const Adapted by_default = adapted(technique, black(), fragments);
    EXPECT_EQ(*std::ranges::min_element(by_default.rounds), 4);
}

}  // namespace
}  // namespace ropsim
