// The loads, stores and atomics of a partition's critical sections: one request a cycle to the L2 slice.
#include "memory/sector_runs.h"
#include "model/interlock_cost.h"
#include "model/interlock_partition.h"

#include <algorithm>

namespace ropsim {

void InterlockPartition::queue_requests(std::uint32_t number, State state, std::uint64_t cycle) {
    Slot& slot = slots_[number];
    slot.state = state;
    slot.line = 0;
    slot.sectors = 0;
    slot.outstanding = 0;
    slot.moved = false;
    if (state != State::kTrying) label(slot, cycle, StageLabel::kRequestQueue);
    if (!more_requests(slot)) return requests_done(number, cycle);
    queue_[(queue_head_ + queue_count_) % queue_.size()] = number;
    ++queue_count_;
}

// Whether the slot has a request to make; its line and sectors are the next one's.
bool InterlockPartition::more_requests(Slot& slot) const {
    if (slot.state == State::kTrying || slot.state == State::kUnlocking) return !slot.moved;
    const QuadOperation& q = operation(slot);
    const LineAccess* lines = slot.batch->lines[q.partition].data() + q.first_line;
    for (; slot.sectors == 0 && slot.line < q.line_count; ++slot.line) {
        const LineAccess& access = lines[slot.line];
        slot.sectors = slot.state == State::kLoading ? access.read_sectors : access.write_sectors;
        if (slot.sectors != 0) return true;
    }
    return slot.sectors != 0;
}

void InterlockPartition::send(std::uint64_t cycle) {
    if (queue_count_ == 0 || send_free_ > cycle) return;
    port_account_.charge(cycle, port_blocked_ ? StageLabel::kMemoryFull : StageLabel::kIdle);
    port_blocked_ = !port.can_issue();
    if (port_blocked_) return;
    const std::uint32_t number = queue_[queue_head_];
    Slot& slot = slots_[number];
    issue(number);
    send_free_ = cycle + 1;
    port_account_.charge(send_free_, StageLabel::kBusy);
    last_cycle_ = std::max(last_cycle_, send_free_);
    if (more_requests(slot)) return;
    queue_head_ = (queue_head_ + 1) % static_cast<std::uint32_t>(queue_.size());
    --queue_count_;
    if (slot.state == State::kLoading) label(slot, cycle, StageLabel::kFill);
    if (slot.state == State::kStoring) label(slot, cycle, StageLabel::kStores);
    if (slot.outstanding == 0) requests_done(number, cycle);
}

// The next run of the slot's sectors, or its lock.
void InterlockPartition::issue(std::uint32_t number) {
    Slot& slot = slots_[number];
    const QuadOperation& q = operation(slot);
    MemoryRequest request;
    LineMask enables;
    if (slot.state == State::kTrying || slot.state == State::kUnlocking) {
        request = lock_request(q, map_, slot.state == State::kUnlocking);
        tries_ += request.write ? 0 : 1;
    } else {
        const LineAccess& access = slot.batch->lines[q.partition][q.first_line + slot.line];
        const std::uint32_t sector_bytes = config_.cache.sector_bytes;
        const SectorRun run = take_run(slot.sectors);
        request.address = access.line_address + std::uint64_t{run.first} * sector_bytes;
        request.bytes = run.length * sector_bytes;
        request.surface = access.surface;
        request.write = slot.state == State::kStoring;
        request.cause = request.write ? MemoryCause::kWriteBack : cause_of(q.kind);
        if (request.write) {
            enables = access.write_bytes.part(run.first * sector_bytes, request.bytes);
            request.masked = enables.count() < request.bytes;
            if (request.masked) request.enables = &enables;
        }
        if (slot.sectors == 0) ++slot.line;
    }
    slot.moved = true;
    count(request, slot);
    const std::uint32_t flight = free_flights_.back();
    free_flights_.pop_back();
    flights_[flight] = {number, request.surface, wheel_.now()};
    request.id = flight;
    ++slot.outstanding;
    if (!port.issue(request)) return;
    free_flights_.push_back(flight);
    --slot.outstanding;
}

void InterlockPartition::count(const MemoryRequest& request, const Slot& slot) {
    CauseBytes& bytes = bytes_[request.surface][static_cast<std::size_t>(request.cause)];
    (request.write ? bytes.write : bytes.read) += request.bytes;
    breakdown_.add(slot.batch->source(operation(slot)), request.bytes, request.write);
}

void InterlockPartition::memory_done(std::uint32_t id, bool write) {
    const std::uint64_t cycle = (wheel_.now() + config_.rop_period_ps - 1) / config_.rop_period_ps;
    last_cycle_ = std::max(last_cycle_, cycle);
    const Flight flight = flights_[id];
    free_flights_.push_back(id);
    if (!write) read_latency_[flight.surface].add(wheel_.now() - flight.asked);
    Slot& slot = slots_[flight.slot];
    // The last answer, unless requests are still to be made.
    if (--slot.outstanding == 0 && !more_requests(slot)) requests_done(flight.slot, cycle);
    wheel_.arm(wheel_id_, cycle * config_.rop_period_ps);
}

void InterlockPartition::memory_port_free() {
    const std::uint64_t cycle = (wheel_.now() + config_.rop_period_ps - 1) / config_.rop_period_ps;
    wheel_.arm(wheel_id_, cycle * config_.rop_period_ps);
}

}  // namespace ropsim
