// One stream of requests through one memory, from the first to the last data.
#pragma once

#include "memory/memory_system.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace ropsim {

struct MemoryRun {
    DramCycle cycles = 0;  // of the memory controllers, from 0 to the last data
    double seconds = 0;    // the same, simulated
    std::uint64_t requests = 0;
    std::uint64_t wrapped_requests = 0;    // whose addresses were over the capacity
    std::uint64_t capacity = 0;            // bytes
    std::vector<DramStatistics> channels;  // each closed at `cycles`
    DramStatistics total;                  // their sum; cycles are those of all channels
    double host_seconds = 0;               // processor time of the simulation alone
    double host_source_seconds = 0;        // ... of reading or making the requests

    std::uint64_t useful_bytes() const { return total.total_read().useful + total.total_write().useful; }
    std::uint64_t bus_bytes() const { return total.total_read().bus + total.total_write().bus; }
    // Useful bytes over all the simulated time.
    double bytes_per_second() const {
        return seconds == 0 ? 0 : static_cast<double>(useful_bytes()) / seconds;
    }
};

struct MemoryRunOptions {
    // At most this many requests between one whose data are awaited and the newest; 0: as many as are
    // accepted.
    std::uint32_t outstanding = 0;
    // The largest AddressRequest::needs that the source makes.
    std::uint32_t needs = 0;
    // Sees every block after it was offered. The cycle of a request that had to wait for data is then that at
    // which it was offered.
    std::function<void(const std::vector<AddressRequest>&)> record;
};

// Throws UserError from the source, and when the configuration's channels do not fit its addresses.
MemoryRun run_memory(const MemoryConfig& config, RequestSource& source, const MemoryRunOptions& options = {});

}  // namespace ropsim
