// A run over time as a Chrome/Perfetto trace: labels of the stages, queues, channels and passes.
#pragma once

#include "model/machine_observation.h"
#include "model/machine_probe.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

class TraceEvents;

// Keeps sums over intervals of equal length, as many as make about `events` events. A run that turns out
// longer has its intervals merged in pairs, so memory is bounded and nothing is lost: cycles by label and
// bytes add up to the run's.
class Timeline : public ProbeClient {
 public:
    // `stride`: cycles between samples; intervals are this times a power of two.
    Timeline(const WatchedMachine& machine, std::uint64_t stride, std::uint64_t events);

    void sample(std::uint64_t cycle) override;
    void labelled(std::size_t stage, std::uint64_t from, std::uint64_t until, StageLabel label) override;
    void finish(std::uint64_t cycles) override;

    std::uint64_t interval_cycles() const { return interval_; }
    // The file's text, JSON. Times are microseconds. Process 1 is the machine: a slice for each pass,
    // counters of the labels of each kind of stage (cycles in the interval, all instances together). Process
    // 2 + p is partition p: a slice wherever one label other than idle is the most frequent one of a stage,
    // counters of the mean occupancy of queues, and of the bytes over the pins in the interval.
    std::string json(const std::vector<PassSpan>& passes) const;

 private:
    void count_bytes();
    using Labels = std::array<std::uint64_t, kStageLabels>;
    struct Bytes {
        std::uint64_t read = 0;
        std::uint64_t write = 0;
    };
    struct Interval {
        std::vector<Labels> stages;           // by stage
        std::vector<std::uint64_t> occupied;  // by queue: sum over samples
        std::vector<Bytes> moved;             // by channel
        std::uint64_t samples = 0;
    };
    Interval& at(std::uint64_t cycle);
    void add_slices(TraceEvents& events, std::size_t stage) const;
    void add_labels(TraceEvents& events, const std::string& kind) const;
    void add_queues(TraceEvents& events, const Interval& interval) const;
    void merge_pairs();
    double microseconds(std::uint64_t cycle) const {
        return static_cast<double>(cycle) * static_cast<double>(machine_.period) * 1e-6;
    }

    const WatchedMachine& machine_;
    std::uint64_t interval_;
    std::size_t most_;  // intervals
    std::uint64_t cycles_ = 0;
    std::uint64_t last_sample_ = 0;
    std::vector<Bytes> moved_;  // by channel: so far
    std::vector<Interval> intervals_;
};

}  // namespace ropsim
