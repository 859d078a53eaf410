// The unit of work the timed and the cached machine share: one quad's framebuffer operations with the memory
// it touches.
#pragma once

#include "memory/memory_cause.h"
#include "memory/rop_cache.h"

#include <cstdint>
#include <vector>

namespace ropsim {

// One cache line of a partition's memory that a quad reads or writes.
struct LineAccess {
    std::uint64_t line_address = 0;    // in the partition's own address space
    std::uint32_t read_sectors = 0;    // sectors that must be here before the operation
    std::uint32_t write_sectors = 0;   // those with bytes that it writes
    std::uint32_t values = kNoValues;  // where the line's bytes stand in the batch's values of the partition
    std::uint8_t surface = 0;          // SurfaceMap's number
    LineMask write_bytes;              // bytes the operation writes

    static constexpr std::uint32_t kNoValues = ~0u;
};

enum class QuadKind : std::uint8_t {
    kDraw,     // fragments, operated
    kCulled,   // depth-tested only: every fragment lies behind the opaque layer
    kCopy,     // a line of a surface initialised from the opaque layer, of a tile loaded or stored, of bins
    kResolve,  // pixels of a touched tile
};

// Why a quad of this kind reads memory.
constexpr MemoryCause cause_of(QuadKind kind) {
    return kind == QuadKind::kCopy      ? MemoryCause::kCopy
           : kind == QuadKind::kResolve ? MemoryCause::kResolve
                                        : MemoryCause::kFill;
}

// What the opaque layer's depth ranges say of a quad's fragments, a bit for each answer
// (QuadOperation::depth).
inline constexpr std::uint8_t kDepthBehind = 1;     // behind the whole tile: not drawn
inline constexpr std::uint8_t kDepthInFront = 2;    // before the whole tile
inline constexpr std::uint8_t kDepthUndecided = 4;  // the depth must be read

// For whom bytes are moved.
struct ByteSource {
    static constexpr std::uint32_t kNoTile = ~0u;
    static constexpr std::uint16_t kNoDraw = 0xFFFF;
    std::uint32_t tile = kNoTile;  // at its pass's resolution
    std::uint16_t draw = kNoDraw;  // of the trace
    std::uint8_t pass = 0;         // of Frame::pass_names()
    std::uint8_t scale = 1;        // `tile` counts tiles at a resolution lower by this factor
};

struct QuadOperation {
    std::uint32_t quad_id = 0;     // tile * 16 + quad: the pixel interlock's key
    std::uint32_t first_line = 0;  // in the batch's lines of `partition`
    std::uint32_t line_count = 0;
    std::uint32_t interval = 0;            // cycles the operation units are taken
    std::uint32_t latency = 0;             // cycles from issue to the write
    std::uint32_t shader_lane_cycles = 0;  // ALU lane cycles of the quad's shading, helper lanes included
    std::uint8_t partition = 0;
    QuadKind kind = QuadKind::kDraw;
    std::uint8_t pixels = 0;  // bit p: pixel p of the quad is operated on
    std::uint8_t scale = 1;   // quad_id counts quads at a resolution lower by this factor
    std::uint16_t draw = ByteSource::kNoDraw;
    std::uint8_t pass = kBatchPass;    // of Frame::pass_names()
    std::uint8_t depth = 0;            // bits of its fragments' depth tests; 0: none is tested
    std::uint8_t depth_lines = 0;      // lines before first_line that the depth unit reads
    std::uint8_t covered = 0;          // bit p: pixel p has a fragment, seen or not
    bool new_tile = false;             // the rasteriser has gone to this tile of the primitive for it
    std::uint8_t texture_fetches = 0;  // of each fragment
    std::uint16_t fetch_bytes = 0;     // of each of them

    static constexpr std::uint8_t kBatchPass = 0xFF;  // the batch's

    // Its depth must be read.
    bool depth_tested() const { return (depth & kDepthUndecided) != 0; }
    // Every fragment is known to be behind without a read.
    bool rejected() const { return depth == kDepthBehind; }
    // Has a shader: of a copy or resolve only where shaders execute it.
    bool is_shaded() const {
        return kind == QuadKind::kDraw || kind == QuadKind::kCulled || shader_lane_cycles != 0;
    }
};

// A stretch of quads in raster order. Lines are kept by partition, in order of the partition's quads.
struct QuadBatch {
    std::vector<QuadOperation> quads;
    std::vector<std::vector<LineAccess>> lines;
    // A line's bytes for each line with some to write, those written set; of surfaces that are compressed.
    std::vector<std::vector<std::uint8_t>> values;
    std::uint64_t unfinished = 0;  // quads not yet written by their partition (timed machine)
    std::uint8_t pass = 0;         // of its quads that do not say; of Frame::pass_names()
    bool by_tile = false;          // raster order holds within a partition's tiles alone

    std::uint8_t pass_of(const QuadOperation& q) const {
        return q.pass == QuadOperation::kBatchPass ? pass : q.pass;
    }
    ByteSource source(const QuadOperation& q) const { return {q.quad_id / 16, q.draw, pass_of(q), q.scale}; }
    void clear() {
        quads.clear();
        for (auto& l : lines) l.clear();
        for (auto& v : values) v.clear();
        unfinished = 0;
        by_tile = false;
    }
};

// Hands out the frame's batches one after the other; nullptr at the end. A batch stays valid until released.
class BatchSource {
 public:
    virtual ~BatchSource() = default;
    virtual QuadBatch* next() = 0;
    virtual void release(QuadBatch* batch) = 0;
};

}  // namespace ropsim
