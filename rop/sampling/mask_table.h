// The precomputed table of masks of stochastic transparency (Enderton et al. 2011, section 5): a mask for
// each of 2,047 pseudorandom entries and 1,024 levels of alpha.
#pragma once

#include "base/error.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ropsim {

// Each entry is a uniform random order of the samples and an offset xi; its mask at a level is the first
// R = floor(level / 1023 * samples + xi) samples of that order. The xi of the entries are the 2,047 values
// (i + 1/2) / 2047 in random order, so that at every level the mean of R / samples over the entries is within
// 1 / (4094 samples) of level / 1023. Level 0 selects no sample and level 1023 all, in every entry.
//
// The paper fixes the sizes and leaves the filling open. Software keeps an entry's order as its prefixes and
// works R out; mask() gives what the full table holds.
class MaskTable {
 public:
    static constexpr std::uint32_t kEntries = 2047;
    static constexpr std::uint32_t kLevels = 1024;

    // `samples`: 1 to 64. The same table on every machine.
    explicit MaskTable(int samples);

    // The nearest of 1,023 equal steps of alpha in [0, 1], half up: 0 gives 0 and 1 gives 1023. Alpha below
    // 1/2046 gives level 0, which never selects a sample.
    static std::uint32_t level(float alpha) {
        return static_cast<std::uint32_t>(static_cast<double>(alpha) * (kLevels - 1) + 0.5);
    }
    // Bit s is set if stored sample s is selected. `entry` below kEntries, `level` below kLevels.
    std::uint64_t mask(std::uint32_t entry, std::uint32_t level) const {
        const std::uint32_t count = (level * samples_ * (2 * kEntries) + xi_[entry]) / kUnit;
        return prefixes_[static_cast<std::size_t>(entry) * (samples_ + 1) + count];
    }
    // Size of the table as hardware holds it: one mask an entry and level.
    std::uint64_t bits() const { return std::uint64_t{kEntries} * kLevels * samples_; }

 private:
    // 1 in the fixed point of R: a multiple of the steps of alpha and of twice those of xi. R = 64 fits.
    static constexpr std::uint32_t kUnit = (kLevels - 1) * 2 * kEntries;

    std::uint32_t samples_;
    std::vector<std::uint32_t> xi_;        // an entry, in units of 1 / kUnit
    std::vector<std::uint64_t> prefixes_;  // samples + 1 an entry: the first R samples of its order
};

}  // namespace ropsim
