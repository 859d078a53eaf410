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

// The most that any control path of the pass moves of a surface.
ByteCount Frame::worst_path(int pass, std::size_t surface) const {
    const Surface& declared = operation_.declaration().surfaces[surface];
    ByteCount worst;
    for (const PathCost& path : cost_) {
        if (path.pass != pass) continue;
        worst.read = std::max(worst.read, access_bytes(declared, path.worst[surface].read));
        worst.write = std::max(worst.write, access_bytes(declared, path.worst[surface].write));
    }
    return worst;
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
            const ByteCount worst = worst_path(static_cast<int>(pass), s);
            t.worst_read += worst.read * pass_operated_[pass];
            t.worst_write += worst.write * pass_operated_[pass];
            if (operation_.declaration().passes[pass].gathers && surfaces[s].scale > 1)
                t.worst_read += static_cast<std::uint64_t>(surfaces[s].gathered) * pass_operated_[pass] *
                                map_.pixel_bytes(static_cast<int>(s));
        }
    }
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
        if (surfaces[s].scale == 1 || surfaces[s].initial != Initial::kOpaqueDepth) continue;
        traffic[s].read += depth_tests_low_.read * map_.pixel_bytes(static_cast<int>(s));
        traffic[s].worst_read += depth_tests_low_.tested * map_.pixel_bytes(static_cast<int>(s));
    }
    SurfaceTraffic& depth = traffic[static_cast<std::size_t>(map_.opaque_depth())];
    const auto fetches =
        static_cast<std::uint64_t>(operation_.declaration().added_shading.opaque_depth_fetches);
    std::uint64_t depths = 0;
    if (trace_.header().opaque) {
        depths += scattering_ * fetches;
        for (const auto& shard : shards_) depths += shard->log.opaque_depths();
    }
    depth.read += (depths + depth_tests_.read) * map_.pixel_bytes(map_.opaque_depth());
    depth.worst_read += (depths + depth_tests_.tested) * map_.pixel_bytes(map_.opaque_depth());
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
    for (std::size_t s = 0; s < declared.surfaces.size(); ++s) {
        const Surface& surface = declared.surfaces[s];
        if (surface.layout == Layout::kPool) {
            // A list has no worst case but its length: every node is read once.
            traffic[s].worst_read += traffic[s].read;
            continue;
        }
        const ByteCount worst = worst_path(kResolvePass, s);
        traffic[s].worst_read += worst.read * read_pixels;
        traffic[s].worst_write += worst.write * resolved_pixels_;
        if (declared.gathers && surface.scale == 1)
            traffic[s].worst_read += static_cast<std::uint64_t>(surface.gathered) * resolved_pixels_ *
                                     map_.pixel_bytes(static_cast<int>(s));
    }
    if (declared.resolve_reads_background && trace_.header().opaque) {
        SurfaceTraffic& t = traffic[static_cast<std::size_t>(map_.opaque_color())];
        const auto behind = static_cast<std::uint64_t>(2 * declared.background_footprint + 1);
        const std::uint64_t bytes =
            resolved_pixels_ * behind * behind * map_.pixel_bytes(map_.opaque_color());
        t.read += bytes;
        t.worst_read += bytes;
    }
    if (declared.gathers && trace_.header().opaque) {
        SurfaceTraffic& t = traffic[static_cast<std::size_t>(map_.opaque_color())];
        const std::uint64_t bytes = map_.pixel_bytes(map_.opaque_color());
        for (const auto& shard : shards_) t.read += shard->log.backgrounds() * bytes;
        t.worst_read += resolved_pixels_ * static_cast<std::uint64_t>(declared.background_gathered) * bytes;
    }
    SurfaceTraffic& t = traffic[static_cast<std::size_t>(map_.image())];
    t.write += resolved_pixels_ * map_.pixel_bytes(map_.image());
    t.worst_write += resolved_pixels_ * map_.pixel_bytes(map_.image());
}

}  // namespace ropsim
