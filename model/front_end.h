// The front end: quads are rasterised, tested, packed into warps, shaded, and leave in raster order to the
// partition that owns their pixels.
#pragma once

#include "memory/clock_period.h"
#include "memory/event_wheel.h"
#include "model/front_end_counts.h"
#include "model/line_read.h"
#include "model/machine_config.h"
#include "model/partition_input.h"
#include "model/quad_operation.h"
#include "model/shader_cores.h"
#include "model/stage_account.h"

#include <cstdint>
#include <deque>
#include <vector>

namespace ropsim {

class ReadCache;

// Rasteriser, warps and ALUs follow by next-free-time arithmetic from what came before them; events stand
// where quads leave, because there they meet the partitions' back-pressure, and where a warp waits for a
// place or for data. Raster order is kept within a partition, which is where it can be seen; a partition that
// stalls holds back the others only through the window and the warps that its quads fill.
class FrontEnd {
 public:
    // `depth_bytes`: of one quad's depths of the opaque layer.
    FrontEnd(EventWheel& wheel, const MachineConfig& config, BatchSource& source,
             std::uint64_t depth_bytes = 0);
    // Before simulation starts.
    void connect(std::vector<PartitionInput*> partitions);
    // Depth units by partition, numbered from 0, and texture caches by core, numbered on; none where the
    // frame has nothing for them. `texture_surface`: of the map.
    void connect_caches(std::vector<ReadCache*> depth_units, std::vector<ReadCache*> texture_caches,
                        int texture_surface);

    Picoseconds step(Picoseconds now);
    // A partition's input queue has room again.
    void partition_free(int partition);
    // Quads keep their place in the window, and warps theirs in a core, until quad_done(), and a pass starts
    // when the one before has left: for what goes on in the shader. Before simulation starts.
    void hold_until_done() { holds_ = true; }
    void quad_done(std::uint32_t warp);
    // The first job of a depth unit or a texture cache is answered at `time`.
    void reads_known(int unit, Picoseconds time);

    std::uint64_t exported() const { return exported_; }
    const FrontEndCounts& counts() const { return counts_; }
    // Quads between launch and export.
    std::uint32_t quads_in_window() const { return in_window_; }
    const StageAccount& account() const { return account_; }
    StageAccount& account() { return account_; }
    StageAccount& rasteriser_account() { return rasteriser_; }
    ShaderCores& cores() { return cores_; }
    const ShaderCores& cores() const { return cores_; }

 private:
    static constexpr std::uint32_t kNoWarp = ~0u;
    struct Rastered {
        QuadBatch* batch;
        std::uint32_t quad;
        std::uint64_t time;  // fractions
    };
    struct Launched {
        QuadBatch* batch;
        std::uint32_t quad;
        std::uint32_t warp;  // or kNoWarp: it may leave as soon as it is first
    };
    // Quads of one partition in the window, in raster order: a ring that grows to what the scene needs.
    struct Lane {
        std::vector<Launched> ring;
        std::size_t places = 0;  // of the ring: none, or a power of two
        std::size_t head = 0;
        std::size_t count = 0;

        const Launched& front() const { return ring[head]; }
        void push(const Launched& launched) {
            if (count == places) [[unlikely]]
                grow();
            ring[(head + count) & (places - 1)] = launched;
            ++count;
        }
        void pop() {
            head = (head + 1) & (places - 1);
            --count;
        }
        void grow();
    };
    struct Warp {
        Picoseconds ready = kNever;  // its quads are shaded
        std::uint32_t left = 0;      // quads not yet exported
        std::uint32_t core = 0;
    };
    // A warp that is being filled.
    struct Packer {
        OpenWarp open;
        std::uint32_t warp = kNoWarp;
        std::uint64_t deadline = 0;    // fractions
        ByteSource source;             // its first quad's
        std::vector<LineRead> texels;  // that its quads fetch
    };
    // Packed, and waiting for a place in a core.
    struct Closed {
        std::uint32_t warp;
        std::uint32_t instructions;
        std::uint64_t time;    // fractions
        std::uint32_t texels;  // of texture_lines_
        ByteSource source;     // for whom they are fetched
    };
    // In a core, while its texels come.
    struct Fetching {
        std::uint32_t warp;
        std::uint32_t instructions;
        std::uint64_t entered;  // fractions
    };

    bool fetch();  // a quad is at next_quad_; false at the end of the frame
    bool at_barrier();
    bool window_has_room() const { return in_window_ + held_ < config_.shader_quads_in_flight; }
    void take_in(Picoseconds now);
    void take_quad(Picoseconds now);
    void read_depths(const QuadBatch& batch, const QuadOperation& quad, Picoseconds time);
    std::uint64_t rasterise(const QuadOperation& quad, Picoseconds now);
    void finish_quad(QuadBatch& batch);
    void settle_depths(Picoseconds now);
    void pack(const Rastered& rastered, Picoseconds now);
    void open_warp(Packer& packer, const Rastered& first);
    void close_warp(Packer& packer, std::uint64_t time);
    void close_warps(Picoseconds now);
    // When a warp may leave unfilled after its time: there is a place for it, and its core's ALU has work for
    // no longer than such a time. Until then it would wait there, and here it may still be filled.
    Picoseconds core_wants() const {
        if (!closed_.empty() || !cores_.has_room()) return kNever;
        return (std::max(cores_.next_alu_free(), timeout_) - timeout_) / kTimeFraction;
    }
    void launch_warps(Picoseconds now);
    void fetch_texels(const Closed& closed, std::uint32_t core, std::uint64_t entered);
    void take_texels(Picoseconds now);
    void set_ready(std::uint32_t warp, std::uint64_t time);
    // When the first quad of a partition may leave; kNever: there is none, or its warp is not launched.
    Picoseconds head_time(std::size_t partition) const {
        const Lane& lane = lanes_[partition];
        if (lane.count == 0) return kNever;
        return lane.front().warp == kNoWarp ? 0 : warps_[lane.front().warp].ready;
    }
    void await_head(std::size_t partition, Picoseconds time);
    void take_due_heads(Picoseconds now);
    std::uint32_t export_quads(Picoseconds now);
    // A quad of this warp has left.
    void leave_warp(std::uint32_t warp) {
        if (--warps_[warp].left == 0) free_warp(warp);
    }
    void free_warp(std::uint32_t warp);
    Picoseconds next_step(Picoseconds now, std::uint32_t exported);
    Picoseconds edge(std::uint64_t time) const {  // the first ROP cycle that does not come before `time`
        return clock_.cycle_from((time + kTimeFraction - 1) / kTimeFraction) * clock_.picoseconds();
    }
    // The edge after the time that units are stepped at: where room that is made now is seen.
    Picoseconds next_edge() const { return (clock_.cycle_of(wheel_.now()) + 1) * clock_.picoseconds(); }

    EventWheel& wheel_;
    const MachineConfig& config_;
    ClockPeriod clock_;  // the ROP's
    BatchSource& source_;
    int wheel_id_;
    std::vector<PartitionInput*> partitions_;
    std::vector<Lane> lanes_;
    // By partition: its head_time() as long as that is to come; kNever where it has a bit of ready_ or
    // waiting_.
    std::vector<Picoseconds> head_ready_;
    Picoseconds next_head_ = kNever;  // the earliest of them
    std::uint64_t ready_ = 0;         // bit p: partition p's first quad may leave
    std::uint64_t waiting_ = 0;       // bit p: partition p has no room for its first quad
    std::size_t turn_ = 0;            // partition that exports first, in turns
    QuadBatch* batch_ = nullptr;
    std::size_t next_quad_ = 0;
    std::size_t batch_quads_ = 0;  // of batch_
    std::uint32_t in_window_ = 0;
    bool holds_ = false;
    std::uint32_t held_ = 0;  // exported and not done
    int pass_ = -1;           // of the quads in the window, and whether they are copies, where passes wait
    bool source_ended_ = false;
    bool told_end_ = false;
    bool follows_ = false;  // in this step: where a quad left, the next one may leave, too
    // Fractions.
    std::uint64_t quad_time_;
    std::uint64_t tile_time_;
    std::uint64_t timeout_;
    std::uint64_t raster_free_ = 0;
    std::uint64_t tiles_free_ = 0;
    std::uint64_t last_packed_ = 0;
    WarpPacking packing_;
    std::vector<Packer> packers_;
    std::uint64_t first_deadline_ = 0;  // fractions; no open warp has an earlier one
    std::deque<Closed> closed_;
    std::vector<ReadCache*> depth_units_;
    std::deque<Rastered> order_;  // from the first on whose depth is not known
    std::vector<ReadCache*> texture_caches_;
    int texture_surface_ = -1;
    std::deque<LineRead> texture_lines_;          // of the closed warps
    std::vector<std::deque<Fetching>> fetching_;  // by core
    std::vector<std::uint32_t> answered_;         // cores whose first job has an answer or will
    std::vector<Warp> warps_;
    std::vector<std::uint32_t> free_warps_;
    bool place_freed_ = false;  // in this step
    ShaderCores cores_;
    std::uint64_t exported_ = 0;
    std::uint64_t depth_bytes_;
    FrontEndCounts counts_;
    StageLabel label_ = StageLabel::kIdle;         // of the cycles until the next step
    StageLabel raster_label_ = StageLabel::kIdle;  // of the rasteriser's cycles without a quad
    StageAccount account_;
    StageAccount rasteriser_;
};

}  // namespace ropsim
