// The cache lines that a quad touches, from the elements that its operations read and wrote.
#pragma once

#include "model/quad_operation.h"
#include "model/surface_map.h"
#include "rop/pixel.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace ropsim {

// Collects the lines a quad touches, merging accesses to one line.
class LineCollector {
 public:
    LineCollector(const SurfaceMap& map, const MachineConfig& config);

    // Starts a quad whose lines are appended to those of `partition` in the batch. `in_memory`: also those of
    // surfaces that operations find on chip.
    void begin(QuadBatch& batch, int partition, bool in_memory = false) {
        lines_ = &batch.lines[static_cast<std::size_t>(partition)];
        values_ = &batch.values[static_cast<std::size_t>(partition)];
        first_ = lines_->size();
        count_ = 0;
        touched_ = 0;
        on_chip_read_ = on_chip_written_ = 0;
        in_memory_ = in_memory;
    }
    // The quad's first line among those of its partition, and how many it has.
    std::uint32_t first() const { return static_cast<std::uint32_t>(first_); }
    std::uint32_t count() const { return count_; }
    // Of a surface that is on chip nothing is collected but the bytes.
    void read(int surface, std::uint64_t address, std::uint32_t bytes) {
        if (on_chip(surface))
            on_chip_read_ += bytes;
        else
            touch<true, false>(surface, address, bytes);
    }
    // `values`: the bytes written, where the surface needs_values().
    void write(int surface, std::uint64_t address, std::uint32_t bytes, const std::uint8_t* values) {
        if (on_chip(surface))
            on_chip_written_ += bytes;
        else
            put(surface, address, bytes, values);
    }
    // Cycles that the quad's bytes take through the ports of tile memory, one each way.
    std::uint32_t on_chip_cycles() const {
        const std::uint32_t bytes = std::max(on_chip_read_, on_chip_written_);
        return bytes == 0 ? 0 : (bytes + tile_bytes_per_cycle_ - 1) / tile_bytes_per_cycle_;
    }
    // All elements of a quad's four pixels. `values`: of one pixel after the other.
    void read_quad(int surface, std::size_t tile, std::uint32_t quad);
    void write_quad(int surface, std::size_t tile, std::uint32_t quad, const std::uint8_t* values);
    // The elements in the masks of one pixel. `values`: of the written ones, one behind the other; returns
    // what is behind them.
    const std::uint8_t* elements(int surface, std::size_t tile, std::uint32_t quad, std::uint32_t pixel,
                                 const SurfaceAccess& access, const std::uint8_t* values) {
        if ((access.read | access.write) == 0) return values;
        const Shape& shape = shapes_[static_cast<std::size_t>(surface)];
        if (shape.pieces.empty()) return piece_by_piece(surface, tile, quad, pixel, access, values);
        const std::uint64_t address = shape.first_address +
                                      std::uint64_t{map_.number_in_partition(tile)} * shape.tile_bytes +
                                      std::uint64_t{map_.place_in_tile(quad, pixel)} * shape.pixel_stride;
        const std::uint64_t offset = address & (line_bytes_ - 1);
        const std::uint64_t sector = offset >> sector_shift_;
        const Pieces written = shape.pieces[access.write];
        const std::uint32_t read = shape.pieces[access.read].sectors << sector;
        LineAccess& l = line(surface, address - offset);
        l.read_sectors |= read;
        l.write_sectors |= written.sectors << sector;
        l.write_bytes.word[offset / 64] |= written.bytes << offset % 64;
        return values;
    }

 private:
    bool on_chip(int surface) const {
        return shapes_[static_cast<std::size_t>(surface)].on_chip && !in_memory_;
    }
    void count_on_chip(int surface, const SurfaceAccess& access);
    void put(int surface, std::uint64_t address, std::uint32_t bytes, const std::uint8_t* values);
    // Where some of a pixel's elements lie, from the pixel's first byte on and from that byte's sector on.
    struct Pieces {
        std::uint64_t bytes = 0;
        std::uint32_t sectors = 0;
    };
    // What of the map is asked for each access.
    struct Shape {
        std::uint32_t element_bytes = 0;
        bool planar = false;
        bool pool = false;
        bool keeps_values = false;
        bool whole_quads = false;
        bool on_chip = false;
        std::uint64_t first_address = 0;
        std::uint64_t tile_bytes = 0;
        std::uint32_t pixel_stride = 0;
        // By mask of elements, where a pixel's bytes are few and in one line, and nobody asks for their
        // values.
        std::vector<Pieces> pieces = {};
    };
    void add_pieces(Shape& shape, std::uint32_t pixel_bytes) const;
    const std::uint8_t* piece_by_piece(int surface, std::size_t tile, std::uint32_t quad, std::uint32_t pixel,
                                       const SurfaceAccess& access, const std::uint8_t* values);
    // Marks bytes as read, written or both.
    template <bool kReads, bool kWrites>
    void touch(int surface, std::uint64_t address, std::uint32_t bytes);
    // Calls visit(address, bytes) for each piece that the elements of the mask, of a pixel whose first
    // element is at `first`, lie in.
    template <class Visit>
    void for_pieces(int surface, std::uint64_t first, std::uint64_t mask, Visit visit);
    LineAccess& line(int surface, std::uint64_t line_address) {
        if ((touched_ >> surface & 1u) == 0) return add_line(surface, line_address);
        // Mostly the one that the pixel before has touched.
        LineAccess& last = (*lines_)[first_ + last_[static_cast<std::size_t>(surface)]];
        return last.line_address == line_address ? last : find_line(surface, line_address);
    }
    // Of bytes of a line; `bytes` > 0.
    std::uint32_t sectors_of(std::uint32_t offset, std::uint32_t bytes) const {
        const std::uint32_t first = offset >> sector_shift_;
        const std::uint32_t last = (offset + bytes - 1) >> sector_shift_;
        return ((2u << (last - first)) - 1u) << first;
    }
    LineAccess& find_line(int surface, std::uint64_t line_address);
    LineAccess& add_line(int surface, std::uint64_t line_address) {
        touched_ |= 1u << surface;
        last_[static_cast<std::size_t>(surface)] = count_++;
        LineAccess& added = lines_->emplace_back();
        added.line_address = line_address;
        added.surface = static_cast<std::uint8_t>(surface);
        return added;
    }

    const SurfaceMap& map_;
    std::vector<Shape> shapes_;                       // by surface
    std::array<std::uint32_t, kMaxSurfaces> last_{};  // by surface: the quad's line of it touched last
    std::uint32_t line_bytes_;
    std::uint32_t sector_shift_;
    std::uint32_t tile_bytes_per_cycle_;
    std::uint32_t on_chip_read_ = 0;  // bytes of the quad
    std::uint32_t on_chip_written_ = 0;
    bool in_memory_ = false;
    std::vector<LineAccess>* lines_ = nullptr;
    std::vector<std::uint8_t>* values_ = nullptr;
    std::size_t first_ = 0;
    std::uint32_t count_ = 0;    // lines of this quad
    std::uint32_t touched_ = 0;  // surfaces with a line of this quad
};

}  // namespace ropsim
