// A chunk's fragments, with what goes with them, in another order.
#pragma once

#include "traces/trace.h"

#include <cstdint>
#include <vector>

namespace ropsim {

// Fragment i becomes the one that was at order[i].
void permute(FragmentChunk& chunk, const std::vector<std::uint32_t>& order);

}  // namespace ropsim
