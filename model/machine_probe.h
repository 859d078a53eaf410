// Looks at a running machine every so many cycles, without a part in it: how full its queues are, what its
// stages wait for.
#pragma once

#include "memory/event_wheel.h"
#include "model/occupancy.h"
#include "model/stage_account.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace ropsim {

inline constexpr std::uint32_t kWholeMachine = ~0u;  // the instance of what there is once

// A queue that can be looked at. Queues of one name have one capacity.
struct WatchedQueue {
    std::string name;
    std::uint32_t instance;  // partition, or kWholeMachine
    std::uint64_t capacity;
    std::function<std::uint32_t()> occupied;
};

struct WatchedStage {
    std::string name;
    std::uint32_t instance;
    StageAccount* account;
};

struct WatchedChannel {
    struct Look {
        std::uint64_t read_bytes = 0;  // over the pins, so far
        std::uint64_t write_bytes = 0;
        bool writing = false;  // it serves its writes
    };
    std::uint32_t instance;
    std::function<Look()> look;
    std::function<void(Picoseconds time)> settle;  // DramChannel::settle()
};

// How a partition stands at a sample.
struct PartitionLook {
    std::uint64_t issued = 0;  // quads that the operation stage has taken so far
    bool starved = false;      // the operation stage has no quad to issue
    bool waits_fill = false;   // its next quad waits for a fill
    StageLabel tags = StageLabel::kIdle;
    std::uint32_t mshrs = 0;  // taken
    bool mshrs_full = false;
    bool slots_full = false;
    std::uint32_t reads = 0;  // that its channel holds
};

struct WatchedMachine {
    Picoseconds period = 0;  // of the ROP clock
    std::vector<WatchedQueue> queues;
    std::vector<WatchedStage> stages;
    std::vector<WatchedChannel> channels;
    std::vector<std::function<PartitionLook(std::uint64_t cycle)>> partitions;
};

// Gets what the probe saw. Values are in the order of WatchedMachine.
class ProbeClient {
 public:
    virtual ~ProbeClient() = default;
    // How things stood at the end of a cycle.
    virtual void sample(std::uint64_t cycle) = 0;
    // These cycles of a stage have this label; stretches of a stage follow one another without a gap. They
    // may lie in the future (work that is reserved) or in the past (a wait that is over).
    virtual void labelled(std::size_t /*stage*/, std::uint64_t /*from*/, std::uint64_t /*until*/,
                          StageLabel /*label*/) {}
    // The simulation is over, after `cycles` cycles; every stage's last stretch has been labelled.
    virtual void finish(std::uint64_t cycles) = 0;
};

// Each client is asked at a stride of its own. A cycle is seen as it is once everything due at its edge is
// done; a channel that holds a request back, as it will be when it lets that in.
class MachineProbe : public WheelObserver {
 public:
    // `machine` stays and keeps its stages.
    explicit MachineProbe(const WatchedMachine& machine)
        : machine_(machine), logs_(machine.stages.size()), labelled_(machine.stages.size()) {}
    // Samples at cycles that are multiples of `stride`, from the first one that is at least `from`, below
    // `to`.
    void add(ProbeClient& client, std::uint64_t stride, std::uint64_t from = 0, std::uint64_t to = kNever);
    // And every stage's labels, from the start of the simulation.
    void tell_labels(ProbeClient& client);

    Picoseconds observe(Picoseconds before) override;
    // The cycles up to the end of the run, after the last step.
    void finish(std::uint64_t cycles);

 private:
    struct Entry {
        ProbeClient* client;
        std::uint64_t stride;
        std::uint64_t next;
        std::uint64_t to;
    };
    void advance(std::uint64_t end);
    void pass_on_labels();

    const WatchedMachine& machine_;
    std::vector<Entry> entries_;
    std::vector<ProbeClient*> told_labels_;
    std::vector<std::vector<StageSpan>> logs_;  // by stage; used if somebody is told
    std::vector<std::uint64_t> labelled_;       // by stage: so far passed on
};

// Histograms of every queue.
class OccupancyProbe : public ProbeClient {
 public:
    explicit OccupancyProbe(const WatchedMachine& machine);
    void sample(std::uint64_t cycle) override;
    void finish(std::uint64_t) override {}
    const std::vector<OccupancyHistogram>& histograms() const { return histograms_; }

 private:
    const WatchedMachine& machine_;
    std::vector<OccupancyHistogram> histograms_;  // one a name, in order of appearance
    std::vector<std::size_t> histogram_of_;       // by queue
};

}  // namespace ropsim
