// The closing of a scheduler's accounts.
#include "base/error.h"
#include "memory/dram_scheduler_inline.h"
#include "memory/dram_waits_inline.h"

#include <algorithm>

namespace ropsim {

void DramScheduler::account_all(DramCycle until) {
    for (Pseudochannel& pc : pseudochannels_) account_wait<false>(pc, until);
}

void DramScheduler::finish(DramCycle end) {
    CHECK(idle(), "{} accesses still queued", present_[kReads] + present_[kWrites]);
    for (const auto& crowds : crowds_)
        CHECK(std::ranges::all_of(crowds, [](std::uint16_t count) { return count == 0; }));
    end = std::max(end, last_data());
    for (const Pseudochannel& pc : pseudochannels_) end = std::max(end, pc.labelled);
    catch_up(end);
    account<false>(end);
    statistics_.cycles = end;
    statistics_.bus_cycles = end * config_.pseudochannels;
    statistics_.rank_cycles = statistics_.bus_cycles * config_.ranks;
    statistics_.rank_active_cycles = banks_.active_cycles(end);
    statistics_.check(config_.burst_bytes(), config_.burst);
}

}  // namespace ropsim
