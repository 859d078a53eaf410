// The way from export to what executes operations: crossbar and input queue of one partition.
#pragma once

#include "base/error.h"
#include "memory/clock_period.h"
#include "memory/event_wheel.h"
#include "model/machine_config.h"
#include "model/quad_operation.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace ropsim {

class FrontEnd;

struct QueuedQuad {
    QuadBatch* batch;
    std::uint32_t quad;
    std::uint32_t warp;     // the front end's name for its warp
    std::uint64_t arrival;  // ROP cycle
};

// A ring with room for the queue and for a quad a cycle in the crossbar before it: with room for the queue
// alone a partition could take no more than input_queue / crossbar_latency quads a cycle. The front end
// pushes; the unit that owns the input pops, and is stepped when the first quad arrives in an empty queue.
class PartitionInput {
 public:
    // `wheel_id`: of the unit that takes the quads.
    PartitionInput(EventWheel& wheel, int wheel_id, int number, const MachineConfig& config)
        : wheel_(wheel),
          wheel_id_(wheel_id),
          number_(number),
          period_(config.rop_period_ps),
          latency_(config.crossbar_latency),
          places_(config.input_queue + config.crossbar_latency),
          ring_(places_) {}
    void connect(FrontEnd& front_end) { front_end_ = &front_end; }

    bool has_room() const { return count_ < places_; }
    void push(QuadBatch& batch, std::uint32_t quad, std::uint32_t warp, Picoseconds now) {
        CHECK(has_room());
        const std::uint64_t arrival = period_.cycle_of(now) + latency_;
        std::uint32_t place = head_ + count_;
        if (place >= places_) place -= places_;
        ring_[place] = {&batch, quad, warp, arrival};
        __builtin_prefetch(&batch.quads[quad]);
        if (++count_ == 1) wheel_.arm(wheel_id_, std::max(arrival * period_.picoseconds(), now));
    }
    // No more quads follow.
    void finish() {
        finished_ = true;
        wheel_.arm(wheel_id_, wheel_.now());
    }

    std::uint32_t size() const { return count_; }
    bool empty() const { return count_ == 0; }
    bool finished() const { return finished_; }
    const QueuedQuad& front() const { return ring_[head_]; }
    // Takes the first quad and tells the front end that there is room.
    void pop();
    // A quad that held its place in the shader cores, in this warp, is done.
    void done(std::uint32_t warp);

 private:
    EventWheel& wheel_;
    int wheel_id_;
    int number_;
    ClockPeriod period_;
    std::uint64_t latency_;
    FrontEnd* front_end_ = nullptr;
    std::uint32_t places_;
    std::vector<QueuedQuad> ring_;
    std::uint32_t head_ = 0;
    std::uint32_t count_ = 0;
    bool finished_ = false;
};

}  // namespace ropsim
