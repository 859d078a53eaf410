// The cache lines that a quad touches, from the elements that its operations read and wrote.
#pragma once

#include "model/quad_operation.h"
#include "model/surface_map.h"
#include "rop/pixel.h"

#include <cstdint>
#include <vector>

namespace ropsim {

// Collects the lines a quad touches, merging accesses to one line.
class LineCollector {
 public:
    LineCollector(const SurfaceMap& map, const MachineConfig& config)
        : map_(map), line_bytes_(config.cache.line_bytes), sector_bytes_(config.cache.sector_bytes) {}

    // Starts a quad whose lines are appended to those of `partition` in the batch.
    void begin(QuadBatch& batch, int partition) {
        lines_ = &batch.lines[static_cast<std::size_t>(partition)];
        values_ = &batch.values[static_cast<std::size_t>(partition)];
        first_ = lines_->size();
    }
    std::uint32_t count() const { return static_cast<std::uint32_t>(lines_->size() - first_); }
    void read(int surface, std::uint64_t address, std::uint32_t bytes) { add(surface, address, bytes); }
    // `values`: the bytes written, where the surface needs_values().
    void write(int surface, std::uint64_t address, std::uint32_t bytes, const std::uint8_t* values);
    // All elements of a quad's four pixels. `values`: of one pixel after the other.
    void read_quad(int surface, std::size_t tile, std::uint32_t quad);
    void write_quad(int surface, std::size_t tile, std::uint32_t quad, const std::uint8_t* values);
    // The elements in the masks of one pixel. `values`: of the written ones, one behind the other; returns
    // what is behind them.
    const std::uint8_t* elements(int surface, std::size_t tile, std::uint32_t quad, std::uint32_t pixel,
                                 const SurfaceAccess& access, const std::uint8_t* values);

 private:
    void add(int surface, std::uint64_t address, std::uint32_t bytes);
    // Calls visit(address, bytes) for each piece that the elements of the mask lie in.
    template <class Visit>
    void for_pieces(int surface, std::size_t tile, std::uint32_t quad, std::uint32_t pixel,
                    std::uint64_t mask, Visit visit);
    LineAccess& line(int surface, std::uint64_t line_address);

    const SurfaceMap& map_;
    std::uint32_t line_bytes_;
    std::uint32_t sector_bytes_;
    std::vector<LineAccess>* lines_ = nullptr;
    std::vector<std::uint8_t>* values_ = nullptr;
    std::size_t first_ = 0;
};

}  // namespace ropsim
