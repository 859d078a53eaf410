// The front end as data: rasteriser, depth tests before shading, shader cores and their texture caches.
#pragma once

#include "base/parameters.h"
#include "memory/rop_cache.h"

#include <cstdint>

namespace ropsim {

// Depth ranges of the opaque layer's tiles, kept on chip.
struct HierarchicalDepthConfig {
    bool enabled = true;
    bool accepts = true;          // keeps the nearest depth too: what is nearer is not read
    std::uint32_t bits = 14;      // of a kept depth; 32: the float itself
    std::uint32_t kibibytes = 0;  // tiles that do not fit have no range; 0: all fit
};

// Where and how the depths that the ranges do not decide are read.
struct DepthTestConfig {
    bool early = false;           // before shading, by a depth unit of each partition
    std::uint32_t kibibytes = 4;  // of its cache
    std::uint32_t ways = 4;
    std::uint32_t quads = 64;   // between look-up and verdict
    std::uint32_t mshrs = 8;    // lines on their way
    std::uint32_t latency = 8;  // ROP cycles from look-up, or from the last fill, to the verdict
};

struct ShaderCoreConfig {
    std::uint32_t cores = 16;         // that share shader.alu_lanes
    std::uint32_t warp_quads = 8;     // a warp has four threads a quad
    std::uint32_t warps = 32;         // in flight in a core
    std::uint32_t pack_timeout = 32;  // shader cycles that a warp waits for its next quad
};

// Texture fetches of the shader cores. What they read is an estimate: traces have no texture coordinates.
struct TextureConfig {
    std::uint32_t kibibytes = 256;    // of one texture; its texels repeat beyond
    std::uint32_t mebibytes = 64;     // of all textures together
    std::uint32_t l1_kibibytes = 16;  // of one core's cache
    std::uint32_t l1_ways = 4;
    std::uint32_t latency = 100;        // ROP cycles from look-up, or from the last fill, to the texels
    std::uint32_t mshrs = 32;           // lines of one core on their way
    std::uint32_t quads_per_cycle = 1;  // lines that a core looks up a ROP cycle: one for a quad's fetch
};

struct FrontEndConfig {
    std::uint32_t raster_tiles_per_cycle = 1024;  // tiles of primitives a shader cycle
    HierarchicalDepthConfig hierarchical;
    DepthTestConfig depth;
    ShaderCoreConfig shader;
    TextureConfig texture;
};

// Reads and checks the keys of all these. Throws UserError.
FrontEndConfig read_front_end(Parameters& parameters);
// Their caches have the lines and sectors of the ROP cache. Throws UserError where that does not fit.
void check_front_end(const Parameters& parameters, const FrontEndConfig& config, RopCacheConfig rop_cache);

}  // namespace ropsim
