// Percentiles against sorting.
#include "memory/latency_histogram.h"

#include "base/random.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

TEST(LatencyHistogram, AgreesWithSorting) {
    LatencyHistogram histogram;
    std::vector<std::uint64_t> all;
    double sum = 0;
    for (std::uint32_t i = 0; i < 50000; ++i) {
        const std::uint64_t value = mix64(i) >> (40 + mix64(i + 1) % 22);
        histogram.add(value);
        all.push_back(value);
        sum += static_cast<double>(value);
    }
    std::sort(all.begin(), all.end());
    EXPECT_DOUBLE_EQ(histogram.mean(), sum / 50000);
    EXPECT_EQ(histogram.maximum(), all.back());
    for (const double fraction : {0.01, 0.5, 0.9, 0.99, 1.0}) {
        const auto exact = static_cast<double>(all[static_cast<std::size_t>(fraction * 50000) - 1]);
        EXPECT_NEAR(histogram.percentile(fraction), exact, exact / 64 + 0.5) << fraction;
    }
    const std::vector<std::uint64_t> octaves = histogram.octaves();
    std::uint64_t counted = 0;
    for (std::size_t k = 0; k < octaves.size(); ++k) {
        const auto in_octave = [k](std::uint64_t value) {
            return std::max<std::uint64_t>(value, 1) >> k == 1;
        };
        EXPECT_EQ(octaves[k], static_cast<std::uint64_t>(std::ranges::count_if(all, in_octave))) << k;
        counted += octaves[k];
    }
    EXPECT_EQ(counted, 50000u);
    LatencyHistogram sum_of_two;
    sum_of_two.add(histogram);
    sum_of_two.add(histogram);
    EXPECT_EQ(sum_of_two.count(), 100000u);
    EXPECT_EQ(sum_of_two.percentile(0.5), histogram.percentile(0.5));
    EXPECT_EQ(LatencyHistogram().percentile(0.5), 0.0);
}

}  // namespace
}  // namespace ropsim
