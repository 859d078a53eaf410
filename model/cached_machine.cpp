#include "model/cached_machine.h"

#include "model/cached_partition.h"
#include "model/frame_pipeline.h"
#include "model/front_end_caches.h"
#include "model/tiled_quads.h"

#include <algorithm>
#include <memory>

namespace ropsim {

namespace {

// Keeps the longest time and its resource.
struct Bottleneck {
    double seconds = 0;
    std::string name = "nothing";
    void consider(const char* resource, double time) {
        if (time <= seconds) return;
        seconds = time;
        name = resource;
    }
};

ReadWriteBytes sum_of(const BytesByCause& bytes) {
    ReadWriteBytes sum;
    for (const auto& causes : bytes) {
        for (const CauseBytes& cause : causes) {
            sum.read += cause.read;
            sum.write += cause.write;
        }
    }
    return sum;
}

void add(BytesByCause& sum, const BytesByCause& one) {
    for (std::size_t s = 0; s < one.size(); ++s) {
        for (std::size_t c = 0; c < kMemoryCauses; ++c) {
            sum[s][c].read += one[s][c].read;
            sum[s][c].write += one[s][c].write;
        }
    }
}

}  // namespace

MachineResult run_cached_machine(Frame& frame, const MachineConfig& config, int threads, TiledQuads* tiled) {
    const SurfaceMap& map = frame.surfaces();
    MachineResult result;
    result.breakdown = {frame.pass_names(), frame.draws(), tiles_across(frame.width()),
                        tiles_across(frame.height())};
    std::vector<std::unique_ptr<CachedPartition>> partitions;
    for (std::uint32_t p = 0; p < config.partitions; ++p)
        partitions.push_back(std::make_unique<CachedPartition>(
            config, map,
            compressed_surfaces(config, map, frame.operation().declaration(), frame.initial_pixels(),
                                static_cast<int>(p)),
            &result.breakdown));
    FramePipeline pipeline(
        [&](QuadBatch& batch) { return tiled != nullptr ? tiled->advance(batch) : frame.advance(batch); },
        threads);
    std::vector<CachedPartition*> owners;
    for (const auto& partition : partitions) owners.push_back(partition.get());
    UntimedFrontEnd front_end(config, map, owners);
    // A partition whose cache has nothing below it that others come to takes its quads of a batch together:
    // its tags stay near the host. Which quads it takes and in which order is the same.
    const bool together = !config.l2.present() && partitions.front()->compressed() == nullptr;
    std::vector<std::vector<const QuadOperation*>> waiting(partitions.size());
    while (QuadBatch* batch = pipeline.next()) {
        for (const QuadOperation& q : batch->quads) {
            front_end.rasterise(q);
            front_end.read_depths(q, *batch);
            if (!reaches_partition(q)) continue;
            ++result.quads;
            if (together)
                waiting[q.partition].push_back(&q);
            else
                partitions[q.partition]->operate(q, *batch);
            front_end.shade(q, *batch);
        }
        for (std::size_t p = 0; p < partitions.size(); ++p) {
            for (const QuadOperation* q : waiting[p]) partitions[p]->operate(*q, *batch);
            waiting[p].clear();
        }
        pipeline.release(batch);
    }
    front_end.finish();
    result.front_end = front_end.counts();
    const double shader_period = static_cast<double>(config.shader_period_ps) * 1e-12;
    const double rop_period = static_cast<double>(config.rop_period_ps) * 1e-12;
    Bottleneck bottleneck;
    bottleneck.consider(
        "shading", static_cast<double>(front_end.lane_cycles()) / config.shader_alu_lanes * shader_period);
    bottleneck.consider("export",
                        static_cast<double>(result.quads) / config.export_quads_per_cycle * rop_period);
    result.miss_port.resize(static_cast<std::size_t>(map.surfaces()));
    result.pins.resize(static_cast<std::size_t>(map.surfaces()));
    for (const auto& p : partitions) {
        p->flush();
        bottleneck.consider("rop_tag", static_cast<double>(p->tag_cycles()) * rop_period);
        bottleneck.consider("rop_operation", static_cast<double>(p->operation_cycles()) * rop_period);
        bottleneck.consider("rop_port", static_cast<double>(p->port_cycles()) * rop_period);
        bottleneck.consider("dram", static_cast<double>(p->bursts()) * config.dram.burst *
                                        config.dram.tck_ps * 1e-12 / config.dram.pseudochannels);
        add(result.miss_port, p->port());
        add(result.pins, p->pins());
        result.channels.push_back({sum_of(p->pins())});
        result.cache.add(p->cache().statistics());
        if (p->compressed() != nullptr) result.compression.add(*p->compressed(), map);
        if (!p->l2()) continue;
        if (!result.l2) result.l2.emplace();
        result.l2->add(p->l2()->statistics());
        bottleneck.consider("l2", static_cast<double>(p->l2()->busy_cycles()) * rop_period);
    }
    result.breakdown.check(result.miss_port);
    result.channel_peak_bytes_per_second = config.dram.peak_bytes_per_second();
    result.seconds = bottleneck.seconds;
    result.bottleneck = bottleneck.name;
    result.rop_cycles = static_cast<std::uint64_t>(bottleneck.seconds / rop_period + 0.5);
    result.front_end.hierarchical_depth_bytes = frame.hierarchical_depth_bytes();
    return result;
}

}  // namespace ropsim
