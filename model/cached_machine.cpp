#include "model/cached_machine.h"

#include "base/error.h"
#include "model/frame_pipeline.h"

#include <algorithm>
#include <bit>
#include <memory>

namespace ropsim {

namespace {

// One partition's cache and what passed through it.
class CachedPartition {
 public:
    CachedPartition(const MachineConfig& config, const SurfaceMap& map)
        : config_(config),
          cache_(config.cache),
          port_(static_cast<std::size_t>(map.surfaces())),
          pins_(static_cast<std::size_t>(map.surfaces())) {
        for (int s = 0; s < map.surfaces(); ++s)
            if (map.starts_clear(s)) cache_.set_clear_range(map.first_address(s), map.address_bytes(s));
    }

    void operate(const QuadOperation& q, const std::vector<LineAccess>& lines) {
        tag_cycles_ += std::max(1u, q.line_count);
        operation_cycles_ += q.interval;
        const MemoryCause cause = q.kind == QuadKind::kCopy ? MemoryCause::kCopy : MemoryCause::kFill;
        for (std::uint32_t l = 0; l < q.line_count; ++l) {
            const LineAccess& access = lines[q.first_line + l];
            const int line = present(access);
            const std::uint32_t missing = cache_.request_sectors(line, access.read_sectors);
            if (missing != 0) {
                move(access.line_address, missing, false, access.surface, cause);
                cache_.fill(line, missing);
            }
            if (access.write_bytes.any()) cache_.write(line, access.write_bytes);
        }
    }
    void flush() {
        cache_.flush([this](const Eviction& e) {
            move(e.line_address, e.sectors, true, e.surface, MemoryCause::kFlush);
        });
    }

    const RopCache& cache() const { return cache_; }
    const BytesByCause& port() const { return port_; }
    const BytesByCause& pins() const { return pins_; }
    std::uint64_t tag_cycles() const { return tag_cycles_; }
    std::uint64_t operation_cycles() const { return operation_cycles_; }
    std::uint64_t bursts() const { return bursts_; }

 private:
    int present(const LineAccess& access) {
        int line = cache_.probe(access.line_address);
        if (line == RopCache::kMiss) {
            Eviction e;
            line = cache_.allocate(access.line_address, access.surface, &e);
            CHECK(line != RopCache::kMiss);
            if (e.sectors != 0) move(e.line_address, e.sectors, true, e.surface, MemoryCause::kWriteBack);
        }
        cache_.touch(line);
        return line;
    }
    // Sectors over the miss port, and the whole bursts they take on the pins.
    void move(std::uint64_t line_address, std::uint32_t sectors, bool write, std::uint8_t surface,
              MemoryCause cause) {
        const std::uint32_t sector_bytes = config_.cache.sector_bytes;
        const std::uint64_t burst_bytes = config_.dram.burst_bytes();
        while (sectors != 0) {
            const auto first = static_cast<std::uint32_t>(std::countr_zero(sectors));
            const auto length = static_cast<std::uint32_t>(std::countr_one(sectors >> first));
            const std::uint64_t begin = line_address + std::uint64_t{first} * sector_bytes;
            const std::uint64_t bytes = std::uint64_t{length} * sector_bytes;
            const std::uint64_t bursts =
                (begin + bytes + burst_bytes - 1) / burst_bytes - begin / burst_bytes;
            bursts_ += bursts;
            CauseBytes& port = port_[surface][static_cast<std::size_t>(cause)];
            CauseBytes& pins = pins_[surface][static_cast<std::size_t>(cause)];
            (write ? port.write : port.read) += bytes;
            (write ? pins.write : pins.read) += bursts * burst_bytes;
            sectors &= ~(~0u >> (32 - length) << first);
        }
    }

    const MachineConfig& config_;
    RopCache cache_;
    BytesByCause port_;
    BytesByCause pins_;
    std::uint64_t tag_cycles_ = 0;
    std::uint64_t operation_cycles_ = 0;
    std::uint64_t bursts_ = 0;
};

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

void add(BytesByCause& sum, const BytesByCause& one) {
    for (std::size_t s = 0; s < one.size(); ++s) {
        for (std::size_t c = 0; c < kMemoryCauses; ++c) {
            sum[s][c].read += one[s][c].read;
            sum[s][c].write += one[s][c].write;
        }
    }
}

}  // namespace

MachineResult run_cached_machine(Frame& frame, const MachineConfig& config, int threads) {
    const SurfaceMap& map = frame.surfaces();
    std::vector<std::unique_ptr<CachedPartition>> partitions;
    for (std::uint32_t p = 0; p < config.partitions; ++p)
        partitions.push_back(std::make_unique<CachedPartition>(config, map));
    FramePipeline pipeline(frame, threads);
    MachineResult result;
    std::uint64_t lane_cycles = 0;
    while (QuadBatch* batch = pipeline.next()) {
        for (const QuadOperation& q : batch->quads) {
            partitions[q.partition]->operate(q, batch->lines[q.partition]);
            lane_cycles += q.kind == QuadKind::kDraw ? q.shader_lane_cycles : 0;
        }
        result.quads += batch->quads.size();
        pipeline.release(batch);
    }
    const double shader_period = static_cast<double>(config.shader_period_ps) * 1e-12;
    const double rop_period = static_cast<double>(config.rop_period_ps) * 1e-12;
    Bottleneck bottleneck;
    bottleneck.consider("shading",
                        static_cast<double>(lane_cycles) / config.shader_alu_lanes * shader_period);
    bottleneck.consider("export",
                        static_cast<double>(result.quads) / config.export_quads_per_cycle * rop_period);
    result.miss_port.resize(static_cast<std::size_t>(map.surfaces()));
    result.pins.resize(static_cast<std::size_t>(map.surfaces()));
    for (const auto& p : partitions) {
        p->flush();
        bottleneck.consider("rop_tag", static_cast<double>(p->tag_cycles()) * rop_period);
        bottleneck.consider("rop_operation", static_cast<double>(p->operation_cycles()) * rop_period);
        bottleneck.consider(
            "dram", static_cast<double>(p->bursts()) * config.dram.burst * config.dram.tck_ps * 1e-12);
        add(result.miss_port, p->port());
        add(result.pins, p->pins());
        result.cache.add(p->cache().statistics());
    }
    result.seconds = bottleneck.seconds;
    result.bottleneck = bottleneck.name;
    result.rop_cycles = static_cast<std::uint64_t>(bottleneck.seconds / rop_period + 0.5);
    return result;
}

}  // namespace ropsim
