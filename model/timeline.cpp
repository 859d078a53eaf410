// Sums over intervals: see timeline.h.
#include "model/timeline.h"

#include <algorithm>

namespace ropsim {

namespace {

// Events that an interval can make: a slice a stage, a counter a kind of stage, one of queues and one of
// bytes a partition.
std::size_t events_of_interval(const WatchedMachine& machine) {
    std::vector<std::string> kinds;
    for (const WatchedStage& stage : machine.stages)
        if (std::ranges::find(kinds, stage.name) == kinds.end()) kinds.push_back(stage.name);
    return machine.stages.size() + kinds.size() + 2 * machine.channels.size() + 1;
}

}  // namespace

Timeline::Timeline(const WatchedMachine& machine, std::uint64_t stride, std::uint64_t events)
    : machine_(machine),
      interval_(stride),
      most_(std::max<std::size_t>(events / events_of_interval(machine), 2)),
      moved_(machine.channels.size()) {}

void Timeline::merge_pairs() {
    for (std::size_t i = 0; i < intervals_.size(); i += 2) {
        Interval& to = intervals_[i / 2];
        if (i != 0) to = std::move(intervals_[i]);
        if (i + 1 == intervals_.size()) continue;
        const Interval& second = intervals_[i + 1];
        for (std::size_t s = 0; s < to.stages.size(); ++s)
            for (std::size_t l = 0; l < kStageLabels; ++l) to.stages[s][l] += second.stages[s][l];
        for (std::size_t q = 0; q < to.occupied.size(); ++q) to.occupied[q] += second.occupied[q];
        for (std::size_t c = 0; c < to.moved.size(); ++c) {
            to.moved[c].read += second.moved[c].read;
            to.moved[c].write += second.moved[c].write;
        }
        to.samples += second.samples;
    }
    intervals_.resize((intervals_.size() + 1) / 2);
    interval_ *= 2;
}

Timeline::Interval& Timeline::at(std::uint64_t cycle) {
    while (cycle / interval_ >= most_) merge_pairs();
    while (cycle / interval_ >= intervals_.size()) {
        Interval& added = intervals_.emplace_back();
        added.stages.resize(machine_.stages.size());
        added.occupied.resize(machine_.queues.size());
        added.moved.resize(machine_.channels.size());
    }
    return intervals_[cycle / interval_];
}

void Timeline::labelled(std::size_t stage, std::uint64_t from, std::uint64_t until, StageLabel label) {
    while (from < until) {
        Interval& interval = at(from);
        const std::uint64_t end = std::min(until, (from / interval_ + 1) * interval_);
        interval.stages[stage][static_cast<std::size_t>(label)] += end - from;
        from = end;
    }
}

// Bytes count where the sample before was: they have moved since.
void Timeline::count_bytes() {
    for (std::size_t c = 0; c < machine_.channels.size(); ++c) {
        const WatchedChannel::Look look = machine_.channels[c].look();
        Bytes& moved = at(last_sample_).moved[c];
        moved.read += look.read_bytes - moved_[c].read;
        moved.write += look.write_bytes - moved_[c].write;
        moved_[c] = {look.read_bytes, look.write_bytes};
    }
}

void Timeline::sample(std::uint64_t cycle) {
    count_bytes();
    Interval& interval = at(cycle);
    ++interval.samples;
    for (std::size_t q = 0; q < machine_.queues.size(); ++q)
        interval.occupied[q] += machine_.queues[q].occupied();
    last_sample_ = cycle;
}

void Timeline::finish(std::uint64_t cycles) {
    cycles_ = cycles;
    if (cycles != 0) count_bytes();  // those since the last sample
}

}  // namespace ropsim
