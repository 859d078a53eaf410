// The syntax of value change dumps, and what of a machine goes into one: see vcd_writer.h.
#include "model/vcd_writer.h"

#include <algorithm>
#include <bit>
#include <limits>

#include <fmt/format.h>

namespace ropsim {

namespace {

constexpr std::uint64_t kUnset = std::numeric_limits<std::uint64_t>::max();

// Identifier codes are the printable characters from ! to ~.
std::string code_of(std::size_t signal) {
    constexpr std::size_t kCodes = '~' - '!' + 1;
    std::string code;
    do {
        code += static_cast<char>('!' + signal % kCodes);
        signal /= kCodes;
    } while (signal != 0);
    return code;
}

std::string change(std::size_t signal, int bits, std::uint64_t value) {
    if (bits == 1) return fmt::format("{}{}\n", value & 1, code_of(signal));
    return fmt::format("b{:b} {}\n", value, code_of(signal));
}

std::vector<std::string> split(const std::string& scope) {
    std::vector<std::string> parts;
    std::size_t at = 0;
    for (std::size_t dot = scope.find('.'); dot != std::string::npos; dot = scope.find('.', at)) {
        parts.push_back(scope.substr(at, dot - at));
        at = dot + 1;
    }
    parts.push_back(scope.substr(at));
    return parts;
}

std::string partition_scope(std::uint32_t instance) {
    return instance == kWholeMachine ? "machine" : fmt::format("machine.partition_{}", instance);
}

}  // namespace

std::size_t VcdWriter::add(const std::string& scope, const std::string& name, int bits) {
    signals_.push_back({scope, name, bits});
    return signals_.size() - 1;
}

void VcdWriter::set(std::size_t signal, std::uint64_t time, std::uint64_t value) {
    changes_.push_back({time, signal, value});
}

std::string VcdWriter::text(const std::string& unit, const std::string& comment, std::uint64_t end) const {
    std::string text = fmt::format("$comment {} $end\n$timescale {} $end\n", comment, unit);
    std::vector<std::string> open;
    const auto enter = [&](const std::vector<std::string>& scope) {
        const auto common = static_cast<std::size_t>(std::ranges::mismatch(open, scope).in1 - open.begin());
        for (; open.size() > common; open.pop_back()) text += "$upscope $end\n";
        for (std::size_t i = common; i < scope.size(); ++i) {
            text += fmt::format("$scope module {} $end\n", scope[i]);
            open.push_back(scope[i]);
        }
    };
    // A scope's signals stand together, and scopes inside another after its own signals.
    std::vector<std::size_t> order(signals_.size());
    for (std::size_t s = 0; s < order.size(); ++s) order[s] = s;
    std::ranges::stable_sort(order, {}, [&](std::size_t s) { return split(signals_[s].scope); });
    for (const std::size_t s : order) {
        enter(split(signals_[s].scope));
        text += fmt::format("$var wire {} {} {} $end\n", signals_[s].bits, code_of(s), signals_[s].name);
    }
    enter({});
    text += "$enddefinitions $end\n";

    std::vector<Change> changes = changes_;
    std::ranges::stable_sort(changes, {}, &Change::time);
    text += fmt::format("#{}\n$dumpvars\n", changes.empty() ? 0 : changes.front().time);
    for (std::size_t s = 0; s < signals_.size(); ++s)
        text += signals_[s].bits == 1 ? fmt::format("x{}\n", code_of(s)) : fmt::format("bx {}\n", code_of(s));
    text += "$end\n";
    std::uint64_t time = changes.empty() ? 0 : changes.front().time;
    for (const Change& c : changes) {
        if (c.time != time) text += fmt::format("#{}\n", c.time);
        time = c.time;
        text += change(c.signal, signals_[c.signal].bits, c.value);
    }
    return text + fmt::format("#{}\n", std::max(end, time));
}

VcdRecorder::VcdRecorder(const WatchedMachine& machine, std::uint64_t from, std::uint64_t to)
    : machine_(machine),
      from_(from),
      to_(to),
      queue_value_(machine.queues.size(), kUnset),
      writing_(machine.channels.size(), 2),
      label_(machine.stages.size(), -1) {
    for (const WatchedQueue& queue : machine.queues)
        queues_.push_back(writer_.add(partition_scope(queue.instance), queue.name,
                                      std::bit_width(std::max<std::uint64_t>(queue.capacity, 1))));
    for (const WatchedChannel& channel : machine.channels)
        channels_.push_back(writer_.add(partition_scope(channel.instance), "dram_serves_writes", 1));
    for (const WatchedStage& stage : machine.stages) {
        const std::string scope = partition_scope(stage.instance) + "." + stage.name;
        for (int l = 0; l < kStageLabels; ++l) {
            const std::size_t signal =
                writer_.add(scope, std::string(kStageLabelNames[static_cast<std::size_t>(l)]), 1);
            if (l == 0) stages_.push_back(signal);
            writer_.set(signal, from * machine.period, 0);
        }
    }
}

void VcdRecorder::sample(std::uint64_t cycle) {
    const std::uint64_t time = cycle * machine_.period;
    for (std::size_t q = 0; q < queues_.size(); ++q) {
        const std::uint64_t value = machine_.queues[q].occupied();
        if (value == queue_value_[q]) continue;
        queue_value_[q] = value;
        writer_.set(queues_[q], time, value);
    }
    for (std::size_t c = 0; c < channels_.size(); ++c) {
        const std::uint8_t writing = machine_.channels[c].look().writing ? 1 : 0;
        if (writing == writing_[c]) continue;
        writing_[c] = writing;
        writer_.set(channels_[c], time, writing);
    }
}

void VcdRecorder::labelled(std::size_t stage, std::uint64_t from, std::uint64_t until, StageLabel label) {
    from = std::max(from, from_);
    until = std::min(until, to_);
    const int number = static_cast<int>(label);
    if (from >= until || number == label_[stage]) return;
    if (label_[stage] >= 0)
        writer_.set(stages_[stage] + static_cast<std::size_t>(label_[stage]), from * machine_.period, 0);
    writer_.set(stages_[stage] + static_cast<std::size_t>(number), from * machine_.period, 1);
    label_[stage] = number;
}

std::string VcdRecorder::text() const {
    return writer_.text(
        "1 ps",
        fmt::format("ROP cycles {} to {} of {} ps: what holds from a cycle's edge to the next", from_, end_,
                    machine_.period),
        end_ * machine_.period);
}

}  // namespace ropsim
