#include "model/line_collector.h"

#include <algorithm>
#include <bit>

namespace ropsim {

LineAccess& LineCollector::line(int surface, std::uint64_t line_address) {
    // Accesses come nearly in order: the line is almost always the last or the one before.
    for (std::size_t i = lines_->size(); i > first_; --i)
        if ((*lines_)[i - 1].line_address == line_address) return (*lines_)[i - 1];
    LineAccess& added = lines_->emplace_back();
    added.line_address = line_address;
    added.surface = static_cast<std::uint8_t>(surface);
    return added;
}

void LineCollector::add(int surface, std::uint64_t address, std::uint32_t bytes) {
    while (bytes > 0) {
        const auto offset = static_cast<std::uint32_t>(address & (line_bytes_ - 1));
        const std::uint32_t here = std::min(bytes, line_bytes_ - offset);
        const std::uint32_t first = offset / sector_bytes_;
        const std::uint32_t last = (offset + here - 1) / sector_bytes_;
        line(surface, address - offset).read_sectors |= ((2u << (last - first)) - 1u) << first;
        address += here;
        bytes -= here;
    }
}

void LineCollector::write(int surface, std::uint64_t address, std::uint32_t bytes,
                          const std::uint8_t* values) {
    const bool keeps = map_.needs_values(surface);
    while (bytes > 0) {
        const auto offset = static_cast<std::uint32_t>(address & (line_bytes_ - 1));
        const std::uint32_t here = std::min(bytes, line_bytes_ - offset);
        LineAccess& l = line(surface, address - offset);
        const LineMask mask = LineMask::range(offset, here);
        for (std::size_t w = 0; w < mask.word.size(); ++w) l.write_bytes.word[w] |= mask.word[w];
        if (keeps) {
            if (l.values == LineAccess::kNoValues) {
                l.values = static_cast<std::uint32_t>(values_->size());
                values_->resize(values_->size() + line_bytes_);
            }
            std::copy_n(values, here, values_->begin() + static_cast<std::ptrdiff_t>(l.values + offset));
            values += here;
        }
        address += here;
        bytes -= here;
    }
}

template <class Visit>
void LineCollector::for_pieces(int surface, std::size_t tile, std::uint32_t quad, std::uint32_t pixel,
                               std::uint64_t mask, Visit visit) {
    const std::uint32_t element_bytes = map_.element_bytes(surface);
    if (map_.layout(surface) == Layout::kPlanar) {
        for (; mask != 0; mask &= mask - 1)
            visit(
                map_.address(surface, tile, quad, pixel, static_cast<std::uint32_t>(std::countr_zero(mask))),
                element_bytes);
        return;
    }
    while (mask != 0) {
        const auto first = static_cast<std::uint32_t>(std::countr_zero(mask));
        const auto length = static_cast<std::uint32_t>(std::countr_one(mask >> first));
        visit(map_.address(surface, tile, quad, pixel, first), length * element_bytes);
        mask = first + length >= 64 ? 0 : mask >> (first + length) << (first + length);
    }
}

const std::uint8_t* LineCollector::elements(int surface, std::size_t tile, std::uint32_t quad,
                                            std::uint32_t pixel, const SurfaceAccess& access,
                                            const std::uint8_t* values) {
    const auto put = [&](std::uint64_t address, std::uint32_t bytes) {
        write(surface, address, bytes, values);
        if (map_.needs_values(surface)) values += bytes;
    };
    if (map_.layout(surface) == Layout::kPool) {
        if (access.write != 0)
            put(map_.node_address(surface, static_cast<std::uint32_t>(access.write)),
                map_.element_bytes(surface));
        return values;
    }
    if (access.read != 0)
        for_pieces(surface, tile, quad, pixel, access.read,
                   [&](std::uint64_t address, std::uint32_t bytes) { add(surface, address, bytes); });
    if (access.write != 0) for_pieces(surface, tile, quad, pixel, access.write, put);
    return values;
}

void LineCollector::read_quad(int surface, std::size_t tile, std::uint32_t quad) {
    if (map_.quads_are_whole(surface)) {
        add(surface, map_.address(surface, tile, quad, 0, 0), 4 * map_.pixel_bytes(surface));
        return;
    }
    for (std::uint32_t pixel = 0; pixel < 4; ++pixel)
        elements(surface, tile, quad, pixel, {map_.all_elements_of(surface), 0}, nullptr);
}

void LineCollector::write_quad(int surface, std::size_t tile, std::uint32_t quad,
                               const std::uint8_t* values) {
    if (map_.quads_are_whole(surface)) {
        write(surface, map_.address(surface, tile, quad, 0, 0), 4 * map_.pixel_bytes(surface), values);
        return;
    }
    for (std::uint32_t pixel = 0; pixel < 4; ++pixel)
        values = elements(surface, tile, quad, pixel, {0, map_.all_elements_of(surface)}, values);
}

}  // namespace ropsim
