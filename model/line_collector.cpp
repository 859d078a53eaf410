#include "model/line_collector.h"

#include "rop/operation_log.h"

#include <algorithm>
#include <bit>

namespace ropsim {

namespace {

// In line: mostly one word, and called for every piece of every pixel.
[[gnu::always_inline]] inline void set_bits(LineMask& mask, std::uint32_t first, std::uint32_t count) {
    std::uint32_t bit = first % 64;
    std::uint32_t word = first / 64;
    for (;;) {
        const std::uint32_t here = std::min(count, 64 - bit);
        mask.word[word++] |= ~std::uint64_t{0} >> (64 - here) << bit;
        if (here == count) return;
        count -= here;
        bit = 0;
    }
}

}  // namespace

LineCollector::LineCollector(const SurfaceMap& map, const MachineConfig& config)
    : map_(map),
      line_bytes_(config.cache.line_bytes),
      sector_shift_(static_cast<std::uint32_t>(std::countr_zero(config.cache.sector_bytes))),
      tile_bytes_per_cycle_(config.tiled.bytes_per_cycle) {
    for (int s = 0; s < map.surfaces(); ++s) {
        shapes_.push_back({map.element_bytes(s), map.layout(s) == Layout::kPlanar,
                           map.layout(s) == Layout::kPool, map.needs_values(s), map.quads_are_whole(s),
                           map.on_chip(s), map.first_address(s), map.tile_bytes(s), map.pixel_stride(s)});
        add_pieces(shapes_.back(), map.pixel_bytes(s));
    }
}

void LineCollector::add_pieces(Shape& shape, std::uint32_t pixel_bytes) const {
    constexpr std::uint32_t kMostElements = 8;
    const std::uint32_t elements = pixel_bytes / shape.element_bytes;
    // Pixels of a power of two of bytes lie neither across lines nor, the small ones, across sectors.
    const bool apart = (shape.planar && elements > 1) || shape.pool || !std::has_single_bit(pixel_bytes);
    if (apart || shape.keeps_values || shape.on_chip || elements > kMostElements || pixel_bytes > 64) return;
    shape.pieces.resize(std::size_t{1} << elements);
    for (std::uint32_t mask = 0; mask < shape.pieces.size(); ++mask) {
        Pieces& pieces = shape.pieces[mask];
        for (std::uint32_t byte = 0; byte < pixel_bytes; ++byte) {
            if ((mask >> byte / shape.element_bytes & 1u) == 0) continue;
            pieces.bytes |= std::uint64_t{1} << byte;
            pieces.sectors |= 1u << (byte >> sector_shift_);
        }
    }
}

LineAccess& LineCollector::find_line(int surface, std::uint64_t line_address) {
    for (std::uint32_t i = count_; i > 0; --i) {
        LineAccess& earlier = (*lines_)[first_ + i - 1];
        if (earlier.line_address != line_address) continue;
        last_[static_cast<std::size_t>(surface)] = i - 1;
        return earlier;
    }
    return add_line(surface, line_address);
}

template <bool kReads, bool kWrites>
inline void LineCollector::touch(int surface, std::uint64_t address, std::uint32_t bytes) {
    while (bytes > 0) {
        const auto offset = static_cast<std::uint32_t>(address & (line_bytes_ - 1));
        const std::uint32_t here = std::min(bytes, line_bytes_ - offset);
        LineAccess& l = line(surface, address - offset);
        const std::uint32_t sectors = sectors_of(offset, here);
        if constexpr (kReads) l.read_sectors |= sectors;
        if constexpr (kWrites) {
            l.write_sectors |= sectors;
            set_bits(l.write_bytes, offset, here);
        }
        address += here;
        bytes -= here;
    }
}
template void LineCollector::touch<true, false>(int, std::uint64_t, std::uint32_t);

void LineCollector::put(int surface, std::uint64_t address, std::uint32_t bytes, const std::uint8_t* values) {
    if (!shapes_[static_cast<std::size_t>(surface)].keeps_values)
        return touch<false, true>(surface, address, bytes);
    while (bytes > 0) {
        const auto offset = static_cast<std::uint32_t>(address & (line_bytes_ - 1));
        const std::uint32_t here = std::min(bytes, line_bytes_ - offset);
        LineAccess& l = line(surface, address - offset);
        l.write_sectors |= sectors_of(offset, here);
        set_bits(l.write_bytes, offset, here);
        if (l.values == LineAccess::kNoValues) {
            l.values = static_cast<std::uint32_t>(values_->size());
            values_->resize(values_->size() + line_bytes_);
        }
        std::copy_n(values, here, values_->begin() + static_cast<std::ptrdiff_t>(l.values + offset));
        values += here;
        address += here;
        bytes -= here;
    }
}

template <class Visit>
void LineCollector::for_pieces(int surface, std::uint64_t first, std::uint64_t mask, Visit visit) {
    const Shape& shape = shapes_[static_cast<std::size_t>(surface)];
    if (mask == 1) return visit(first, shape.element_bytes);  // as most surfaces have it
    if (shape.planar) {
        const std::uint32_t plane = shape.element_bytes * kTilePixels;
        for (; mask != 0; mask &= mask - 1)
            visit(first + static_cast<std::uint64_t>(std::countr_zero(mask)) * plane, shape.element_bytes);
        return;
    }
    while (mask != 0) {
        const auto start = static_cast<std::uint32_t>(std::countr_zero(mask));
        const auto length = static_cast<std::uint32_t>(std::countr_one(mask >> start));
        visit(first + std::uint64_t{start} * shape.element_bytes, length * shape.element_bytes);
        mask = start + length >= 64 ? 0 : mask >> (start + length) << (start + length);
    }
}

void LineCollector::count_on_chip(int surface, const SurfaceAccess& access) {
    const std::uint32_t bytes = map_.element_bytes(surface);
    on_chip_read_ += static_cast<std::uint32_t>(count_elements(access.read)) * bytes;
    on_chip_written_ += static_cast<std::uint32_t>(count_elements(access.write)) * bytes;
}

const std::uint8_t* LineCollector::piece_by_piece(int surface, std::size_t tile, std::uint32_t quad,
                                                  std::uint32_t pixel, const SurfaceAccess& access,
                                                  const std::uint8_t* values) {
    if (on_chip(surface)) {
        count_on_chip(surface, access);
        return shapes_[static_cast<std::size_t>(surface)].keeps_values
                   ? values + count_elements(access.write) * map_.element_bytes(surface)
                   : values;
    }
    const Shape& shape = shapes_[static_cast<std::size_t>(surface)];
    const auto piece = [&](std::uint64_t address, std::uint32_t bytes) {
        put(surface, address, bytes, values);
        if (shape.keeps_values) values += bytes;
    };
    if (shape.pool) {
        if (access.write != 0)
            piece(map_.node_address(surface, static_cast<std::uint32_t>(access.write)), shape.element_bytes);
        return values;
    }
    const std::uint64_t first = map_.address(surface, tile, quad, pixel, 0);
    if (access.read == access.write && !shape.keeps_values) {
        for_pieces(surface, first, access.read, [&](std::uint64_t address, std::uint32_t bytes) {
            touch<true, true>(surface, address, bytes);
        });
        return values;
    }
    if (access.read != 0)
        for_pieces(surface, first, access.read, [&](std::uint64_t address, std::uint32_t bytes) {
            touch<true, false>(surface, address, bytes);
        });
    if (access.write != 0) for_pieces(surface, first, access.write, piece);
    return values;
}

void LineCollector::read_quad(int surface, std::size_t tile, std::uint32_t quad) {
    if (shapes_[static_cast<std::size_t>(surface)].whole_quads)
        return read(surface, map_.address(surface, tile, quad, 0, 0), 4 * map_.pixel_bytes(surface));
    for (std::uint32_t pixel = 0; pixel < 4; ++pixel)
        elements(surface, tile, quad, pixel, {map_.all_elements_of(surface), 0}, nullptr);
}

void LineCollector::write_quad(int surface, std::size_t tile, std::uint32_t quad,
                               const std::uint8_t* values) {
    if (shapes_[static_cast<std::size_t>(surface)].whole_quads)
        return write(surface, map_.address(surface, tile, quad, 0, 0), 4 * map_.pixel_bytes(surface), values);
    for (std::uint32_t pixel = 0; pixel < 4; ++pixel)
        values = elements(surface, tile, quad, pixel, {0, map_.all_elements_of(surface)}, values);
}

}  // namespace ropsim
