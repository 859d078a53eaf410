// Fisher and Yates' shuffle.
#include "capture/geometry/shuffled_order.h"

#include "base/random.h"

#include <utility>

namespace ropsim {

std::vector<std::uint32_t> shuffled_order(std::uint32_t count, std::uint64_t seed) {
    std::vector<std::uint32_t> order(count);
    for (std::uint32_t i = 0; i < count; ++i) order[i] = i;
    const std::uint64_t key = mix64(seed ^ (0x53687566ull << 32));
    for (std::uint32_t left = count; left > 1; --left) {
        const std::uint64_t chosen = std::uint64_t{random_bits(key, left)} * left >> 32;
        std::swap(order[left - 1], order[chosen]);
    }
    return order;
}

}  // namespace ropsim
