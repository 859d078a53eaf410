// The events of a timeline, one a line.
#include "model/timeline.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {

namespace {

using Json = nlohmann::ordered_json;

constexpr int kMachine = 1;  // process numbers; partition p is the p-th behind it

int process_of(std::uint32_t instance) {
    return instance == kWholeMachine ? kMachine : kMachine + 1 + static_cast<int>(instance);
}

}  // namespace

class TraceEvents {
 public:
    void add(const Json& event) {
        text_ += count_++ == 0 ? "\n" : ",\n";
        text_ += event.dump();
    }
    void name(const char* what, int process, int thread, const std::string& name) {
        add({{"name", what}, {"ph", "M"}, {"pid", process}, {"tid", thread}, {"args", {{"name", name}}}});
    }
    void slice(const std::string& name, int process, int thread, double from, double until, Json args) {
        add({{"name", name},
             {"ph", "X"},
             {"ts", from},
             {"dur", until - from},
             {"pid", process},
             {"tid", thread},
             {"args", std::move(args)}});
    }
    void counter(const std::string& name, int process, double at, Json values) {
        add({{"name", name}, {"ph", "C"}, {"ts", at}, {"pid", process}, {"args", std::move(values)}});
    }
    const std::string& text() const { return text_; }

 private:
    std::string text_;
    std::size_t count_ = 0;
};

namespace {

// Slices of a thread must not overlap: each pass takes the first lane that is free.
void add_passes(TraceEvents& events, const std::vector<PassSpan>& passes) {
    std::vector<double> free;
    for (const PassSpan& pass : passes) {
        const double from = static_cast<double>(pass.start) * 1e-6;
        const double until = static_cast<double>(std::max(pass.end, pass.start)) * 1e-6;
        const auto lane = std::ranges::find_if(free, [&](double end) { return end <= from; });
        const auto number = static_cast<std::size_t>(lane - free.begin());
        if (lane == free.end()) free.push_back(0);
        free[number] = until;
        events.slice(pass.name, kMachine, static_cast<int>(number), from, until, {{"quads", pass.quads}});
    }
    for (std::size_t lane = 0; lane < free.size(); ++lane)
        events.name("thread_name", kMachine, static_cast<int>(lane), "passes");
}

std::vector<std::string> kinds_of(const WatchedMachine& machine) {
    std::vector<std::string> kinds;
    for (const WatchedStage& stage : machine.stages)
        if (std::ranges::find(kinds, stage.name) == kinds.end()) kinds.push_back(stage.name);
    return kinds;
}

// Threads 0... are taken by passes in the machine's process, which has no slices of stages but the front
// end's.
int thread_of(std::size_t stage) {
    return 100 + static_cast<int>(stage);
}

}  // namespace

std::string Timeline::json(const std::vector<PassSpan>& passes) const {
    TraceEvents events;
    events.name("process_name", kMachine, 0, "machine");
    for (const WatchedChannel& channel : machine_.channels)
        events.name("process_name", process_of(channel.instance), 0,
                    fmt::format("partition {}", channel.instance));
    for (std::size_t s = 0; s < machine_.stages.size(); ++s)
        events.name("thread_name", process_of(machine_.stages[s].instance), thread_of(s),
                    machine_.stages[s].name);
    add_passes(events, passes);
    for (std::size_t s = 0; s < machine_.stages.size(); ++s) add_slices(events, s);
    for (const std::string& kind : kinds_of(machine_)) add_labels(events, kind);
    for (const Interval& interval : intervals_) add_queues(events, interval);
    return fmt::format(
        "{{\"displayTimeUnit\":\"ns\",\"otherData\":{},\"traceEvents\":[{}\n]}}\n",
        Json{{"cycles", cycles_}, {"cycle_picoseconds", machine_.period}, {"interval_cycles", interval_}}
            .dump(),
        events.text());
}

// Where one label other than idle is the most frequent one; neighbours with the same are one slice.
void Timeline::add_slices(TraceEvents& events, std::size_t stage) const {
    const auto dominant = [&](std::size_t interval) {
        const Labels& labels = intervals_[interval].stages[stage];
        return static_cast<std::size_t>(std::ranges::max_element(labels) - labels.begin());
    };
    for (std::size_t i = 0; i < intervals_.size();) {
        const std::size_t label = dominant(i);
        const std::size_t first = i;
        std::uint64_t cycles = 0;
        for (; i < intervals_.size() && dominant(i) == label; ++i)
            cycles += intervals_[i].stages[stage][label];
        if (label == static_cast<std::size_t>(StageLabel::kIdle) || cycles == 0) continue;
        events.slice(std::string(kStageLabelNames[label]), process_of(machine_.stages[stage].instance),
                     thread_of(stage), microseconds(first * interval_),
                     microseconds(std::min(i * interval_, cycles_)), {{"cycles", cycles}});
    }
}

// All stages of a kind together, with the labels that any of them has.
void Timeline::add_labels(TraceEvents& events, const std::string& kind) const {
    std::vector<Labels> sums(intervals_.size());
    Labels all{};
    for (std::size_t s = 0; s < machine_.stages.size(); ++s) {
        if (machine_.stages[s].name != kind) continue;
        for (std::size_t i = 0; i < intervals_.size(); ++i) {
            for (std::size_t l = 0; l < kStageLabels; ++l) {
                sums[i][l] += intervals_[i].stages[s][l];
                all[l] += intervals_[i].stages[s][l];
            }
        }
    }
    for (std::size_t i = 0; i < intervals_.size(); ++i) {
        Json values = Json::object();
        for (std::size_t l = 0; l < kStageLabels; ++l)
            if (all[l] != 0) values[std::string(kStageLabelNames[l])] = sums[i][l];
        events.counter(kind + " cycles", kMachine, microseconds(i * interval_), std::move(values));
    }
}

void Timeline::add_queues(TraceEvents& events, const Interval& interval) const {
    const auto number = static_cast<std::uint64_t>(&interval - intervals_.data());
    const double at = microseconds(number * interval_);
    // Queues of an instance stand together.
    for (std::size_t q = 0; q < machine_.queues.size() && interval.samples != 0;) {
        const std::uint32_t instance = machine_.queues[q].instance;
        Json values = Json::object();
        for (; q < machine_.queues.size() && machine_.queues[q].instance == instance; ++q)
            values[machine_.queues[q].name] =
                static_cast<double>(interval.occupied[q]) / static_cast<double>(interval.samples);
        events.counter("occupied", process_of(instance), at, std::move(values));
    }
    for (std::size_t c = 0; c < machine_.channels.size(); ++c)
        events.counter("pin bytes", process_of(machine_.channels[c].instance), at,
                       {{"read", interval.moved[c].read}, {"write", interval.moved[c].write}});
}

}  // namespace ropsim
