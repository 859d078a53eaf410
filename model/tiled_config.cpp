#include "model/tiled_config.h"

#include "rop/declaration.h"
#include "traces/trace.h"

#include <algorithm>
#include <numeric>

namespace ropsim {

namespace {

constexpr std::uint32_t kOpaqueDepthBytes = 4;

std::uint32_t count(Parameters& p, const char* key, std::uint32_t fallback, std::int64_t low,
                    std::int64_t high) {
    return static_cast<std::uint32_t>(p.get_integer(key, fallback, low, high));
}

// Surfaces that share one place in tile memory.
struct Candidate {
    std::uint32_t bytes = 0;  // a pixel
    std::vector<std::size_t> surfaces;
};

std::vector<Candidate> candidates(const Declaration& declared, const TraceHeader& trace) {
    const std::size_t surfaces = declared.surfaces.size();
    const std::size_t opaque_depth = surfaces;
    const std::size_t opaque_color = surfaces + 1;
    const std::size_t image = surfaces + 2;
    const auto samples = static_cast<std::uint32_t>(trace.samples);
    std::vector<Candidate> list;
    if (trace.opaque) list.push_back({kOpaqueDepthBytes * samples, {opaque_depth}});
    for (std::size_t s = 0; s < surfaces; ++s) {
        const Surface& surface = declared.surfaces[s];
        if (surface.layout == Layout::kPool) continue;
        list.push_back({static_cast<std::uint32_t>(surface.element_bytes() * surface.elements), {s}});
        // The colour target itself: the opaque colour is loaded straight into it.
        if (s == 0 && !declared.resolves) list.back().surfaces.push_back(opaque_color);
    }
    if (declared.resolves) {
        const bool is_packed =
            declared.image_format == Format::kR11G11B10 || declared.image_format == Format::kRgb9e5;
        const auto texel = static_cast<std::uint32_t>(
            FieldSpec::real(declared.image_format, is_packed ? 3 : 4, 0, ValueRange::kColor).bits() / 8);
        list.push_back({texel * (trace.opaque ? samples : 1), {opaque_color, image}});
    }
    return list;
}

}  // namespace

TiledConfig read_tiled(Parameters& p) {
    TiledConfig c;
    c.tile = count(p, "tiled.tile", c.tile, 8, 32);
    if (c.tile != 8 && c.tile != 16 && c.tile != 32)
        throw UserError(p.where("tiled.tile"), "must be 8, 16 or 32 pixels");
    c.memory_bytes = count(p, "tiled.kibibytes", c.memory_bytes / 1024, 0, 65536) * 1024;
    c.shrink = p.get_flag("tiled.shrink", c.shrink);
    c.hit_latency = count(p, "tiled.hit_latency", c.hit_latency, 0, 1000);
    c.bytes_per_cycle = count(p, "tiled.bytes_per_cycle", c.bytes_per_cycle, 1, 65536);
    c.entry_bytes = count(p, "tiled.entry_bytes", c.entry_bytes, 1, 64);
    c.primitive_bytes = count(p, "tiled.primitive_bytes", c.primitive_bytes, 0, 4096);
    c.bin_entries_per_cycle = count(p, "tiled.bin_entries_per_cycle", c.bin_entries_per_cycle, 1, 1024);
    c.overlap_binning = p.get_flag("tiled.overlap_binning", c.overlap_binning);
    return c;
}

TilePlan plan_tiles(const TiledConfig& config, const Declaration& declared, const TraceHeader& trace) {
    TilePlan plan;
    plan.tiled = true;
    plan.side = static_cast<int>(config.tile);
    plan.small_across = tiles_across(trace.width);
    plan.on_chip.assign(declared.surfaces.size() + 3, 0);
    for (const Surface& s : declared.surfaces)
        plan.pixel_bytes.push_back(
            s.layout == Layout::kPool ? 0 : static_cast<std::uint32_t>(s.element_bytes() * s.elements));
    plan.tiled_resolve = declared.footprint == 0 && !declared.gathers;
    const auto around = [](const Pass& pass) { return pass.gathers || pass.scale > 1; };
    plan.tiled_passes =
        static_cast<int>(std::ranges::find_if(declared.passes, around) - declared.passes.begin());
    if (std::ranges::any_of(declared.passes, [](const Pass& pass) { return pass.scale > 1; }))
        plan.tiled_passes = 0;
    // Rounds are not left in their middle.
    if (plan.tiled_passes <= declared.repeat.last && plan.tiled_passes > declared.repeat.first)
        plan.tiled_passes = declared.repeat.first;
    if (plan.tiled_passes < static_cast<int>(declared.passes.size())) plan.tiled_resolve = false;

    const std::vector<Candidate> wanted = candidates(declared, trace);
    const auto pixel = std::accumulate(wanted.begin(), wanted.end(), std::uint64_t{0},
                                       [](std::uint64_t sum, const Candidate& c) { return sum + c.bytes; });
    const auto pixels = [&] {
        return static_cast<std::uint64_t>(plan.side) * static_cast<std::uint64_t>(plan.side);
    };
    while (plan.tiled_resolve && config.shrink && plan.side > kTileSize &&
           pixel * pixels() > config.memory_bytes)
        plan.side /= 2;
    plan.wanted_bytes = pixel * pixels();
    const auto tiles = [&](int size) { return (size + plan.side - 1) / plan.side; };
    plan.across = tiles(trace.width);
    plan.down = tiles(trace.height);
    if (!plan.tiled_resolve) return plan;
    for (const Candidate& c : wanted) {
        if (plan.state_bytes + c.bytes * pixels() > config.memory_bytes) break;
        plan.state_bytes += c.bytes * pixels();
        for (const std::size_t s : c.surfaces) plan.on_chip[s] = 1;
    }
    return plan;
}

}  // namespace ropsim
