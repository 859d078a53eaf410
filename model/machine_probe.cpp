// When the probe looks, and the histograms of what it sees: see machine_probe.h.
#include "model/machine_probe.h"

#include <algorithm>

namespace ropsim {

void MachineProbe::add(ProbeClient& client, std::uint64_t stride, std::uint64_t from, std::uint64_t to) {
    CHECK(stride != 0);
    entries_.push_back({&client, stride, (from + stride - 1) / stride * stride, to});
}

void MachineProbe::tell_labels(ProbeClient& client) {
    told_labels_.push_back(&client);
    for (std::size_t s = 0; s < logs_.size(); ++s) machine_.stages[s].account->set_log(&logs_[s]);
}

void MachineProbe::pass_on_labels() {
    if (told_labels_.empty()) return;
    for (std::size_t s = 0; s < logs_.size(); ++s) {
        for (const StageSpan& span : logs_[s]) {
            for (ProbeClient* client : told_labels_)
                client->labelled(s, labelled_[s], span.until, span.label);
            labelled_[s] = span.until;
        }
        logs_[s].clear();
    }
}

// All cycles below `end`, in order: the channels can only be settled from cycle to cycle.
void MachineProbe::advance(std::uint64_t end) {
    while (true) {
        std::uint64_t cycle = end;
        for (const Entry& entry : entries_)
            if (entry.next < entry.to) cycle = std::min(cycle, entry.next);
        if (cycle == end) return;
        for (const WatchedChannel& channel : machine_.channels)
            if (channel.settle) channel.settle(cycle * machine_.period + 1);
        for (Entry& entry : entries_) {
            if (entry.next != cycle || cycle >= entry.to) continue;
            entry.client->sample(cycle);
            entry.next += entry.stride;
        }
    }
}

Picoseconds MachineProbe::observe(Picoseconds before) {
    advance((before + machine_.period - 1) / machine_.period);
    pass_on_labels();
    std::uint64_t next = kNever;
    for (const Entry& entry : entries_)
        if (entry.next < entry.to) next = std::min(next, entry.next);
    return next == kNever ? kNever : next * machine_.period;
}

void MachineProbe::finish(std::uint64_t cycles) {
    advance(cycles);
    pass_on_labels();
    for (const Entry& entry : entries_) entry.client->finish(cycles);
}

OccupancyProbe::OccupancyProbe(const WatchedMachine& machine) : machine_(machine) {
    for (const WatchedQueue& queue : machine.queues) {
        const auto found = std::ranges::find(histograms_, queue.name, &OccupancyHistogram::queue);
        histogram_of_.push_back(static_cast<std::size_t>(found - histograms_.begin()));
        if (found == histograms_.end()) histograms_.emplace_back(queue.name, queue.capacity);
        ++histograms_[histogram_of_.back()].instances;
    }
}

void OccupancyProbe::sample(std::uint64_t) {
    for (std::size_t q = 0; q < machine_.queues.size(); ++q)
        histograms_[histogram_of_[q]].add(machine_.queues[q].occupied());
}

}  // namespace ropsim
