// A seeded random order.
#pragma once

#include <cstdint>
#include <vector>

namespace ropsim {

// The numbers below `count`, every order equally likely over the seeds; a pure function of both.
std::vector<std::uint32_t> shuffled_order(std::uint32_t count, std::uint64_t seed);

}  // namespace ropsim
