// The scheduler's queues: places in lists, the way to the banks, retirement.
#include "base/error.h"
#include "memory/dram_scheduler.h"

#include <algorithm>

namespace ropsim {

inline void DramScheduler::append(List& list, std::uint16_t slot) {
    access_[slot].before = list.tail;
    access_[slot].after = kNone;
    (list.tail == kNone ? list.head : access_[list.tail].after) = slot;
    list.tail = slot;
}

inline void DramScheduler::remove(List& list, std::uint16_t slot) {
    const Access& access = access_[slot];
    (access.before == kNone ? list.head : access_[access.before].after) = access.after;
    (access.after == kNone ? list.tail : access_[access.after].before) = access.before;
}

template <bool kUsual>
void DramScheduler::enqueue(const Part& part, const DramRequest& request, DramCycle arrival, DramCycle now) {
    if (next_age_ >> kAgeBits != 0) [[unlikely]]
        renumber();
    CHECK(!free_slots_.empty());
    const std::uint16_t slot = free_slots_.back();
    free_slots_.pop_back();
    Access& access = access_[slot];
    access.arrival = arrival;
    access.ready = now + config_.front_cycles;
    access.age = next_age_++;
    access.row = part.row;
    access.column = part.column;
    access.left = part.bursts;
    access.number = request.number;
    access.bank = part.bank;
    access.write = request.write;
    access.whole = part.whole;
    access.activated = access.precharged = access.hurried = false;
    access.queued = true;
    const Direction direction = request.write ? kWrites : kReads;
    Queues& queues = queues_of<kUsual>(part.bank);
    ++queues.count[direction];
    ++present_[direction];
    (request.write ? statistics_.write_queue_sum : statistics_.read_queue_sum) -= now;
    Pseudochannel& pc = channel_of<kUsual>(part.bank);
    ++pc.present;
    if (!kUsual && config_.bank_queue != 0) return append(queues.waiting[direction], slot);
    List& list = list_of<kUsual>(access);
    const bool alone = list.head == kNone;
    append(list, slot);
    if ((kUsual || !mixed_) && direction != queues.direction) return;
    // A younger access changes nothing but where the bank had no hit or no access at all.
    if (!alone && (part.row != banks_.open_row(part.bank) ||
                   (pc.lanes[request.write ? kWriteLane : kReadLane] >> part.bank & 1) != 0))
        return;
    refresh_candidate<kUsual>(part.bank, now);
    reconsider<kUsual>(pc, part.bank, now);
}

template void DramScheduler::enqueue<true>(const Part&, const DramRequest&, DramCycle, DramCycle);
template void DramScheduler::enqueue<false>(const Part&, const DramRequest&, DramCycle, DramCycle);

// Ages are 31 bits: start over from the oldest entry.
void DramScheduler::renumber() {
    std::uint32_t oldest = next_age_;
    const auto each = [&](auto visit) {
        for (auto& lists : lists_)
            for (List& list : lists)
                for (std::uint16_t s = list.head; s != kNone; s = access_[s].after) visit(access_[s]);
        for (Queues& queues : queues_)
            for (List& list : queues.waiting)
                for (std::uint16_t s = list.head; s != kNone; s = access_[s].after) visit(access_[s]);
    };
    each([&](const Access& access) { oldest = std::min(oldest, access.age); });
    each([&](Access& access) { access.age -= oldest; });
    next_age_ -= oldest;
    const std::uint64_t shift = std::uint64_t{oldest} << kAgeShift;
    for (Pseudochannel& pc : pseudochannels_) {
        for (std::size_t lane = 0; lane < kLanes; ++lane)
            for (std::uint32_t bank = 0; bank < config_.banks(); ++bank)
                if ((pc.lanes[lane] >> bank & 1) != 0 && candidate_[bank][lane].slot != kNone)
                    keys_[lane].order[bank] -= shift;
        for (Best& best : pc.best)
            if (best.time != kNoCycle && best.lane != kRefreshLane)
                best.order = keys_[best.lane].order_of(best.bank);
    }
}

// The oldest access of the present direction whose bank's own queue has room.
std::uint16_t DramScheduler::movable(const Queues& queues) const {
    const bool either = config_.write_drain == DramWriteDrain::kNone;
    std::uint16_t oldest = kNone;
    for (const Direction direction : {kReads, kWrites}) {
        if (!either && direction != queues.direction) continue;
        for (std::uint16_t slot = queues.waiting[direction].head; slot != kNone; slot = access_[slot].after) {
            if (bank_fill_[access_[slot].bank] >= config_.bank_queue) continue;
            if (oldest == kNone || access_[slot].age < access_[oldest].age) oldest = slot;
            break;
        }
    }
    return oldest;
}

// Moves an access into its bank's queue; its first command may follow a cycle later.
void DramScheduler::move(Queues& queues, std::uint16_t slot, DramCycle now) {
    Access& access = access_[slot];
    remove(queues.waiting[access.write], slot);
    append(list_of<false>(access), slot);
    ++bank_fill_[access.bank];
    access.ready = std::max(access.ready, now + 1);
    queues.last_move = now;
    leave_queue<false>(access, now);
    refresh_candidate<false>(access.bank, now);
    choose_all(pseudochannels_[pseudochannel_of(access.bank)], now);
    update_direction(queues, now);
}

// Frees the access' entry.
template <bool kUsual>
inline void DramScheduler::leave_queue(Access& access, DramCycle now) {
    Queues& queues = queues_of<kUsual>(access.bank);
    access.queued = false;
    if (access.hurried) --queues.hurried;
    if (--queues.count[access.write ? kWrites : kReads] == 0 && !access.write) queues.reads_gone = now;
    if (queues.batch != 0) --queues.batch;
    if (full_reads_ == nullptr || (full_reads_ == &queues && !access.write)) ++chances_;
}

template void DramScheduler::leave_queue<false>(Access&, DramCycle);

// An access whose last burst was just issued leaves the channel.
template <bool kUsual>
void DramScheduler::retire(std::uint16_t slot, DramCycle now) {
    Access& access = access_[slot];
    if (kUsual || access.queued)
        leave_queue<kUsual>(access, now);
    else
        ++chances_;
    if (!kUsual && config_.bank_queue != 0) --bank_fill_[access.bank];
    if (!kUsual && promoted_[access.bank] == slot) promoted_[access.bank] = kNone;
    remove(list_of<kUsual>(access), slot);
    free_slots_.push_back(slot);
    --present_[access.write ? kWrites : kReads];
    (access.write ? statistics_.write_queue_sum : statistics_.read_queue_sum) += now;
    --channel_of<kUsual>(access.bank).present;
    if (!access.activated) ++statistics_.row_hits;
    if (access.write || --pieces_left_[access.number] != 0) return;
    const DramCycle done = now + config_.read_cycles() + config_.back_cycles;
    finished_.push_back({access.number, done});
    statistics_.read_latency.add(done - access.arrival);
}

template void DramScheduler::retire<true>(std::uint16_t, DramCycle);
template void DramScheduler::retire<false>(std::uint16_t, DramCycle);

}  // namespace ropsim
