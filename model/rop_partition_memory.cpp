// The memory side of a ROP partition: requests to its channel, their answers, and the flush at the end of the
// frame.
#include "memory/sector_runs.h"
#include "model/rop_partition.h"

#include <algorithm>
#include <bit>

namespace ropsim {

// A request for each run of neighbouring sectors. For fills the id gets the run's sectors.
void RopPartition::queue_requests(std::uint64_t line_address, std::uint32_t sectors,
                                  const MemoryRequest& common, const LineMask* enables) {
    // Only a slice keeps masks, and for longer than this call.
    for_each_run(line_address, sectors, config_.cache.sector_bytes, common,
                 slice_ != nullptr ? enables : nullptr, [this](const MemoryRequest& run) {
                     if (!run.write) asked_[run.id >> kSectorShift] = wheel_.now();
                     queue_request(run);
                 });
}

void RopPartition::queue_request(const MemoryRequest& request) {
    MissPortBytes& bytes = miss_port_[request.surface][static_cast<std::size_t>(request.cause)];
    (request.write ? bytes.write : bytes.read) += request.bytes;
    breakdown_.add(moved_for_, request.bytes, request.write);
    CHECK(request_room() != 0);
    if (config_.cache_port_bytes != 0 && request_count_ == 0)
        out_.charge(clock_.cycle_of(wheel_.now()), StageLabel::kIdle);
    requests_[request_tail_] = request;
    if (request.enables != nullptr) {
        enables_[request_tail_] = *request.enables;
        requests_[request_tail_].enables = &enables_[request_tail_];
    }
    request_tail_ = next_place(request_tail_);
    ++request_count_;
}

void RopPartition::queue_write(const Eviction& eviction, MemoryCause cause) {
    if (eviction.sectors == 0) return;
    moved_for_ = std::bit_cast<ByteSource>(eviction.writer);
    if (compressed_ != nullptr)
        queue_block(eviction, cause);
    else
        queue_sectors(eviction, cause);
}

void RopPartition::queue_sectors(const Eviction& eviction, MemoryCause cause) {
    queue_requests(eviction.line_address, eviction.sectors,
                   write_back_request(eviction, config_.cache.sector_bytes, cause), &eviction.bytes);
}

void RopPartition::send_request(std::uint64_t cycle) {
    const MemoryRequest& request = requests_[request_head_];
    request_head_ = next_place(request_head_);
    --request_count_;
    sent_ = cycle;
    request_free_ = cycle + (request.write ? config_.port_cycles(request.bytes) : 1);
    if (config_.cache_port_bytes != 0) {
        out_.charge(cycle, StageLabel::kMemoryFull);
        out_.charge(request_free_, StageLabel::kBusy);
    }
    last_cycle_ = std::max(last_cycle_, request_free_);
    port.issue(request);
}

bool RopPartition::flushing() const {
    return input_.finished() && input_.empty() && write_head_ == tag_tail_ && !tagging_ &&
           flush_line_ < cache_.line_count();
}

// The end of the frame: one dirty line a cycle.
void RopPartition::flush_line(std::uint64_t cycle) {
    if (!flushing() || flush_free_ > cycle || !can_write_back()) return;
    const int line = cache_.next_dirty(flush_line_);
    if (line == RopCache::kMiss) {
        flush_line_ = cache_.line_count();
        return;
    }
    queue_write(cache_.clean(line), MemoryCause::kFlush);
    flush_line_ = line + 1;
    flush_free_ = cycle + 1;
    last_cycle_ = std::max(last_cycle_, cycle + 1);
}

void RopPartition::memory_done(std::uint32_t id, bool write) {
    const std::uint64_t cycle = clock_.cycle_from(wheel_.now());
    last_cycle_ = std::max(last_cycle_, cycle);
    if (write) return;
    if (config_.cache_port_bytes != 0 && !through_port(id, cycle)) return;
    if (fill(id, cycle)) wheel_.arm(wheel_id_, cycle * clock_.picoseconds());
}

// Data that were on their way to the cache while they arrived are in it with their last byte; those that had
// to wait for the port follow later: false.
bool RopPartition::through_port(std::uint32_t id, std::uint64_t cycle) {
    const bool counted = (id & (kBlockFill | kLeavingRead | kStateRead)) != 0;
    const std::uint32_t bytes =
        counted ? (id & kBlockBytes) * kBlockUnit : ((id & kField) + 1) * config_.cache.sector_bytes;
    const std::uint32_t cycles = config_.port_cycles(bytes);
    fill_free_ = std::max(cycle, fill_free_ + cycles);
    in_.charge(fill_free_ - cycles, StageLabel::kIdle);
    in_.charge(fill_free_, StageLabel::kBusy);
    if (fill_free_ == cycle) return true;
    CHECK(fill_count_ < fills_.size());
    fills_[(fill_head_ + fill_count_) % fills_.size()] = {fill_free_, id};
    ++fill_count_;
    last_cycle_ = std::max(last_cycle_, fill_free_);
    wheel_.arm(wheel_id_, fill_free_ * clock_.picoseconds());
    return false;
}

void RopPartition::take_fills(std::uint64_t cycle) {
    for (; fill_count_ != 0 && fills_[fill_head_].cycle <= cycle; --fill_count_) {
        fill(fills_[fill_head_].id, fills_[fill_head_].cycle);
        fill_head_ = (fill_head_ + 1) % static_cast<std::uint32_t>(fills_.size());
    }
}

// Sectors have arrived. Returns whether something can go on that could not before.
bool RopPartition::fill(std::uint32_t id, std::uint64_t cycle) {
    if ((id & (kLeavingRead | kStateRead)) != 0) {
        if ((id & kStateRead) != 0)
            state_pending_ = false;
        else
            leaving_read_done((id & ~kLeavingRead) >> kMshrShift, cycle);
        return true;
    }
    const bool block = (id & kBlockFill) != 0;
    const int mshr = static_cast<int>((id & ~kBlockFill) >> kMshrShift);
    const std::uint32_t sectors = block ? mshrs_[mshr].outstanding : fill_sectors(id);
    const std::uint64_t ready =
        block ? cycle + decompress_latency(cache_.surface(mshrs_[mshr].cache_line)) : cycle;
    const std::uint8_t surface = cache_.surface(mshrs_[mshr].cache_line);
    const Picoseconds latency =
        wheel_.now() - asked_[block ? static_cast<std::uint32_t>(mshr) << kSectorShift : id >> kSectorShift];
    const int line = mshrs_[mshr].cache_line;
    cache_.fill(line, sectors);
    std::uint32_t woken = mshrs_.arrive(mshr, sectors);
    // Conditions are joined without branches: which holds is as good as random.
    const auto waits_for = [this](StageLabel label) {
        return static_cast<int>(tag_waits_) & static_cast<int>(tag_label_ == label);
    };
    const auto letting_go = static_cast<int>(!cache_.pinned(line));
    int complete = 0;
    for (; woken != 0; woken &= woken - 1) {
        Slot& s = slots_[static_cast<std::size_t>(std::countr_zero(woken))];
        s.awaited = ready >= s.operands_ready ? surface : s.awaited;
        s.operands_ready = std::max(s.operands_ready, ready);
        complete |= static_cast<int>(--s.fills == 0);
    }
    // The quad whose lines are being looked up may have to give them up now.
    const int gives_up = complete & static_cast<int>(tagging_) & static_cast<int>(slot(tag_tail_).fills == 0);
    ways_changed_ = (static_cast<int>(ways_changed_) | letting_go | gives_up) != 0;
    // A tag stage that waits for a miss register or a way can go on, and one that waits for a block to leave
    // where these sectors are what it wants.
    const int wakes = (waits_for(StageLabel::kMshrsFull) & static_cast<int>(!mshrs_.full())) |
                      waits_for(StageLabel::kEvictionBuffer) |
                      (waits_for(StageLabel::kCacheWays) & static_cast<int>(ways_changed_));
    const bool none_issued = write_head_ == issue_head_;
    if (complete != 0) issue_operations();
    if (none_issued && write_head_ != issue_head_ && watches_writes())
        wheel_.arm(wheel_id_, std::max(slot(write_head_).written, cycle) * clock_.picoseconds());
    read_latency_[surface].add(latency);  // far away in the host's memory, and nothing waits for it: last
    return wakes != 0;
}

void RopPartition::memory_port_free() {
    if (request_count_ == 0 && !input_.finished()) return;
    const std::uint64_t cycle = clock_.cycle_from(wheel_.now());
    wheel_.arm(wheel_id_, cycle * clock_.picoseconds());
}

}  // namespace ropsim
