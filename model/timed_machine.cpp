#include "model/timed_machine.h"

#include "base/error.h"
#include "memory/dram_channel.h"
#include "memory/event_wheel.h"
#include "model/frame_pipeline.h"
#include "model/front_end.h"
#include "model/rop_partition.h"

#include <algorithm>
#include <memory>

namespace ropsim {

namespace {

class TimedMachine : public sc_core::sc_module {
 public:
    TimedMachine(const sc_core::sc_module_name& name, const MachineConfig& config, const Frame& frame,
                 BatchSource& source)
        : sc_core::sc_module(name), wheel("wheel"), front_end(wheel, config, source) {
        std::vector<RopPartition*> connected;
        for (std::uint32_t p = 0; p < config.partitions; ++p) {
            partitions.push_back(std::make_unique<RopPartition>(
                fmt::format("partition_{}", p).c_str(), static_cast<int>(p), wheel, config, frame.surfaces(),
                source,
                compressed_surfaces(config, frame.surfaces(), frame.operation().declaration(),
                                    frame.initial_pixels(), static_cast<int>(p))));
            channels.push_back(
                std::make_unique<DramChannel>(fmt::format("channel_{}", p).c_str(), wheel, config.dram));
            partitions.back()->port.socket.bind(channels.back()->socket);
            partitions.back()->connect(front_end);
            connected.push_back(partitions.back().get());
        }
        front_end.connect(connected);
    }

    EventWheel wheel;
    FrontEnd front_end;
    std::vector<std::unique_ptr<RopPartition>> partitions;
    std::vector<std::unique_ptr<DramChannel>> channels;
};

std::uint64_t total_cycles(const TimedMachine& machine, const MachineConfig& config) {
    std::uint64_t last = std::max(machine.front_end.account().labelled(),
                                  (machine.wheel.now() + config.rop_period_ps - 1) / config.rop_period_ps);
    for (const auto& p : machine.partitions) last = std::max(last, p->last_cycle());
    return last;
}

// Miss-port bytes are the sum over surfaces and causes by construction; what the channels saw must be the
// same, cause by cause, and bus bytes are those plus padding (and minus reads that the write queue answered).
void check_conservation(const TimedMachine& machine, const MachineResult& result) {
    for (std::size_t s = 0; s < result.miss_port.size(); ++s) {
        for (std::size_t c = 0; c < kMemoryCauses; ++c) {
            const DramBytes& read = result.dram.read[s][c];
            const DramBytes& write = result.dram.write[s][c];
            CHECK(read.useful == result.miss_port[s][c].read && write.useful == result.miss_port[s][c].write,
                  "surface {} cause {}: port {} and {}, channel {} and {}", s, c, result.miss_port[s][c].read,
                  result.miss_port[s][c].write, read.useful, write.useful);
            CHECK(read.bus + read.forwarded >= read.useful && write.bus >= write.useful,
                  "surface {} cause {}", s, c);
        }
    }
    for (const auto& channel : machine.channels) CHECK(channel->empty());
}

MachineResult collect(TimedMachine& machine, const MachineConfig& config, const SurfaceMap& map) {
    MachineResult result;
    result.timed = true;
    result.rop_cycles = total_cycles(machine, config);
    const Picoseconds end = result.rop_cycles * config.rop_period_ps;
    result.seconds = static_cast<double>(end) * 1e-12;
    const auto surfaces = static_cast<std::size_t>(map.surfaces());
    result.miss_port.resize(surfaces);
    result.pins.resize(surfaces);
    StageReport tags{"rop_tag", {}, config.partitions};
    StageReport operations{"rop_operation", {}, config.partitions};
    for (const auto& p : machine.partitions) {
        p->finish(result.rop_cycles);
        tags.account.add(p->tag_account());
        operations.account.add(p->operation_account());
        result.cache.add(p->cache().statistics());
        if (p->compressed() != nullptr) result.compression.add(*p->compressed(), map);
        result.quads += p->quads();
        for (std::size_t s = 0; s < surfaces; ++s) {
            for (std::size_t c = 0; c < kMemoryCauses; ++c) {
                result.miss_port[s][c].read += p->miss_port()[s][c].read;
                result.miss_port[s][c].write += p->miss_port()[s][c].write;
            }
        }
    }
    CHECK(result.quads == machine.front_end.exported(), "{} of {} quads", result.quads,
          machine.front_end.exported());
    machine.front_end.account().finish(result.rop_cycles);
    for (const auto& channel : machine.channels) {
        channel->finish(end);
        result.dram.add(channel->statistics());
    }
    for (std::size_t s = 0; s < surfaces; ++s)
        for (std::size_t c = 0; c < kMemoryCauses; ++c)
            result.pins[s][c] = {result.dram.read[s][c].bus, result.dram.write[s][c].bus,
                                 result.dram.read[s][c].forwarded};
    result.dram_utilisation = result.dram.utilisation();
    result.alu_utilisation = machine.front_end.alu_utilisation(end);
    result.stages = {{"front_end", machine.front_end.account(), 1}, tags, operations};
    check_conservation(machine, result);
    return result;
}

}  // namespace

MachineResult run_timed_machine(Frame& frame, const MachineConfig& config, int threads) {
    use_picosecond_resolution();
    FramePipeline pipeline(frame, threads);
    TimedMachine machine("machine", config, frame, pipeline);
    sc_core::sc_start();
    return collect(machine, config, frame.surfaces());
}

}  // namespace ropsim
