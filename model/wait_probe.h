// Counts what the operation stages are found waiting for.
#pragma once

#include "model/machine_observation.h"
#include "model/machine_probe.h"

#include <array>
#include <cstdint>
#include <vector>

namespace ropsim {

class WaitProbe : public ProbeClient {
 public:
    explicit WaitProbe(const WatchedMachine& machine)
        : machine_(machine), partitions_(machine.partitions.size()) {}
    void sample(std::uint64_t cycle) override {
        for (std::size_t p = 0; p < partitions_.size(); ++p)
            count(machine_.partitions[p](cycle), partitions_[p]);
    }
    void finish(std::uint64_t) override {}
    const WaitCounts& counts() const { return counts_; }

 private:
    // A partition that has no quad waits for one only if one comes: its samples count when it does.
    struct Partition {
        std::uint64_t issued = 0;
        std::array<std::uint64_t, kStageLabels> starved{};
    };
    void count(const PartitionLook& look, Partition& partition) {
        ++counts_.samples;
        if (look.issued != partition.issued) {
            for (std::size_t l = 0; l < kStageLabels; ++l) counts_.starved[l] += partition.starved[l];
            partition = {look.issued, {}};
        }
        if (look.starved) ++partition.starved[static_cast<std::size_t>(look.tags)];
        if (!look.waits_fill) return;
        ++counts_.fill;
        counts_.fill_mshrs_full += look.mshrs_full ? 1 : 0;
        counts_.fill_slots_full += look.slots_full ? 1 : 0;
        counts_.fill_mshrs += look.mshrs;
        counts_.fill_reads += look.reads;
    }

    const WatchedMachine& machine_;
    std::vector<Partition> partitions_;
    WaitCounts counts_;
};

}  // namespace ropsim
