#include "model/surface_map.h"

#include "base/error.h"
#include "rop/stored_bytes.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <tuple>
#include <utility>

namespace ropsim {

namespace {
constexpr std::uint32_t kOpaqueDepthBytes = 4;  // float32
constexpr std::uint64_t round_up(std::uint64_t value, std::uint64_t unit) {
    return (value + unit - 1) / unit * unit;
}

// Bits of x and y in turn, x's first; both below 8.
constexpr std::uint32_t morton_number(std::uint32_t x, std::uint32_t y) {
    const auto spread = [](std::uint32_t v) { return (v & 1u) | (v & 2u) << 1 | (v & 4u) << 2; };
    return spread(x) | spread(y) << 1;
}

bool packed(Format format) {
    return format == Format::kR11G11B10 || format == Format::kRgb9e5;
}

FieldKind kind_of(Format format) {
    switch (format) {
        case Format::kFloat32:
            return FieldKind::kFloat32;
        case Format::kFloat16:
            return FieldKind::kFloat16;
        case Format::kUnorm8:
        case Format::kUnorm16:
        case Format::kUnorm24:
            return FieldKind::kUnorm;
        case Format::kSnorm8:
            return FieldKind::kSnorm;
        case Format::kRgb9e5:
            return FieldKind::kPacked;
        default:
            return FieldKind::kInteger;  // R11G11B10's unsigned floats order as integers do
    }
}

// The field follows those that are there, without a gap.
void add_fields(const StoredField& field, BlockFormat& format) {
    std::uint32_t bit = 0;
    if (!format.fields.empty())
        bit = format.fields.back().bit +
              static_cast<std::uint32_t>(format.fields.back().bits) * format.fields.back().channels;
    const auto add = [&](int bits, int channels) {
        format.fields.push_back({static_cast<std::uint16_t>(bit), static_cast<std::uint8_t>(bits),
                                 static_cast<std::uint8_t>(channels), kind_of(field.format)});
        bit += static_cast<std::uint32_t>(bits * channels);
    };
    if (field.format == Format::kR11G11B10) {
        for (const int bits : {11, 11, 10}) add(bits, 1);
    } else if (packed(field.format) || field.format == Format::kBits) {
        add(field.bits, 1);
    } else {
        add(field.bits / field.channels, field.channels);
    }
}

// One depth an element: kept as depths. One element a pixel, or colours sample by sample: as colours. The
// rest, lists and arrays of nodes, as nodes.
SurfaceClass class_of(const Surface& s, Layout layout) {
    const bool alone = s.fields.size() == 1 && s.fields[0].channels == 1;
    const bool depth = s.initial == Initial::kOpaqueDepth ||
                       (s.name.find("depth") != std::string::npos && s.name != "optical_depth");
    if (alone && depth && s.layout != Layout::kPool) return SurfaceClass::kDepth;
    if (s.layout == Layout::kPool) return SurfaceClass::kNodes;
    return s.elements == 1 || layout == Layout::kPlanar ? SurfaceClass::kColor : SurfaceClass::kNodes;
}

BlockFormat block_format(const Surface& s, Layout layout) {
    BlockFormat format;
    format.surface_class = class_of(s, layout);
    format.element_bytes = static_cast<std::uint32_t>(s.element_bytes());
    for (const StoredField& field : s.fields) add_fields(field, format);
    format.clear_element.resize(format.element_bytes);
    store_elements(s, s.clear_words.data(), 1, format.clear_element.data());
    return format;
}
}  // namespace

SurfaceMap::SurfaceMap(const Declaration& declaration, const MachineConfig& config, const TraceHeader& trace)
    : partitions_(static_cast<int>(config.partitions)),
      line_bytes_(std::max(config.cache.line_bytes, config.l2.present() ? config.l2.cache.line_bytes : 0)),
      order_(config.layout.pixels),
      compression_(config.compression),
      technique_surfaces_(static_cast<int>(declaration.surfaces.size())) {
    order_pixels();
    share_out_tiles(config, tiles_across(trace.width), tiles_across(trace.height));
    for (const Surface& s : declaration.surfaces) {
        const auto bytes = static_cast<std::uint32_t>(s.element_bytes());
        if (s.layout == Layout::kPool) {
            pool_nodes_ = std::min<std::uint64_t>(config.pool_bytes / config.partitions / bytes, kNoNode - 1);
            place(s.name, s.layout, bytes, 1, pool_nodes_ * bytes, block_format(s, s.layout)).starts_clear =
                compression_.codec[static_cast<std::size_t>(SurfaceClass::kNodes)] != CodecKind::kNone;
            continue;
        }
        const Layout layout = config.layout.elements == LayoutConfig::Elements::kTechnique ? s.layout
                              : config.layout.elements == LayoutConfig::Elements::kPlanar
                                  ? Layout::kPlanar
                                  : Layout::kInterleaved;
        const bool constant = s.initial == Initial::kClear || !trace.opaque;
        place(s.name, layout, bytes, s.elements, 0, block_format(s, layout)).starts_clear =
            constant && config.fast_clear;
    }
    place_fixed(declaration, trace, std::uint64_t{config.front.texture.mebibytes} << 20);
    if (config.interlock.executes && config.interlock.mode == InterlockMode::kSpin) {
        place("locks", Layout::kInterleaved, 4, 1, 0, BlockFormat{});
        locks_ = surfaces() - 1;
    }
    on_chip_.assign(placed_.size(), 0);
    if (config.tiles.tiled) place_tiled(config.tiles, declaration, config.tiled.entry_bytes);
    partition_bytes_ = round_up(partition_bytes_, std::max(line_bytes_, MetadataCache::kLineBytes));
    const std::uint64_t states =
        MetadataCache::bytes_for(compression_.metadata, partition_bytes_, compression_.block_bytes);
    if (partition_bytes_ + states > config.dram.capacity_bytes())
        throw UserError(
            "memory", fmt::format("the surfaces need {} MiB a partition, its channel holds {} MiB; use fewer "
                                  "samples or nodes, a smaller pool.mebibytes or more rop.partitions",
                                  partition_bytes_ >> 20, config.dram.capacity_bytes() >> 20));
}

// What every machine has besides the technique's surfaces.
void SurfaceMap::place_fixed(const Declaration& declaration, const TraceHeader& trace,
                             std::uint64_t texture_bytes) {
    const FieldSpec texel = FieldSpec::real(declaration.image_format,
                                            packed(declaration.image_format) ? 3 : 4, 0, ValueRange::kColor);
    const auto image_bytes = static_cast<std::uint32_t>(texel.bits() / 8);
    BlockFormat color;
    color.surface_class = SurfaceClass::kColor;
    color.element_bytes = image_bytes;
    add_fields({0, texel.channels, texel.format, texel.bits()}, color);
    color.clear_element.assign(image_bytes, 0);
    BlockFormat depth;
    depth.surface_class = SurfaceClass::kDepth;
    depth.element_bytes = kOpaqueDepthBytes;
    depth.fields = {{0, 32, 1, FieldKind::kFloat32}};
    depth.clear_element.assign(kOpaqueDepthBytes, 0);
    place("opaque_depth", Layout::kInterleaved, kOpaqueDepthBytes, trace.samples, 0, depth);
    place("opaque_color", Layout::kInterleaved, image_bytes, trace.samples, 0, color);
    // Written only: what was there before need not be known.
    Placed& image = place("image", Layout::kInterleaved, image_bytes, 1, 0, color);
    image.starts_clear = image.codec != CodecKind::kNone;
    const bool textured = std::ranges::any_of(trace.draws, [](const Draw& draw) {
        return draw.full.texture_fetches > 0 || draw.alpha.texture_fetches > 0;
    });
    if (!textured) return;
    // A share of all textures, dealt out in pieces.
    textures_ = surfaces();
    BlockFormat texels;
    texels.surface_class = SurfaceClass::kColor;
    texels.element_bytes = 4;
    Placed& textures = place("textures", Layout::kPool, 4, 1,
                             texture_bytes / static_cast<std::uint64_t>(partitions_), texels);
    textures.codec = CodecKind::kNone;
}

void SurfaceMap::order_pixels() {
    for (std::uint32_t place = 0; place < place_of_.size(); ++place) {
        const std::uint32_t quad = place / 4;
        const std::uint32_t x = quad % 4 * 2 + place % 2;
        const std::uint32_t y = quad / 4 * 2 + place % 4 / 2;
        place_of_[place] =
            static_cast<std::uint8_t>(order_ == LayoutConfig::Order::kQuads  ? place
                                      : order_ == LayoutConfig::Order::kRows ? y * kTileSize + x
                                                                             : morton_number(x, y));
    }
}

// Behind the others the bins, of which memory has what it needs. What stays on chip is not compressed; its
// addresses are reserved and not used.
void SurfaceMap::place_tiled(const TilePlan& plan, const Declaration& declaration,
                             std::uint32_t entry_bytes) {
    on_chip_ = plan.on_chip;
    for (int s = 0; s < technique_surfaces_; ++s)
        if (on_chip(s) && (s != 0 || declaration.resolves))
            placed_[static_cast<std::size_t>(s)].codec = CodecKind::kNone;
    BlockFormat format;
    format.surface_class = SurfaceClass::kColor;
    format.element_bytes = entry_bytes;
    Placed& bins = place("bins", Layout::kPool, entry_bytes, 1, plan.bin_bytes, format);
    bins.codec = CodecKind::kNone;
    bins_ = surfaces() - 1;
    on_chip_.resize(placed_.size(), 0);
}

void SurfaceMap::share_out_tiles(const MachineConfig& config, int width, int height) {
    const auto across = static_cast<std::size_t>(width);
    const auto down = static_cast<std::size_t>(height);
    const std::size_t side = config.partition_tiles;
    std::vector<std::size_t> order(across * down);
    std::iota(order.begin(), order.end(), std::size_t{0});
    if (config.layout.morton_tiles) {
        constexpr std::size_t kSquare = 8;  // tiles on a side, by Morton number inside
        const auto place = [&](std::size_t tile) {
            const std::size_t x = tile % across;
            const std::size_t y = tile / across;
            return std::tuple(y / kSquare, x / kSquare,
                              morton_number(static_cast<std::uint32_t>(x % kSquare),
                                            static_cast<std::uint32_t>(y % kSquare)));
        };
        std::ranges::sort(order, {}, place);
    }
    owner_.resize(across * down);
    local_tile_.resize(across * down);
    tiles_of_.resize(config.partitions);
    for (const std::size_t tile : order) {
        // Rows of squares are shifted against each other, so that neither a row nor a column of the screen
        // falls to few partitions. Odd shift: with a power of two of partitions every one gets its turn.
        const std::size_t shift = config.partitions / 2 | 1;
        const std::size_t owner = (tile % across / side + tile / across / side * shift) % config.partitions;
        owner_[tile] = static_cast<std::uint8_t>(owner);
        local_tile_[tile] = static_cast<std::uint32_t>(tiles_of_[owner].size());
        tiles_of_[owner].push_back(tile);
    }
    for (const auto& tiles : tiles_of_)
        largest_share_ = std::max<std::uint64_t>(largest_share_, tiles.size());
}

SurfaceMap::Placed& SurfaceMap::place(const std::string& name, Layout layout, std::uint32_t element_bytes,
                                      int elements, std::uint64_t bytes, const BlockFormat& format) {
    Placed p;
    p.name = name;
    p.layout = layout;
    p.element_bytes = element_bytes;
    p.elements = elements;
    const bool planar = layout == Layout::kPlanar;
    p.pixel_stride = planar ? element_bytes : element_bytes * static_cast<std::uint32_t>(elements);
    p.element_stride = planar ? element_bytes * kTilePixels : element_bytes;
    p.format = format;
    p.format.block_bytes = compression_.block_bytes;
    p.format.elements = layout == Layout::kPool ? 0 : static_cast<std::uint32_t>(elements);
    p.format.planar = planar;
    p.codec = compression_.codec[static_cast<std::size_t>(format.surface_class)];
    // Blocks begin where tiles do.
    const std::uint64_t unit =
        p.codec == CodecKind::kNone ? line_bytes_ : std::max(line_bytes_, compression_.block_bytes);
    p.tile_bytes = round_up(
        static_cast<std::uint64_t>(element_bytes) * static_cast<std::uint64_t>(elements) * kTilePixels, unit);
    p.base = round_up(partition_bytes_, unit);
    p.bytes = round_up(layout == Layout::kPool ? bytes : p.tile_bytes * largest_share_, unit);
    partition_bytes_ = p.base + p.bytes;
    return placed_.emplace_back(std::move(p));
}

void SurfaceMap::prepare(RopCache& cache) const {
    const std::array<std::uint32_t, kCacheSections>& bytes = cache.config().section_bytes;
    for (int s = 0; s < surfaces(); ++s) {
        // Sections by class; nodes share the colours' where they have none.
        auto section = static_cast<int>(surface_class(s));
        if (surface_class(s) == SurfaceClass::kNodes && bytes[2] == 0) section = 1;
        if (bytes[0] != 0) cache.set_section(static_cast<std::uint8_t>(s), section);
        if (starts_clear(s)) cache.set_clear_range(first_address(s), address_bytes(s));
    }
}

}  // namespace ropsim
