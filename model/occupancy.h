// How full a queue was found: a histogram over samples.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

// Of all queues of one name (a partition each, as a rule), every sample of each counted once.
struct OccupancyHistogram {
    static constexpr std::uint64_t kBins = 64;

    std::string queue;
    std::uint32_t instances = 0;
    std::uint64_t capacity = 0;
    std::uint64_t samples = 0;
    std::uint64_t sum = 0;
    std::uint64_t maximum = 0;             // of the samples
    std::uint64_t bin_width = 1;           // 1 up to a capacity of 63
    std::vector<std::uint64_t> histogram;  // [b]: samples of bin_width * b up to, not including, the next

    OccupancyHistogram() = default;
    OccupancyHistogram(std::string name, std::uint64_t most)
        : queue(std::move(name)), capacity(most), bin_width((most + kBins) / kBins) {}

    // A sample that found `occupied` entries.
    void add(std::uint64_t occupied) {
        // Most have a bin for each number: no division then.
        const std::uint64_t bin = bin_width == 1 ? occupied : occupied / bin_width;
        if (bin >= histogram.size()) histogram.resize(bin + 1);
        ++histogram[bin];
        ++samples;
        sum += occupied;
        maximum = std::max(maximum, occupied);
    }
    double mean() const {
        return samples == 0 ? 0.0 : static_cast<double>(sum) / static_cast<double>(samples);
    }
};

}  // namespace ropsim
