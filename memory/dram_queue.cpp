// The scheduler's queues: ages, and the way to the banks' own.
#include "base/error.h"
#include "memory/dram_scheduler_inline.h"

#include <algorithm>

namespace ropsim {

// Ages are 31 bits: start over from the oldest entry.
void DramScheduler::renumber() {
    std::uint64_t oldest = next_age_;
    const auto each = [&](auto visit) {
        for (std::size_t list = 0; list < lists_.lists(); ++list)
            for_each_in(list, [&](std::uint16_t slot) { visit(access_[slot]); });
    };
    each([&](const Access& access) { oldest = std::min(oldest, access.order); });
    const std::uint64_t shift = oldest / kFirstAge * kFirstAge - kFirstAge;
    each([&](Access& access) { access.order -= shift; });
    next_age_ -= shift;
    for (std::size_t lane = 0; lane < kLanes; ++lane)
        for (std::uint32_t bank = 0; bank < config_.banks(); ++bank)
            if (has_candidate(lane, bank) && candidate_[lane][bank].slot != kNone)
                keys_[lane].make_older(bank, shift);
    for (Pseudochannel& pc : pseudochannels_)
        for (Best& best : pc.best)
            if (best.time != kNoCycle && best.lane() != kRefreshLane)
                best.order = keys_[best.lane()].order_of(best.bank());
}

// The oldest access of the present direction whose bank's own queue has room.
std::uint16_t DramScheduler::movable(const Queues& queues) const {
    const bool either = config_.write_drain == DramWriteDrain::kNone;
    std::uint16_t oldest = kNone;
    for (const Direction direction : {kReads, kWrites}) {
        if (!either && direction != queues.direction) continue;
        for (std::uint16_t slot = lists_.first(waiting_list(direction, queues)); !lists_.is_end(slot);
             slot = lists_.after(slot)) {
            if (bank_fill_[access_[slot].bank] >= config_.bank_queue) continue;
            if (oldest == kNone || access_[slot].order < access_[oldest].order) oldest = slot;
            break;
        }
    }
    return oldest;
}

// Moves an access into its bank's queue; its first command may follow a cycle later.
void DramScheduler::move(Queues& queues, std::uint16_t slot, DramCycle now) {
    Access& access = access_[slot];
    lists_.remove(slot);
    lists_.append(bank_list<false>(access.write ? kWrites : kReads, access.bank), slot);
    ++bank_fill_[access.bank];
    access.ready = std::max(access.ready, now + 1);
    queues.last_move = now;
    leave_queue<false>(access, access.write ? kWrites : kReads, now);
    refresh_candidate<false>(access.bank, now);
    choose_all(pseudochannels_[pseudochannel_of(access.bank)], now);
    update_direction(queues, now);
}

}  // namespace ropsim
