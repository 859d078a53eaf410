// Value change dumps (IEEE 1364-2001, clause 18): signals over time for a waveform viewer.
#pragma once

#include "model/machine_probe.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

// Collects changes and writes them in order of time. A signal is a bit vector of up to 64 bits, unsigned;
// before its first value it is unknown.
class VcdWriter {
 public:
    // `scope`: module names from the outside in, separated by dots. Signals of a scope are added one after
    // the other. Names have no blanks. Returns the signal's number.
    std::size_t add(const std::string& scope, const std::string& name, int bits);
    // From `time` on. Calls may come in any order of time; of two for one signal and time the later holds.
    void set(std::size_t signal, std::uint64_t time, std::uint64_t value);
    // The file's text. `unit`: of the times, such as "1 ps"; `end`: time of the end.
    std::string text(const std::string& unit, const std::string& comment, std::uint64_t end) const;

 private:
    struct Signal {
        std::string scope;
        std::string name;
        int bits;
    };
    struct Change {
        std::uint64_t time;
        std::size_t signal;
        std::uint64_t value;
    };
    std::vector<Signal> signals_;
    std::vector<Change> changes_;
};

// The window of a run: every queue's occupancy, what each stage's cycle is labelled (a bit a label), and
// whether a channel serves its writes, cycle by cycle.
class VcdRecorder : public ProbeClient {
 public:
    // Cycles from, from + 1, ... to - 1.
    VcdRecorder(const WatchedMachine& machine, std::uint64_t from, std::uint64_t to);
    void sample(std::uint64_t cycle) override;
    void labelled(std::size_t stage, std::uint64_t from, std::uint64_t until, StageLabel label) override;
    void finish(std::uint64_t cycles) override { end_ = std::min(to_, cycles); }
    std::string text() const;

 private:
    const WatchedMachine& machine_;
    std::uint64_t from_, to_;
    std::uint64_t end_ = 0;
    VcdWriter writer_;
    std::vector<std::size_t> queues_, channels_;  // signals
    std::vector<std::size_t> stages_;             // the first label's; the others follow
    std::vector<std::uint64_t> queue_value_;      // last one set
    std::vector<std::uint8_t> writing_;
    std::vector<int> label_;  // last one set, -1: none
};

}  // namespace ropsim
