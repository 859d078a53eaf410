// Statistics of opacity reference values.
#include "analysis/claims/opacity_statistics.h"

#include "base/random.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace ropsim {
namespace {

std::uint32_t reference(OpacityHash hash, std::uint32_t index, std::uint32_t surface) {
    return opacity_reference<PlainDatapath>(hash, index, surface);
}

bool passes(double alpha, std::uint32_t value) {
    return static_cast<double>(value) < alpha * 0x1p32;
}

}  // namespace

bool aligned_spans_stratified(OpacityHash hash, int spans) {
    for (std::uint32_t k = 1; k <= 10; ++k) {
        const std::uint32_t size = 1u << k;
        std::vector<char> seen(size);
        for (std::uint32_t surface = 0; surface < 64; ++surface) {
            for (int span = 0; span < spans; ++span) {
                const std::uint32_t first =
                    random_bits(mix64(k * 64 + surface), static_cast<std::uint32_t>(span)) << k;
                std::ranges::fill(seen, 0);
                for (std::uint32_t i = 0; i < size; ++i) {
                    char& place = seen[reference(hash, first + i, surface) >> (32 - k)];
                    if (place != 0) return false;
                    place = 1;
                }
            }
        }
    }
    return true;
}

bool spans_stratified(const std::vector<double>& sequence) {
    for (std::size_t size = 2; size <= sequence.size(); size *= 2) {
        for (std::size_t first = 0; first + size <= sequence.size(); first += size) {
            std::vector<char> seen(size, 0);
            for (std::size_t i = 0; i < size; ++i) {
                char& place = seen[static_cast<std::size_t>(sequence[first + i] * static_cast<double>(size))];
                if (place != 0) return false;
                place = 1;
            }
        }
    }
    return true;
}

int farthest_from_share(int samples, int trials) {
    int farthest = 0;
    for (std::uint32_t trial = 0; trial < static_cast<std::uint32_t>(trials); ++trial) {
        const double alpha = random_unit(1, 3 * trial);
        const std::uint32_t pixel = random_bits(1, 3 * trial + 1) >> 8;
        const std::uint32_t surface = random_bits(1, 3 * trial + 2) >> 24;
        int count = 0;
        for (int s = 0; s < samples; ++s)
            count += passes(alpha, reference(OpacityHash::kPaper,
                                             pixel * static_cast<std::uint32_t>(samples) +
                                                 static_cast<std::uint32_t>(s),
                                             surface))
                         ? 1
                         : 0;
        const double share = alpha * samples;
        const int low = static_cast<int>(std::floor(share));
        const int high = static_cast<int>(std::ceil(share));
        farthest = std::max({farthest, low - count, count - high});
    }
    return farthest;
}

Coverage mean_coverage(OpacityHash hash, double alpha, int surfaces, int samples, int pixels) {
    double sum = 0;
    double squares = 0;
    for (int pixel = 0; pixel < pixels; ++pixel) {
        std::uint64_t covered = 0;
        for (int surface = 0; surface < surfaces; ++surface)
            for (int s = 0; s < samples; ++s)
                if (passes(alpha, reference(hash, static_cast<std::uint32_t>(pixel * samples + s),
                                            static_cast<std::uint32_t>(surface))))
                    covered |= std::uint64_t{1} << s;
        const double share = static_cast<double>(std::popcount(covered)) / samples;
        sum += share;
        squares += share * share;
    }
    const double mean = sum / pixels;
    return {mean, std::sqrt(std::max(0.0, squares / pixels - mean * mean) / pixels)};
}

double largest_correlation(OpacityHash hash, int indices) {
    double largest = 0;
    for (std::uint32_t surface = 1; surface <= 8; ++surface) {
        double sum = 0;
        for (int i = 0; i < indices; ++i) {
            const auto index = static_cast<std::uint32_t>(i);
            const double a = reference(hash, index, 0) * 0x1p-32 - 0.5;
            const double b = reference(hash, index, surface) * 0x1p-32 - 0.5;
            sum += a * b;
        }
        largest = std::max(largest, std::abs(sum / indices * 12));
    }
    return largest;
}

}  // namespace ropsim
