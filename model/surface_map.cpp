#include "model/surface_map.h"

#include "base/error.h"

#include <algorithm>
#include <bit>

namespace ropsim {

namespace {
constexpr std::uint32_t kOpaqueDepthBytes = 4;  // float32
constexpr std::uint64_t round_up(std::uint64_t value, std::uint64_t unit) {
    return (value + unit - 1) / unit * unit;
}
}  // namespace

SurfaceMap::SurfaceMap(const Declaration& declaration, const MachineConfig& config, const TraceHeader& trace)
    : partitions_(static_cast<int>(config.partitions)),
      line_bytes_(config.cache.line_bytes),
      technique_surfaces_(static_cast<int>(declaration.surfaces.size())) {
    const auto across = static_cast<std::size_t>(tiles_across(trace.width));
    const auto down = static_cast<std::size_t>(tiles_across(trace.height));
    const std::size_t side = config.partition_tiles;
    std::vector<std::uint32_t> tiles(config.partitions);
    owner_.resize(across * down);
    local_tile_.resize(across * down);
    for (std::size_t y = 0; y < down; ++y) {
        for (std::size_t x = 0; x < across; ++x) {
            // Rows of squares are shifted against each other, so that neither a row nor a column of the
            // screen falls to few partitions. Odd shift: with a power of two of partitions every one gets its
            // turn.
            const std::size_t shift = config.partitions / 2 | 1;
            const std::size_t owner = (x / side + (y / side) * shift) % config.partitions;
            owner_[y * across + x] = static_cast<std::uint8_t>(owner);
            local_tile_[y * across + x] = tiles[owner]++;
        }
    }
    largest_share_ = *std::max_element(tiles.begin(), tiles.end());
    for (const Surface& s : declaration.surfaces) {
        const auto bytes = static_cast<std::uint32_t>(s.element_bytes());
        if (s.layout == Layout::kPool) {
            pool_nodes_ = std::min<std::uint64_t>(config.pool_bytes / config.partitions / bytes, kNoNode - 1);
            place(s.name, s.layout, bytes, 1, pool_nodes_ * bytes);
        } else {
            place(s.name, s.layout, bytes, s.elements, 0);
            const bool constant = s.initial == Initial::kClear || !trace.opaque;
            placed_.back().starts_clear = constant && config.fast_clear;
        }
    }
    const auto image_bytes = static_cast<std::uint32_t>(format_info(declaration.image_format).bits * 4 / 8);
    place("opaque_depth", Layout::kInterleaved, kOpaqueDepthBytes, trace.samples, 0);
    place("opaque_color", Layout::kInterleaved, image_bytes, trace.samples, 0);
    place("image", Layout::kInterleaved, image_bytes, 1, 0);
    if (partition_bytes_ > config.dram.capacity_bytes())
        throw UserError(
            "memory", fmt::format("the surfaces need {} MiB a partition, its channel holds {} MiB; use fewer "
                                  "samples or nodes, a smaller pool.mebibytes or more rop.partitions",
                                  partition_bytes_ >> 20, config.dram.capacity_bytes() >> 20));
}

void SurfaceMap::place(const std::string& name, Layout layout, std::uint32_t element_bytes, int elements,
                       std::uint64_t bytes) {
    Placed p;
    p.name = name;
    p.layout = layout;
    p.element_bytes = element_bytes;
    p.elements = elements;
    p.tile_bytes = round_up(
        static_cast<std::uint64_t>(element_bytes) * static_cast<std::uint64_t>(elements) * kTilePixels,
        line_bytes_);
    p.base = partition_bytes_;
    p.bytes = round_up(layout == Layout::kPool ? bytes : p.tile_bytes * largest_share_, line_bytes_);
    partition_bytes_ += p.bytes;
    placed_.push_back(std::move(p));
}

std::uint64_t SurfaceMap::tile_address(int surface, std::size_t tile) const {
    const Placed& p = placed_[static_cast<std::size_t>(surface)];
    return p.base + local_tile_[tile] * p.tile_bytes;
}

std::uint64_t SurfaceMap::address(int surface, std::size_t tile, std::uint32_t quad, std::uint32_t pixel,
                                  std::uint32_t element) const {
    const Placed& p = placed_[static_cast<std::size_t>(surface)];
    const std::uint64_t place = quad * 4 + pixel;
    const std::uint64_t offset =
        p.layout == Layout::kPlanar
            ? (std::uint64_t{element} * kTilePixels + place) * p.element_bytes
            : (place * static_cast<std::uint64_t>(p.elements) + element) * p.element_bytes;
    return p.base + local_tile_[tile] * p.tile_bytes + offset;
}

LineAccess& LineCollector::line(int surface, std::uint64_t line_address) {
    // Accesses come nearly in order: the line is almost always the last or the one before.
    for (std::size_t i = lines_->size(); i > first_; --i)
        if ((*lines_)[i - 1].line_address == line_address) return (*lines_)[i - 1];
    LineAccess& added = lines_->emplace_back();
    added.line_address = line_address;
    added.surface = static_cast<std::uint8_t>(surface);
    return added;
}

void LineCollector::add(int surface, std::uint64_t address, std::uint32_t bytes, bool write) {
    while (bytes > 0) {
        const auto offset = static_cast<std::uint32_t>(address & (line_bytes_ - 1));
        const std::uint32_t here = std::min(bytes, line_bytes_ - offset);
        LineAccess& l = line(surface, address - offset);
        if (write) {
            const LineMask mask = LineMask::range(offset, here);
            for (std::size_t w = 0; w < mask.word.size(); ++w) l.write_bytes.word[w] |= mask.word[w];
        } else {
            const std::uint32_t first = offset / sector_bytes_;
            const std::uint32_t last = (offset + here - 1) / sector_bytes_;
            l.read_sectors |= ((2u << (last - first)) - 1u) << first;
        }
        address += here;
        bytes -= here;
    }
}

void LineCollector::run(int surface, std::size_t tile, std::uint32_t quad, std::uint32_t pixel,
                        std::uint64_t mask, bool write) {
    const std::uint32_t element_bytes = map_.element_bytes(surface);
    if (map_.layout(surface) == Layout::kPlanar) {
        for (; mask != 0; mask &= mask - 1)
            add(surface,
                map_.address(surface, tile, quad, pixel, static_cast<std::uint32_t>(std::countr_zero(mask))),
                element_bytes, write);
        return;
    }
    while (mask != 0) {
        const auto first = static_cast<std::uint32_t>(std::countr_zero(mask));
        const auto length = static_cast<std::uint32_t>(std::countr_one(mask >> first));
        add(surface, map_.address(surface, tile, quad, pixel, first), length * element_bytes, write);
        mask = first + length >= 64 ? 0 : mask >> (first + length) << (first + length);
    }
}

void LineCollector::elements(int surface, std::size_t tile, std::uint32_t quad, std::uint32_t pixel,
                             const SurfaceAccess& access) {
    if (map_.layout(surface) == Layout::kPool) {
        if (access.write != 0) {
            const auto node = static_cast<std::uint32_t>(access.write);
            add(surface, map_.node_address(surface, node), map_.element_bytes(surface), true);
        }
        return;
    }
    if (access.read != 0) run(surface, tile, quad, pixel, access.read, false);
    if (access.write != 0) run(surface, tile, quad, pixel, access.write, true);
}

}  // namespace ropsim
