// Where the bytes of a pixel live: surfaces, tiles and quads placed in each partition's own address space.
#pragma once

#include "memory/block_format.h"
#include "model/machine_config.h"
#include "model/quad_operation.h"
#include "rop/declaration.h"
#include "rop/pixel.h"
#include "traces/trace.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

// The technique's surfaces come first, in order of declaration; then what every machine has.
class SurfaceMap {
 public:
    SurfaceMap(const Declaration& declaration, const MachineConfig& config, const TraceHeader& trace);

    int partition_of(std::size_t tile) const { return owner_[tile]; }
    int partitions() const { return partitions_; }
    int surfaces() const { return static_cast<int>(placed_.size()); }
    const std::string& name(int surface) const { return placed_[static_cast<std::size_t>(surface)].name; }
    int opaque_depth() const { return technique_surfaces_; }
    int opaque_color() const { return technique_surfaces_ + 1; }
    int image() const { return technique_surfaces_ + 2; }
    // A word a pixel, where shaders lock pixels themselves (interlock.mode = spin).
    int locks() const { return locks_; }
    int bins() const { return bins_; }  // of the tiled engine; -1 elsewhere
    // Kept in tile memory: its accesses are no traffic.
    bool on_chip(int surface) const { return on_chip_[static_cast<std::size_t>(surface)] != 0; }
    int technique_surfaces() const { return technique_surfaces_; }
    int textures() const { return textures_; }  // -1: the trace's draws have none
    // Bytes of one element, and of a pixel's elements.
    std::uint32_t element_bytes(int surface) const {
        return placed_[static_cast<std::size_t>(surface)].element_bytes;
    }
    std::uint32_t pixel_bytes(int surface) const {
        return element_bytes(surface) *
               static_cast<std::uint32_t>(placed_[static_cast<std::size_t>(surface)].elements);
    }
    std::uint64_t all_elements_of(int surface) const {
        return all_elements(placed_[static_cast<std::size_t>(surface)].elements);
    }
    // Whether memory need not be read until written: cleared with fast clear on, or never read before it is
    // written.
    bool starts_clear(int surface) const { return placed_[static_cast<std::size_t>(surface)].starts_clear; }
    // Tells a partition's cache which of its sections each surface lives in, and what starts clear.
    void prepare(RopCache& cache) const;
    // Address range of a surface in a partition; ranges start on lines and cover whole lines.
    std::uint64_t first_address(int surface) const { return placed_[static_cast<std::size_t>(surface)].base; }
    std::uint64_t address_bytes(int surface) const {
        return placed_[static_cast<std::size_t>(surface)].bytes;
    }
    // Nodes of a list pool in one partition's share.
    std::uint64_t pool_nodes() const { return pool_nodes_; }
    // Bytes of partition address space in use.
    std::uint64_t partition_bytes() const { return partition_bytes_; }

    // What the surface's bytes are, and by what they are compressed.
    SurfaceClass surface_class(int surface) const {
        return placed_[static_cast<std::size_t>(surface)].format.surface_class;
    }
    const BlockFormat& format(int surface) const { return placed_[static_cast<std::size_t>(surface)].format; }
    CodecKind codec(int surface) const { return placed_[static_cast<std::size_t>(surface)].codec; }
    // Whether what is written to the surface must be known, not only where.
    bool needs_values(int surface) const { return codec(surface) != CodecKind::kNone; }
    // Where the states of blocks lie in a partition, behind everything else.
    std::uint64_t metadata_address() const { return partition_bytes_; }

    // Address of element `element` of a pixel: `tile` (screen tile number), `quad` 0..15 row-major in the
    // tile, `pixel` 0..3 row-major in the quad.
    std::uint64_t address(int surface, std::size_t tile, std::uint32_t quad, std::uint32_t pixel,
                          std::uint32_t element) const {
        return tile_address(surface, tile) + offset_in_tile(surface, quad, pixel, element);
    }
    // Its parts: where a surface begins (first_address()), the tile's number in its partition times
    // tile_bytes(), and, of the first element, the pixel's place in the tile times the bytes between places.
    std::uint32_t number_in_partition(std::size_t tile) const { return local_tile_[tile]; }
    std::uint32_t place_in_tile(std::uint32_t quad, std::uint32_t pixel) const {
        return place_of_[quad * 4 + pixel];
    }
    std::uint32_t pixel_stride(int surface) const {
        return placed_[static_cast<std::size_t>(surface)].pixel_stride;
    }
    std::uint64_t node_address(int surface, std::uint32_t node) const {
        return first_address(surface) + static_cast<std::uint64_t>(node) * element_bytes(surface);
    }
    // The same, from the start of the tile's bytes.
    std::uint64_t offset_in_tile(int surface, std::uint32_t quad, std::uint32_t pixel,
                                 std::uint32_t element) const {
        const Placed& p = placed_[static_cast<std::size_t>(surface)];
        return std::uint64_t{place_of_[quad * 4 + pixel]} * p.pixel_stride +
               std::uint64_t{element} * p.element_stride;
    }
    // The tile that an address of a partition's share of a surface (not a pool) belongs to.
    std::size_t tile_at(int partition, int surface, std::uint64_t address) const {
        return tiles_of_[static_cast<std::size_t>(partition)]
                        [static_cast<std::size_t>((address - first_address(surface)) / tile_bytes(surface))];
    }
    // Whether there is such a tile: partitions own unequal shares.
    bool has_tile_at(int partition, int surface, std::uint64_t address) const {
        return (address - first_address(surface)) / tile_bytes(surface) <
               tiles_of_[static_cast<std::size_t>(partition)].size();
    }
    // Whether the four pixels of a quad lie side by side, in one piece.
    bool quads_are_whole(int surface) const {
        return order_ != LayoutConfig::Order::kRows && layout(surface) == Layout::kInterleaved;
    }
    // First address of a tile's bytes in a surface, and how many it has (whole lines).
    std::uint64_t tile_address(int surface, std::size_t tile) const {
        const Placed& p = placed_[static_cast<std::size_t>(surface)];
        return p.base + local_tile_[tile] * p.tile_bytes;
    }
    std::uint64_t tile_bytes(int surface) const {
        return placed_[static_cast<std::size_t>(surface)].tile_bytes;
    }
    Layout layout(int surface) const { return placed_[static_cast<std::size_t>(surface)].layout; }

 private:
    struct Placed {
        std::string name;
        Layout layout = Layout::kInterleaved;
        std::uint32_t element_bytes = 0;
        int elements = 1;
        std::uint32_t pixel_stride = 0;  // bytes from one place in a tile to the next, and from one element
        std::uint32_t element_stride = 0;
        std::uint64_t tile_bytes = 0;
        std::uint64_t base = 0;
        std::uint64_t bytes = 0;
        bool starts_clear = false;
        BlockFormat format;
        CodecKind codec = CodecKind::kNone;
    };
    void order_pixels();
    void share_out_tiles(const MachineConfig& config, int width, int height);
    // `bytes`: of a pool.
    Placed& place(const std::string& name, Layout layout, std::uint32_t element_bytes, int elements,
                  std::uint64_t bytes, const BlockFormat& format);
    void place_fixed(const Declaration& declaration, const TraceHeader& trace, std::uint64_t texture_bytes);
    void place_tiled(const TilePlan& plan, const Declaration& declaration, std::uint32_t entry_bytes);

    int partitions_;
    std::uint32_t line_bytes_;
    LayoutConfig::Order order_;
    // Of a tile's pixels by quad and pixel in it: how many lie before.
    std::array<std::uint8_t, kTilePixels> place_of_{};
    CompressionConfig compression_;
    int technique_surfaces_;
    int textures_ = -1;
    std::uint64_t largest_share_ = 0;                 // tiles of the partition that owns most
    std::vector<std::vector<std::size_t>> tiles_of_;  // by partition, in the order in which they lie
    std::vector<std::uint8_t> owner_;                 // by tile
    std::vector<std::uint32_t> local_tile_;           // by tile: its number among its partition's tiles
    std::vector<Placed> placed_;
    std::uint64_t pool_nodes_ = 0;
    std::uint64_t partition_bytes_ = 0;
    int locks_ = -1;
    int bins_ = -1;
    std::vector<std::uint8_t> on_chip_;  // by surface
};

}  // namespace ropsim
