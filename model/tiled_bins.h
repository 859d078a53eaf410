// The bins of the tiled engine: which primitives touch a tile, where its entries and their vertices lie, and
// the quads that write and read them.
#pragma once

#include "model/line_collector.h"
#include "model/machine_config.h"
#include "model/quad_operation.h"
#include "model/surface_map.h"
#include "traces/trace.h"

#include <cstdint>
#include <vector>

namespace ropsim {

// A tile's bin is a list of blocks of one cache line in its partition's memory, taken from a heap as entries
// come; a primitive's transformed vertices are kept once, in the partition of the first tile it touches. A
// primitive is known by its fragments, hidden ones included: one without any is not there, and where a trace
// comes back to a primitive after others it is binned again.
class TileBins {
 public:
    // Goes over the whole trace once. `map`: places tiles; need not have bins yet.
    TileBins(TraceReader& trace, const MachineConfig& config, const SurfaceMap& map);

    std::uint64_t entries() const { return entries_; }
    std::uint64_t primitives() const { return owner_.size(); }
    std::uint64_t tile_entries(std::uint32_t tile) const { return primitives_of_[tile].size(); }
    // Of memory in the partition that needs most, whole lines.
    std::uint64_t largest_share() const;
    // Bytes that the binner writes, and that a pass over the tile reads.
    std::uint64_t written_bytes() const;
    std::uint64_t read_bytes(std::uint32_t tile) const;

    // Lines the binner writes in a partition, in the order in which they fill.
    std::size_t writes(int partition) const { return writes_[static_cast<std::size_t>(partition)].size(); }
    void append_write(int partition, std::size_t number, const SurfaceMap& map, LineCollector& collector,
                      QuadBatch& batch) const;
    // Reads a tile's bin: a quad a block of entries, with the vertices that lie in the tile's own partition;
    // those of others are read by quads of theirs in front of it. `pass`: on whose account.
    void append_reads(std::uint32_t tile, std::uint8_t pass, const SurfaceMap& map, LineCollector& collector,
                      QuadBatch& batch) const;

 private:
    struct Write {
        std::uint32_t tile;  // of 8x8 pixels: on whose account
        std::uint32_t line;  // of the blocks, or of the vertices
        std::uint32_t bytes;
        bool vertices;
    };
    void add_entry(std::uint32_t tile, int partition);
    void add_primitive(std::uint32_t tile, int partition);
    std::uint64_t vertices_address(int partition, const SurfaceMap& map) const {
        return map.first_address(map.bins()) +
               std::uint64_t{blocks_[static_cast<std::size_t>(partition)]} * line_bytes_;
    }

    std::uint32_t line_bytes_;
    std::uint32_t entry_bytes_;
    std::uint32_t primitive_bytes_;
    int tile_parts_;  // tiles of 8x8 pixels on a tile's side
    std::uint64_t entries_ = 0;
    std::vector<std::vector<std::uint32_t>> primitives_of_;  // by tile
    std::vector<std::vector<std::uint32_t>> blocks_of_;      // by tile: of its partition
    std::vector<std::uint32_t> small_tile_;                  // by tile: its first of 8x8 pixels
    std::vector<std::uint8_t> owner_;                        // by primitive: partition of its vertices
    std::vector<std::uint32_t> place_;                       // and their number there
    std::vector<std::uint32_t> blocks_;                      // by partition
    std::vector<std::uint32_t> kept_;                        // by partition: primitives
    std::vector<std::vector<Write>> writes_;                 // by partition
};

}  // namespace ropsim
