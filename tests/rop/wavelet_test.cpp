// Wavelet transparency against its own bins in double precision, found without a wavelet; bytes, hazards,
// order.
#include "rop/visibility/haar_wavelets.h"
#include "tests/rop/random_fragments.h"
#include "tests/rop/worst_case_bytes.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

// Absorbance as a step function over bins: the Haar series up to a rank is its mean over each bin, here taken
// fragment by fragment.
class Bins {
 public:
    Bins(std::span<const Fragment> fragments, int rank) : bins_(2 << rank) {
        for (const Fragment& f : fragments) {
            nearest_ = std::min(nearest_, static_cast<double>(f.z));
            farthest_ = std::max(farthest_, static_cast<double>(f.z));
        }
        mean_.assign(static_cast<std::size_t>(bins_), 0.0);
        for (const Fragment& f : fragments)
            for (int b = 0; b < bins_; ++b)
                mean_[static_cast<std::size_t>(b)] +=
                    absorbance(f) * std::clamp(b + 1 - position(f.z), 0.0, 1.0);
    }
    static double absorbance(const Fragment& f) {
        return std::min(-std::log(1.0 - static_cast<double>(f.a)), -std::log(1e-5));
    }
    double position(double z) const {
        if (farthest_ > nearest_) return (z - nearest_) / (farthest_ - nearest_) * (bins_ - 1);
        return z > nearest_ ? bins_ - 1 : 0;
    }
    // In front of z without what `own`, at z, adds there.
    double transmittance(double z, double own) const {
        const double at = std::clamp(position(z), 0.0, bins_ - 1.0);
        const auto b = static_cast<std::size_t>(at);
        const double into = at - static_cast<double>(b);
        const double start = b == 0 ? 0.0 : mean_[b - 1];
        const double end = mean_[b] - own * (1 - into);
        return std::min(1.0, std::exp(-(start + (end - start) * into)));
    }
    double total() const { return std::exp(-mean_.back()); }

 private:
    int bins_;
    double nearest_ = 1;
    double farthest_ = 0;
    std::vector<double> mean_;
};

std::vector<Fragment> layers(int count, Random& random) {
    std::vector<Fragment> fragments;
    for (int i = 0; i < count; ++i)
        fragments.push_back(test::fragment_at(0, 0, random.real(0.2, 0.9), random.real(0.02, 0.9),
                                              {random.real(0, 1), random.real(0, 1), random.real(0, 1)}));
    return fragments;
}

TEST(Wavelet, EqualsBinsInDouble) {
    Random random(41);
    for (int rank = 1; rank <= kMaxHaarRank; ++rank) {
        for (int i = 0; i < 100; ++i) {
            const auto fragments = layers(random.integer(1, 25), random);
            TestFrame frame("wavelet:format=float32,rank=" + std::to_string(rank), test::header_of(1, 1));
            frame.draw(fragments);
            const Bins bins(fragments, rank);
            double alpha = 0;
            std::array<double, 3> sum{};
            for (const Fragment& f : fragments) {
                const double t = bins.transmittance(f.z, Bins::absorbance(f));
                alpha += t * f.a;
                sum = {sum[0] + t * f.r, sum[1] + t * f.g, sum[2] + t * f.b};
            }
            const auto color = frame.color();
            const auto background = test::background_of(frame.header(), 0, 0);
            for (std::size_t c = 0; c < 3; ++c)
                ASSERT_NEAR(color[c], sum[c] / alpha * (1 - bins.total()) + bins.total() * background[c],
                            3e-5)
                    << "rank " << rank;
            std::vector<float> depths;
            for (int k = 0; k < 40; ++k) depths.push_back(random.real(0, 1));
            std::vector<float> values(depths.size());
            frame.operation().visibility(frame.store(), 0, 0, depths, values);
            for (std::size_t k = 0; k < depths.size(); ++k)
                ASSERT_NEAR(values[k], bins.transmittance(depths[k], 0), 3e-5) << "rank " << rank;
        }
    }
}

// RMS of vis(z) against the product in front, at random depths.
TEST(Wavelet, ApproachesTheTransmittanceAsRankGrows) {
    double before = 1;
    for (int rank = 1; rank <= kMaxHaarRank; ++rank) {
        Random random(42);
        double sum = 0;
        int count = 0;
        for (int i = 0; i < 300; ++i) {
            const auto fragments = layers(12, random);
            TestFrame frame("wavelet:format=float32,rank=" + std::to_string(rank), test::header_of(1, 1));
            frame.draw_pass(0, fragments);
            frame.draw_pass(1, fragments);
            for (int k = 0; k < 20; ++k, ++count) {
                const std::array<float, 1> z = {random.real(0, 1)};
                std::array<float, 1> value{};
                frame.operation().visibility(frame.store(), 0, 0, z, value);
                double exact = 1;
                for (const Fragment& f : fragments)
                    if (f.z < z[0]) exact *= 1.0 - static_cast<double>(f.a);
                sum += std::pow(value[0] - exact, 2);
            }
        }
        const double rms = std::sqrt(sum / count);
        EXPECT_LT(rms, 0.8 * before) << rank;
        before = rms;
    }
}

// The nearest and the farthest of a pixel's fragments are at both ends of its range: two layers are exact,
// and so is one.
TEST(Wavelet, TwoLayersAreExact) {
    Random random(43);
    const TraceHeader header = test::header_of(20, 20);
    std::vector<Fragment> fragments;
    for (int i = 0; i < 400; ++i)
        for (int k = 0; k <= i % 2; ++k)
            fragments.push_back(test::fragment_at(i % 20, i / 20, random.real(0, 1), random.real(0.01, 0.99),
                                                  {random.real(0, 1), random.real(0, 1), random.real(0, 1)}));
    for (const char* rank : {"1", "3", "5"}) {
        TestFrame frame(std::string("wavelet:format=float32,rank=") + rank, header);
        frame.draw(fragments);
        EXPECT_LT(test::worst_error(frame, fragments), 2e-5) << rank;
    }
}

// Rank 3 in float16: 256 bits of coefficients, 64 of colour, 64 of depth range. A count of each surface's
// bytes once a pass gives 128; but the range is read again in passes 1 and 2, since it says where a
// fragment's depth lies: 16 more.
TEST(Wavelet, BitsAndBytes) {
    EXPECT_EQ(test::storage_bits("wavelet"), 384);
    const ByteCount bytes = test::worst_case_bytes("wavelet");
    EXPECT_EQ(bytes.read, 80u + 16u);
    EXPECT_EQ(bytes.write, 48u);
    EXPECT_EQ(test::storage_bits("wavelet:bounds=frame"), 320);
}

// Of 16 coefficients a fragment adds to rank + 2 and reads at most 2 rank + 2 for its own bin and the one
// before.
TEST(Wavelet, TouchesTheCoefficientsOfItsDepth) {
    Random random(44);
    for (int rank = 1; rank <= kMaxHaarRank; ++rank) {
        const auto fragments = layers(200, random);
        TestFrame frame("wavelet:rank=" + std::to_string(rank), test::header_of(1, 1));
        frame.draw_pass(0, fragments);
        frame.draw_pass(1, fragments);
        std::size_t record = fragments.size();
        for (; record < 2 * fragments.size(); ++record) {
            const SurfaceAccess& access = frame.log().record_access(record)[1];
            ASSERT_EQ(std::popcount(access.read), rank + 2);
            ASSERT_EQ(access.read, access.write);
        }
        frame.draw_pass(2, fragments);
        for (; record < 3 * fragments.size(); ++record) {
            const SurfaceAccess& access = frame.log().record_access(record)[1];
            ASSERT_GE(std::popcount(access.read), rank + 2);
            ASSERT_LE(std::popcount(access.read), 2 * rank + 2);
            ASSERT_EQ(access.write, 0u);
        }
    }
}

// Where a fragment's coefficients lie depends on the pixel's range: a fetch after a fetch. A range of the
// frame needs none.
TEST(Wavelet, PixelBoundsCostAFetchStage) {
    const auto stages = [](const char* technique) {
        const auto operation = TestFrame::make(technique, test::header_of(1, 1));
        std::uint32_t sum = 0;
        for (const PathCost& path : operation->cost(test::plain_shape()))
            sum += path.work.units[static_cast<std::size_t>(Unit::kFetchStage)];
        return sum;
    };
    EXPECT_EQ(stages("wavelet"), 2u);
    EXPECT_EQ(stages("wavelet:bounds=frame"), 0u);
}

// A fragment of alpha 0 beyond the others would widen the range and coarsen the bins.
TEST(Wavelet, FragmentsOfAlphaZeroDoNotWidenTheRange) {
    Random random(45);
    auto fragments = layers(6, random);
    TestFrame without("wavelet", test::header_of(1, 1));
    without.draw(fragments);
    fragments.insert(fragments.begin() + 3, test::fragment_at(0, 0, 0.99f, 0, {0, 0, 0}));
    fragments.push_back(test::fragment_at(0, 0, 0.01f, 0, {0, 0, 0}));
    TestFrame with("wavelet", test::header_of(1, 1));
    with.draw(fragments);
    EXPECT_EQ(with.color(), without.color());
}

// Coplanar layers see none of each other, as in adaptive transparency, and share the pixel's total alpha
// evenly: exact compositing shows the first one more.
TEST(Wavelet, CoplanarLayersAreAveraged) {
    TestFrame frame("wavelet:format=float32", test::header_of(1, 1, 1, {0, 0, 1}));
    frame.draw(std::vector<Fragment>{test::fragment_at(0, 0, 0.5f, 0.5f, {1, 0, 0}),
                                     test::fragment_at(0, 0, 0.5f, 0.5f, {0, 1, 0})});
    const auto color = frame.color();
    EXPECT_NEAR(color[0], 0.375, 1e-6);
    EXPECT_NEAR(color[1], 0.375, 1e-6);
    EXPECT_NEAR(color[2], 0.25, 1e-6);
}

// n additions in float16 of positive terms: each order is within n half ulps of the largest sum, an ulp being
// 2^-10 of it.
TEST(Wavelet, OrderChangesCoefficientsByTheirRounding) {
    Random random(46);
    constexpr int kLayers = 30;
    auto fragments = layers(kLayers, random);
    TestFrame first("wavelet", test::header_of(1, 1));
    first.draw_pass(0, fragments);
    first.draw_pass(1, fragments);
    double absorbance = 0;
    for (const Fragment& f : fragments) absorbance += Bins::absorbance(f);
    bool differ = false;
    for (int round = 0; round < 30; ++round) {
        random.shuffle(fragments);
        TestFrame other("wavelet", test::header_of(1, 1));
        other.draw_pass(0, fragments);
        other.draw_pass(1, fragments);
        for (std::size_t w = 2; w < 18; ++w) {
            const float a = std::bit_cast<float>(first.words(0, 0)[w]);
            const float b = std::bit_cast<float>(other.words(0, 0)[w]);
            differ = differ || a != b;
            ASSERT_NEAR(a, b, kLayers * 0x1p-10 * absorbance);
        }
    }
    EXPECT_TRUE(differ);
}

// Float16 coefficients of thick media: an opaque layer's 11.5 has an ulp of 1/128, a thin one's in front is
// lost in it only where they share a coefficient.
TEST(Wavelet, OpaqueLayersStayOpaque) {
    Random random(47);
    for (int i = 0; i < 200; ++i) {
        auto fragments = layers(random.integer(0, 20), random);
        fragments.push_back(test::fragment_at(0, 0, random.real(0, 1), 1.0f, {1, 1, 1}));
        for (Fragment& f : fragments) f.r = f.g = f.b = 0;
        TestFrame frame("wavelet", test::header_of(1, 1, 1, {1, 1, 1}));
        frame.draw(fragments);
        ASSERT_EQ(frame.color()[0], 0.0f);
    }
}

}  // namespace
}  // namespace ropsim
