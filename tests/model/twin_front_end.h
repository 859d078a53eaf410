// The twin's front end: one cycle's work at every ROP cycle.
#pragma once

#include "model/frame.h"
#include "model/front_end_counts.h"
#include "model/machine_config.h"
#include "model/texture_lines.h"
#include "tests/model/twin_partition.h"
#include "tests/model/twin_reads.h"

#include <algorithm>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace ropsim {

// A window of quads, warps of them in cores, and each quad leaving for its partition in raster order of that
// partition. Times between ticks are real numbers of picoseconds.
class TwinFrontEnd {
 public:
    using Time = long double;

    TwinFrontEnd(const MachineConfig& config, Frame& frame)
        : config_(config),
          front_(config.front),
          frame_(frame),
          lanes_(config.partitions),
          cores_(config.front.shader.cores),
          fetching_(config.front.shader.cores) {}

    void tick(std::uint64_t cycle, std::vector<std::unique_ptr<TwinPartition>>& partitions) {
        const Picoseconds now = cycle * config_.rop_period_ps;
        settle_depths(now);
        while (window_ < config_.shader_quads_in_flight && fetch()) take_in(now);
        if (!open_.empty() && ended_ && order_.empty()) close_warp(last_packed_);
        if (!open_.empty() && deadline_ <= static_cast<Time>(now) && core_wants(now)) close_warp(deadline_);
        for (std::size_t c = 0; c < texture_caches.size(); ++c)
            for (; texture_caches[c]->answered(now); texture_caches[c]->take()) {
                shade(*fetching_[c].front(), now);
                fetching_[c].pop_front();
            }
        while (!closed_.empty() && enter_core(*closed_.front())) {
            Warp& warp = *closed_.front();
            const Picoseconds entered = std::max(now, static_cast<Picoseconds>(warp.closed));
            if (warp.texels.empty()) {
                shade(warp, now);
            } else {
                texture_caches[warp.core]->push(warp.texels, entered);
                fetching_[warp.core].push_back(closed_.front());
            }
            closed_.pop_front();
        }
        export_quads(cycle, partitions);
        if (!ended_ || window_ > 0) return;
        const auto rastered = static_cast<Picoseconds>(rastered_);
        end_ = std::max(end_, (rastered + config_.rop_period_ps - 1) / config_.rop_period_ps);
        if (rastered > now) return;
        for (auto& p : partitions) p->upstream_finished();
    }
    void quad_done(QuadBatch* batch) {
        if (--batch->unfinished > 0) return;
        std::erase_if(batches_, [&](const std::unique_ptr<QuadBatch>& b) {
            return b.get() == batch && b.get() != current_;
        });
    }
    std::uint64_t end() const { return end_; }

    std::vector<std::unique_ptr<TwinReadCache>> depth_units;     // by partition, where there are any
    std::vector<std::unique_ptr<TwinReadCache>> texture_caches;  // by core

 private:
    struct Warp {
        std::uint32_t quads = 0;  // then those that have not left
        std::uint32_t instructions = 0;
        Time closed = 0;
        std::size_t core = 0;
        std::optional<Picoseconds> ready;
        std::vector<LineRead> texels;
        bool empty() const { return quads == 0; }
    };
    struct Core {
        std::uint32_t warps = 0;
        Time alu_free = 0;
    };
    struct Rastered {
        QuadBatch* batch;
        std::uint32_t quad;
        Time time;
    };
    struct Shading {
        QuadBatch* batch;
        std::uint32_t quad;
        std::shared_ptr<Warp> warp;  // none: it is not shaded
    };
    bool fetch() {
        while (!ended_ && (current_ == nullptr || next_ == current_->quads.size())) {
            batches_.push_back(std::make_unique<QuadBatch>());
            current_ = batches_.back().get();
            ended_ = !frame_.advance(*current_);
            current_->unfinished = current_->quads.size();
            next_ = 0;
        }
        return !ended_;
    }
    void take_in(Picoseconds now) {
        const auto number = static_cast<std::uint32_t>(next_);
        const QuadOperation& q = current_->quads[next_++];
        Time time = static_cast<Time>(now);
        if (q.kind == QuadKind::kDraw || q.kind == QuadKind::kCulled) {
            const auto period = static_cast<Time>(config_.shader_period_ps);
            rastered_ = std::max(rastered_, time) + period / config_.raster_quads_per_cycle;
            if (q.new_tile) {
                tiled_ = std::max(tiled_, time) + period / front_.raster_tiles_per_cycle;
                rastered_ = std::max(rastered_, tiled_);
            }
            time = rastered_;
        }
        if (!reaches_partition(q) && q.depth_lines == 0) return quad_done(current_);
        ++window_;
        if (q.depth_lines != 0) {
            std::vector<LineRead> lines;
            for (std::uint32_t l = q.first_line - q.depth_lines; l < q.first_line; ++l) {
                const LineAccess& a = current_->lines[q.partition][l];
                lines.push_back({a.line_address, a.read_sectors, a.surface});
            }
            depth_units[q.partition]->push(lines, static_cast<Picoseconds>(time));
        }
        order_.push_back({current_, number, time});
        if (q.depth_lines == 0) settle_depths(now);
    }
    // In raster order, up to the first whose depth is not known.
    void settle_depths(Picoseconds now) {
        for (; !order_.empty(); order_.pop_front()) {
            const Rastered first = order_.front();
            const QuadOperation& q = first.batch->quads[first.quad];
            Time time = first.time;
            if (q.depth_lines != 0) {
                if (!depth_units[q.partition]->answered(now)) return;
                depth_units[q.partition]->take();
                time = std::max(time, static_cast<Time>(now));
            }
            if (reaches_partition(q)) {
                pack(first, q, time, now);
                continue;
            }
            --window_;
            end_ = std::max<std::uint64_t>(end_, now / config_.rop_period_ps);
            quad_done(first.batch);
        }
    }
    void pack(const Rastered& rastered, const QuadOperation& q, Time time, Picoseconds now) {
        QuadBatch* batch = rastered.batch;
        const std::uint32_t number = rastered.quad;
        if (q.kind != QuadKind::kDraw && q.kind != QuadKind::kCulled) {
            if (!open_.empty()) close_warp(last_packed_);
            lanes_[q.partition].push_back({batch, number, nullptr});
            return;
        }
        last_packed_ = std::max(last_packed_, time);
        if (!open_.empty() && (open_draw_ != q.draw || open_pass_ != batch->pass)) close_warp(last_packed_);
        if (!open_.empty() && last_packed_ > deadline_ && core_wants(now)) close_warp(deadline_);
        if (open_.empty()) {
            deadline_ =
                last_packed_ + static_cast<Time>(front_.shader.pack_timeout * config_.shader_period_ps);
            filling_ = std::make_shared<Warp>();
        }
        open_draw_ = q.draw;
        open_pass_ = batch->pass;
        for_texture_lines(config_, frame_.surfaces().textures(), q,
                          [&](const LineRead& read) { open_.texels.push_back(read); });
        open_.quads += 1;
        open_.instructions = std::max(open_.instructions, (q.shader_lane_cycles + 3) / 4);
        lanes_[q.partition].push_back({batch, number, filling_});
        if (open_.quads == front_.shader.warp_quads) close_warp(last_packed_);
    }
    void close_warp(Time time) {
        *filling_ = open_;
        filling_->closed = time;
        closed_.push_back(filling_);
        open_ = {};
    }
    // The core that is next in turn to take a warp has work for no longer than the timeout, to the
    // picosecond.
    bool core_wants(Picoseconds now) const {
        for (std::size_t i = 0; closed_.empty() && i < cores_.size(); ++i) {
            const Core& core = cores_[(core_turn_ + i) % cores_.size()];
            if (core.warps != front_.shader.warps)
                return core.alu_free <
                       static_cast<Time>(now + 1 + front_.shader.pack_timeout * config_.shader_period_ps);
        }
        return false;
    }
    // The next core in turn that has a place.
    bool enter_core(Warp& warp) {
        for (std::size_t i = 0; i < cores_.size(); ++i) {
            const std::size_t c = (core_turn_ + i) % cores_.size();
            if (cores_[c].warps == front_.shader.warps) continue;
            ++cores_[c].warps;
            warp.core = c;
            core_turn_ = (c + 1) % cores_.size();
            return true;
        }
        return false;
    }
    void shade(Warp& warp, Picoseconds now) {
        Core& core = cores_[warp.core];
        const auto period = static_cast<Time>(config_.shader_period_ps);
        const Time lanes = static_cast<Time>(config_.shader_alu_lanes) / front_.shader.cores;
        core.alu_free = std::max({core.alu_free, warp.closed, static_cast<Time>(now)}) +
                        period * warp.instructions * 4 * front_.shader.warp_quads / lanes;
        warp.ready = static_cast<Picoseconds>(core.alu_free + config_.shader_latency * period);
    }
    void export_quads(std::uint64_t cycle, std::vector<std::unique_ptr<TwinPartition>>& partitions) {
        const Picoseconds now = cycle * config_.rop_period_ps;
        std::uint32_t exported = 0;
        for (std::uint32_t i = 0; i < config_.partitions && exported < config_.export_quads_per_cycle; ++i) {
            const std::uint32_t p = (turn_ + i) % config_.partitions;
            if (lanes_[p].empty() || !partitions[p]->has_room()) continue;
            Shading& first = lanes_[p].front();
            if (first.warp && (!first.warp->ready || *first.warp->ready > now)) continue;
            partitions[p]->push(first.batch, first.quad, cycle);
            if (first.warp && --first.warp->quads == 0) --cores_[first.warp->core].warps;
            lanes_[p].pop_front();
            ++exported;
        }
        window_ -= exported;
        // Whoever had the first turn in a cycle that exported goes last in the next.
        if (exported > 0) {
            turn_ = (turn_ + 1) % config_.partitions;
            end_ = cycle + 1;
        }
    }

    const MachineConfig& config_;
    const FrontEndConfig& front_;
    Frame& frame_;
    std::vector<std::deque<Shading>> lanes_;  // by partition
    std::vector<Core> cores_;
    std::size_t core_turn_ = 0;
    std::vector<std::unique_ptr<QuadBatch>> batches_;
    QuadBatch* current_ = nullptr;
    std::size_t next_ = 0;
    bool ended_ = false;
    std::uint32_t window_ = 0;
    std::uint32_t turn_ = 0;
    Time rastered_ = 0;
    Time tiled_ = 0;
    Time last_packed_ = 0;
    Time deadline_ = 0;
    Warp open_;  // being filled
    std::uint16_t open_draw_ = 0;
    std::uint8_t open_pass_ = 0;
    std::shared_ptr<Warp> filling_;  // what it will be
    std::deque<std::shared_ptr<Warp>> closed_;
    std::deque<Rastered> order_;
    std::vector<std::deque<std::shared_ptr<Warp>>> fetching_;  // by core
    std::uint64_t end_ = 0;
};

}  // namespace ropsim
