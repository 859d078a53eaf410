#include "model/front_end_caches.h"

#include "model/texture_lines.h"

#include <utility>

#include <fmt/format.h>

namespace ropsim {

ReadCacheConfig depth_unit_config(const MachineConfig& config) {
    const DepthTestConfig& depth = config.front.depth;
    ReadCacheConfig c;
    c.cache = config.cache;
    c.cache.section_bytes = {};
    c.cache.size_bytes = depth.kibibytes * 1024;
    c.cache.ways = depth.ways;
    c.jobs = depth.quads;
    c.mshrs = depth.mshrs;
    c.latency = depth.latency;
    c.cause = MemoryCause::kFill;
    return c;
}

ReadCacheConfig texture_cache_config(const MachineConfig& config) {
    const TextureConfig& texture = config.front.texture;
    ReadCacheConfig c;
    c.cache = config.cache;
    c.cache.section_bytes = {};
    c.cache.size_bytes = texture.l1_kibibytes * 1024;
    c.cache.ways = texture.l1_ways;
    c.jobs = config.front.shader.warps;
    c.mshrs = texture.mshrs;
    c.latency = texture.latency;
    c.lines_per_cycle = texture.quads_per_cycle;
    c.cause = MemoryCause::kTexture;
    return c;
}

FrontEndCaches::FrontEndCaches(EventWheel& wheel, const MachineConfig& config, const SurfaceMap& map,
                               bool opaque, const std::vector<CompressedSurfaces*>& compressed,
                               TrafficBreakdown& breakdown, FrontEnd& front_end) {
    const bool depths = has_depth_units(config, opaque);
    const bool texels = map.textures() >= 0;
    if (!depths && !texels) return;
    std::vector<ReadPort*> all_ports;
    std::vector<ReadCache*> depth_units;
    std::vector<ReadCache*> texture_caches;
    for (std::uint32_t p = 0; p < config.partitions; ++p) {
        ports.push_back(std::make_unique<ReadPort>(fmt::format("read_port_{}", p).c_str(), wheel,
                                                   config.rop_period_ps, map.surfaces(), 64, breakdown));
        all_ports.push_back(ports.back().get());
    }
    for (std::uint32_t p = 0; depths && p < config.partitions; ++p) {
        depth.push_back(std::make_unique<ReadCache>(wheel, depth_unit_config(config), config.rop_period_ps,
                                                    std::vector<ReadPort*>{all_ports[p]}, 0, compressed[p],
                                                    front_end, static_cast<int>(p)));
        depth_units.push_back(depth.back().get());
    }
    for (std::uint32_t c = 0; texels && c < config.front.shader.cores; ++c) {
        textures.push_back(std::make_unique<ReadCache>(
            wheel, texture_cache_config(config), config.rop_period_ps, all_ports,
            map.first_address(map.textures()), nullptr, front_end, static_cast<int>(config.partitions + c)));
        texture_caches.push_back(textures.back().get());
    }
    front_end.connect_caches(std::move(depth_units), std::move(texture_caches), map.textures());
}

void FrontEndCaches::add_bytes(BytesByCause& bytes) const {
    for (const auto& port : ports)
        for (std::size_t s = 0; s < bytes.size(); ++s)
            for (std::size_t c = 0; c < kMemoryCauses; ++c) bytes[s][c].read += port->bytes()[s][c].read;
}

void FrontEndCaches::add_stages(std::uint64_t total_cycles, std::vector<StageReport>& stages) {
    const auto add = [&](const char* name, const std::vector<std::unique_ptr<ReadCache>>& caches) {
        if (caches.empty()) return;
        StageReport report{name, {}, static_cast<std::uint32_t>(caches.size())};
        for (const auto& cache : caches) {
            cache->account().finish(total_cycles);
            report.account.add(cache->account());
        }
        stages.push_back(report);
    };
    add("depth_unit", depth);
    add("texture_cache", textures);
}

RopCacheStatistics FrontEndCaches::depth_statistics() const {
    RopCacheStatistics sum;
    for (const auto& unit : depth) sum.add(unit->statistics());
    return sum;
}

RopCacheStatistics FrontEndCaches::texture_statistics() const {
    RopCacheStatistics sum;
    for (const auto& cache : textures) sum.add(cache->statistics());
    return sum;
}

UntimedFrontEndCaches::UntimedFrontEndCaches(const MachineConfig& config, const SurfaceMap& map,
                                             std::vector<UntimedMemory*> partitions)
    : config_(config),
      map_(map),
      partitions_(std::move(partitions)),
      depth_config_(depth_unit_config(config)),
      texture_config_(texture_cache_config(config)),
      depth_(config.partitions, RopCache(depth_config_.cache)),
      textures_(map.textures() >= 0 ? config.front.shader.cores : 1, RopCache(texture_config_.cache)) {}

void UntimedFrontEndCaches::look_up(RopCache& cache, const LineRead& read, const ReadCacheConfig& config,
                                    const ByteSource& source, UntimedMemory* owner) {
    int line = cache.probe(read.address, read.surface);
    if (line == RopCache::kMiss) {
        Eviction clean;
        line = cache.allocate(read.address, read.surface, &clean);
    }
    cache.touch(line);
    MemoryRequest request;
    request.cause = config.cause;
    const std::uint32_t came = for_missing(
        cache, line, read, request, owner != nullptr ? owner->compressed() : nullptr, [&](MemoryRequest r) {
            if (owner != nullptr) return owner->read_for(source, r);
            const std::uint64_t piece = r.address / ReadCache::kInterleave;
            const std::size_t partitions = partitions_.size();
            if (partitions > 1)
                r.address = piece / partitions * ReadCache::kInterleave + r.address % ReadCache::kInterleave;
            r.address += map_.first_address(map_.textures());
            partitions_[piece % partitions]->read_for(source, r);
        });
    if (came != 0) cache.fill(line, came);
}

void UntimedFrontEndCaches::read_depths(const QuadOperation& q, const QuadBatch& batch) {
    const LineAccess* lines = batch.lines[q.partition].data() + q.first_line - q.depth_lines;
    for (std::uint32_t l = 0; l < q.depth_lines; ++l)
        look_up(depth_[q.partition], {lines[l].line_address, lines[l].read_sectors, lines[l].surface},
                depth_config_, batch.source(q), partitions_[q.partition]);
}

void UntimedFrontEndCaches::fetch_texels(const QuadOperation& q, const QuadBatch& batch, std::size_t core) {
    for_texture_lines(config_, map_.textures(), q, [&](const LineRead& read) {
        look_up(textures_[core], read, texture_config_, batch.source(q), nullptr);
    });
}

RopCacheStatistics UntimedFrontEndCaches::depth_statistics() const {
    RopCacheStatistics sum;
    for (const RopCache& cache : depth_) sum.add(cache.statistics());
    return sum;
}

RopCacheStatistics UntimedFrontEndCaches::texture_statistics() const {
    RopCacheStatistics sum;
    for (const RopCache& cache : textures_) sum.add(cache.statistics());
    return sum;
}

void UntimedFrontEnd::shade(const QuadOperation& q, const QuadBatch& batch) {
    Packer& packer = open_[WarpPacking::warp_of(q, batch)];
    const std::uint8_t pass = batch.pass_of(q);
    const std::size_t tile = packing_.tile_of(q, batch);
    if (!q.is_shaded()) {
        if (packer.open.quads > 0 && WarpPacking::ends_warp(q, batch)) close_warp(packer);
        return;
    }
    if (packer.open.quads > 0 && !packer.open.takes(q, pass, tile)) close_warp(packer);
    if (packer.open.quads == 0) packer.core = caches_.next_core();
    packer.open.add(q, pass, tile);
    counts_.shade(q);
    if (q.texture_fetches != 0) caches_.fetch_texels(q, batch, packer.core);
    if (packer.open.quads == warp_quads_) close_warp(packer);
}

void UntimedFrontEnd::close_warp(Packer& packer) {
    ++counts_.warps;
    counts_.warp_quad_places += warp_quads_;
    lane_cycles_ += std::uint64_t{4} * warp_quads_ * packer.open.instructions;
    packer.open = {};
}

void UntimedFrontEnd::finish() {
    for (Packer& packer : open_)
        if (packer.open.quads > 0) close_warp(packer);
}

FrontEndCounts UntimedFrontEnd::counts() const {
    FrontEndCounts counts = counts_;
    counts.depth_cache = caches_.depth_statistics();
    counts.texture_cache = caches_.texture_statistics();
    return counts;
}

}  // namespace ropsim
