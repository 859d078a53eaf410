// Engine `shader`: the critical sections of the quads that one partition's memory holds.
#pragma once

#include "memory/event_wheel.h"
#include "memory/l2_slice.h"
#include "memory/latency_histogram.h"
#include "memory/tlm_memory_port.h"
#include "model/byte_counts.h"
#include "model/interlock_order.h"
#include "model/interlock_table.h"
#include "model/machine_config.h"
#include "model/partition_input.h"
#include "model/quad_operation.h"
#include "model/stage_account.h"
#include "model/surface_map.h"
#include "model/traffic_breakdown.h"

#include <array>
#include <cstdint>
#include <vector>

namespace ropsim {

// Shaded quads come in raster order, one a cycle. A quad that operates on pixels gets their interlock: in
// order of arrival, or by trying again and again a lock in memory. Then it loads what the operation reads,
// executes its instructions, stores, waits for word of its stores and gives the pixels back. Other quads go
// their way at the same time, as many as the shader cores hold. All loads and stores of the partition's
// memory pass through one port, a request a cycle, to the L2 slice.
//
// Where the shader cores' lanes are busy is the front end's account (operation_lane_cycles()); here an
// operation takes the time of its dependent instructions.
class InterlockPartition : public sc_core::sc_module, public MemoryPortClient {
 public:
    // `breakdown` counts for whom bytes move; `order`, if any, is told who operates when.
    InterlockPartition(const sc_core::sc_module_name& name, int number, EventWheel& wheel,
                       const MachineConfig& config, const SurfaceMap& map, BatchSource& source,
                       TrafficBreakdown& breakdown, InterlockOrder* order);

    TlmMemoryPort port;
    PartitionInput& input() { return input_; }
    // The slice that the port is bound to: told when nothing more comes.
    void connect(L2Slice& slice) { slice_ = &slice; }

    Picoseconds step(Picoseconds now);
    void memory_done(std::uint32_t id, bool write) override;
    void memory_port_free() override;

    bool drained() const;
    // Cycle after the last thing this partition did.
    std::uint64_t last_cycle() const { return last_cycle_; }
    void finish(std::uint64_t total_cycles);

    // The port: busy with a request, or the next one waits for the slice to take it.
    const StageAccount& port_account() const { return port_account_; }
    // Cycles of all quads between arrival and end, by what they were spent on: `interlock` waiting for the
    // pixels, `request_queue` for the port, `fill` for loads, `stores` for word of stores, `busy` executing.
    const std::array<std::uint64_t, kStageLabels>& quad_cycles() const { return quad_cycles_; }
    // [surface][cause]: bytes over the port.
    const BytesByCause& bytes() const { return bytes_; }
    // By surface: picoseconds from a load's request to its data at the port.
    const std::vector<LatencyHistogram>& read_latency() const { return read_latency_; }
    std::uint64_t quads() const { return quads_done_; }
    // Tries for a lock, and those of them that found it taken.
    std::uint64_t tries() const { return tries_; }
    std::uint64_t retries() const { return retries_; }

 private:
    static constexpr std::uint32_t kRequests =
        128;  // between port and slice; a slice answers 64 reads at once
    enum class State : std::uint8_t {
        kFree,
        kWaiting,     // for its turn
        kTrying,      // an atomic for the lock is queued or under way
        kLockKnown,   // its answer is on the way back
        kBackingOff,  // until the next try
        kBeginning,   // granted
        kLoading,     // loads are queued or under way
        kExecuting,   // from the last data on
        kStoring,     // stores are queued or under way
        kEnding,      // until word of the stores and the release
        kUnlocking,   // the lock's store is queued
    };
    struct Slot {
        QuadBatch* batch = nullptr;
        std::uint32_t quad = 0;
        std::uint32_t warp = 0;         // the front end's
        std::uint32_t line = 0;         // that requests are made of next
        std::uint32_t sectors = 0;      // of it, still to be asked for
        std::uint32_t outstanding = 0;  // requests under way
        std::uint64_t since = 0;        // cycle that its label began
        StageLabel label = StageLabel::kIdle;
        State state = State::kFree;
        bool moved = false;  // a request was made in this state
        InterlockOrder::Ordinals ordinals{};
    };
    struct Timer {
        std::uint64_t cycle;
        std::uint64_t number;  // of equal times the first set is the first to come
        std::uint32_t slot;
        bool operator>(const Timer& other) const {
            return cycle != other.cycle ? cycle > other.cycle : number > other.number;
        }
    };
    struct Flight {
        std::uint32_t slot = 0;
        std::uint8_t surface = 0;
        Picoseconds asked = 0;
    };

    const QuadOperation& operation(const Slot& s) const { return s.batch->quads[s.quad]; }
    std::uint32_t locked_pixels(const QuadOperation& q) const;
    bool spins() const { return config_.interlock.mode == InterlockMode::kSpin; }

    void admit(std::uint64_t cycle);
    void grant(std::uint32_t slot, std::uint64_t cycle);
    void record_grant(std::uint32_t slot);
    void release(std::uint32_t slot, std::uint64_t cycle);
    void leave(std::uint32_t slot, std::uint64_t cycle);
    void set_timer(std::uint32_t slot, std::uint64_t cycle);
    void run_timers(std::uint64_t cycle);
    void timer_done(std::uint32_t slot, std::uint64_t cycle);
    void queue_requests(std::uint32_t slot, State state, std::uint64_t cycle);
    void requests_done(std::uint32_t slot, std::uint64_t cycle);
    void stored(std::uint32_t slot, std::uint64_t cycle);
    bool more_requests(Slot& slot) const;
    void send(std::uint64_t cycle);
    void issue(std::uint32_t slot);
    void count(const MemoryRequest& request, const Slot& slot);
    void label(Slot& slot, std::uint64_t cycle, StageLabel next);

    const MachineConfig& config_;
    const SurfaceMap& map_;
    EventWheel& wheel_;
    BatchSource& source_;
    InterlockOrder* order_;
    int number_;
    int wheel_id_;
    PartitionInput input_;
    L2Slice* slice_ = nullptr;
    bool told_slice_ = false;

    std::vector<Slot> slots_;
    std::vector<std::uint32_t> free_slots_;
    InterlockTable table_;
    std::vector<std::uint32_t> granted_;  // those of one release
    std::vector<Timer> timers_;           // heap, the earliest first
    std::uint64_t timer_number_ = 0;
    std::vector<std::uint32_t> queue_;  // ring of slots with requests to make
    std::uint32_t queue_head_ = 0;
    std::uint32_t queue_count_ = 0;
    std::vector<Flight> flights_;
    std::vector<std::uint32_t> free_flights_;

    std::uint64_t admit_free_ = 0;
    std::uint64_t send_free_ = 0;
    bool port_blocked_ = false;  // the next request waits for the slice to take one
    std::uint64_t last_cycle_ = 0;
    std::uint64_t quads_done_ = 0;
    std::uint64_t tries_ = 0;
    std::uint64_t retries_ = 0;
    StageAccount port_account_;
    std::array<std::uint64_t, kStageLabels> quad_cycles_{};
    BytesByCause bytes_;
    TrafficBreakdown& breakdown_;
    std::vector<LatencyHistogram> read_latency_;
};

}  // namespace ropsim
