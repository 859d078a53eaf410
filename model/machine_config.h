// The simulated machine as data: clocks, shader cores, ROP partitions, caches, datapath and memory.
#pragma once

#include "base/parameters.h"
#include "memory/block_codec.h"
#include "memory/dram_device.h"
#include "memory/l2_slice.h"
#include "memory/metadata_cache.h"
#include "memory/rop_cache.h"
#include "model/format_rates.h"
#include "model/front_end_config.h"
#include "model/hazard_config.h"
#include "model/interlock_config.h"
#include "model/skip_config.h"
#include "model/tiled_config.h"
#include "rop/datapath.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

// Compression between ROP cache and memory: what is tried on the surfaces of each class.
struct CompressionConfig {
    std::array<CodecKind, 3> codec = {CodecKind::kNone, CodecKind::kNone,
                                      CodecKind::kNone};  // by SurfaceClass
    std::uint32_t block_bytes = 256;
    std::vector<std::uint32_t> levels = {32, 64, 128};  // bytes that a compressed block may take
    bool sticky = false;                // a raw block is not compressed again before it is cleared
    std::uint32_t eviction_buffer = 8;  // blocks between cache and memory: being read, compressed or written
    MetadataConfig metadata;

    bool any() const {
        return std::ranges::any_of(codec, [](CodecKind kind) { return kind != CodecKind::kNone; });
    }
};

// How the pixels of a surface lie in memory.
struct LayoutConfig {
    enum class Elements : std::uint8_t { kTechnique, kInterleaved, kPlanar };
    enum class Order : std::uint8_t { kQuads, kRows, kMorton };
    Elements elements = Elements::kTechnique;
    Order pixels = Order::kQuads;  // in a tile
    bool morton_tiles = false;  // tiles of a partition by Morton number in squares of 8x8 tiles, else by rows
};

// Every member is a key of a hardware preset or file (docs/hardware.md); ranges are checked when it is read.
struct MachineConfig {
    std::string preset;

    std::uint64_t rop_period_ps = 1000;     // clock.rop_mhz
    std::uint64_t shader_period_ps = 1000;  // clock.shader_mhz

    std::uint32_t shader_alu_lanes = 2048;  // ALU lanes of all shader cores: fragment-instructions a cycle
    std::uint32_t shader_latency = 200;     // shader cycles from launch to export of a quad
    std::uint32_t shader_quads_in_flight = 2048;  // quads between launch and export (reorder window)
    std::uint32_t raster_quads_per_cycle = 16;    // quads rasterised and depth-tested a shader cycle
    std::uint32_t export_quads_per_cycle = 8;     // quads exported a ROP cycle, in raster order

    FrontEndConfig front;

    std::uint32_t partitions = 8;
    std::uint32_t partition_tiles = 2;  // tiles on a side of the square that one partition owns
    std::uint32_t lanes = 4;            // pixel lanes a partition, each with its operation units
    std::uint32_t input_queue = 16;     // quads that have arrived at a partition
    std::uint32_t quads_in_flight = 32;
    std::uint32_t crossbar_latency = 16;  // ROP cycles from export to the partition's input queue
    HazardConfig hazards;

    RopCacheConfig cache;
    std::uint32_t cache_ports = 1;  // lines of a quad looked up, and lines of a quad written, a ROP cycle
    std::uint32_t cache_port_bytes = 0;  // to and from the memory port a ROP cycle, each way; 0: no limit
    std::uint32_t mshrs = 16;
    std::uint32_t cache_hit_latency = 4;     // ROP cycles from tag check to operands
    std::uint32_t cache_request_queue = 16;  // requests between cache and memory port
    bool fast_clear = true;
    CompressionConfig compression;
    LayoutConfig layout;

    L2Config l2;  // of one partition's slice between ROP cache and channel; period: the ROP clock's

    TiledConfig tiled;
    TilePlan tiles;  // of a run with the tiled engine

    std::uint64_t pool_bytes = 0;  // memory for list nodes, all partitions together

    // Cycles that `bytes` take through the cache's memory port.
    std::uint32_t port_cycles(std::uint32_t bytes) const {
        return cache_port_bytes == 0 ? 1 : (bytes + cache_port_bytes - 1) / cache_port_bytes;
    }
    // Cycles that `lines` take through the tags, or to be written.
    std::uint32_t line_cycles(std::uint32_t lines) const {
        return cache_ports == 1 ? lines : (lines + cache_ports - 1) / cache_ports;
    }

    DatapathShape datapath;
    FormatRates rates;
    SkipConfig skip;
    InterlockConfig interlock;
    DramConfig dram;  // of one partition's memory channel
};

// Names of the built-in presets with one line each.
struct HardwarePreset {
    std::string name;
    std::string summary;
};
const std::vector<HardwarePreset>& hardware_presets();

// Opens a preset by name or a TOML file by path (anything with a '/' or ending in .toml). Throws UserError.
Parameters hardware_parameters(const std::string& preset_or_file);

// Applies one key=value. Throws UserError, naming `where`, when it is not of that form.
void set_from_text(Parameters& parameters, const std::string& text, const std::string& where);

// Reads and checks every key; Parameters::close() is the caller's, after the last reader of other keys.
MachineConfig machine_config(Parameters& parameters, const std::string& preset_name);

}  // namespace ropsim
