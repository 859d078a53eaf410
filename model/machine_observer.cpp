// What of each part can be seen: see machine_observer.h.
#include "model/machine_observer.h"

namespace ropsim {

MachineObserver::MachineObserver(const ObservationOptions& options, Picoseconds rop_period)
    : options_(options) {
    machine_.period = rop_period;
}

void MachineObserver::watch(FrontEnd& front_end, const MachineConfig& config) {
    machine_.queues.push_back({"shader_window", kWholeMachine, config.shader_quads_in_flight,
                               [&front_end] { return front_end.quads_in_window(); }});
    machine_.stages.push_back({"front_end", kWholeMachine, &front_end.account()});
    machine_.stages.push_back({"rasteriser", kWholeMachine, &front_end.rasteriser_account()});
}

void MachineObserver::watch(RopPartition& partition, DramChannel& channel, std::uint32_t p,
                            const MachineConfig& config) {
    const RopPartition* const rop = &partition;
    const DramScheduler* const dram = &channel.scheduler();
    const DramConfig& d = config.dram;
    const std::uint32_t behind = d.banks() * (d.bank_queue + (d.activated_leave_queue ? 1 : 0));
    const auto queue = [&](const char* name, std::uint64_t capacity, auto occupied) {
        machine_.queues.push_back({name, p, capacity, occupied});
    };
    queue("input_queue", config.input_queue + config.crossbar_latency, [rop] { return rop->input().size(); });
    queue("slots", config.quads_in_flight, [rop] { return rop->slots_in_use(); });
    queue("miss_registers", config.mshrs, [rop] { return rop->mshrs_in_use(); });
    queue("request_queue", config.cache_request_queue, [rop] { return rop->requests_queued(); });
    queue("dram_reads", d.max_reads(), [dram] { return dram->queued_reads(); });
    queue("dram_writes", d.queue_pairs() * d.write_queue + behind, [dram] { return dram->queued_writes(); });
    const std::array<StageAccount*, 4> accounts = partition.accounts();
    machine_.stages.push_back({"rop_tag", p, accounts[0]});
    machine_.stages.push_back({"rop_operation", p, accounts[1]});
    if (config.cache_port_bytes != 0) {
        machine_.stages.push_back({"rop_port_out", p, accounts[2]});
        machine_.stages.push_back({"rop_port_in", p, accounts[3]});
    }
    machine_.channels.push_back(
        {p,
         [dram, burst = d.burst_bytes()] {
             const DramStatistics& s = dram->statistics();
             return WatchedChannel::Look{s.read_bursts * burst, s.write_bursts * burst, dram->draining() > 0};
         },
         [&channel](Picoseconds time) { channel.settle(time); }});
    machine_.partitions.push_back([rop, dram, &config](std::uint64_t cycle) {
        const RopPartition::Waits waits = rop->waits(cycle);
        return PartitionLook{waits.issued,
                             waits.starved,
                             waits.fill,
                             waits.tags,
                             rop->mshrs_in_use(),
                             rop->mshrs_in_use() == config.mshrs,
                             rop->slots_in_use() == config.quads_in_flight,
                             dram->queued_reads()};
    });
}

void MachineObserver::start(EventWheel& wheel) {
    probe_.emplace(machine_);
    occupancy_.emplace(machine_);
    waits_.emplace(machine_);
    probe_->add(*occupancy_, options_.probe_cycles);
    probe_->add(*waits_, options_.probe_cycles);
    if (options_.timeline) {
        timeline_.emplace(machine_, options_.probe_cycles, options_.timeline_events);
        probe_->add(*timeline_, options_.probe_cycles);
        probe_->tell_labels(*timeline_);
    }
    if (options_.vcd) {
        vcd_.emplace(machine_, options_.vcd_from, options_.vcd_to);
        probe_->add(*vcd_, 1, options_.vcd_from, options_.vcd_to);
        probe_->tell_labels(*vcd_);
    }
    wheel.set_observer(*probe_);
}

void MachineObserver::finish(std::uint64_t cycles, const BatchWatch& batches, MachineObservation& result) {
    probe_->finish(cycles);
    result.probe_cycles = options_.probe_cycles;
    result.occupancy = occupancy_->histograms();
    result.waits = waits_->counts();
    result.rastered = batches.rastered();
    result.reuse = batches.reuse().counts();
    result.passes = batches.passes();
    if (timeline_) result.timeline = timeline_->json(result.passes);
    if (vcd_) result.vcd = vcd_->text();
}

}  // namespace ropsim
