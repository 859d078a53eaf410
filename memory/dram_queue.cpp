// The scheduler's queue: admission, hazards between reads and writes, retirement, and the accounting of
// cycles.
#include "base/error.h"
#include "memory/dram_scheduler.h"

#include <algorithm>
#include <bit>

namespace ropsim {

bool DramScheduler::push(const DramRequest& request, DramCycle arrival, DramCycle now) {
    if (idle()) catch_up_refreshes(now);
    account(now);
    const bool admitted = admit(request, arrival, now);
    if (idle()) return admitted;
    if (update_direction(now))
        choose(now);
    else if (!admitted)
        return false;
    plan(now);
    return admitted;
}

bool DramScheduler::admit(const DramRequest& request, DramCycle arrival, DramCycle now) {
    auto& pieces = pieces_;
    const auto count = static_cast<std::size_t>(split(request, pieces));
    const Direction direction = request.write ? kWrites : kReads;
    std::size_t covered = 0;
    std::uint64_t in_the_way = 0;
    if (count_[1 - direction] != 0)
        for (std::size_t i = 0; i < count; ++i)
            if (overlap(pieces[i], &in_the_way) == Overlap::kCovered) ++covered;
    if (covered == count) {
        count_request(request, 0, true);
        statistics_.read_latency.add(now + config_.forward_cycles - arrival);
        finished_.push_back({request.number, now + config_.forward_cycles});
        return true;
    }
    if (in_the_way != 0) {
        if (!request.write) hurried_ |= in_the_way;
        return false;
    }
    const std::uint32_t room = (request.write ? config_.write_queue : config_.read_queue) - count_[direction];
    if (count > room) {
        if (request.write) write_queue_short_ = true;
        return false;
    }
    std::uint64_t bursts = 0;
    for (std::size_t i = 0; i < count; ++i) {
        pieces[i].arrival = arrival;
        bursts += pieces[i].left;
        enqueue(pieces[i]);
        if (direction != direction_) continue;
        refresh_candidate(pieces[i].bank, now);
        reconsider(pieces[i].bank, now);
    }
    if (!request.write) pieces_left_[request.number] = static_cast<std::uint32_t>(count);
    count_request(request, bursts, false);
    return true;
}

// The accesses that make up a request.
int DramScheduler::split(const DramRequest& request, std::array<Access, kMaxSlots>& pieces) const {
    const std::uint64_t burst_bytes = config_.burst_bytes();
    const std::uint64_t end = request.address + request.bytes;
    std::uint64_t from = request.address;
    std::size_t count = 0;
    while (from < end) {
        const std::uint64_t block_end = (from / map_.contiguous_bytes() + 1) * map_.contiguous_bytes();
        const std::uint64_t to = std::min(end, block_end);
        const DramPlace place = map_.place(from);
        CHECK(count < pieces.size(), "a request of {} bytes", request.bytes);
        Access& piece = pieces[count++];
        piece = Access{};
        piece.row = place.row;
        piece.column = place.column;
        piece.left = static_cast<std::uint32_t>((to - 1) / burst_bytes - from / burst_bytes + 1);
        piece.number = request.number;
        piece.bank = static_cast<std::uint8_t>(place.bank);
        piece.write = request.write;
        piece.whole = request.write && !request.masked && from % burst_bytes == 0 && to % burst_bytes == 0;
        from = to;
    }
    return static_cast<int>(count);
}

DramScheduler::Overlap DramScheduler::overlap(const Access& access, std::uint64_t* in_the_way) const {
    std::uint64_t overlapping = 0;
    bool covered = false;
    bool partial = false;
    for (std::uint64_t slots = bank_slots_[access.write ? kReads : kWrites][access.bank]; slots != 0;
         slots &= slots - 1) {
        const int slot = std::countr_zero(slots);
        const Access& other = access_[static_cast<std::size_t>(slot)];
        if (other.row != access.row || other.column >= access.column + access.left ||
            access.column >= other.column + other.left)
            continue;
        overlapping |= std::uint64_t{1} << slot;
        const bool around =
            other.column <= access.column && access.column + access.left <= other.column + other.left;
        if (!other.whole)
            partial = true;
        else if (around)
            covered = true;
    }
    *in_the_way |= overlapping;
    if (overlapping == 0) return Overlap::kNone;
    return !access.write && covered && !partial ? Overlap::kCovered : Overlap::kConflict;
}

void DramScheduler::enqueue(const Access& access) {
    if (next_age_ >> kAgeBits != 0) renumber();
    const Direction direction = access.write ? kWrites : kReads;
    const std::uint32_t first = access.write ? config_.read_queue : 0;
    const int slot = std::countr_zero(~used_ >> first) + static_cast<int>(first);
    CHECK(slot < kMaxSlots);
    const std::uint64_t bit = std::uint64_t{1} << slot;
    Access& entry = access_[static_cast<std::size_t>(slot)];
    entry = access;
    entry.age = next_age_++;
    used_ |= bit;
    bank_slots_[direction][access.bank] |= bit;
    ++count_[direction];
}

// Ages are 31 bits: start over from the oldest entry.
void DramScheduler::renumber() {
    std::uint32_t oldest = next_age_;
    for (std::uint64_t slots = used_; slots != 0; slots &= slots - 1)
        oldest = std::min(oldest, access_[static_cast<std::size_t>(std::countr_zero(slots))].age);
    for (std::uint64_t slots = used_; slots != 0; slots &= slots - 1)
        access_[static_cast<std::size_t>(std::countr_zero(slots))].age -= oldest;
    next_age_ -= oldest;
    const std::uint64_t shift = std::uint64_t{oldest} << kBankBits;
    for (std::uint32_t bank = 0; bank < bank_count_; ++bank)
        if (candidate_[bank].time != kNoCycle) candidate_[bank].order -= shift;
    if (best_time_ != kNoCycle) best_order_ -= shift;
}

void DramScheduler::count_request(const DramRequest& request, std::uint64_t bursts, bool forwarded) {
    auto& clients = request.write ? statistics_.write : statistics_.read;
    DramBytes& bytes = clients[request.surface][static_cast<std::size_t>(request.cause)];
    ++(request.write ? statistics_.writes : statistics_.reads);
    bytes.useful += request.bytes;
    bytes.bus += bursts * config_.burst_bytes();
    if (!forwarded) return;
    bytes.forwarded += request.bytes;
    ++statistics_.forwarded_reads;
}

// An access whose last burst was just issued leaves the queue.
void DramScheduler::retire(std::uint8_t slot, DramCycle now) {
    const Access& access = access_[slot];
    const std::uint64_t bit = std::uint64_t{1} << slot;
    const Direction direction = access.write ? kWrites : kReads;
    used_ &= ~bit;
    hurried_ &= ~bit;
    bank_slots_[direction][access.bank] &= ~bit;
    --count_[direction];
    if (batch_ != 0) --batch_;
    ++retired_;
    if (!access.activated) ++statistics_.row_hits;
    if (access.write) return;
    if (count_[kReads] == 0) reads_gone_ = now;
    if (--pieces_left_[access.number] != 0) return;
    finished_.push_back({access.number, last_data_});
    statistics_.read_latency.add(last_data_ - access.arrival);
}

// Labels all cycles before `until`.
void DramScheduler::account(DramCycle until) {
    if (until <= accounted_) return;
    const DramCycle span = until - accounted_;
    statistics_.read_queue_sum += span * count_[kReads];
    statistics_.write_queue_sum += span * count_[kWrites];
    if (accounted_ < slot_end_) {
        const DramCycle data_until = std::min(until, slot_end_);
        statistics_.label_cycles[static_cast<std::size_t>(slot_label_)] += data_until - accounted_;
        accounted_ = data_until;
    }
    statistics_.label_cycles[static_cast<std::size_t>(reason_)] += until - accounted_;
    accounted_ = until;
}

void DramScheduler::finish(DramCycle end) {
    CHECK(idle(), "{} accesses still queued", count_[kReads] + count_[kWrites]);
    end = std::max({end, last_data_, accounted_});
    catch_up_refreshes(end);
    account(end);
    statistics_.cycles = accounted_;
    statistics_.check(config_.burst_bytes(), config_.burst);
}

}  // namespace ropsim
