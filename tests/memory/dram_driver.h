// Drives a DramScheduler without SystemC and records the commands it issues.
#pragma once

#include "base/parameters.h"
#include "memory/dram_scheduler.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace ropsim {

// A device with keys on top: {"dram.trefi", "0"}.
inline DramConfig test_config(const std::string& device,
                              const std::vector<std::pair<std::string, std::string>>& keys = {}) {
    Parameters parameters("test");
    parameters.set("dram.device", device, "test");
    for (const auto& [key, value] : keys) parameters.set(key, value, "test");
    DramConfig config = dram_config(parameters);
    parameters.close();
    return config;
}

struct IssuedCommand {
    DramCycle cycle;
    DramCommand command;
    std::uint32_t bank;
    std::uint32_t row;
    std::uint32_t column;
};

class CommandRecorder : public DramCommandTrace {
 public:
    void command(DramCycle cycle, DramCommand command, std::uint32_t bank, std::uint32_t row,
                 std::uint32_t column) override {
        commands.push_back({cycle, command, bank, row, column});
    }
    // Cycles of all commands of one kind.
    std::vector<DramCycle> cycles(DramCommand kind) const {
        std::vector<DramCycle> result;
        for (const IssuedCommand& issued : commands)
            if (issued.command == kind) result.push_back(issued.cycle);
        return result;
    }
    std::vector<IssuedCommand> commands;
};

class DramDriver {
 public:
    explicit DramDriver(const DramConfig& config) : scheduler(config) {
        scheduler.set_trace(&recorder);
        for (std::uint32_t i = config.max_reads(); i > 0; --i) numbers_.push_back(i - 1);
    }

    // Offers a request at `cycle` at the earliest, stepping until it is taken. Returns the cycle of
    // admission.
    DramCycle offer(std::uint64_t address, std::uint32_t bytes, bool write, DramCycle cycle = 0,
                    bool masked = false) {
        run_before(cycle);
        now = std::max(now, cycle);
        const DramCycle arrival = now;
        while (!try_push(address, bytes, write, masked, arrival)) {
            if (scheduler.next() == kNoCycle) return kNoCycle;  // stuck: the caller's test fails
            advance();
        }
        return now;
    }
    // Runs everything that is queued.
    void drain() {
        while (scheduler.next() != kNoCycle) advance();
    }
    // Steps until (not including) `cycle`.
    void run_before(DramCycle cycle) {
        while (scheduler.next() < cycle) advance();
    }
    void advance() {
        now = std::max(now, scheduler.next());
        scheduler.step(now);
        collect();
    }

    DramScheduler scheduler;
    CommandRecorder recorder;
    std::vector<DramScheduler::Finished> finished;
    DramCycle now = 0;

 private:
    bool try_push(std::uint64_t address, std::uint32_t bytes, bool write, bool masked, DramCycle arrival) {
        DramRequest request;
        request.address = address;
        request.bytes = bytes;
        request.write = write;
        request.masked = masked;
        request.cause = write ? MemoryCause::kWriteBack : MemoryCause::kFill;
        if (!write) {
            if (numbers_.empty()) return false;
            request.number = numbers_.back();
        }
        if (!scheduler.push(request, arrival, now)) return false;
        if (!write) numbers_.pop_back();
        collect();
        return true;
    }
    void collect() {
        for (const DramScheduler::Finished& done : scheduler.finished()) {
            numbers_.push_back(done.number);
            finished.push_back(done);
        }
        scheduler.finished().clear();
    }
    std::vector<std::uint32_t> numbers_;
};

}  // namespace ropsim
