// Shader cores: warps of quads, the places that a core has for them, and its ALU.
#pragma once

#include "memory/event_wheel.h"
#include "model/machine_config.h"
#include "model/quad_operation.h"
#include "model/stage_account.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace ropsim {

// Times of the front end's arithmetic are in fractions of a picosecond, so that fast units do not round to
// nothing.
inline constexpr std::uint64_t kTimeFraction = 256;

// Quads on their way into a warp: in raster order, of one draw and pass, and of one tile where partitions
// have tiles of their own.
struct OpenWarp {
    std::uint32_t quads = 0;
    std::uint32_t instructions = 0;  // of its longest thread: the others wait for it
    std::uint16_t draw = 0;
    std::uint8_t pass = 0;
    std::size_t tile = 0;

    bool takes(const QuadOperation& q, std::uint8_t of_pass, std::size_t of_tile) const {
        return quads > 0 && draw == q.draw && pass == of_pass && tile == of_tile;
    }
    void add(const QuadOperation& q, std::uint8_t of_pass, std::size_t of_tile) {
        draw = q.draw;
        pass = of_pass;
        tile = of_tile;
        // Of a quad with fragments joined in its registers some lanes work longer.
        instructions = std::max(instructions, (q.shader_lane_cycles + 3) / 4);
        ++quads;
    }
};

// Which of the warps that are being filled a quad goes to. Where quads come tile by tile each partition fills
// one from the tile that it draws; otherwise there is one for all, since quads leave in raster order.
class WarpPacking {
 public:
    explicit WarpPacking(const MachineConfig& config) : config_(config) {}
    // Warps that are filled at the same time.
    std::size_t warps() const { return config_.tiles.tiled ? config_.partitions : 1; }
    static std::size_t warp_of(const QuadOperation& q, const QuadBatch& batch) {
        return batch.by_tile ? q.partition : 0;
    }
    std::size_t tile_of(const QuadOperation& q, const QuadBatch& batch) const {
        return batch.by_tile ? config_.tiles.tile_of(q.quad_id / 16) : 0;
    }
    // What has no shader ends the warp of its raster order; reads of bins and loads of tiles come besides.
    static bool ends_warp(const QuadOperation& q, const QuadBatch& batch) {
        return !batch.by_tile || q.kind != QuadKind::kCopy;
    }

 private:
    const MachineConfig& config_;
};

// A warp takes instructions x threads / lanes cycles of its core's ALU, full or not; warps of a core follow
// one another there by next-free-time arithmetic, while their latencies overlap.
class ShaderCores {
 public:
    explicit ShaderCores(const MachineConfig& config);

    // Whether some core has a place for a warp.
    bool has_room() const { return places_ > 0; }
    std::uint32_t in_flight() const { return places() - places_; }
    std::uint32_t places() const { return shader_.cores * shader_.warps; }
    // When the ALU of the core whose place is taken next has done all its work, in fractions. Some core has
    // room.
    std::uint64_t next_alu_free() const { return cores_[next_core()].alu_free; }
    // Takes a place: of the next core in turn that has one.
    std::uint32_t enter();
    // Books the ALU of `core` for a warp whose operands are there at `time`; returns when it is shaded. Both
    // in fractions.
    std::uint64_t shade(std::uint32_t core, std::uint64_t entered, std::uint64_t time,
                        std::uint32_t instructions);
    // All quads of a warp have left.
    void leave(std::uint32_t core);

    // Of all cores, to be called once, at the end.
    StageAccount finish(std::uint64_t total_cycles);
    // Share of the lanes' time that warps took.
    double utilisation(Picoseconds total) const;

 private:
    struct Core {
        std::uint32_t warps = 0;
        bool was_full = false;       // since its ALU was last booked
        std::uint64_t alu_free = 0;  // fractions
        StageAccount account;
    };
    std::uint32_t next_core() const;
    std::uint64_t cycle(std::uint64_t time) const { return time / (kTimeFraction * rop_period_); }

    ShaderCoreConfig shader_;
    std::uint64_t rop_period_;
    std::uint64_t latency_;           // fractions
    std::uint64_t instruction_time_;  // fractions x lanes of all cores, of one instruction of a warp
    std::uint64_t lanes_;
    std::uint32_t places_;
    std::uint32_t turn_ = 0;
    std::uint64_t busy_ = 0;  // fractions, of all cores
    std::vector<Core> cores_;
};

}  // namespace ropsim
