// What a request needs to enter the scheduler: its accesses, no hazard between reads and writes, room.
#include "base/error.h"
#include "memory/dram_scheduler_inline.h"
#include "memory/dram_waits_inline.h"

#include <algorithm>

namespace ropsim {

// Whether a pair of queues has entries for so many more accesses.
inline bool DramScheduler::fits(Queues& queues, Direction direction, std::size_t entries) {
    const std::uint32_t room = direction == kWrites ? config_.write_queue : config_.read_queue;
    if (queues.count[direction] + entries <= room) return true;
    if (direction == kWrites)
        queues.write_queue_short = true;
    else if (present_[kWrites] == 0)
        full_reads_ = &queues;  // with writes about, whoever asks again also turns the bus
    return false;
}

// Whether the queues have entries for all parts of a request.
template <bool kUsual, class Parts>
inline bool DramScheduler::has_room(const Parts& parts, Direction direction) {
    if (kUsual || parts.size() == 1 || queues_.size() == 1)
        return fits(queues_of<kUsual>(parts[0].bank), direction, parts.size());
    for (Queues& queues : queues_) {
        std::size_t needed = 0;
        for (const Part& part : parts) needed += &queues_of<kUsual>(part.bank) == &queues ? 1 : 0;
        if (needed != 0 && !fits(queues, direction, needed)) return false;
    }
    return true;
}

// The bytes from `from` to `to`, which one entry holds.
inline DramScheduler::Part DramScheduler::part_of(const DramRequest& request, std::uint64_t from,
                                                  std::uint64_t to) const {
    const std::uint64_t in_burst = (std::uint64_t{1} << burst_shift_) - 1;
    const DramPlace place = map_.place(from);
    return {place.row,
            place.column,
            static_cast<std::uint32_t>(((to - 1) >> burst_shift_) - (from >> burst_shift_) + 1),
            static_cast<std::uint8_t>(place.bank),
            request.write && !request.masked && ((from | to) & in_burst) == 0,
            static_cast<std::uint16_t>((from >> entry_shift_) % kCrowds)};
}

// The parts of a request that one entry does not hold.
std::span<const DramScheduler::Part> DramScheduler::split_up(const DramRequest& request) {
    const std::uint64_t end = request.address + request.bytes;
    std::uint64_t from = request.address;
    std::size_t count = 0;
    while (from < end) {
        const std::uint64_t to = std::min(end, ((from >> entry_shift_) + 1) << entry_shift_);
        CHECK(count < kMaxParts, "a request of {} bytes", request.bytes);
        parts_[count++] = part_of(request, from, to);
        from = to;
    }
    return {parts_.data(), count};
}

// Visits the accesses of one direction in a bank, wherever they wait.
template <class Visit>
void DramScheduler::for_each_of(std::uint32_t bank, Direction direction, Visit visit) {
    for_each_in(bank_list<false>(direction, bank), [&](std::uint16_t slot) {
        if (access_[slot].write == (direction == kWrites)) visit(access_[slot]);
    });
    if (config_.bank_queue == 0) return;
    for_each_in(waiting_list(direction, queues_of<false>(bank)), [&](std::uint16_t slot) {
        if (access_[slot].bank == bank) visit(access_[slot]);
    });
}

inline bool DramScheduler::overlaps(const Access& access, const Part& part) {
    return access.row == part.row && access.column < part.column + part.bursts &&
           part.column < access.column + access.left;
}

// How bytes of a part relate to queued accesses of the other direction; writes that stand in a read's way
// without holding it whole are hurried.
DramScheduler::Overlap DramScheduler::find_overlap(const Part& part, bool write) {
    bool any = false, covered = false, partial = false;
    for_each_of(part.bank, write ? kReads : kWrites, [&](const Access& other) {
        if (!overlaps(other, part)) return;
        any = true;
        const bool around =
            other.column <= part.column && part.column + part.bursts <= other.column + other.left;
        if (!other.whole)
            partial = true;
        else if (around)
            covered = true;
    });
    if (!any) return Overlap::kNone;
    if (!write && covered && !partial) return Overlap::kCovered;
    if (!write)
        for_each_of(part.bank, kWrites, [&](Access& other) {
            if (!overlaps(other, part) || other.hurried || !other.queued) return;
            other.hurried = true;
            ++queues_of<false>(other.bank).hurried;
        });
    return Overlap::kConflict;
}

// Whether every access of a write falls into bursts that a queued write will move anyway; those then write
// its bytes, too.
bool DramScheduler::merge(std::span<const Part> parts) {
    std::array<Access*, kMaxParts> into{};
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const Part& part = parts[i];
        for_each_of(part.bank, kWrites, [&](Access& other) {
            if (other.row == part.row && other.column <= part.column &&
                part.column + part.bursts <= other.column + other.left)
                into[i] = &other;
        });
        if (into[i] == nullptr) return false;
    }
    for (std::size_t i = 0; i < parts.size(); ++i)
        if (parts[i].bursts == into[i]->left) into[i]->whole |= parts[i].whole;
    return true;
}

// Its bytes: asked for, moved, or taken along by others' bursts.
inline void DramScheduler::count_request(const DramRequest& request, std::uint64_t bursts,
                                         std::uint64_t forwarded) {
    auto& clients = request.write ? statistics_.write : statistics_.read;
    DramBytes& bytes = clients[request.surface][static_cast<std::size_t>(request.cause)];
    ++(request.write ? statistics_.writes : statistics_.reads);
    bytes.useful += request.bytes;
    bytes.bus += bursts << burst_shift_;
    bytes.forwarded += forwarded;
    if (forwarded != 0) ++(request.write ? statistics_.merged_writes : statistics_.forwarded_reads);
}

template <bool kUsual>
[[gnu::always_inline]] inline void DramScheduler::enqueue(Part part, const DramRequest& request,
                                                          DramCycle arrival, DramCycle now) {
    if (next_age_ == kEndOfAges) [[unlikely]]
        renumber();
    CHECK(!free_slots_.empty());
    const std::uint16_t slot = free_slots_.back();
    free_slots_.pop_back();
    Access& access = access_[slot];
    access.arrival = arrival;
    access.ready = now + config_.front_cycles;
    access.order = next_age_ | part.bank;
    next_age_ += kFirstAge;
    access.row = part.row;
    access.column = part.column;
    access.left = part.bursts;
    access.number = request.number;
    access.bank = part.bank;
    access.write = request.write;
    access.whole = part.whole;
    access.crowd = part.crowd;
    access.activated = access.precharged = access.hurried = false;
    access.queued = true;
    const Direction direction = request.write ? kWrites : kReads;
    Queues& queues = queues_of<kUsual>(part.bank);
    ++queues.count[direction];
    ++present_[direction];
    ++crowds_[direction][part.crowd];
    (request.write ? statistics_.write_queue_sum : statistics_.read_queue_sum) -= now;
    Pseudochannel& pc = channel_of<kUsual>(part.bank);
    ++pc.present;
    if (!kUsual && config_.bank_queue != 0) return lists_.append(waiting_list(direction, queues), slot);
    const std::size_t list = bank_list<kUsual>(direction, part.bank);
    const bool alone = lists_.empty(list);
    lists_.append(list, slot);
    if ((kUsual || !mixed_) && direction != queues.direction) return;
    // A younger access changes nothing but where the bank had no hit or no access at all.
    if (!alone && (part.row != banks_.open_row(part.bank) ||
                   has_candidate(request.write ? kWriteLane : kReadLane, part.bank)))
        return;
    if (kUsual) account<kUsual>(now);
    refresh_candidate<kUsual>(part.bank, now);
    reconsider<kUsual>(pc, part.bank, now);
    unplanned_ = true;
}

template <bool kUsual, class Parts>
[[gnu::always_inline]] inline bool DramScheduler::admit_parts(const Parts& parts, const DramRequest& request,
                                                              DramCycle arrival, DramCycle now) {
    if (present_[request.write ? kReads : kWrites] != 0) {
        std::size_t covered = 0;
        bool conflict = false;
        for (const Part& part : parts) {
            const Overlap found = overlap(part, request.write);
            covered += found == Overlap::kCovered ? 1 : 0;
            conflict |= found != Overlap::kNone;
        }
        if (covered == parts.size()) {
            count_request(request, 0, request.bytes);
            statistics_.read_latency.add(now + config_.forward_cycles - arrival);
            finished_.push_back({request.number, now + config_.forward_cycles});
            return true;
        }
        if (conflict) return false;
    }
    if (request.write && config_.merge_writes && present_[kWrites] != 0 && merge(parts)) {
        count_request(request, 0, request.bytes);
        return true;
    }
    if (!has_room<kUsual>(parts, request.write ? kWrites : kReads)) return false;
    std::uint64_t bursts = 0;
    for (const Part& part : parts) {
        bursts += part.bursts;
        enqueue<kUsual>(part, request, arrival, now);
    }
    if (!request.write) pieces_left_[request.number] = static_cast<std::uint32_t>(parts.size());
    count_request(request, bursts, 0);
    return true;
}

template <bool kUsual>
[[gnu::always_inline]] inline bool DramScheduler::admit(const DramRequest& request, DramCycle arrival,
                                                        DramCycle now) {
    // What refuses a write before and since refuses it again; whatever it overlaps, nothing else comes of it.
    if (kUsual && request.write && queues_[0].write_queue_short && !config_.merge_writes &&
        queues_[0].count[kWrites] == config_.write_queue)
        return false;
    const std::uint64_t end = request.address + request.bytes;
    if (request.address >> entry_shift_ != (end - 1) >> entry_shift_)
        return admit_parts<kUsual>(split_up(request), request, arrival, now);
    const std::array<Part, 1> part = {part_of(request, request.address, end)};
    return admit_parts<kUsual>(part, request, arrival, now);
}

template <bool kUsual>
inline bool DramScheduler::push_as(const DramRequest& request, DramCycle arrival, DramCycle now) {
    unplanned_ = idle();
    if (unplanned_) catch_up(now);
    // In the usual channel only new candidates and a turn change what is waited for, and account for it.
    if (!kUsual || unplanned_) account<kUsual>(now);
    full_reads_ = nullptr;
    const bool admitted = admit<kUsual>(request, arrival, now);
    if (idle()) return admitted;
    bool turned = false;
    if constexpr (kUsual) {
        turned = update_direction(queues_[0], now);
        // Nothing new for the next step.
        if (!unplanned_ && !queues_[0].unsettled) return admitted;
    } else {
        for (Queues& queues : queues_) turned |= update_direction(queues, now);
    }
    if (!admitted && !turned) return false;
    plan<kUsual>(now, first_time<kUsual>());
    return admitted;
}

bool DramScheduler::push(const DramRequest& request, DramCycle arrival, DramCycle now) {
    return usual_ ? push_as<true>(request, arrival, now) : push_as<false>(request, arrival, now);
}

}  // namespace ropsim
