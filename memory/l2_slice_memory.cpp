// The memory side of a slice: its requests, their answers, and the flush at the end of the frame.
#include "base/error.h"
#include "memory/l2_slice.h"
#include "memory/sector_runs.h"

#include <algorithm>
#include <bit>

namespace ropsim {

void L2Slice::queue_requests(std::uint64_t line_address, std::uint32_t sectors, const MemoryRequest& common) {
    for_each_run(line_address, sectors, config_.cache.sector_bytes, common, nullptr,
                 [this](const MemoryRequest& request) {
                     PortBytes& bytes =
                         statistics_.memory[request.surface][static_cast<std::size_t>(request.cause)];
                     (request.write ? bytes.write : bytes.read) += request.bytes;
                     CHECK(request_count_ < requests_.size());
                     requests_[(request_head_ + request_count_) % requests_.size()] = request;
                     ++request_count_;
                 });
}

void L2Slice::queue_write(const Eviction& eviction, MemoryCause cause) {
    if (eviction.sectors == 0) return;
    queue_requests(eviction.line_address, eviction.sectors,
                   write_back_request(eviction, config_.cache.sector_bytes, cause));
}

// One a cycle.
bool L2Slice::send_request(std::uint64_t cycle) {
    if (request_count_ == 0 || request_free_ > cycle || !port.can_issue()) return false;
    const MemoryRequest request = requests_[request_head_];
    request_head_ = (request_head_ + 1) % static_cast<std::uint32_t>(requests_.size());
    --request_count_;
    request_free_ = cycle + 1;
    last_cycle_ = std::max(last_cycle_, request_free_);
    port.issue(request);
    return true;
}

void L2Slice::memory_done(std::uint32_t id, bool write) {
    const std::uint64_t cycle = cycle_at(wheel_.now());
    last_cycle_ = std::max(last_cycle_, cycle);
    if (write) return;
    const auto mshr = static_cast<int>(id >> kFillRegisterShift);
    const std::uint32_t sectors = fill_sectors(id);
    cache_.fill(mshrs_[mshr].cache_line, sectors);
    for (std::uint64_t woken = mshrs_.arrive(mshr, sectors); woken != 0; woken &= woken - 1) {
        const auto read = static_cast<std::uint32_t>(std::countr_zero(woken));
        // One that is still being looked up is complete with its last line.
        if (--reads_[read].misses == 0 && static_cast<int>(read) != current_) complete(read, cycle);
    }
    if (answer_count_ != 0) wheel_.arm(wheel_id_, std::max(answers_[answer_head_].cycle, cycle) * period_);
    // A request that waits for anything may have been waiting for this line.
    if (label_ != L2Label::kIdle) wheel_.arm(wheel_id_, cycle * period_);
}

void L2Slice::memory_port_free() {
    wheel_.arm(wheel_id_, cycle_at(wheel_.now()) * period_);
}

void L2Slice::end_of_frame() {
    frame_ended_ = true;
    wheel_.arm(wheel_id_, wheel_.now());
}

bool L2Slice::flushing() const {
    return config_.flush && frame_ended_ && input_count_ == 0 && held_.empty() &&
           free_reads_.size() == reads_.size() && flush_line_ < cache_.line_count();
}

// The end of the frame: one dirty line a cycle.
void L2Slice::flush_line(std::uint64_t cycle) {
    if (!flushing() || flush_free_ > cycle || request_room() < worst_requests_) return;
    const int line = cache_.next_dirty(flush_line_);
    if (line == RopCache::kMiss) {
        flush_line_ = cache_.line_count();
        return;
    }
    queue_write(cache_.clean(line), MemoryCause::kFlush);
    flush_line_ = line + 1;
    flush_free_ = cycle + 1;
    last_cycle_ = std::max(last_cycle_, flush_free_);
}

bool L2Slice::drained() const {
    return input_count_ == 0 && held_.empty() && gates_.empty() && free_reads_.size() == reads_.size() &&
           request_count_ == 0 && port.in_flight() == 0 &&
           (!config_.flush || !frame_ended_ || flush_line_ == cache_.line_count());
}

void L2Slice::finish(std::uint64_t total_cycles) {
    CHECK(drained(), "a slice stopped with {} queued, {} requests", input_count_, request_count_);
    charge(total_cycles, L2Label::kIdle);
    std::uint64_t sum = 0;
    for (const std::uint64_t c : statistics_.label_cycles) sum += c;
    CHECK(sum == total_cycles && labelled_ == total_cycles, "labels sum to {}, the slice ran {} of {} cycles",
          sum, labelled_, total_cycles);
    statistics_.cycles = total_cycles;
    statistics_.cache = cache_.statistics();
}

}  // namespace ropsim
