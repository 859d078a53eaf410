// What was seen of a timed machine while it ran, beyond its counters: by samples, and on demand over time.
#pragma once

#include "model/occupancy.h"
#include "model/stage_account.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

// What to look at. Nothing here changes a simulated cycle.
struct ObservationOptions {
    std::uint64_t probe_cycles = 127;  // ROP cycles between samples; a prime, to beat with nothing
    bool timeline = false;
    std::uint64_t timeline_events = 50'000;  // about as many; a file has some 120 bytes for each
    bool vcd = false;
    std::uint64_t vcd_from = 0, vcd_to = 20'000;  // ROP cycles, `to` excluded
};

// A reason for which the operation stages do not operate, or that they do.
struct CycleCause {
    std::string cause;  // "operation", "fill.<surface>", "interlock", "cache_read", "tags.<label>", ...
    double share = 0;   // of all cycles of all operation stages, or of places for quads, 0..1
    std::string text;   // one sentence with its numbers
};

// What the operation stages were found waiting for, and how the memory side stood meanwhile.
// Samples, of all partitions.
struct WaitCounts {
    std::uint64_t samples = 0;
    std::uint64_t fill = 0;                             // the next quad waits for a fill
    std::uint64_t fill_mshrs_full = 0;                  // ... and every miss register is taken
    std::uint64_t fill_slots_full = 0;                  // ... or every slot for quads
    std::uint64_t fill_mshrs = 0;                       // ... and so many are, summed
    std::uint64_t fill_reads = 0;                       // ... and the channel holds so many reads, summed
    std::array<std::uint64_t, kStageLabels> starved{};  // no quad to issue, by label of the tag stage
};

// Of a sample of lines, chosen by a hash of their address as SHARDS does (Waldspurger, Park, Garthwaite and
// Ahmad, FAST 2015): every use of one in `every`. A cache of N lines is then a fully associative LRU cache of
// N / every.
struct ReuseCounts {
    // A cache of `bytes` a partition, all sections grown alike, would have missed so many of the reads of
    // lines that were used before.
    struct Size {
        std::uint64_t bytes = 0;
        std::uint64_t misses = 0;
    };
    std::uint32_t every = 0;  // one line in so many
    std::uint64_t reads = 0;  // reads of sampled lines that were used before
    std::vector<Size> sizes;  // rising; the first is the cache as it is
};

// A pass, or a round of a repeated one, in the machine. Passes overlap: there is no barrier between them.
struct PassSpan {
    std::string name;
    std::uint64_t start = 0;  // ps: its first batch was asked for, to launch its first quad
    std::uint64_t end = 0;    // ps: its last quad was written
    std::uint64_t quads = 0;
};

struct MachineObservation {
    std::uint64_t probe_cycles = 0;
    std::vector<OccupancyHistogram> occupancy;
    WaitCounts waits;
    // Of the operation stages: cycles labelled `fill`, by surface awaited; of those labelled `cache_read` the
    // ones behind a fill, and behind a wait for the interlock.
    std::vector<std::uint64_t> fill_cycles, fill_reads;
    std::uint64_t interlock_reads = 0;
    // After their last operation: while other partitions still operate, and when none does.
    std::uint64_t finished_cycles = 0, end_cycles = 0;
    std::uint64_t exported = 0, rastered = 0;  // quads
    ReuseCounts reuse;
    std::vector<PassSpan> passes;
    std::vector<CycleCause> bottlenecks;  // largest share first; shares add up to 1
    std::string timeline, vcd;            // texts of the files asked for
};

}  // namespace ropsim
