// Whether a larger ROP cache would help: stack distances of a sample of its lines.
#pragma once

#include "memory/lru_stack.h"
#include "model/machine_observation.h"
#include "model/quad_operation.h"
#include "model/surface_map.h"

#include <array>
#include <cstdint>
#include <vector>

namespace ropsim {

// Lines are chosen by a hash of their address.
class ReuseSample {
 public:
    ReuseSample(const RopCacheConfig& cache, const SurfaceMap& map);
    // All lines of a batch, in their partitions' order.
    void use(const QuadBatch& batch);
    ReuseCounts counts() const;

 private:
    static constexpr std::array<std::uint32_t, 9> kEighths = {8, 10, 12, 16, 24, 32, 48, 64, 128};
    // Sampled lines of a cache as it is: fewer tell too little, more cost time.
    static constexpr std::uint32_t kSampled = 16;
    struct Section {
        LruStack stack;
        std::vector<std::uint32_t> number;  // by line of the address space: 1 + its number in the stack
        std::uint32_t lines = 0;
    };

    std::uint64_t size_bytes_;
    int line_shift_;
    int sampled_shift_ = 0;                                   // one line in 2^this
    std::vector<std::uint8_t> section_of_;                    // by surface
    std::vector<Section> sections_;                           // [partition * kCacheSections + section]
    std::array<std::uint64_t, kEighths.size() + 1> reads_{};  // by level
};

}  // namespace ropsim
