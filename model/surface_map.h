// Where the bytes of a pixel live: surfaces, tiles and quads placed in each partition's own address space.
#pragma once

#include "model/machine_config.h"
#include "model/quad_operation.h"
#include "rop/declaration.h"
#include "rop/pixel.h"
#include "traces/trace.h"

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
    int technique_surfaces() const { return technique_surfaces_; }
    // Bytes of one element, and of a pixel's elements.
    std::uint32_t element_bytes(int surface) const {
        return placed_[static_cast<std::size_t>(surface)].element_bytes;
    }
    std::uint32_t pixel_bytes(int surface) const {
        return element_bytes(surface) *
               static_cast<std::uint32_t>(placed_[static_cast<std::size_t>(surface)].elements);
    }
    // Whether memory need not be read until written: cleared with fast clear on, or never read before it is
    // written.
    bool starts_clear(int surface) const { return placed_[static_cast<std::size_t>(surface)].starts_clear; }
    // Address range of a surface in a partition; ranges start on lines and cover whole lines.
    std::uint64_t first_address(int surface) const { return placed_[static_cast<std::size_t>(surface)].base; }
    std::uint64_t address_bytes(int surface) const {
        return placed_[static_cast<std::size_t>(surface)].bytes;
    }
    // Nodes of a list pool in one partition's share.
    std::uint64_t pool_nodes() const { return pool_nodes_; }
    // Bytes of partition address space in use.
    std::uint64_t partition_bytes() const { return partition_bytes_; }

    // Address of element `element` of a pixel: `tile` (screen tile number), `quad` 0..15 row-major in the
    // tile, `pixel` 0..3 row-major in the quad.
    std::uint64_t address(int surface, std::size_t tile, std::uint32_t quad, std::uint32_t pixel,
                          std::uint32_t element) const;
    std::uint64_t node_address(int surface, std::uint32_t node) const {
        return first_address(surface) + static_cast<std::uint64_t>(node) * element_bytes(surface);
    }
    // First address of a tile's bytes in a surface, and how many it has (whole lines).
    std::uint64_t tile_address(int surface, std::size_t tile) const;
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
        std::uint64_t tile_bytes = 0;
        std::uint64_t base = 0;
        std::uint64_t bytes = 0;
        bool starts_clear = false;
    };
    void place(const std::string& name, Layout layout, std::uint32_t element_bytes, int elements,
               std::uint64_t bytes);

    int partitions_;
    std::uint32_t line_bytes_;
    int technique_surfaces_;
    std::uint64_t largest_share_ = 0;        // tiles of the partition that owns most
    std::vector<std::uint8_t> owner_;        // by tile
    std::vector<std::uint32_t> local_tile_;  // by tile: its number among its partition's tiles
    std::vector<Placed> placed_;
    std::uint64_t pool_nodes_ = 0;
    std::uint64_t partition_bytes_ = 0;
};

// Collects the lines a quad touches, merging accesses to one line.
class LineCollector {
 public:
    LineCollector(const SurfaceMap& map, const MachineConfig& config)
        : map_(map), line_bytes_(config.cache.line_bytes), sector_bytes_(config.cache.sector_bytes) {}

    // Starts a quad whose lines are appended to `lines`.
    void begin(std::vector<LineAccess>& lines) {
        lines_ = &lines;
        first_ = lines.size();
    }
    std::uint32_t count() const { return static_cast<std::uint32_t>(lines_->size() - first_); }
    void read(int surface, std::uint64_t address, std::uint32_t bytes) {
        add(surface, address, bytes, false);
    }
    void write(int surface, std::uint64_t address, std::uint32_t bytes) {
        add(surface, address, bytes, true);
    }
    // The elements in the masks of one pixel.
    void elements(int surface, std::size_t tile, std::uint32_t quad, std::uint32_t pixel,
                  const SurfaceAccess& access);

 private:
    void add(int surface, std::uint64_t address, std::uint32_t bytes, bool write);
    void run(int surface, std::size_t tile, std::uint32_t quad, std::uint32_t pixel, std::uint64_t mask,
             bool write);
    LineAccess& line(int surface, std::uint64_t line_address);

    const SurfaceMap& map_;
    std::uint32_t line_bytes_;
    std::uint32_t sector_bytes_;
    std::vector<LineAccess>* lines_ = nullptr;
    std::size_t first_ = 0;
};

}  // namespace ropsim
