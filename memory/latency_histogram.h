// Latencies in cycles: exact mean and maximum, percentiles within 1.6 %.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

namespace ropsim {

// Buckets of width 1 up to 128, then 64 buckets an octave.
class LatencyHistogram {
 public:
    void add(std::uint64_t cycles) {
        ++buckets_[bucket(cycles)];
        ++count_;
        sum_ += cycles;
        if (cycles > maximum_) maximum_ = cycles;
    }
    void add(const LatencyHistogram& other) {
        for (std::size_t i = 0; i < buckets_.size(); ++i) buckets_[i] += other.buckets_[i];
        count_ += other.count_;
        sum_ += other.sum_;
        if (other.maximum_ > maximum_) maximum_ = other.maximum_;
    }
    std::uint64_t count() const { return count_; }
    std::uint64_t maximum() const { return maximum_; }
    // How many lie in [2^k, 2^(k+1)), by k, up to the last that has any; 0 counts as 1.
    std::vector<std::uint64_t> octaves() const {
        std::vector<std::uint64_t> counts;
        for (std::size_t i = 0; i < buckets_.size(); ++i) {
            if (buckets_[i] == 0) continue;
            const auto low = static_cast<std::uint64_t>(std::max(middle(i), 1.0));
            const auto octave = static_cast<std::size_t>(std::bit_width(low)) - 1;
            counts.resize(std::max(counts.size(), octave + 1));
            counts[octave] += buckets_[i];
        }
        return counts;
    }
    // In cycles; 0 when nothing was counted.
    double mean() const {
        return count_ == 0 ? 0.0 : static_cast<double>(sum_) / static_cast<double>(count_);
    }
    // The smallest bucket bound below which at least `fraction` of all lie (its middle), 0 < fraction <= 1.
    double percentile(double fraction) const {
        const double wanted = fraction * static_cast<double>(count_);
        std::uint64_t seen = 0;
        for (std::size_t i = 0; i < buckets_.size(); ++i) {
            seen += buckets_[i];
            if (seen != 0 && static_cast<double>(seen) >= wanted)
                return std::min(middle(i), static_cast<double>(maximum_));
        }
        return 0.0;
    }

 private:
    static constexpr std::size_t kOctaves = 34;  // up to 2^40 cycles
    static std::size_t bucket(std::uint64_t cycles) {
        if (cycles < 128) return cycles;
        const int shift = static_cast<int>(std::bit_width(cycles)) - 7;  // leaves 64..127
        const std::size_t index = static_cast<std::size_t>(shift) * 64 + (cycles >> shift);
        return index < 64 * kOctaves ? index : 64 * kOctaves - 1;
    }
    static double middle(std::size_t index) {
        if (index < 128) return static_cast<double>(index);
        const std::size_t shift = index / 64 - 1;
        const double low = static_cast<double>((index - shift * 64) << shift);
        return low + (static_cast<double>(std::uint64_t{1} << shift) - 1) / 2;
    }
    std::array<std::uint64_t, 64 * kOctaves> buckets_{};
    std::uint64_t count_ = 0;
    std::uint64_t sum_ = 0;
    std::uint64_t maximum_ = 0;
};

}  // namespace ropsim
