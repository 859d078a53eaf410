// What a DRAM channel counted: bytes by surface and cause, rows, commands, and one label for every cycle.
#pragma once

#include "memory/latency_histogram.h"
#include "memory/memory_cause.h"

#include <array>
#include <cstdint>

namespace ropsim {

struct DramConfig;

// What a cycle of a pseudo-channel was spent on. A column command owns `burst` cycles from its issue (its
// data follow CL or CWL later); every other cycle belongs to what the next command waits for.
enum class DramLabel : std::uint8_t {
    kReadData,
    kWriteData,
    kIdle,              // no request queued
    kRefresh,           // from the refresh being due to its end
    kPrecharge,         // closing a row: tRP, or tRAS, tRTP, tWR before it
    kActivate,          // opening a row: tRCD
    kActivationWindow,  // tRRD, tFAW, t32AW
    kTurnaround,        // read to write or back
    kColumnGap,         // tCCD
    kCommandBus,        // the command bus was taken
    kWriteWait,         // only writes queued, waiting whether reads come
};
inline constexpr int kDramLabels = 11;
// "read_data", "write_data", "idle", "refresh", ...
const char* to_string(DramLabel label);

struct DramBytes {
    std::uint64_t useful = 0;  // asked for
    std::uint64_t bus = 0;     // moved over the pins: whole bursts
    // useful bytes without bursts of their own: of reads that the write queue served, of writes that it
    // merged
    std::uint64_t forwarded = 0;
};

// pJ, by what they were spent on.
struct DramEnergy {
    double activate = 0;  // and precharge
    double read = 0, write = 0;
    double refresh = 0;
    double background = 0;
    double total() const { return activate + read + write + refresh + background; }
};

struct DramStatistics {
    using ByClient = std::array<std::array<DramBytes, kMemoryCauses>, kMaxSurfaces>;
    ByClient read{};   // [surface][cause]
    ByClient write{};  // [surface][cause]

    std::uint64_t reads = 0, writes = 0;              // requests
    std::uint64_t forwarded_reads = 0;                // requests among `reads`
    std::uint64_t merged_writes = 0;                  // requests among `writes`
    std::uint64_t read_bursts = 0, write_bursts = 0;  // column commands
    std::uint64_t row_hits = 0;       // accesses (bursts of a request in one row) to an open row
    std::uint64_t row_misses = 0;     // ... to a closed bank
    std::uint64_t row_conflicts = 0;  // ... to a bank with another row open
    std::uint64_t activations = 0, precharges = 0, turnarounds = 0;
    std::uint64_t refreshes = 0, bank_refreshes = 0;          // of ranks, of single banks
    std::uint64_t blocking_requests = 0, blocking_bytes = 0;  // b_transport; outside every other count
    std::array<std::uint64_t, kDramLabels> label_cycles{};    // sums to `bus_cycles` after finish()
    std::uint64_t cycles = 0;
    std::uint64_t bus_cycles = 0;                           // cycles x pseudo-channels: of all data buses
    std::uint64_t rank_cycles = 0;                          // cycles x ranks of all pseudo-channels
    std::uint64_t rank_active_cycles = 0;                   // ... of which with a row open
    std::uint64_t read_queue_sum = 0, write_queue_sum = 0;  // accesses x cycles, once none is queued
    std::uint64_t blocked_cycles = 0;  // cycles in which a request stood in front of the channel
    LatencyHistogram read_latency;     // cycles from arrival to the end of the data

    std::uint64_t label(DramLabel which) const { return label_cycles[static_cast<std::size_t>(which)]; }
    DramBytes total_read() const;
    DramBytes total_write() const;
    // Share of the cycles in which the data buses moved data, 0..1.
    double utilisation() const;
    // From the command counts and the energies of `config`. Requires finish().
    DramEnergy energy(const DramConfig& config) const;
    // Adds another channel's counts (cycles add up too: channel cycles).
    void add(const DramStatistics& other);
    // Checks that labels sum to the bus cycles, that bus bytes are column commands times `burst_bytes`, and
    // that data labels are column commands times `burst`. Aborts with the values otherwise.
    void check(std::uint32_t burst_bytes, std::uint32_t burst) const;
};

}  // namespace ropsim
