// Counts what the operation stages are found waiting for.
#pragma once

#include "model/machine_observation.h"
#include "model/machine_probe.h"

#include <cstdint>

namespace ropsim {

class WaitProbe : public ProbeClient {
 public:
    explicit WaitProbe(const WatchedMachine& machine) : machine_(machine) {}
    void sample(std::uint64_t first, std::uint64_t step, std::uint64_t end) override {
        for (std::uint64_t cycle = first; cycle < end; cycle += step)
            for (const auto& partition : machine_.partitions) count(partition(cycle));
    }
    void finish(std::uint64_t) override {}
    const WaitCounts& counts() const { return counts_; }

 private:
    void count(const PartitionLook& look) {
        ++counts_.samples;
        if (look.starved) ++counts_.starved[static_cast<std::size_t>(look.tags)];
        if (!look.waits_fill) return;
        ++counts_.fill;
        counts_.fill_mshrs_full += look.mshrs_full ? 1 : 0;
        counts_.fill_slots_full += look.slots_full ? 1 : 0;
        counts_.fill_accesses += look.accesses;
    }

    const WatchedMachine& machine_;
    WaitCounts counts_;
};

}  // namespace ropsim
