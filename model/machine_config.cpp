#include "model/machine_config.h"

#include "hardware_presets.h"

#include "base/error.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <sstream>

#include <fmt/ranges.h>

namespace ropsim {

namespace {

std::uint32_t count(Parameters& p, const std::string& key, std::uint32_t fallback, std::int64_t low,
                    std::int64_t high) {
    return static_cast<std::uint32_t>(p.get_integer(key, fallback, low, high));
}

std::uint64_t period_ps(Parameters& p, const std::string& key, double fallback_mhz) {
    return static_cast<std::uint64_t>(1e6 / p.get_real(key, fallback_mhz, 10, 10000) + 0.5);
}

void read_datapath(Parameters& p, DatapathShape& shape) {
    // Latencies are those of single-precision units in a pipeline of about 1 GHz, estimates. A mux folds into
    // the stage of the unit it follows; a dependent fetch takes what a hit of the ROP cache does. A budget of
    // 0 gives every lane as many units as the operation needs.
    static constexpr std::array<const char*, kUnitCount> kBudgetKeys = {"rop.adders",
                                                                        "rop.multipliers",
                                                                        "rop.dividers",
                                                                        "rop.comparators",
                                                                        "rop.muxes",
                                                                        "rop.integer_adders",
                                                                        "rop.integer_multipliers",
                                                                        "rop.logic_units",
                                                                        "rop.converters",
                                                                        "rop.random_generators",
                                                                        "rop.tables",
                                                                        "rop.transcendentals",
                                                                        "rop.fetch_stages"};
    const std::array<int, kUnitCount> latency = {
        2, 2, 8, 1, 0, 1, 2, 1, 1, 2, 1, 6, static_cast<int>(p.get_integer("cache.hit_latency", 4, 0, 1000))};
    for (std::size_t u = 0; u < static_cast<std::size_t>(kUnitCount); ++u) {
        const std::string unit(kUnitNames[u]);
        shape.latency[u] = static_cast<int>(p.get_integer("datapath.latency." + unit, latency[u], 0, 1000));
        shape.budget[u] = static_cast<int>(p.get_integer(kBudgetKeys[u], 0, 0, 100000));
    }
}

// The sections of a cache that is split by class of surface: what is not given to depth or nodes is colour's.
void read_sections(Parameters& p, RopCacheConfig& cache) {
    const std::int64_t whole = cache.size_bytes / 1024;
    const std::int64_t depth = p.get_integer("cache.depth_kibibytes", whole / 2, 1, 65536);
    const std::int64_t nodes = p.get_integer("cache.node_kibibytes", 0, 0, 65536);
    const std::int64_t rest = std::max<std::int64_t>(whole - depth - nodes, 1);
    const std::int64_t color = p.get_integer("cache.color_kibibytes", rest, 1, 65536);
    if (depth + color + nodes != whole)
        throw UserError(
            p.has("cache.depth_kibibytes") ? p.where("cache.depth_kibibytes") : p.where("cache.organisation"),
            fmt::format("{} KiB for depth, {} for colour and {} for nodes must make "
                        "cache.kibibytes = {}",
                        depth, color, nodes, whole));
    const auto bytes = [](std::int64_t kibibytes) { return static_cast<std::uint32_t>(kibibytes * 1024); };
    cache.section_bytes = {bytes(depth), bytes(color), bytes(nodes)};
}

// check_cache_config(), whose fault is put to the key of `section` that it is about.
void check_cache(const Parameters& p, const std::string& section, const RopCacheConfig& cache) {
    try {
        check_cache_config(cache);
    } catch (const UserError& error) {
        const std::string_view what = error.what();
        const char* key = what.starts_with("line_bytes")     ? ".line_bytes"
                          : what.starts_with("sector_bytes") ? ".sector_bytes"
                          : what.starts_with("a section")    ? ".depth_kibibytes"
                                                             : ".kibibytes";
        throw UserError(p.where(section + key), error.what());
    }
}

// A fill and the write-back before it must fit, each in as many requests as every other sector makes.
void check_request_queue(const Parameters& p, const char* key, std::uint32_t entries,
                         const RopCacheConfig& cache) {
    const std::uint32_t sectors = cache.line_bytes / cache.sector_bytes;
    if (entries < sectors)
        throw UserError(p.where(key),
                        fmt::format("must be at least {}: a line has {} sectors", sectors, sectors));
}

// Every key is read whether there is a slice or not, so that its size alone can be varied down to 0.
void read_l2(Parameters& p, L2Config& l2) {
    l2.cache.size_bytes = count(p, "l2.kibibytes", 0, 0, 65536) * 1024;
    l2.cache.ways = count(p, "l2.ways", 16, 1, 64);
    l2.cache.line_bytes = count(p, "l2.line_bytes", 128, 64, 256);
    l2.cache.sector_bytes = count(p, "l2.sector_bytes", 32, 8, 256);
    l2.latency = count(p, "l2.latency", 40, 0, 1000);
    l2.bytes_per_cycle = count(p, "l2.bytes_per_cycle", l2.bytes_per_cycle, 1, 4096);
    l2.mshrs = count(p, "l2.mshrs", l2.mshrs, 1, 256);
    l2.input_queue = count(p, "l2.input_queue", l2.input_queue, 1, 4096);
    l2.request_queue = count(p, "l2.request_queue", l2.request_queue, 16, 4096);
    l2.flush = p.get_flag("l2.flush", true);
    if (!l2.present()) return;
    check_cache(p, "l2", l2.cache);
    check_request_queue(p, "l2.request_queue", l2.request_queue, l2.cache);
}

void read_rop(Parameters& p, MachineConfig& c) {
    c.partitions = count(p, "rop.partitions", c.partitions, 1, 64);
    c.partition_tiles = count(p, "rop.partition_tiles", c.partition_tiles, 1, 64);
    c.lanes = count(p, "rop.lanes", c.lanes, 1, 64);
    c.input_queue = count(p, "rop.input_queue", c.input_queue, 1, 4096);
    c.quads_in_flight = count(p, "rop.quads_in_flight", c.quads_in_flight, 1, 32);
    c.crossbar_latency = count(p, "rop.crossbar_latency", c.crossbar_latency, 0, 10000);
    c.hazards = read_hazards(p);
    c.cache.size_bytes = count(p, "cache.kibibytes", 16, 1, 65536) * 1024;
    c.cache.ways = count(p, "cache.ways", c.cache.ways, 1, 64);
    c.cache.line_bytes = count(p, "cache.line_bytes", c.cache.line_bytes, 64, 256);
    c.cache.sector_bytes = count(p, "cache.sector_bytes", c.cache.sector_bytes, 8, 256);
    c.cache_ports = count(p, "cache.ports", c.cache_ports, 1, 16);
    c.cache_port_bytes = count(p, "cache.port_bytes", c.cache_port_bytes, 0, 4096);
    c.mshrs = count(p, "cache.mshrs", c.mshrs, 1, 256);
    c.cache_hit_latency = count(p, "cache.hit_latency", c.cache_hit_latency, 0, 1000);
    c.cache_request_queue = count(p, "cache.request_queue", c.cache_request_queue, 16, 4096);
    if (p.get_choice("cache.organisation", "shared", {"shared", "separate"}) == "separate")
        read_sections(p, c.cache);
    check_cache(p, "cache", c.cache);
    check_request_queue(p, "cache.request_queue", c.cache_request_queue, c.cache);
    read_l2(p, c.l2);
    c.fast_clear = p.get_flag("cache.fast_clear", true);
    c.pool_bytes = static_cast<std::uint64_t>(p.get_integer("pool.mebibytes", 256, 1, 1 << 20)) << 20;
}

CodecKind codec(Parameters& p, const std::string& key, std::initializer_list<std::string_view> names,
                std::initializer_list<CodecKind> kinds) {
    const std::string chosen = p.get_choice(key, "none", names);
    return kinds.begin()[std::ranges::find(names, chosen) - names.begin()];
}

std::vector<std::uint32_t> read_levels(Parameters& p, std::uint32_t block_bytes) {
    std::vector<std::uint32_t> levels;
    std::istringstream words(p.get_string("compression.levels", "32 64 128"));
    for (std::uint32_t level = 0; words >> level;) levels.push_back(level);
    const bool rising = std::ranges::adjacent_find(levels, std::greater_equal<>()) == levels.end();
    const bool whole =
        std::ranges::all_of(levels, [](std::uint32_t level) { return level != 0 && level % 8 == 0; });
    if (!words.eof() || levels.empty() || !rising || !whole || levels.back() >= block_bytes)
        throw UserError(
            p.where("compression.levels"),
            fmt::format("must be rising multiples of 8 below compression.block_bytes = {}, such as "
                        "\"32 64 128\"",
                        block_bytes));
    return levels;
}

void read_compression(Parameters& p, MachineConfig& c) {
    CompressionConfig& compression = c.compression;
    compression.codec = {
        codec(p, "compression.depth", {"none", "planes", "delta", "best"},
              {CodecKind::kNone, CodecKind::kDepthPlanes, CodecKind::kDepthDelta, CodecKind::kDepthBest}),
        codec(p, "compression.color", {"none", "delta"}, {CodecKind::kNone, CodecKind::kColorDelta}),
        codec(p, "compression.nodes", {"none", "delta", "used", "used_delta"},
              {CodecKind::kNone, CodecKind::kNodeDelta, CodecKind::kNodesUsed, CodecKind::kNodesUsedDelta})};
    compression.block_bytes = count(p, "compression.block_bytes", 256, 64, 256);
    compression.levels = read_levels(p, compression.block_bytes);
    compression.sticky = p.get_flag("compression.sticky", false);
    compression.eviction_buffer = count(p, "compression.eviction_buffer", 8, 1, 64);
    MetadataConfig& metadata = compression.metadata;
    metadata.size_bytes = count(p, "metadata.kibibytes", 0, 0, 1024) * 1024;
    metadata.ways = count(p, "metadata.ways", metadata.ways, 1, 64);
    metadata.bits = count(p, "metadata.bits", metadata.bits, 1, 64);
    if (metadata.size_bytes != 0)
        check_cache(
            p, "metadata",
            {metadata.size_bytes, metadata.ways, MetadataCache::kLineBytes, MetadataCache::kSectorBytes});
    if (!compression.any() && metadata.size_bytes == 0) return;
    if (!std::has_single_bit(compression.block_bytes) || compression.block_bytes < c.cache.line_bytes)
        throw UserError(p.where("compression.block_bytes"),
                        fmt::format("{} must be a power of two and at least cache.line_bytes = {}",
                                    compression.block_bytes, c.cache.line_bytes));
    // A fill, a write-back, the rest of its block and its state, there and back.
    const std::uint32_t sectors = c.cache.line_bytes / c.cache.sector_bytes;
    if (c.cache_request_queue < sectors + 5)
        throw UserError(p.where("cache.request_queue"),
                        fmt::format("must be at least {} with compression", sectors + 5));
}

void read_layout(Parameters& p, LayoutConfig& layout) {
    const std::string elements =
        p.get_choice("layout.elements", "technique", {"technique", "interleaved", "planar"});
    layout.elements = elements == "planar"        ? LayoutConfig::Elements::kPlanar
                      : elements == "interleaved" ? LayoutConfig::Elements::kInterleaved
                                                  : LayoutConfig::Elements::kTechnique;
    const std::string pixels = p.get_choice("layout.pixels", "quads", {"quads", "rows", "morton"});
    layout.pixels = pixels == "rows"     ? LayoutConfig::Order::kRows
                    : pixels == "morton" ? LayoutConfig::Order::kMorton
                                         : LayoutConfig::Order::kQuads;
    layout.morton_tiles = p.get_choice("layout.tiles", "rows", {"rows", "morton"}) == "morton";
}

}  // namespace

const std::vector<HardwarePreset>& hardware_presets() {
    static const std::vector<HardwarePreset> presets = [] {
        std::vector<HardwarePreset> list;
        for (const auto& [name, text] : kHardwarePresets) {
            const std::string_view body(text);
            // The first line of a preset says what it is.
            const std::size_t end = body.find('\n');
            list.push_back({name, std::string(body.substr(2, end - 2))});
        }
        return list;
    }();
    return presets;
}

Parameters hardware_parameters(const std::string& preset_or_file) {
    const std::string context = fmt::format("hardware '{}'", preset_or_file);
    for (const auto& [name, text] : kHardwarePresets)
        if (name == preset_or_file)
            return Parameters::from_toml_text(context, text, fmt::format("preset '{}'", name));
    if (preset_or_file.find('/') != std::string::npos || preset_or_file.ends_with(".toml"))
        return Parameters::from_toml_file(context, preset_or_file);
    std::vector<std::string> names;
    for (const HardwarePreset& p : hardware_presets()) names.push_back(p.name);
    throw UserError("--hardware", fmt::format("unknown preset '{}'; choose one of {}, or give a .toml file",
                                              preset_or_file, fmt::join(names, ", ")));
}

void set_from_text(Parameters& parameters, const std::string& text, const std::string& where) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
        throw UserError(where, fmt::format("'{}' is not key=value", text));
    parameters.set(text.substr(0, equals), text.substr(equals + 1), where);
}

MachineConfig machine_config(Parameters& p, const std::string& preset_name) {
    MachineConfig c;
    c.preset = preset_name;
    c.rop_period_ps = period_ps(p, "clock.rop_mhz", 1000);
    c.shader_period_ps = period_ps(p, "clock.shader_mhz", 1000);
    c.shader_alu_lanes = count(p, "shader.alu_lanes", c.shader_alu_lanes, 1, 1 << 20);
    c.shader_latency = count(p, "shader.latency", c.shader_latency, 0, 1 << 20);
    c.shader_quads_in_flight = count(p, "shader.quads_in_flight", c.shader_quads_in_flight, 1, 1 << 20);
    c.raster_quads_per_cycle = count(p, "shader.raster_quads_per_cycle", c.raster_quads_per_cycle, 1, 1024);
    c.export_quads_per_cycle = count(p, "shader.export_quads_per_cycle", c.export_quads_per_cycle, 1, 1024);
    c.front = read_front_end(p);
    read_rop(p, c);
    check_front_end(p, c.front, c.cache);
    read_compression(p, c);
    read_layout(p, c.layout);
    read_datapath(p, c.datapath);
    c.rates = read_format_rates(p);
    c.skip = read_skips(p);
    c.interlock = read_interlock(p);
    c.tiled = read_tiled(p);
    c.dram = dram_config(p);
    return c;
}

}  // namespace ropsim
