// What a partition knows of the blocks of its compressed and fast-cleared surfaces: their bytes and their
// states.
#pragma once

#include "memory/compressed_memory.h"
#include "memory/metadata_cache.h"
#include "model/machine_config.h"
#include "model/surface_map.h"
#include "rop/pixel_store.h"

#include <memory>
#include <optional>
#include <vector>

namespace ropsim {

// The bytes that a frame starts with: cleared surfaces, and the opaque layer where an earlier pass left it.
class FrameContents : public InitialContents {
 public:
    // All must outlive it. Of `store` only what never changes is used.
    FrameContents(const SurfaceMap& map, const Declaration& declaration, const PixelStore& store,
                  int partition)
        : map_(map), declaration_(declaration), store_(store), partition_(partition) {}
    void fill(int surface, std::uint64_t offset, std::uint32_t bytes, std::uint8_t* out) const override;

    // A tile's bytes of a surface that is not a pool; `bytes` gets map.tile_bytes().
    void tile(int surface, std::size_t tile, std::vector<std::uint8_t>& bytes) const;

 private:
    void pixel(int surface, int x, int y, std::vector<std::uint8_t>& bytes) const;

    const SurfaceMap& map_;
    const Declaration& declaration_;
    const PixelStore& store_;
    int partition_;
    // The blocks of a tile are asked for one after the other.
    mutable int last_surface_ = -1;
    mutable std::uint64_t last_tile_ = 0;
    mutable std::vector<std::uint8_t> last_bytes_;
    mutable std::vector<std::uint32_t> words_;
};

class CompressedSurfaces {
 public:
    CompressedSurfaces(const MachineConfig& config, const SurfaceMap& map, const Declaration& declaration,
                       const PixelStore& store, int partition);

    CompressedMemory memory;
    std::optional<MetadataCache> metadata;  // nothing: states are on chip

    // Whether memory's blocks of this surface have states to look up.
    bool has_states(int surface) const {
        return metadata && has_states_[static_cast<std::size_t>(surface)] != 0;
    }

 private:
    FrameContents contents_;
    std::vector<std::uint8_t> has_states_;  // by surface
};

// nullptr where nothing is compressed and no states are kept in memory.
std::unique_ptr<CompressedSurfaces> compressed_surfaces(const MachineConfig& config, const SurfaceMap& map,
                                                        const Declaration& declaration,
                                                        const PixelStore& store, int partition);

}  // namespace ropsim
