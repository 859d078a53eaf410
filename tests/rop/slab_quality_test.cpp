// How good stochastic layered alpha blending is at 20 layers a pixel, against stochastic transparency and the
// k-buffer, all with the depth and alpha normalisation of Enderton et al. 2011: Wyman's claim that 8 layers
// beat 32 samples, which holds where layers are dense and arrive in random order.
#include "tests/rop/random_fragments.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

constexpr std::uint32_t kLayers = 20;
constexpr int kSide = 64;
constexpr int kPixels = kSide * kSide;

enum class Arrival { kRandom, kNearToFar, kFarToNear };

// In every pixel layers of random colour and depth, of one alpha or (0) of random ones.
std::vector<Fragment> layers(double alpha, Arrival arrival) {
    Random random(17);
    std::vector<Fragment> all;
    for (int i = 0; i < kPixels; ++i) {
        std::vector<Fragment> own;
        for (std::uint32_t l = 0; l < kLayers; ++l)
            own.push_back(test::fragment_at(i % kSide, i / kSide, random.real(0, 1),
                                            alpha > 0 ? static_cast<float>(alpha) : random.real(0, 1),
                                            {random.real(0, 1), random.real(0, 1), random.real(0, 1)}, l));
        if (arrival == Arrival::kNearToFar) std::ranges::sort(own, {}, &Fragment::z);
        if (arrival == Arrival::kFarToNear) std::ranges::sort(own, std::greater<>(), &Fragment::z);
        all.insert(all.end(), own.begin(), own.end());
    }
    return all;
}

std::span<const Fragment> of_pixel(const std::vector<Fragment>& all, int i) {
    return std::span(all).subspan(static_cast<std::size_t>(i) * kLayers, kLayers);
}

// Mean square error of the pixels and its standard error.
struct Error {
    double mean = 0;
    double deviation = 0;
    double rms8() const { return 255 * std::sqrt(mean); }
    // Of rms8, for small deviations.
    double rms8_deviation() const { return 255 * deviation / (2 * std::sqrt(mean)); }
};
template <class Color>
Error error_of(const std::vector<Fragment>& all, Color color) {
    double sum = 0;
    double squares = 0;
    for (int i = 0; i < kPixels; ++i) {
        const auto exact = test::composited(of_pixel(all, i), i % kSide, i / kSide, {0, 0, 0});
        const std::array<double, 3> got = color(i);
        double e = 0;
        for (std::size_t c = 0; c < 3; ++c) e += std::pow(got[c] - exact[c], 2) / 3;
        sum += e;
        squares += e * e;
    }
    const double mean = sum / kPixels;
    return {mean, std::sqrt((squares / kPixels - mean * mean) / kPixels)};
}
Error measured(const std::string& technique, const std::vector<Fragment>& all) {
    TestFrame frame(technique + ",format=float32", test::header_of(kSide, kSide, 1, {0, 0, 0}), 5, 1, false);
    frame.draw(all);
    const auto image = frame.image();
    return error_of(all, [&](int i) {
        const auto at = static_cast<std::size_t>(3 * i);
        return std::array<double, 3>{image[at], image[at + 1], image[at + 2]};
    });
}
std::string slab(const std::string& bits) {
    return "slab:layers=8,composite=normalised,bits=" + bits;
}
std::string stochastic(int samples) {
    return fmt::format("stochastic:method=depth_based,samples={}", samples);
}

// Section 2.1 in double with draws of its own.
Error by_definition(const std::vector<Fragment>& all, int bits) {
    Random random(99);
    return error_of(all, [&](int i) {
        std::vector<Fragment> list;
        double clear = 1;
        for (const Fragment& f : of_pixel(all, i)) {
            clear *= 1.0 - static_cast<double>(f.a);
            std::size_t at = 0;
            double transmittance = 1;
            for (; at < list.size() && list[at].z <= f.z; ++at)
                transmittance *= 1.0 - static_cast<double>(list[at].a);
            const int s = static_cast<int>(bits * (1 - transmittance) + 0.5);
            const int t = static_cast<int>(bits * static_cast<double>(f.a) + 0.5);
            double hidden = 1;
            for (int k = 0; k < t; ++k) hidden *= static_cast<double>(std::max(s - k, 0)) / (bits - k);
            if (random.unit() >= 1 - hidden) continue;
            list.insert(list.begin() + static_cast<std::ptrdiff_t>(at), f);
            if (list.size() > 8) list.pop_back();
        }
        std::array<double, 3> u{};
        double u1 = 0;
        for (const Fragment& f : of_pixel(all, i)) {
            double seen = 1;
            for (const Fragment& l : list) seen *= l.z < f.z ? 1.0 - static_cast<double>(l.a) : 1;
            u = {u[0] + seen * f.r, u[1] + seen * f.g, u[2] + seen * f.b};
            u1 += seen * f.a;
        }
        const double scale = u1 > 0 ? (1 - clear) / u1 : 0;
        return std::array<double, 3>{scale * u[0], scale * u[1], scale * u[2]};
    });
}

// Against an independent program's run over random colours in random order: RMS in 1/255, within 4 standard
// errors of two samples of this size and the rounding of what it printed.
TEST(SlabQuality, TwentyLayersInRandomOrder) {
    struct Row {
        double alpha, st8, st32, n, n2, n4, k_buffer;
    };
    for (const Row& row :
         {Row{.1, 3.62, 1.52, 4.43, 4.41, 4.45, 4.39}, Row{.3, 7.98, 3.72, 6.97, 5.36, 5.05, 4.99},
          Row{.6, 8.14, 3.90, 3.96, 2.26, 1.07, .22}, Row{0, 7.24, 3.37, 4.49, 2.58, 1.90, 2.09}}) {
        const auto all = layers(row.alpha, Arrival::kRandom);
        const auto expect = [&](const std::string& technique, double rms) {
            const Error e = measured(technique, all);
            EXPECT_NEAR(e.rms8(), rms, 4 * std::sqrt(2.0) * e.rms8_deviation() + 0.005)
                << technique << " alpha " << row.alpha;
        };
        expect(stochastic(8), row.st8);
        expect(stochastic(32), row.st32);
        expect(slab("8"), row.n);
        expect(slab("16"), row.n2);
        expect(slab("32"), row.n4);
        expect(slab("inf"), row.k_buffer);
    }
}

TEST(SlabQuality, AsByDefinition) {
    for (const double alpha : {.3, 0.}) {
        for (const Arrival arrival : {Arrival::kRandom, Arrival::kNearToFar, Arrival::kFarToNear}) {
            const auto all = layers(alpha, arrival);
            for (const int bits : {8, 16}) {
                const Error a = measured(slab(std::to_string(bits)), all);
                const Error b = by_definition(all, bits);
                EXPECT_NEAR(a.mean, b.mean, 4 * std::hypot(a.deviation, b.deviation)) << bits;
            }
        }
    }
}

// "Quality better than 32 samples" of 8 layers with b = 2n: of dense or mixed layers in random order, not of
// thin ones, and near to far not even better than 8 samples.
TEST(SlabQuality, AgainstThirtyTwoSamples) {
    const auto better = [](const Error& a, const Error& b) {
        return a.mean + 4 * std::hypot(a.deviation, b.deviation) < b.mean;
    };
    for (const double alpha : {.1, .3, .6, 0.}) {
        const auto all = layers(alpha, Arrival::kRandom);
        const Error layered = measured(slab("16"), all);
        const Error samples = measured(stochastic(32), all);
        if (alpha == .1 || alpha == .3)
            EXPECT_TRUE(better(samples, layered)) << alpha;
        else
            EXPECT_TRUE(better(layered, samples)) << alpha;
    }
    const auto sorted = layers(.6, Arrival::kNearToFar);
    const Error layered = measured(slab("16"), sorted);
    EXPECT_NEAR(layered.rms8(), 10.1, 4 * std::sqrt(2.0) * layered.rms8_deviation());
    EXPECT_TRUE(better(measured(stochastic(8), sorted), layered));
}

}  // namespace
}  // namespace ropsim
