// When the passes of a frame were simulated: the time between the ends of batches, by the pass of the batch.
#pragma once

#include "memory/event_wheel.h"
#include "model/quad_operation.h"

#include <algorithm>
#include <vector>

namespace ropsim {

// Stands between the frame's batches and the machine. A batch ends when its last quad is written; the time
// since the end of the one before it belongs to its pass. Passes overlap in the machine, so this is the time
// that a pass adds, and all of them sum to the end of the last batch.
class PassClock : public BatchSource {
 public:
    PassClock(BatchSource& source, const EventWheel& wheel, std::size_t passes)
        : source_(source), wheel_(wheel), time_(passes, 0) {}

    QuadBatch* next() override { return source_.next(); }
    void release(QuadBatch* batch) override {
        const Picoseconds now = std::max(wheel_.now(), last_);
        time_[batch->pass] += now - last_;
        last_ = now;
        source_.release(batch);
    }

    // By pass of Frame::pass_names(), picoseconds; what follows the last batch until `end` belongs to the
    // last of them, the end of the frame.
    std::vector<Picoseconds> times(Picoseconds end) const {
        std::vector<Picoseconds> times = time_;
        times.back() += end - last_;
        return times;
    }

 private:
    BatchSource& source_;
    const EventWheel& wheel_;
    std::vector<Picoseconds> time_;
    Picoseconds last_ = 0;
};

}  // namespace ropsim
