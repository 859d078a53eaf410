// A slice of the second-level cache without a clock: what passes through it, and how long that would take.
#pragma once

#include "memory/l2_slice.h"
#include "memory/l2_statistics.h"
#include "memory/rop_cache.h"
#include "memory/tlm_memory_port.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace ropsim {

// Takes requests in order; a fill is there at once.
class UntimedL2 {
 public:
    explicit UntimedL2(const L2Config& config) : config_(config), cache_(config.cache) {}

    // Looks up one request; a masked write must have its enables. Returns what goes to memory for it, valid
    // until the next call.
    const std::vector<MemoryRequest>& access(const MemoryRequest& request);
    // The end of the frame: dirty bytes go to memory, unless the configuration leaves them here.
    const std::vector<MemoryRequest>& flush();

    const RopCache& cache() const { return cache_; }
    // Counts so far; labels and cycles are 0.
    L2Statistics statistics() const;
    // Cycles of the busier of look-ups (writes with their data) and of the data read.
    std::uint64_t busy_cycles() const { return std::max(look_up_cycles_, data_cycles_); }

 private:
    void look_up(const MemoryRequest& request, std::uint32_t from, std::uint32_t bytes);
    void to_memory(std::uint64_t line_address, std::uint32_t sectors, const MemoryRequest& common);

    L2Config config_;
    RopCache cache_;
    std::vector<MemoryRequest> below_;
    L2Statistics statistics_;
    std::uint64_t look_up_cycles_ = 0;
    std::uint64_t data_cycles_ = 0;
};

}  // namespace ropsim
