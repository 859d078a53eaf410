// What a request needs to enter the scheduler: its accesses, no hazard between reads and writes, room.
#include "base/error.h"
#include "memory/dram_scheduler.h"

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

// Whether the queues have entries for all accesses of the request.
inline bool DramScheduler::has_room(const DramRequest& request, std::size_t count) {
    const Direction direction = request.write ? kWrites : kReads;
    if (count == 1 || queues_.size() == 1) return fits(queues_of(piece(0).bank), direction, count);
    for (Queues& queues : queues_) {
        std::size_t needed = 0;
        for (std::size_t i = 0; i < count; ++i) needed += &queues_of(piece(i).bank) == &queues ? 1 : 0;
        if (needed != 0 && !fits(queues, direction, needed)) return false;
    }
    return true;
}

// Sets piece `i` to the bytes from `from` to `to`, which one entry holds. Field by field: a copy would wait
// for the narrow stores.
inline void DramScheduler::set_piece(std::size_t i, const DramRequest& request, std::uint64_t from,
                                     std::uint64_t to) {
    const std::uint64_t in_burst = (std::uint64_t{1} << burst_shift_) - 1;
    const DramPlace place = map_.place(from);
    Access& access = piece(i);
    access.row = place.row;
    access.column = place.column;
    access.left = static_cast<std::uint32_t>(((to - 1) >> burst_shift_) - (from >> burst_shift_) + 1);
    access.number = request.number;
    access.bank = static_cast<std::uint8_t>(place.bank);
    access.write = request.write;
    access.whole = request.write && !request.masked && ((from | to) & in_burst) == 0;
    access.activated = access.precharged = access.hurried = false;
    access.queued = true;
}

// Fills piece()s with the accesses that make up a request; their number.
inline std::size_t DramScheduler::split(const DramRequest& request) {
    const std::uint64_t end = request.address + request.bytes;
    if (request.address >> entry_shift_ != (end - 1) >> entry_shift_) return split_up(request);
    set_piece(0, request, request.address, end);
    return 1;
}

// ... where one entry does not hold it.
std::size_t DramScheduler::split_up(const DramRequest& request) {
    const std::uint64_t end = request.address + request.bytes;
    std::uint64_t from = request.address;
    std::size_t count = 0;
    while (from < end) {
        const std::uint64_t to = std::min(end, ((from >> entry_shift_) + 1) << entry_shift_);
        CHECK(count < kMaxPieces, "a request of {} bytes", request.bytes);
        set_piece(count++, request, from, to);
        from = to;
    }
    return count;
}

bool DramScheduler::push(const DramRequest& request, DramCycle arrival, DramCycle now) {
    if (idle()) catch_up(now);
    account(now);
    full_reads_ = nullptr;
    const bool admitted = admit(request, arrival, now);
    if (idle()) return admitted;
    bool turned = false;
    for (Queues& queues : queues_) turned |= update_direction(queues, now);
    if (!admitted && !turned) return false;
    plan(now, first_time());
    return admitted;
}

bool DramScheduler::admit(const DramRequest& request, DramCycle arrival, DramCycle now) {
    const std::size_t count = split(request);
    if (present_[request.write ? kReads : kWrites] != 0) {
        std::size_t covered = 0;
        bool conflict = false;
        for (std::size_t i = 0; i < count; ++i) {
            const Overlap found = overlap(piece(i));
            covered += found == Overlap::kCovered ? 1 : 0;
            conflict |= found != Overlap::kNone;
        }
        if (covered == count) {
            count_request(request, 0, request.bytes);
            statistics_.read_latency.add(now + config_.forward_cycles - arrival);
            finished_.push_back({request.number, now + config_.forward_cycles});
            return true;
        }
        if (conflict) return false;
    }
    if (request.write && config_.merge_writes && present_[kWrites] != 0 && merge(count)) {
        count_request(request, 0, request.bytes);
        return true;
    }
    if (!has_room(request, count)) return false;
    std::uint64_t bursts = 0;
    for (std::size_t i = 0; i < count; ++i) {
        Access& access = piece(0);
        access.arrival = arrival;
        access.ready = now + config_.front_cycles;
        bursts += access.left;
        enqueue(now);
    }
    if (!request.write) pieces_left_[request.number] = static_cast<std::uint32_t>(count);
    count_request(request, bursts, 0);
    return true;
}

// Visits the accesses of one direction in the bank of `access`, wherever they wait.
template <class Visit>
void DramScheduler::for_each_of(const Access& access, Direction direction, Visit visit) {
    for (std::uint16_t slot = lists_[mixed_ ? 0 : direction][access.bank].head; slot != kNone;
         slot = access_[slot].after)
        if (access_[slot].write == (direction == kWrites)) visit(access_[slot]);
    if (config_.bank_queue == 0) return;
    for (std::uint16_t slot = queues_of(access.bank).waiting[direction].head; slot != kNone;
         slot = access_[slot].after)
        if (access_[slot].bank == access.bank) visit(access_[slot]);
}

// How bytes of `access` relate to queued accesses of the other direction; writes that stand in a read's way
// without holding it whole are hurried.
DramScheduler::Overlap DramScheduler::find_overlap(const Access& access) {
    bool any = false, covered = false, partial = false;
    const auto overlaps = [&](const Access& other) {
        return other.row == access.row && other.column < access.column + access.left &&
               access.column < other.column + other.left;
    };
    for_each_of(access, access.write ? kReads : kWrites, [&](const Access& other) {
        if (!overlaps(other)) return;
        any = true;
        const bool around =
            other.column <= access.column && access.column + access.left <= other.column + other.left;
        if (!other.whole)
            partial = true;
        else if (around)
            covered = true;
    });
    if (!any) return Overlap::kNone;
    if (!access.write && covered && !partial) return Overlap::kCovered;
    if (!access.write)
        for_each_of(access, kWrites, [&](Access& other) {
            if (!overlaps(other) || other.hurried || !other.queued) return;
            other.hurried = true;
            ++queues_of(other.bank).hurried;
        });
    return Overlap::kConflict;
}

// Whether every access of a write falls into bursts that a queued write will move anyway; those then write
// its bytes, too.
bool DramScheduler::merge(std::size_t count) {
    std::array<Access*, kMaxPieces> into{};
    for (std::size_t i = 0; i < count; ++i) {
        const Access& part = piece(i);
        for_each_of(part, kWrites, [&](Access& other) {
            if (other.row == part.row && other.column <= part.column &&
                part.column + part.left <= other.column + other.left)
                into[i] = &other;
        });
        if (into[i] == nullptr) return false;
    }
    for (std::size_t i = 0; i < count; ++i)
        if (piece(i).left == into[i]->left) into[i]->whole |= piece(i).whole;
    return true;
}

}  // namespace ropsim
