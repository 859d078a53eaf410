// Warps: packed in raster order, launched where a core has a place, shaded when their texels are here.
#include "model/front_end.h"
#include "model/read_cache.h"
#include "model/texture_lines.h"

#include <algorithm>
#include <utility>

namespace ropsim {

// In raster order: into the warp that is being filled, or, without shading, straight to its lane.
void FrontEnd::pack(const Rastered& rastered, Picoseconds now) {
    const QuadBatch& batch = *rastered.batch;
    const QuadOperation& quad = batch.quads[rastered.quad];
    Lane& lane = lanes_[quad.partition];
    Packer& packer = packers_[WarpPacking::warp_of(quad, batch)];
    std::uint32_t warp = kNoWarp;
    if (quad.is_shaded()) {
        last_packed_ = std::max(last_packed_, rastered.time);
        const std::uint8_t pass = batch.pass_of(quad);
        const std::size_t tile = packing_.tile_of(quad, batch);
        if (packer.open.quads > 0) {
            if (!packer.open.takes(quad, pass, tile))
                close_warp(packer, last_packed_);
            else if (last_packed_ > packer.deadline && core_wants() <= now)
                close_warp(packer, packer.deadline);
        }
        if (packer.open.quads == 0) open_warp(packer, rastered);
        warp = packer.warp;
        packer.open.add(quad, pass, tile);
        counts_.shade(quad);
        if (quad.texture_fetches != 0 && texture_surface_ >= 0)
            for_texture_lines(config_, texture_surface_, quad,
                              [&](const LineRead& read) { packer.texels.push_back(read); });
    } else if (packer.open.quads > 0 && WarpPacking::ends_warp(quad, batch)) {
        close_warp(packer, last_packed_);
    }
    lane.push({rastered.batch, rastered.quad, warp});
    if (lane.count == 1) await_head(quad.partition, head_time(quad.partition));
    if (packer.open.quads == config_.front.shader.warp_quads) close_warp(packer, last_packed_);
}

void FrontEnd::open_warp(Packer& packer, const Rastered& first) {
    if (free_warps_.empty()) {
        free_warps_.push_back(static_cast<std::uint32_t>(warps_.size()));
        warps_.emplace_back();
    }
    packer.warp = free_warps_.back();
    free_warps_.pop_back();
    warps_[packer.warp].ready = kNever;
    packer.deadline = last_packed_ + timeout_;
    first_deadline_ = std::min(first_deadline_, packer.deadline);
    packer.source = first.batch->source(first.batch->quads[first.quad]);
}

void FrontEnd::close_warp(Packer& packer, std::uint64_t time) {
    ++counts_.warps;
    counts_.warp_quad_places += config_.front.shader.warp_quads;
    warps_[packer.warp] = {kNever, packer.open.quads, 0};
    closed_.push_back({packer.warp, packer.open.instructions, time,
                       static_cast<std::uint32_t>(packer.texels.size()), packer.source});
    texture_lines_.insert(texture_lines_.end(), packer.texels.begin(), packer.texels.end());
    packer.texels.clear();
    packer.open = {};
}

// Those that have waited long enough and are wanted, or that nothing more can come to.
void FrontEnd::close_warps(Picoseconds now) {
    const bool last = source_ended_ && order_.empty();
    first_deadline_ = ~std::uint64_t{0};
    for (Packer& packer : packers_) {
        if (packer.open.quads == 0) continue;
        if (last)
            close_warp(packer, last_packed_);
        else if (packer.deadline <= now * kTimeFraction && core_wants() <= now)
            close_warp(packer, packer.deadline);
        else
            first_deadline_ = std::min(first_deadline_, packer.deadline);
    }
}

void FrontEnd::launch_warps(Picoseconds now) {
    for (; !closed_.empty() && cores_.has_room(); closed_.pop_front()) {
        const Closed& closed = closed_.front();
        Warp& warp = warps_[closed.warp];
        warp.core = cores_.enter();
        const std::uint64_t entered = std::max(closed.time, now * kTimeFraction);
        if (closed.texels != 0)
            fetch_texels(closed, warp.core, entered);
        else
            set_ready(closed.warp, cores_.shade(warp.core, entered, entered, closed.instructions));
    }
}

void FrontEnd::fetch_texels(const Closed& closed, std::uint32_t core, std::uint64_t entered) {
    for (std::uint32_t l = 0; l < closed.texels; ++l) {
        texture_caches_[core]->add_line(texture_lines_.front());
        texture_lines_.pop_front();
    }
    texture_caches_[core]->push(closed.source, entered / kTimeFraction);
    fetching_[core].push_back({closed.warp, closed.instructions, entered});
}

// Warps whose texels are here take their core's ALU.
void FrontEnd::take_texels(Picoseconds now) {
    for (std::size_t i = 0; i < answered_.size();) {
        const std::uint32_t core = answered_[i];
        ReadCache& cache = *texture_caches_[core];
        for (Picoseconds known = cache.first_known(); known <= now; known = cache.first_known()) {
            const Fetching& first = fetching_[core].front();
            const std::uint64_t time = std::max(known * kTimeFraction, first.entered);
            set_ready(first.warp, cores_.shade(core, first.entered, time, first.instructions));
            fetching_[core].pop_front();
            cache.take();
        }
        if (cache.first_known() != kNever) {
            ++i;
        } else {
            answered_[i] = answered_.back();
            answered_.pop_back();
        }
    }
}

void FrontEnd::set_ready(std::uint32_t warp, std::uint64_t time) {
    warps_[warp].ready = time / kTimeFraction;
    for (std::size_t p = 0; p < lanes_.size(); ++p)
        if (lanes_[p].count > 0 && lanes_[p].front().warp == warp) await_head(p, warps_[warp].ready);
}

}  // namespace ropsim
