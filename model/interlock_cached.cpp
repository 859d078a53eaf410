// Engine `shader` without a clock: see run_cached_interlock().
#include "memory/sector_runs.h"
#include "memory/untimed_l2.h"
#include "model/frame_pipeline.h"
#include "model/front_end_caches.h"
#include "model/interlock_cost.h"
#include "model/interlock_machine.h"

#include <algorithm>
#include <array>
#include <memory>

namespace ropsim {

namespace {

// One partition's slice and channel, and what passes through them.
class CachedInterlock final : public UntimedMemory {
 public:
    CachedInterlock(const MachineConfig& config, const SurfaceMap& map, MachineResult& result)
        : config_(config), map_(map), result_(result), l2_(config.l2) {}

    void operate(const QuadOperation& q, const QuadBatch& batch) {
        const ByteSource source = batch.source(q);
        const LineAccess* lines = batch.lines[q.partition].data() + q.first_line;
        const bool locks =
            config_.interlock.mode == InterlockMode::kSpin && q.kind == QuadKind::kDraw && q.pixels != 0;
        if (locks) lock(q, source, false);
        for (std::uint32_t l = 0; l < q.line_count; ++l) {
            MemoryRequest read;
            read.surface = lines[l].surface;
            read.cause = cause_of(q.kind);
            runs(lines[l].line_address, lines[l].read_sectors, read, nullptr, source);
        }
        for (std::uint32_t l = 0; l < q.line_count; ++l) {
            if (lines[l].write_sectors == 0) continue;
            MemoryRequest write;
            write.surface = lines[l].surface;
            write.write = true;
            write.masked = true;
            write.cause = MemoryCause::kWriteBack;
            runs(lines[l].line_address, lines[l].write_sectors, write, &lines[l].write_bytes, source);
        }
        if (locks) lock(q, source, true);
    }
    // Past the port, which is the critical sections' own.
    void read_for(const ByteSource& source, const MemoryRequest& request) override {
        pass_on(request, source);
    }
    void flush() {
        for (const MemoryRequest& request : l2_.flush()) to_memory(request);
    }
    const UntimedL2& l2() const { return l2_; }
    std::uint64_t requests() const { return requests_; }
    std::uint64_t bursts() const { return bursts_; }
    ReadWriteBytes pins() const { return pins_; }

 private:
    void lock(const QuadOperation& q, const ByteSource& source, bool gives_back) {
        move(lock_request(q, map_, gives_back), source);
    }
    void runs(std::uint64_t line_address, std::uint32_t sectors, const MemoryRequest& common,
              const LineMask* enables, const ByteSource& source) {
        for_each_run(line_address, sectors, config_.cache.sector_bytes, common, enables,
                     [&](const MemoryRequest& request) { move(request, source); });
    }
    void move(const MemoryRequest& request, const ByteSource& source) {
        ++requests_;
        pass_on(request, source);
    }
    void pass_on(const MemoryRequest& request, const ByteSource& source) {
        CauseBytes& port = result_.miss_port[request.surface][static_cast<std::size_t>(request.cause)];
        (request.write ? port.write : port.read) += request.bytes;
        result_.breakdown.add(source, request.bytes, request.write);
        for (const MemoryRequest& below : l2_.access(request)) to_memory(below);
    }
    void to_memory(const MemoryRequest& request) {
        const std::uint64_t burst = config_.dram.burst_bytes();
        const std::uint64_t bursts =
            (request.address + request.bytes + burst - 1) / burst - request.address / burst;
        bursts_ += bursts;
        CauseBytes& pins = result_.pins[request.surface][static_cast<std::size_t>(request.cause)];
        (request.write ? pins.write : pins.read) += bursts * burst;
        (request.write ? pins_.write : pins_.read) += bursts * burst;
    }

    const MachineConfig& config_;
    const SurfaceMap& map_;
    MachineResult& result_;
    UntimedL2 l2_;
    std::uint64_t requests_ = 0;
    std::uint64_t bursts_ = 0;
    ReadWriteBytes pins_;
};

// ROP cycles of critical sections on each pixel, one after the other.
class Chains {
 public:
    Chains(const MachineConfig& config, std::size_t tiles) : config_(config), cycles_(tiles * kTilePixels) {}
    void add(const QuadOperation& q, const QuadBatch& batch) {
        if (q.kind != QuadKind::kDraw || q.pixels == 0) return;
        const std::uint32_t pixels = config_.interlock.per_pixel ? q.pixels : 0xFu;
        const std::uint64_t section =
            critical_cycles(q, batch.lines[q.partition].data() + q.first_line, config_);
        for (std::uint32_t p = 0; p < 4; ++p)
            if ((pixels >> p & 1u) != 0)
                longest_ = std::max(longest_, cycles_[std::size_t{q.quad_id} * 4 + p] += section);
    }
    std::uint64_t longest() const { return longest_; }

 private:
    const MachineConfig& config_;
    std::vector<std::uint64_t> cycles_;
    std::uint64_t longest_ = 0;
};

// Keeps the longest time and its resource.
void consider(MachineResult& result, const char* resource, double seconds) {
    if (seconds <= result.seconds) return;
    result.seconds = seconds;
    result.bottleneck = resource;
}

}  // namespace

MachineResult run_cached_interlock(Frame& frame, const MachineConfig& config, int threads) {
    const SurfaceMap& map = frame.surfaces();
    MachineResult result;
    result.bottleneck = "nothing";
    result.miss_port.resize(static_cast<std::size_t>(map.surfaces()));
    result.pins.resize(result.miss_port.size());
    result.breakdown = {frame.pass_names(), frame.draws(), tiles_across(frame.width()),
                        tiles_across(frame.height())};
    std::vector<std::unique_ptr<CachedInterlock>> partitions;
    std::vector<CachedInterlock*> owners;
    for (std::uint32_t p = 0; p < config.partitions; ++p) {
        partitions.push_back(std::make_unique<CachedInterlock>(config, map, result));
        owners.push_back(partitions.back().get());
    }
    UntimedFrontEnd front_end(config, map, owners);
    Chains chains(config, static_cast<std::size_t>(tiles_across(frame.width())) *
                              static_cast<std::size_t>(tiles_across(frame.height())));
    FramePipeline pipeline(frame, threads);
    InterlockSource source(pipeline, config.interlock);
    while (QuadBatch* batch = source.next()) {
        for (const QuadOperation& q : batch->quads) {
            front_end.read(q, *batch);
            if (!reaches_partition(q)) continue;
            partitions[q.partition]->operate(q, *batch);
            chains.add(q, *batch);
            ++result.quads;
        }
        source.release(batch);
    }
    front_end.finish();
    result.front_end = front_end.counts();
    result.front_end.hierarchical_depth_bytes = frame.hierarchical_depth_bytes();
    const double shader_period = static_cast<double>(config.shader_period_ps) * 1e-12;
    const double rop_period = static_cast<double>(config.rop_period_ps) * 1e-12;
    consider(result, "shading",
             static_cast<double>(front_end.lane_cycles()) / config.shader_alu_lanes * shader_period);
    consider(result, "export",
             static_cast<double>(result.quads) / config.export_quads_per_cycle * rop_period);
    consider(result, "interlock", static_cast<double>(chains.longest()) * rop_period);
    result.l2.emplace();
    for (const auto& p : partitions) {
        p->flush();
        consider(result, "interlock_port", static_cast<double>(p->requests()) * rop_period);
        consider(result, "l2", static_cast<double>(p->l2().busy_cycles()) * rop_period);
        consider(result, "dram",
                 static_cast<double>(p->bursts()) * config.dram.burst * config.dram.tck_ps * 1e-12 /
                     config.dram.pseudochannels);
        result.channels.push_back({p->pins()});
        result.l2->add(p->l2().statistics());
    }
    result.breakdown.check(result.miss_port);
    result.channel_peak_bytes_per_second = config.dram.peak_bytes_per_second();
    result.rop_cycles = static_cast<std::uint64_t>(result.seconds / rop_period + 0.5);
    return result;
}

}  // namespace ropsim
