#include "model/timed_machine.h"

#include "base/error.h"
#include "memory/dram_channel.h"
#include "memory/event_wheel.h"
#include "memory/l2_slice.h"
#include "memory/simulate.h"
#include "model/frame_pipeline.h"
#include "model/front_end.h"
#include "model/front_end_caches.h"
#include "model/interlock_cost.h"
#include "model/interlock_machine.h"
#include "model/machine_observer.h"
#include "model/rop_partition.h"
#include "model/tiled_quads.h"

#include <algorithm>
#include <memory>

namespace ropsim {

namespace {

class TimedMachine : public sc_core::sc_module {
 public:
    TimedMachine(const sc_core::sc_module_name& name, const MachineConfig& config, const Frame& frame,
                 BatchSource& source, const ObservationOptions& observe, InterlockOrder* order)
        : sc_core::sc_module(name),
          wheel("wheel"),
          batches(source, wheel, frame.pass_names(), config.cache, frame.surfaces()),
          observer(observe, config.rop_period_ps),
          front_end(wheel, config, batches,
                    std::uint64_t{4} * frame.surfaces().pixel_bytes(frame.surfaces().opaque_depth())),
          breakdown(frame.pass_names(), frame.draws(), tiles_across(frame.width()),
                    tiles_across(frame.height())) {
        std::vector<PartitionInput*> connected;
        std::vector<CompressedSurfaces*> compressed;
        if (config.interlock.executes) front_end.hold_until_done();
        for (std::uint32_t p = 0; p < config.partitions; ++p) {
            const std::string part = fmt::format("partition_{}", p);
            if (config.interlock.executes) {
                interlocks.push_back(std::make_unique<InterlockPartition>(part.c_str(), static_cast<int>(p),
                                                                          wheel, config, frame.surfaces(),
                                                                          batches, breakdown, order));
                connected.push_back(&interlocks.back()->input());
                compressed.push_back(nullptr);
                continue;
            }
            partitions.push_back(std::make_unique<RopPartition>(
                part.c_str(), static_cast<int>(p), wheel, config, frame.surfaces(), batches, breakdown,
                compressed_surfaces(config, frame.surfaces(), frame.operation().declaration(),
                                    frame.initial_pixels(), static_cast<int>(p))));
            connected.push_back(&partitions.back()->input());
            compressed.push_back(partitions.back()->compressed());
        }
        front_end.connect(connected);
        caches = std::make_unique<FrontEndCaches>(wheel, config, frame.surfaces(), frame.has_opaque_layer(),
                                                  compressed, breakdown, front_end);
        // Each level is stepped after the ones above it: what goes down in a cycle is seen there in that
        // cycle.
        for (std::uint32_t p = 0; p < config.partitions; ++p) {
            if (config.l2.present())
                slices.push_back(std::make_unique<L2Slice>(fmt::format("l2_{}", p).c_str(), wheel, config.l2,
                                                           config.rop_period_ps));
            channels.push_back(
                std::make_unique<DramChannel>(fmt::format("channel_{}", p).c_str(), wheel, config.dram));
            if (config.l2.present()) slices.back()->port.bind(*channels.back());
            if (config.interlock.executes) {
                interlocks[p]->port.socket.bind(slices.back()->socket);
                interlocks[p]->connect(*slices.back());
            } else if (config.l2.present()) {
                partitions[p]->port.socket.bind(slices.back()->socket);
                partitions[p]->connect(*slices.back());
            } else {
                partitions[p]->port.bind(*channels.back());
            }
            if (caches->ports.empty()) continue;
            if (config.l2.present())
                caches->ports[p]->port.socket.bind(slices.back()->socket);
            else
                caches->ports[p]->port.bind(*channels.back());
        }
        observer.watch(front_end, config);
        for (std::uint32_t p = 0; p < partitions.size(); ++p)
            observer.watch(*partitions[p], *channels[p], p, config);
        observer.start(wheel);
    }

    EventWheel wheel;
    BatchWatch batches;
    MachineObserver observer;
    FrontEnd front_end;
    TrafficBreakdown breakdown;
    std::vector<std::unique_ptr<RopPartition>> partitions;
    InterlockPartitions interlocks;                // in place of partitions
    std::vector<std::unique_ptr<L2Slice>> slices;  // none, or one a partition
    std::vector<std::unique_ptr<DramChannel>> channels;
    std::unique_ptr<FrontEndCaches> caches;
};

std::uint64_t total_cycles(const TimedMachine& machine, const MachineConfig& config) {
    std::uint64_t last = std::max(machine.front_end.account().labelled(),
                                  (machine.wheel.now() + config.rop_period_ps - 1) / config.rop_period_ps);
    for (const auto& p : machine.partitions) last = std::max(last, p->last_cycle());
    for (const auto& p : machine.interlocks) last = std::max(last, p->last_cycle());
    for (const auto& s : machine.slices) last = std::max(last, s->last_cycle());
    return last;
}

// Miss-port bytes are the sum over surfaces and causes by construction; what the level below saw must be the
// same, cause by cause, and bus bytes are the channels' plus padding (and minus reads that the write queue
// answered).
void check_conservation(const TimedMachine& machine, const MachineResult& result) {
    for (std::size_t s = 0; s < result.miss_port.size(); ++s) {
        for (std::size_t c = 0; c < kMemoryCauses; ++c) {
            const DramBytes& read = result.dram.read[s][c];
            const DramBytes& write = result.dram.write[s][c];
            const CauseBytes& above = result.miss_port[s][c];
            PortBytes asked{above.read, above.write};
            if (result.l2) {
                const PortBytes& looked_up = result.l2->looked_up[s][c];
                CHECK(looked_up.read == asked.read && looked_up.write == asked.write,
                      "surface {} cause {}: port {} and {}, slices {} and {}", s, c, asked.read, asked.write,
                      looked_up.read, looked_up.write);
                asked = result.l2->memory[s][c];
            }
            CHECK(read.useful == asked.read && write.useful == asked.write,
                  "surface {} cause {}: port {} and {}, channel {} and {}", s, c, asked.read, asked.write,
                  read.useful, write.useful);
            CHECK(read.bus + read.forwarded >= read.useful && write.bus + write.forwarded >= write.useful,
                  "surface {} cause {}", s, c);
        }
    }
    for (const auto& channel : machine.channels) CHECK(channel->empty());
}

// The look-up stage of the slices in the words of the partitions' stages.
StageReport l2_stage(const MachineResult& result, std::uint32_t slices) {
    StageReport report{"l2", {}, slices};
    constexpr std::array<StageLabel, kL2Labels> kLabels = {StageLabel::kBusy,         StageLabel::kIdle,
                                                           StageLabel::kSlotsFull,    StageLabel::kMshrsFull,
                                                           StageLabel::kRequestQueue, StageLabel::kCacheWays};
    for (std::size_t l = 0; l < kLabels.size(); ++l)
        report.account.charge(report.account.labelled() + result.l2->label_cycles[l], kLabels[l]);
    return report;
}

void collect_channels(TimedMachine& machine, Picoseconds end, MachineResult& result) {
    for (const auto& channel : machine.channels) {
        channel->finish(end);
        const DramStatistics& d = channel->statistics();
        result.dram.add(d);
        result.channels.push_back({{d.total_read().bus, d.total_write().bus},
                                   d.row_hits,
                                   d.row_misses,
                                   d.row_conflicts,
                                   d.utilisation()});
    }
    for (std::size_t s = 0; s < result.pins.size(); ++s)
        for (std::size_t c = 0; c < kMemoryCauses; ++c)
            result.pins[s][c] = {result.dram.read[s][c].bus, result.dram.write[s][c].bus,
                                 result.dram.read[s][c].forwarded + result.dram.write[s][c].forwarded};
}

// Before the accounts are finished: how long each partition operated is still to be seen.
void collect_waits(const TimedMachine& machine, MachineResult& result) {
    MachineObservation& observation = result.observation;
    observation.fill_cycles.resize(result.miss_port.size());
    observation.fill_reads.resize(result.miss_port.size());
    std::uint64_t last = 0;
    for (const auto& p : machine.partitions) last = std::max(last, p->operation_account().labelled());
    for (const auto& p : machine.partitions) {
        const StageAccount& operations = p->operation_account();
        std::uint64_t filling = 0;
        for (std::size_t s = 0; s < observation.fill_cycles.size(); ++s) {
            filling += p->fill_cycles()[s];
            observation.fill_cycles[s] += p->fill_cycles()[s];
            observation.fill_reads[s] += p->fill_reads()[s];
        }
        CHECK(filling == operations.cycles(StageLabel::kFill), "{} of {} fill cycles", filling,
              operations.cycles(StageLabel::kFill));
        observation.interlock_reads += p->interlock_reads();
        observation.finished_cycles += last - operations.labelled();
        observation.end_cycles += result.rop_cycles - last;
    }
    observation.exported = machine.front_end.exported();
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
    result.read_latency.resize(surfaces);
    StageReport tags{"rop_tag", {}, config.partitions};
    StageReport operations{"rop_operation", {}, config.partitions};
    StageReport port_out{"rop_port_out", {}, config.partitions};
    StageReport port_in{"rop_port_in", {}, config.partitions};
    collect_waits(machine, result);
    for (const auto& p : machine.partitions) {
        p->finish(result.rop_cycles);
        tags.account.add(p->tag_account());
        operations.account.add(p->operation_account());
        port_out.account.add(p->port_out_account());
        port_in.account.add(p->port_in_account());
        result.cache.add(p->cache().statistics());
        if (p->compressed() != nullptr) result.compression.add(*p->compressed(), map);
        result.quads += p->quads();
        result.writes_coalesced += p->writes_saved();
        for (std::size_t s = 0; s < surfaces; ++s) result.read_latency[s].add(p->read_latency()[s]);
        for (std::size_t s = 0; s < surfaces; ++s) {
            for (std::size_t c = 0; c < kMemoryCauses; ++c) {
                result.miss_port[s][c].read += p->miss_port()[s][c].read;
                result.miss_port[s][c].write += p->miss_port()[s][c].write;
            }
        }
    }
    for (const auto& p : machine.interlocks) p->finish(result.rop_cycles);
    if (config.interlock.executes) collect_interlocks(machine.interlocks, result);
    CHECK(result.quads == machine.front_end.exported(), "{} of {} quads", result.quads,
          machine.front_end.exported());
    machine.front_end.account().finish(result.rop_cycles);
    result.front_end = machine.front_end.counts();
    result.front_end.depth_cache = machine.caches->depth_statistics();
    result.front_end.texture_cache = machine.caches->texture_statistics();
    machine.caches->add_bytes(result.miss_port);
    for (const auto& s : machine.slices) {
        s->finish(result.rop_cycles);
        if (!result.l2) result.l2.emplace();
        result.l2->add(s->statistics());
    }
    collect_channels(machine, end, result);
    result.dram_utilisation = result.dram.utilisation();
    result.dram_energy = result.dram.energy(config.dram);
    result.pass_times = machine.batches.added_times(end);
    result.alu_utilisation = machine.front_end.cores().utilisation(end);
    machine.front_end.rasteriser_account().finish(result.rop_cycles);
    result.stages = {
        {"front_end", machine.front_end.account(), 1},
        {"rasteriser", machine.front_end.rasteriser_account(), 1},
        {"shader_core", machine.front_end.cores().finish(result.rop_cycles), config.front.shader.cores}};
    if (config.interlock.executes) {
        const auto executed = interlock_stages(machine.interlocks, config, result.rop_cycles);
        result.stages.insert(result.stages.end(), executed.begin(), executed.end());
    } else {
        result.stages.insert(result.stages.end(), {tags, operations});
        if (config.cache_port_bytes != 0) result.stages.insert(result.stages.end(), {port_out, port_in});
    }
    machine.caches->add_stages(result.rop_cycles, result.stages);
    if (result.l2) result.stages.push_back(l2_stage(result, config.partitions));
    result.channel_peak_bytes_per_second = config.dram.peak_bytes_per_second();
    machine.observer.finish(result.rop_cycles, machine.batches, result.observation);
    check_conservation(machine, result);
    result.breakdown = machine.breakdown;
    result.breakdown.check(result.miss_port);
    return result;
}

}  // namespace

MachineResult run_timed_machine(Frame& frame, const MachineConfig& config, int threads,
                                const ObservationOptions& observe, TiledQuads* tiled, InterlockOrder* order) {
    use_picosecond_resolution();
    FramePipeline pipeline(
        [&](QuadBatch& batch) { return tiled != nullptr ? tiled->advance(batch) : frame.advance(batch); },
        threads);
    InterlockSource shaded(pipeline, config.interlock);
    BatchSource& source = config.interlock.executes ? static_cast<BatchSource&>(shaded) : pipeline;
    TimedMachine machine("machine", config, frame, source, observe, order);
    simulate();
    MachineResult result = collect(machine, config, frame.surfaces());
    result.front_end.hierarchical_depth_bytes = frame.hierarchical_depth_bytes();
    return result;
}

}  // namespace ropsim
