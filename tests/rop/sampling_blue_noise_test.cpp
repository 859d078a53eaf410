// Spatiotemporal blue noise: histograms exactly, spectra by a discrete Fourier transform, and the masks made
// of it against their definition.
#include "rop/sampling/blue_noise.h"
#include "tests/rop/sampling_statistics.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <complex>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

constexpr int kSide = BlueNoise::kSide;
constexpr int kSlices = BlueNoise::kSlices;
constexpr int kArea = kSide * kSide;

double unit(int x, int y, int slice) {
    return BlueNoise::instance().threshold(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
                                           static_cast<std::uint32_t>(slice)) *
           0x1p-32;
}

TEST(BlueNoise, EachThresholdOnce) {
    const BlueNoise& noise = BlueNoise::instance();
    std::vector<bool> seen(std::size_t{kArea} * kSlices);
    for (std::uint32_t slice = 0; slice < kSlices; ++slice) {
        std::vector<bool> in_slice(kArea);
        for (std::uint32_t y = 0; y < kSide; ++y)
            for (std::uint32_t x = 0; x < kSide; ++x) {
                const std::uint32_t threshold = noise.threshold(x, y, slice);
                ASSERT_EQ(threshold % (1u << 14), 1u << 13) << "the middle of its interval";
                ASSERT_FALSE(seen[threshold >> 14]);
                ASSERT_FALSE(in_slice[threshold >> 20]) << "one in each of 4,096 intervals a slice";
                seen[threshold >> 14] = true;
                in_slice[threshold >> 20] = true;
                ASSERT_EQ(noise.threshold(x + kSide, y + 7 * kSide, slice + kSlices), threshold);
            }
    }
}

// Images depend on it.
TEST(BlueNoise, IsTheSameEverywhere) {
    std::uint64_t checksum = 0xCBF29CE484222325ull;  // FNV-1a over words
    for (std::uint32_t y = 0; y < kSide; ++y)
        for (std::uint32_t x = 0; x < kSide; ++x)
            for (std::uint32_t slice = 0; slice < kSlices; ++slice)
                checksum = (checksum ^ BlueNoise::instance().threshold(x, y, slice)) * 0x100000001B3ull;
    EXPECT_EQ(checksum, 9267591701110825765u);
}

using Complex = std::complex<double>;

// Discrete Fourier transform of 64 values.
std::array<Complex, kSide> transform(const std::array<Complex, kSide>& values) {
    static const std::array<Complex, kSide> roots_of_one = [] {
        std::array<Complex, kSide> roots;
        for (std::size_t i = 0; i < kSide; ++i)
            roots[i] = std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(i) / kSide);
        return roots;
    }();
    std::array<Complex, kSide> result{};
    for (std::size_t f = 0; f < kSide; ++f)
        for (std::size_t i = 0; i < kSide; ++i) result[f] += values[i] * roots_of_one[f * i % kSide];
    return result;
}

// Mean power of a plane at frequencies of 1 to 8 and of 20 to 32 periods a side, in units of white noise's of
// the same variance.
struct Spectrum {
    double low = 0;
    double high = 0;
};
Spectrum spectrum_of(const std::function<double(int, int)>& value) {
    std::array<std::array<Complex, kSide>, kSide> rows;
    double sum = 0;
    double squares = 0;
    for (int y = 0; y < kSide; ++y) {
        std::array<Complex, kSide> row;
        for (int x = 0; x < kSide; ++x) {
            const double v = value(x, y);
            row[static_cast<std::size_t>(x)] = v;
            sum += v;
            squares += v * v;
        }
        rows[static_cast<std::size_t>(y)] = transform(row);
    }
    const double white = squares - sum * sum / kArea;
    Spectrum spectrum;
    std::array<int, 2> counts{};
    for (std::size_t u = 0; u < kSide; ++u) {
        std::array<Complex, kSide> column;
        for (std::size_t y = 0; y < kSide; ++y) column[y] = rows[y][u];
        column = transform(column);
        for (std::size_t v = 0; v < kSide; ++v) {
            const double frequency = std::hypot(std::min(u, kSide - u), std::min(v, kSide - v));
            const double power = std::norm(column[v]) / white;
            if (frequency >= 1 && frequency <= 8) {
                spectrum.low += power;
                ++counts[0];
            } else if (frequency >= 20 && frequency <= 32) {
                spectrum.high += power;
                ++counts[1];
            }
        }
    }
    return {spectrum.low / counts[0], spectrum.high / counts[1]};
}

TEST(BlueNoise, SlicesHaveLittlePowerAtLowFrequencies) {
    for (int slice = 0; slice < kSlices; slice += 9) {
        const Spectrum blue = spectrum_of([&](int x, int y) { return unit(x, y, slice); });
        EXPECT_LT(blue.low, 0.01) << slice;
        EXPECT_GT(blue.high, 1.1) << slice;
    }
    std::mt19937 random(1);
    const Spectrum white = spectrum_of([&](int, int) { return static_cast<double>(random()); });
    EXPECT_NEAR(white.low, 1, 0.4) << "the measure itself, about 200 frequencies in pairs";
}

// So have the pixels that pass at any alpha, after the offsets of a key.
TEST(BlueNoiseMask, PassingPixelsAreBlue) {
    for (const float alpha : {0.05f, 0.2f, 0.5f, 0.9f}) {
        const Spectrum blue = spectrum_of([&](int x, int y) {
            return static_cast<double>(blue_noise_mask(8, alpha, x + 300, y + 77, 12345) >> 3 & 1);
        });
        EXPECT_LT(blue.low, 0.15) << alpha;
    }
}

TEST(BlueNoise, PixelsHaveLittlePowerAtLowFrequenciesOfTime) {
    double low = 0;
    double all = 0;
    for (int pixel = 0; pixel < kArea; pixel += 5) {
        std::array<Complex, kSide> values;
        for (int slice = 0; slice < kSlices; ++slice)
            values[static_cast<std::size_t>(slice)] = unit(pixel % kSide, pixel / kSide, slice);
        values = transform(values);
        for (std::size_t f = 1; f <= 4; ++f) low += std::norm(values[f]) / 4;
        for (std::size_t f = 1; f < kSlices; ++f) all += std::norm(values[f]) / (kSlices - 1);
    }
    EXPECT_LT(low / all, 0.05);
}

// The number of S samples that pass varies less from pixel to pixel than S independent ones, S a (1 - a).
TEST(BlueNoiseMask, SamplesOfAPixelAreStratified) {
    for (const auto& [samples, alpha, share] :
         {std::tuple(4, 0.5f, 0.30), {8, 0.1f, 0.45}, {8, 0.5f, 0.20}, {16, 0.3f, 0.16}, {64, 0.5f, 0.09}}) {
        double sum = 0;
        double squares = 0;
        int n = 0;
        for (std::uint64_t key = 0; key < 8; ++key)
            for (int pixel = 0; pixel < kArea; ++pixel, ++n) {
                const int passed =
                    std::popcount(blue_noise_mask(samples, alpha, pixel % kSide, pixel / kSide, key));
                sum += passed;
                squares += passed * passed;
            }
        const double mean = sum / n;
        const double a = static_cast<double>(alpha);
        EXPECT_LT(squares / n - mean * mean, share * samples * a * (1 - a)) << samples << " " << a;
    }
}

// Over a torus of pixels each sample passes floor or ceiling of 4096 alpha times, whatever the key.
TEST(BlueNoiseMask, PassRateIsAlpha) {
    for (const float alpha : {0.003f, 0.1f, 0.25f, 0.7f, 0.999f})
        for (const std::uint64_t key : {0ull, 77ull, ~0ull}) {
            std::array<int, 64> passed{};
            for (int pixel = 0; pixel < kArea; ++pixel) {
                const std::uint64_t mask = blue_noise_mask(64, alpha, pixel % kSide, pixel / kSide, key);
                for (std::size_t s = 0; s < 64; ++s) passed[s] += static_cast<int>(mask >> s & 1);
            }
            for (const int count : passed) {
                ASSERT_GE(count, std::floor(kArea * static_cast<double>(alpha)));
                ASSERT_LE(count, std::ceil(kArea * static_cast<double>(alpha)));
            }
        }
}

TEST(BlueNoiseMask, AlphaOneAlwaysPassesAlphaZeroNever) {
    for (const int samples : {1, 8, 64})
        for (int pixel = 0; pixel < kArea; ++pixel) {
            const int x = pixel % kSide - 32;
            const int y = pixel / kSide - 32;
            ASSERT_EQ(blue_noise_mask(samples, 1.0f, x, y, 5), low_bits(static_cast<std::uint32_t>(samples)));
            ASSERT_EQ(blue_noise_mask(samples, 0.0f, x, y, 5), 0u);
        }
}

// A key moves the torus and nothing else: the threshold of one sample, found by bisection over alpha, tells
// where to, and all other masks follow.
TEST(BlueNoiseMask, KeysMoveTheTorus) {
    const BlueNoise& noise = BlueNoise::instance();
    std::array<std::map<std::uint32_t, int>, 3> eighths;  // of (x, y), (y, slice) and (slice, x)
    for (std::uint64_t key = 0; key < 640; ++key) {
        std::uint32_t low = 0;
        std::uint32_t high = 1u << 19;
        while (high - low > 1) {
            const std::uint32_t middle = (low + high) / 2;
            const bool passes = blue_noise_mask(1, static_cast<float>(middle) * 0x1p-19f, 0, 0, key) != 0;
            (passes ? high : low) = middle;
        }
        const auto position = [&] {
            for (std::uint32_t i = 0; i < std::uint32_t{kArea} * kSlices; ++i)
                if (noise.threshold(i, i / kSide, i / kArea) >> 13 == low) return i;
            return 0u;
        }();
        const std::array<std::uint32_t, 3> moved = {position % kSide / 8, position / kSide % kSide / 8,
                                                    position / kArea / 8};
        for (std::size_t i = 0; i < 3; ++i) ++eighths[i][8 * moved[i] + moved[(i + 1) % 3]];
        for (std::uint32_t i = 0; i < 200; ++i) {
            const float alpha = static_cast<float>(i % 50) / 50.0f;
            const std::uint32_t x = i * 17;
            const std::uint32_t y = i * 5;
            std::uint64_t expected = 0;
            for (std::uint32_t s = 0; s < 16; ++s) {
                const double threshold =
                    noise.threshold(position + x, position / kSide + y, position / kArea + s);
                if (static_cast<double>(alpha) * 0x1p32 > threshold) expected |= std::uint64_t{1} << s;
            }
            ASSERT_EQ(blue_noise_mask(16, alpha, static_cast<int>(x), static_cast<int>(y), key), expected);
        }
    }
    for (const auto& counts : eighths)
        EXPECT_LT(test::chi_square(counts, 64), test::chi_square_limit(63)) << "all offsets equally often";
}

// Masks of two keys pass together as often as independent ones: the correlation over all pixels and 8
// samples, averaged over many pairs, is 0 within 4 of its standard errors, and none is large.
TEST(BlueNoiseMask, KeysAreUncorrelated) {
    const float alpha = 0.5f;
    double sum = 0;
    double squares = 0;
    constexpr int kPairs = 200;
    for (std::uint64_t pair = 0; pair < kPairs; ++pair) {
        int equal = 0;
        for (int pixel = 0; pixel < kArea; ++pixel) {
            const int x = pixel % kSide;
            const int y = pixel / kSide;
            equal += 8 - std::popcount(blue_noise_mask(8, alpha, x, y, 2 * pair) ^
                                       blue_noise_mask(8, alpha, x, y, 2 * pair + 1));
        }
        const double correlation = 2.0 * equal / (8.0 * kArea) - 1;
        EXPECT_LT(std::abs(correlation), 0.06) << pair;
        sum += correlation;
        squares += correlation * correlation;
    }
    const double error = std::sqrt(squares) / kPairs;
    EXPECT_LT(std::abs(sum / kPairs), 4 * error);
    EXPECT_LT(error, 0.002);
}

}  // namespace
}  // namespace ropsim
