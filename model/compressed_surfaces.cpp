#include "model/compressed_surfaces.h"

#include "model/machine_result.h"
#include "rop/stored_bytes.h"

#include <algorithm>
#include <bit>

namespace ropsim {

void FrameContents::fill(int surface, std::uint64_t offset, std::uint32_t bytes, std::uint8_t* out) const {
    const std::uint64_t address = map_.first_address(surface) + offset;
    // Nobody reads nodes before they are written, nor tiles that the partition does not have.
    if (map_.layout(surface) == Layout::kPool || !map_.has_tile_at(partition_, surface, address)) {
        std::fill_n(out, bytes, std::uint8_t{0});
        return;
    }
    const std::uint64_t tile_number = offset / map_.tile_bytes(surface);
    if (last_surface_ != surface || last_tile_ != tile_number) {
        tile(surface, map_.tile_at(partition_, surface, address), last_bytes_);
        last_surface_ = surface;
        last_tile_ = tile_number;
    }
    std::copy_n(last_bytes_.begin() + static_cast<std::ptrdiff_t>(offset % map_.tile_bytes(surface)), bytes,
                out);
}

void FrameContents::tile(int surface, std::size_t tile, std::vector<std::uint8_t>& bytes) const {
    const TraceHeader& trace = store_.trace();
    const auto across = static_cast<std::size_t>(tiles_across(trace.width));
    const int x0 = static_cast<int>(tile % across) * kTileSize;
    const int y0 = static_cast<int>(tile / across) * kTileSize;
    const std::uint32_t element_bytes = map_.element_bytes(surface);
    bytes.assign(map_.tile_bytes(surface), 0);
    std::vector<std::uint8_t> one;
    for (std::uint32_t i = 0; i < kTilePixels; ++i) {
        const std::uint32_t quad = i / 4;
        const std::uint32_t in_quad = i % 4;
        const int x = x0 + static_cast<int>(quad % 4 * 2 + in_quad % 2);
        const int y = y0 + static_cast<int>(quad / 4 * 2 + in_quad / 2);
        pixel(surface, std::min(x, trace.width - 1), std::min(y, trace.height - 1), one);
        for (std::size_t e = 0; e * element_bytes < one.size(); ++e)
            std::copy_n(one.begin() + static_cast<std::ptrdiff_t>(e) * element_bytes, element_bytes,
                        bytes.begin() + static_cast<std::ptrdiff_t>(map_.offset_in_tile(
                                            surface, quad, in_quad, static_cast<std::uint32_t>(e))));
    }
}

// Its elements, one behind the other.
void FrameContents::pixel(int surface, int x, int y, std::vector<std::uint8_t>& bytes) const {
    bytes.assign(map_.pixel_bytes(surface), 0);
    const int samples = store_.trace().samples;
    if (surface == map_.opaque_depth()) {
        for (int m = 0; m < samples; ++m) {
            const auto word = std::bit_cast<std::array<std::uint8_t, 4>>(store_.opaque_depth(x, y, m));
            std::copy(word.begin(), word.end(), bytes.begin() + std::ptrdiff_t{4} * m);
        }
    } else if (surface == map_.opaque_color()) {
        const PixelBackground background = store_.background(x, y);
        const std::uint32_t texel = map_.element_bytes(surface);
        for (int m = 0; m < samples; ++m) {
            const glm::vec3& color = background.sample[static_cast<std::size_t>(m)];
            const auto stored = stored_rgb(declaration_.image_format, {color.r, color.g, color.b});
            store_color(declaration_.image_format, stored.data(), texel,
                        bytes.data() + static_cast<std::size_t>(m) * texel);
        }
    } else if (surface < map_.technique_surfaces()) {
        const Surface& declared = declaration_.surfaces[static_cast<std::size_t>(surface)];
        store_.initial_pixel(x, y, words_);
        store_elements(declared, words_.data() + declared.first_word, all_elements(declared.elements),
                       bytes.data());
    }
}

CompressedSurfaces::CompressedSurfaces(const MachineConfig& config, const SurfaceMap& map,
                                       const Declaration& declaration, const PixelStore& store, int partition)
    : memory(config.compression.block_bytes, contents_),
      contents_(map, declaration, store, partition),
      has_states_(static_cast<std::size_t>(map.surfaces())) {
    const CompressionConfig& compression = config.compression;
    if (compression.metadata.size_bytes != 0)
        metadata.emplace(compression.metadata, map.metadata_address(), compression.block_bytes);
    for (int s = 0; s < map.surfaces(); ++s) {
        if (map.needs_values(s)) {
            const bool pool = map.layout(s) == Layout::kPool;
            const std::uint64_t tile_bytes = pool ? map.address_bytes(s) : map.tile_bytes(s);
            const std::uint64_t used_bytes =
                pool ? tile_bytes : std::uint64_t{map.pixel_bytes(s)} * kTilePixels;
            memory.add(
                {s, map.first_address(s), map.address_bytes(s), tile_bytes, used_bytes, map.starts_clear(s)},
                BlockCodec(map.codec(s), map.format(s), compression.levels));
        }
        has_states_[static_cast<std::size_t>(s)] = map.needs_values(s) || map.starts_clear(s) ? 1 : 0;
        if (metadata && map.starts_clear(s)) metadata->set_clear(map.first_address(s), map.address_bytes(s));
    }
}

std::unique_ptr<CompressedSurfaces> compressed_surfaces(const MachineConfig& config, const SurfaceMap& map,
                                                        const Declaration& declaration,
                                                        const PixelStore& store, int partition) {
    if (!config.compression.any() && config.compression.metadata.size_bytes == 0) return nullptr;
    return std::make_unique<CompressedSurfaces>(config, map, declaration, store, partition);
}

void CompressionReport::add(const CompressedSurfaces& partition, const SurfaceMap& map) {
    surfaces.resize(static_cast<std::size_t>(map.surfaces()));
    for (int s = 0; s < map.surfaces(); ++s)
        if (partition.memory.holds(s)) surfaces[static_cast<std::size_t>(s)].add(partition.memory.counts(s));
    if (partition.metadata) metadata.add(partition.metadata->statistics());
}

}  // namespace ropsim
