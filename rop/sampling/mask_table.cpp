// Filling the mask table.
#include "rop/sampling/mask_table.h"

#include "base/random.h"
#include "rop/sampling/mask_patterns.h"

#include <numeric>
#include <utility>

namespace ropsim {
namespace {

// Fisher and Yates's shuffle; the draws are uniform up to 2^-32.
void shuffle(std::vector<std::uint32_t>& values, std::uint64_t key) {
    for (auto left = static_cast<std::uint32_t>(values.size()); left > 1; --left) {
        const auto picked = static_cast<std::uint32_t>((std::uint64_t{random_bits(key, left)} * left) >> 32);
        std::swap(values[left - 1], values[picked]);
    }
}

}  // namespace

MaskTable::MaskTable(int samples) : samples_(static_cast<std::uint32_t>(samples)) {
    CHECK(samples >= 1 && samples <= 64, "{} samples", samples);
    const std::uint64_t key = mix64(0x6D61736B73ull + samples_);  // "masks"
    xi_.resize(kEntries);
    std::iota(xi_.begin(), xi_.end(), 0u);
    shuffle(xi_, key);
    for (std::uint32_t& xi : xi_) xi = (2 * xi + 1) * (kLevels - 1);
    prefixes_.reserve(static_cast<std::size_t>(kEntries) * (samples_ + 1));
    std::vector<std::uint32_t> order(samples_);
    for (std::uint32_t entry = 0; entry < kEntries; ++entry) {
        std::iota(order.begin(), order.end(), 0u);
        shuffle(order, mix64(key + 1 + entry));
        std::uint64_t mask = 0;
        prefixes_.push_back(mask);
        for (const std::uint32_t sample : order) prefixes_.push_back(mask |= std::uint64_t{1} << sample);
    }
}

}  // namespace ropsim
