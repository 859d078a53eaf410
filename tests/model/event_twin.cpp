// The loop that ticks every part of the twin once a cycle.
#include "tests/model/event_twin.h"

#include "base/error.h"
#include "tests/model/twin_front_end.h"
#include "tests/model/twin_partition.h"
#include "tests/model/twin_reads.h"
#include "tests/model/twin_slice.h"

#include <algorithm>
#include <memory>
#include <vector>

namespace ropsim {

namespace {

class TwinMachine : public sc_core::sc_module {
 public:
    TwinMachine(const sc_core::sc_module_name& name, Frame& frame, const MachineConfig& config)
        : sc_core::sc_module(name), wheel("wheel"), config_(config), front_end_(config, frame) {
        id_ = wheel.add(*this);
        for (std::uint32_t p = 0; p < config.partitions; ++p) {
            woken_.push_back(false);
            const auto wake = [this, p] {
                woken_[p] = true;
                wheel.arm(id_, wheel.now());
            };
            partitions.push_back(
                std::make_unique<TwinPartition>(fmt::format("port_{}", p), wheel, config, frame.surfaces(),
                                                wake, [this](QuadBatch* b) { front_end_.quad_done(b); }));
            channels.push_back(
                std::make_unique<DramChannel>(fmt::format("channel_{}", p).c_str(), wheel, config.dram));
            if (config.l2.present()) {
                slices.push_back(std::make_unique<TwinSlice>(fmt::format("slice_{}", p).c_str(), wheel,
                                                             config.l2, config.rop_period_ps,
                                                             [this] { wheel.arm(id_, wheel.now()); }));
                partitions.back()->port.socket.bind(slices.back()->socket);
                slices.back()->port.socket.bind(channels.back()->socket);
            } else {
                partitions.back()->port.socket.bind(channels.back()->socket);
            }
        }
        make_read_caches(frame);
        wheel.arm(id_, 0);
    }

    Picoseconds step(Picoseconds now) {
        const std::uint64_t cycle = now / config_.rop_period_ps;
        const Picoseconds following = (cycle + 1) * config_.rop_period_ps;
        if (now % config_.rop_period_ps != 0) return following;
        // Memory that speaks at the very edge of a cycle is heard in it, by the partition it spoke to.
        const bool again = cycle < next_cycle_;
        if (!again) front_end_.tick(cycle, partitions);
        next_cycle_ = cycle + 1;
        bool done = true;
        for (std::size_t p = 0; p < partitions.size(); ++p) {
            if (!again || woken_[p]) partitions[p]->tick(cycle);
            woken_[p] = false;
            done = done && partitions[p]->drained();
            if (slices.empty()) continue;
            slices[p]->tick(cycle, partitions[p]->drained());
            done = done && slices[p]->drained();
        }
        for (auto& cache : front_end_.depth_units) cache->tick(cycle);
        for (auto& cache : front_end_.texture_caches) cache->tick(cycle);
        for (auto& port : read_ports) {
            port->tick(cycle);
            done = done && port->drained();
        }
        return done ? kNever : following;
    }
    const TwinFrontEnd& front_end() const { return front_end_; }
    std::uint64_t cycles() const {
        std::uint64_t end =
            std::max(front_end_.end(), (dram_end() + config_.rop_period_ps - 1) / config_.rop_period_ps);
        for (const auto& p : partitions) end = std::max(end, p->end());
        for (const auto& s : slices) end = std::max(end, s->end());
        return end;
    }
    // The last data on any channel's pins.
    Picoseconds dram_end() const { return last_data_; }
    void note_last_data(Picoseconds time) { last_data_ = std::max(last_data_, time); }

    EventWheel wheel;
    std::vector<std::unique_ptr<TwinPartition>> partitions;
    std::vector<std::unique_ptr<TwinSlice>> slices;  // none, or one a partition
    std::vector<std::unique_ptr<DramChannel>> channels;
    std::vector<std::unique_ptr<TwinReadPort>> read_ports;  // none, or one a partition

 private:
    // Without slices: a twin slice has one socket for one initiator.
    void make_read_caches(const Frame& frame) {
        const bool depths = has_depth_units(config_, frame.has_opaque_layer());
        const int textures = frame.surfaces().textures();
        if (!depths && textures < 0) return;
        CHECK(slices.empty());
        for (std::uint32_t p = 0; p < config_.partitions; ++p) {
            read_ports.push_back(std::make_unique<TwinReadPort>(fmt::format("read_port_{}", p), wheel,
                                                                frame.surfaces().surfaces(),
                                                                [this] { wheel.arm(id_, wheel.now()); }));
            read_ports.back()->port.socket.bind(channels[p]->socket);
        }
        for (std::uint32_t p = 0; depths && p < config_.partitions; ++p)
            front_end_.depth_units.push_back(std::make_unique<TwinReadCache>(
                wheel, depth_unit_config(config_), config_.rop_period_ps,
                [this, p](std::uint64_t address) { return std::pair(read_ports[p].get(), address); }));
        const std::uint64_t base = textures < 0 ? 0 : frame.surfaces().first_address(textures);
        const auto locate = [this, base](std::uint64_t address) {
            const std::uint64_t piece = address / 256;
            return std::pair(read_ports[piece % read_ports.size()].get(),
                             base + piece / read_ports.size() * 256 + address % 256);
        };
        for (std::uint32_t c = 0; textures >= 0 && c < config_.front.shader.cores; ++c)
            front_end_.texture_caches.push_back(std::make_unique<TwinReadCache>(
                wheel, texture_cache_config(config_), config_.rop_period_ps, locate));
    }

    const MachineConfig& config_;
    TwinFrontEnd front_end_;
    int id_;
    std::uint64_t next_cycle_ = 0;
    std::vector<bool> woken_;  // by partition: memory has spoken since its last tick
    Picoseconds last_data_ = 0;
};

// When data last moved on a channel: column commands tell, as they are issued.
class LastData : public DramCommandTrace {
 public:
    LastData(TwinMachine& machine, const DramConfig& dram) : machine_(machine), dram_(dram) {}
    void command(DramCycle cycle, DramCommand command, std::uint32_t, std::uint32_t, std::uint32_t) override {
        if (command == DramCommand::kRead)
            machine_.note_last_data((cycle + dram_.read_cycles()) * dram_.tck_ps);
        if (command == DramCommand::kWrite)
            machine_.note_last_data((cycle + dram_.write_cycles()) * dram_.tck_ps);
    }

 private:
    TwinMachine& machine_;
    const DramConfig& dram_;
};

}  // namespace

MachineResult run_event_twin(Frame& frame, const MachineConfig& config) {
    use_picosecond_resolution();
    TwinMachine machine("twin", frame, config);
    LastData last_data(machine, config.dram);
    for (auto& channel : machine.channels) channel->set_trace(&last_data);
    sc_core::sc_start();
    MachineResult result;
    result.timed = true;
    result.rop_cycles = machine.cycles();
    result.miss_port.resize(static_cast<std::size_t>(frame.surfaces().surfaces()));
    for (const auto& s : machine.slices) {
        CHECK(s->drained(), "the twin stopped early");
        if (!result.l2) result.l2.emplace();
        result.l2->cache.add(s->cache_statistics());
        result.l2->memory[0][0].read += s->memory_bytes();
    }
    for (const auto& p : machine.partitions) {
        CHECK(p->drained(), "the twin stopped early");
        result.cache.add(p->cache_statistics());
        for (std::size_t s = 0; s < result.miss_port.size(); ++s)
            for (std::size_t c = 0; c < kMemoryCauses; ++c) {
                result.miss_port[s][c].read += p->miss_port()[s][c].read;
                result.miss_port[s][c].write += p->miss_port()[s][c].write;
            }
    }
    for (const auto& port : machine.read_ports)
        for (std::size_t s = 0; s < result.miss_port.size(); ++s)
            for (std::size_t c = 0; c < kMemoryCauses; ++c)
                result.miss_port[s][c].read += port->bytes()[s][c].read;
    for (const auto& unit : machine.front_end().depth_units)
        result.front_end.depth_cache.add(unit->statistics());
    for (const auto& cache : machine.front_end().texture_caches)
        result.front_end.texture_cache.add(cache->statistics());
    return result;
}

}  // namespace ropsim
