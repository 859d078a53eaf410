// Address patterns made on the fly: the workloads that memory systems are compared on.
#pragma once

#include "memory/address_trace.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

// With b = bytes, n = span / b, S(x) = SplitMix64's output for state x. Request i is
//   seq_read, seq_write   address (i mod n) b
//   rand_read, rand_write address (S(20240607 + i) mod n) b
//   seq_mix50, rand_mix50 the same, a write where bit 17 of S(20240607 xor 7919 i) is set
//   chase                 rand_read, each after the data of the one before
//   stride_rmw            a read, and a write of the same bytes after its data, at steps of 4 KiB: `window`
//   reads
//                         first, then a write and the next read in turn
struct PatternOptions {
    std::string name;
    std::uint64_t requests = 1'000'000;
    std::uint64_t span = 0;     // bytes of address space, a multiple of `bytes`
    std::uint32_t bytes = 64;   // of a request
    std::uint32_t window = 16;  // of stride_rmw
};

const std::vector<std::string>& pattern_names();

class AccessPattern : public RequestSource {
 public:
    // No request needs one further back.
    static constexpr std::uint32_t kNeeds = 64;
    // Throws UserError on an unknown name or a span that does not fit.
    explicit AccessPattern(PatternOptions options);
    bool next(std::vector<AddressRequest>& block) override;

 private:
    AddressRequest request(std::uint64_t i) const;
    AddressRequest strided(std::uint64_t i) const;

    PatternOptions options_;
    std::uint64_t blocks_ = 0;
    std::uint64_t made_ = 0;
    bool random_ = false;
    bool write_ = false;
    bool mixed_ = false;
    bool strided_ = false;
    std::uint32_t needs_ = 0;
};

}  // namespace ropsim
