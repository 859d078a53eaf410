// Everything that looks on at a timed machine, put together.
#pragma once

#include "memory/dram_channel.h"
#include "model/batch_watch.h"
#include "model/front_end.h"
#include "model/rop_partition.h"
#include "model/timeline.h"
#include "model/vcd_writer.h"
#include "model/wait_probe.h"

#include <optional>

namespace ropsim {

// Parts are named before the simulation starts; partitions and channels in order, the machine's period first.
class MachineObserver {
 public:
    MachineObserver(const ObservationOptions& options, Picoseconds rop_period);
    void watch(FrontEnd& front_end, const MachineConfig& config);
    // The partition `p` and its channel.
    void watch(RopPartition& partition, DramChannel& channel, std::uint32_t p, const MachineConfig& config);
    // Begins to look.
    void start(EventWheel& wheel);
    // After `cycles` cycles, when every stage's account is finished. Fills in what was sampled and recorded.
    void finish(std::uint64_t cycles, const BatchWatch& batches, MachineObservation& result);

 private:
    ObservationOptions options_;
    WatchedMachine machine_;
    std::optional<MachineProbe> probe_;
    std::optional<OccupancyProbe> occupancy_;
    std::optional<WaitProbe> waits_;
    std::optional<Timeline> timeline_;
    std::optional<VcdRecorder> vcd_;
};

}  // namespace ropsim
