// The order in which operations came to each pixel of a machine that does not keep the trace's, and the
// trace's fragments in that order.
#pragma once

#include "model/frame.h"
#include "rop/declaration.h"
#include "traces/depth_test.h"
#include "traces/trace.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace ropsim {

// Keeps a word an operation: about 4 bytes for each fragment of the trace and pass.
class InterlockOrder {
 public:
    using Ordinals = std::array<std::uint32_t, 4>;

    // `tile_fragments`: TraceReader's. `passes`: numbers of Frame::pass_names().
    InterlockOrder(const std::vector<std::uint64_t>& tile_fragments, std::size_t passes);

    // A quad's fragments arrive in raster order: their numbers among those of their pixels (bits of `pixels`)
    // in this pass.
    Ordinals arrive(std::uint8_t pass, std::uint32_t quad_id, std::uint32_t pixels);
    // They operate now, before `overtaken` earlier ones of the same pixels.
    void operate(std::uint8_t pass, std::uint32_t quad_id, std::uint32_t pixels, const Ordinals& ordinals,
                 std::uint64_t overtaken);

    // Pairs of operations on a pixel that came in the other order than the trace's.
    std::uint64_t inversions() const { return inversions_; }

    // An operation: its pixel in the tile (quad * 4 + pixel of it) and its number there.
    struct Operation {
        std::uint32_t pixel : 6;
        std::uint32_t ordinal : 26;
    };
    std::span<const Operation> operations(std::uint8_t pass, std::size_t tile) const;

 private:
    struct OfPass {
        std::vector<Operation> operations;   // tile by tile
        std::vector<std::uint32_t> used;     // by tile
        std::vector<std::uint32_t> arrived;  // by tile and pixel
    };
    OfPass& of_pass(std::uint8_t pass);

    std::vector<std::uint64_t> first_;  // by tile, of its operations
    std::vector<OfPass> passes_;        // empty where nothing has operated
    std::uint64_t inversions_ = 0;
};

// Why a technique cannot be run again in the machine's order; empty if it can.
std::string no_replay(const Declaration& declaration);

// The trace's fragments, each pass in its own order, some tiles after the other: memory does not grow with
// the trace.
class InterlockReplay : public FragmentSource {
 public:
    // All must outlive it; the trace is rewound and its selection of tiles changed.
    InterlockReplay(TraceReader& trace, const Declaration& declaration, const InterlockOrder& order)
        : trace_(trace), declaration_(declaration), order_(order), depth_test_(trace.header()) {}

    bool next(FragmentChunk& chunk, unsigned wanted, std::uint8_t pass) override;

 private:
    static constexpr std::uint64_t kFragments = 1 << 21;  // at a time, or one tile's
    void read_tiles(std::size_t first, std::size_t last, unsigned wanted, FragmentChunk& chunk);
    void reorder(std::size_t first, std::size_t last, std::uint8_t pass, FragmentChunk& chunk) const;
    bool operated(const FragmentChunk& chunk, std::size_t i) const;
    std::size_t pixel_of(const Fragment& f) const;

    TraceReader& trace_;
    const Declaration& declaration_;
    const InterlockOrder& order_;
    OpaqueDepthTest depth_test_;
    std::size_t next_tile_ = 0;
};

}  // namespace ropsim
