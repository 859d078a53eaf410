#include "model/cache_sweep.h"

#include "base/error.h"
#include "memory/lru_traffic.h"
#include "memory/sector_runs.h"
#include "model/cached_partition.h"
#include "model/frame_pipeline.h"
#include "model/front_end_caches.h"
#include "rop/transcendental.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace ropsim {

namespace {

constexpr std::uint64_t kLargestIdeal = std::uint64_t{64} << 20;  // bytes; then without end

// In lines: four an octave, and the sizes asked for.
std::vector<std::uint32_t> ideal_capacities(const std::vector<std::uint32_t>& sizes,
                                            std::uint32_t line_bytes) {
    std::vector<std::uint32_t> lines;
    for (const std::uint32_t size : sizes) lines.push_back(size / line_bytes);
    const auto largest = static_cast<double>(kLargestIdeal) / line_bytes;
    for (int quarter = 0;; ++quarter) {
        const double capacity = deterministic_exp2(quarter / 4.0);
        if (capacity > largest) break;
        lines.push_back(static_cast<std::uint32_t>(std::lround(capacity)));
    }
    std::sort(lines.begin(), lines.end());
    lines.erase(std::unique(lines.begin(), lines.end()), lines.end());
    return lines;
}

// Whole bursts of these sectors of a line, each run of them a request.
std::uint64_t burst_bytes_of(std::uint64_t line_address, std::uint32_t sectors, const MachineConfig& config) {
    const std::uint64_t burst = config.dram.burst_bytes();
    std::uint64_t bytes = 0;
    while (sectors != 0) {
        const SectorRun run = take_run(sectors);
        const std::uint64_t begin = line_address + std::uint64_t{run.first} * config.cache.sector_bytes;
        const std::uint64_t end = begin + std::uint64_t{run.length} * config.cache.sector_bytes;
        bytes += ((end + burst - 1) / burst - begin / burst) * burst;
    }
    return bytes;
}

void add(BytesByCause& sum, const BytesByCause& one) {
    for (std::size_t s = 0; s < one.size(); ++s) {
        for (std::size_t c = 0; c < kMemoryCauses; ++c) {
            sum[s][c].read += one[s][c].read;
            sum[s][c].write += one[s][c].write;
        }
    }
}

// All caches of one partition.
class SweptPartition {
 public:
    SweptPartition(const std::vector<MachineConfig>& sizes, std::vector<std::uint32_t> ideal,
                   const Frame& frame, int number)
        : config_(sizes[0]),
          ideal_(config_.cache.line_bytes, config_.cache.sector_bytes, std::move(ideal),
                 frame.surfaces().surfaces()),
          uncached_(static_cast<std::size_t>(frame.surfaces().surfaces())) {
        const SurfaceMap& map = frame.surfaces();
        for (const MachineConfig& config : sizes)
            caches_.push_back(std::make_unique<CachedPartition>(
                config, map,
                compressed_surfaces(config, map, frame.operation().declaration(), frame.initial_pixels(),
                                    number)));
        for (int s = 0; s < map.surfaces(); ++s)
            if (map.starts_clear(s)) ideal_.set_clear_range(map.first_address(s), map.address_bytes(s));
    }

    // Of size `number`.
    CachedPartition* cache(std::size_t number) { return caches_[number].get(); }

    void operate(const QuadOperation& q, const QuadBatch& batch) {
        for (const auto& cache : caches_) cache->operate(q, batch);
        const LineAccess* lines = batch.lines[q.partition].data() + q.first_line;
        for (std::uint32_t l = 0; l < q.line_count; ++l) {
            const LineAccess& access = lines[l];
            ideal_.use(access.line_address, access.read_sectors, access.write_bytes, access.surface);
            ReadWriteBytes& bytes = uncached_[access.surface];
            bytes.read += burst_bytes_of(access.line_address, access.read_sectors, config_);
            bytes.write += burst_bytes_of(access.line_address, access.write_sectors, config_);
        }
    }

    void finish(CacheSweep& sweep) {
        for (std::size_t i = 0; i < caches_.size(); ++i) {
            caches_[i]->flush();
            sweep.caches[i].cache.add(caches_[i]->cache().statistics());
            add(sweep.caches[i].miss_port, caches_[i]->port());
            add(sweep.caches[i].pins, caches_[i]->pins());
        }
        const std::uint64_t sector_bytes = config_.cache.sector_bytes;
        for (std::size_t level = 0; level < sweep.ideal.size(); ++level) {
            IdealCache& ideal = sweep.ideal[level];
            for (std::size_t s = 0; s < ideal.surfaces.size(); ++s) {
                ideal.surfaces[s].read += ideal_.fills(static_cast<int>(s), level) * sector_bytes;
                ideal.surfaces[s].write += ideal_.write_backs(static_cast<int>(s), level) * sector_bytes;
            }
            ideal.line_hit_share += ideal_.line_hit_share(level) * static_cast<double>(ideal_.uses());
        }
        for (std::size_t s = 0; s < uncached_.size(); ++s) {
            sweep.uncached[s].read += uncached_[s].read;
            sweep.uncached[s].write += uncached_[s].write;
        }
        sweep.line_uses += ideal_.uses();
        sweep.largest_footprint =
            std::max(sweep.largest_footprint, std::uint64_t{ideal_.lines()} * config_.cache.line_bytes);
    }

 private:
    const MachineConfig& config_;
    std::vector<std::unique_ptr<CachedPartition>> caches_;
    LruTraffic ideal_;
    std::vector<ReadWriteBytes> uncached_;
};

}  // namespace

CacheSweep sweep_cache_sizes(Frame& frame, const std::vector<MachineConfig>& configs, int threads) {
    CHECK(!configs.empty());
    const MachineConfig& config = configs.front();
    std::vector<std::uint32_t> sizes;
    for (const MachineConfig& each : configs) sizes.push_back(each.cache.size_bytes);
    const SurfaceMap& map = frame.surfaces();
    const auto surfaces = static_cast<std::size_t>(map.surfaces());
    const std::vector<std::uint32_t> capacities = ideal_capacities(sizes, config.cache.line_bytes);
    std::vector<std::unique_ptr<SweptPartition>> partitions;
    for (std::uint32_t p = 0; p < config.partitions; ++p)
        partitions.push_back(
            std::make_unique<SweptPartition>(configs, capacities, frame, static_cast<int>(p)));

    std::vector<UntimedFrontEnd> front_ends;
    for (std::size_t i = 0; i < configs.size(); ++i) {
        std::vector<CachedPartition*> owners;
        for (const auto& partition : partitions) owners.push_back(partition->cache(i));
        front_ends.emplace_back(configs[i], map, owners);
    }
    FramePipeline pipeline(frame, threads);
    while (QuadBatch* batch = pipeline.next()) {
        for (const QuadOperation& q : batch->quads) {
            for (UntimedFrontEnd& front_end : front_ends) front_end.read(q, *batch);
            if (reaches_partition(q)) partitions[q.partition]->operate(q, *batch);
        }
        pipeline.release(batch);
    }

    CacheSweep sweep;
    sweep.uncached.resize(surfaces);
    for (const std::uint32_t size : sizes)
        sweep.caches.push_back({size, {}, BytesByCause(surfaces), BytesByCause(surfaces)});
    for (const std::uint32_t lines : capacities)
        sweep.ideal.push_back(
            {std::uint64_t{lines} * config.cache.line_bytes, std::vector<ReadWriteBytes>(surfaces), 0});
    sweep.ideal.push_back({0, std::vector<ReadWriteBytes>(surfaces), 0});
    for (const auto& partition : partitions) partition->finish(sweep);
    for (IdealCache& ideal : sweep.ideal)
        ideal.line_hit_share /= std::max<double>(1, static_cast<double>(sweep.line_uses));
    return sweep;
}

}  // namespace ropsim
