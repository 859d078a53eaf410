// What the frame's operations add up to: bytes by surface without caches, counts by control path.
#include "model/frame.h"
#include "model/frame_shard.h"

#include <algorithm>

namespace ropsim {

std::uint64_t Frame::path_count(std::size_t path) const {
    std::uint64_t sum = 0;
    for (const auto& shard : shards_) sum += shard->log.path_count(path);
    return sum;
}

std::array<std::uint64_t, 2> Frame::path_steps(std::size_t path) const {
    std::array<std::uint64_t, 2> sum{};
    for (const auto& shard : shards_)
        for (std::size_t k = 0; k < 2; ++k) sum[k] += shard->log.path_steps(path)[k];
    return sum;
}

std::uint64_t Frame::touched_tiles() const {
    std::uint64_t sum = 0;
    for (const auto& shard : shards_) sum += shard->store.touched_tiles();
    return sum;
}

std::uint64_t Frame::pool_used() const {
    std::uint64_t sum = 0;
    for (const auto& shard : shards_) sum += shard->store.pool() != nullptr ? shard->store.pool()->used() : 0;
    return sum;
}

std::uint64_t Frame::pool_overflowed() const {
    std::uint64_t sum = 0;
    for (const auto& shard : shards_)
        sum += shard->store.pool() != nullptr ? shard->store.pool()->overflowed() : 0;
    return sum;
}

std::vector<SurfaceTraffic> Frame::traffic() const {
    std::vector<SurfaceTraffic> traffic(static_cast<std::size_t>(map_.surfaces()));
    const auto& surfaces = operation_.declaration().surfaces;
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
        SurfaceTraffic& t = traffic[s];
        const auto bytes = static_cast<std::uint64_t>(surfaces[s].element_bytes());
        for (const auto& shard : shards_) {
            t.read += shard->log.read_elements(s) * bytes;
            t.write += shard->log.write_elements(s) * bytes;
        }
        // The largest over the control paths of each pass, for every operation: what a model without caches
        // that does not know the path must assume.
        for (std::size_t pass = 0; pass < pass_operated_.size(); ++pass) {
            std::uint64_t read = 0;
            std::uint64_t write = 0;
            for (const PathCost& path : cost_) {
                if (path.pass != static_cast<int>(pass)) continue;
                read = std::max(read, access_bytes(surfaces[s], path.worst[s].read));
                write = std::max(write, access_bytes(surfaces[s], path.worst[s].write));
            }
            t.worst_read += read * pass_operated_[pass];
            t.worst_write += write * pass_operated_[pass];
        }
    }
    SurfaceTraffic& depth = traffic[static_cast<std::size_t>(map_.opaque_depth())];
    depth.read += depth_tested_ * map_.pixel_bytes(map_.opaque_depth());
    depth.worst_read = depth.read;
    add_initialise_traffic(traffic);
    add_resolve_traffic(traffic);
    return traffic;
}

void Frame::add_initialise_traffic(std::vector<SurfaceTraffic>& traffic) const {
    const auto& surfaces = operation_.declaration().surfaces;
    for (int s = 0; s < map_.technique_surfaces(); ++s) {
        const Surface& surface = surfaces[static_cast<std::size_t>(s)];
        const std::uint64_t pixels = written_initially_[static_cast<std::size_t>(s)];
        SurfaceTraffic& to = traffic[static_cast<std::size_t>(s)];
        to.write += pixels * map_.pixel_bytes(s);
        to.worst_write += pixels * map_.pixel_bytes(s);
        if (surface.initial == Initial::kClear || !trace_.header().opaque) continue;
        const int from = surface.initial == Initial::kOpaqueDepth ? map_.opaque_depth() : map_.opaque_color();
        SurfaceTraffic& read = traffic[static_cast<std::size_t>(from)];
        read.read += pixels * map_.pixel_bytes(from);
        read.worst_read += pixels * map_.pixel_bytes(from);
    }
}

void Frame::add_resolve_traffic(std::vector<SurfaceTraffic>& traffic) const {
    const Declaration& declared = operation_.declaration();
    if (!declared.resolves) return;
    // A window reads every pixel in it.
    const auto side = static_cast<std::uint64_t>(2 * declared.footprint + 1);
    const std::uint64_t read_pixels = resolved_pixels_ * side * side;
    for (const PathCost& path : cost_) {
        if (path.pass != kResolvePass) continue;
        for (std::size_t s = 0; s < declared.surfaces.size(); ++s) {
            if (declared.surfaces[s].layout == Layout::kPool) {
                // A list has no worst case but its length: every node is read once.
                traffic[s].worst_read += traffic[s].read;
                continue;
            }
            traffic[s].worst_read += access_bytes(declared.surfaces[s], path.worst[s].read) * read_pixels;
            traffic[s].worst_write +=
                access_bytes(declared.surfaces[s], path.worst[s].write) * resolved_pixels_;
        }
    }
    if (declared.resolve_reads_background && trace_.header().opaque) {
        SurfaceTraffic& t = traffic[static_cast<std::size_t>(map_.opaque_color())];
        const auto behind = static_cast<std::uint64_t>(2 * declared.background_footprint + 1);
        const std::uint64_t bytes =
            resolved_pixels_ * behind * behind * map_.pixel_bytes(map_.opaque_color());
        t.read += bytes;
        t.worst_read += bytes;
    }
    SurfaceTraffic& t = traffic[static_cast<std::size_t>(map_.image())];
    t.write += resolved_pixels_ * map_.pixel_bytes(map_.image());
    t.worst_write += resolved_pixels_ * map_.pixel_bytes(map_.image());
}

}  // namespace ropsim
