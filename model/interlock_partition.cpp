// A quad's way through its critical section: see interlock_partition.h.
#include "model/interlock_partition.h"

#include <algorithm>
#include <functional>

namespace ropsim {

namespace {
// More than one partition can be sent before it is done with the first of them.
std::uint32_t slot_count(const MachineConfig& config) {
    return std::min(config.shader_quads_in_flight, 1u << 16);
}
}  // namespace

InterlockPartition::InterlockPartition(const sc_core::sc_module_name& name, int number, EventWheel& wheel,
                                       const MachineConfig& config, const SurfaceMap& map,
                                       BatchSource& source, TrafficBreakdown& breakdown,
                                       InterlockOrder* order)
    : sc_core::sc_module(name),
      port("port", wheel, *this, static_cast<int>(kRequests)),
      config_(config),
      map_(map),
      wheel_(wheel),
      source_(source),
      order_(order),
      number_(number),
      wheel_id_(wheel.add(*this)),
      input_(wheel, wheel_id_, number, config),
      slots_(slot_count(config)),
      table_(slot_count(config)),
      queue_(slot_count(config)),
      flights_(kRequests),
      bytes_(static_cast<std::size_t>(map.surfaces())),
      breakdown_(breakdown),
      read_latency_(bytes_.size()) {
    for (std::size_t i = slots_.size(); i > 0; --i) free_slots_.push_back(static_cast<std::uint32_t>(i - 1));
    for (std::uint32_t i = kRequests; i > 0; --i) free_flights_.push_back(i - 1);
    granted_.reserve(slots_.size());
    timers_.reserve(slots_.size());
}

Picoseconds InterlockPartition::step(Picoseconds now) {
    const Picoseconds period = config_.rop_period_ps;
    const std::uint64_t cycle = now / period;
    if (now % period != 0) return (cycle + 1) * period;
    run_timers(cycle);
    admit(cycle);
    run_timers(cycle);
    send(cycle);
    run_timers(cycle);
    send(cycle);  // of operations that take no time
    std::uint64_t next = kNever;
    if (!timers_.empty()) next = timers_.front().cycle;
    if (!input_.empty() && !free_slots_.empty())
        next = std::min(next, std::max({input_.front().arrival, admit_free_, cycle + 1}));
    if (queue_count_ != 0 && port.can_issue()) next = std::min(next, std::max(send_free_, cycle + 1));
    if (!told_slice_ && drained()) {
        told_slice_ = true;
        slice_->end_of_frame();
    }
    return next == kNever ? kNever : next * period;
}

// The pixels that a quad's operation must have for itself. Copies and resolves follow a barrier.
std::uint32_t InterlockPartition::locked_pixels(const QuadOperation& q) const {
    if (q.kind != QuadKind::kDraw || q.pixels == 0) return 0;
    return config_.interlock.per_pixel ? q.pixels : 0xF;
}

void InterlockPartition::label(Slot& slot, std::uint64_t cycle, StageLabel next) {
    CHECK(cycle >= slot.since, "cycle {} after {}", slot.since, cycle);
    quad_cycles_[static_cast<std::size_t>(slot.label)] += cycle - slot.since;
    slot.since = cycle;
    slot.label = next;
}

void InterlockPartition::admit(std::uint64_t cycle) {
    if (input_.empty() || free_slots_.empty() || admit_free_ > cycle || input_.front().arrival > cycle)
        return;
    const QueuedQuad queued = input_.front();
    const std::uint32_t number = free_slots_.back();
    free_slots_.pop_back();
    Slot& slot = slots_[number];
    slot.batch = queued.batch;
    slot.quad = queued.quad;
    slot.warp = queued.warp;
    slot.since = cycle;
    slot.label = StageLabel::kInterlock;
    admit_free_ = cycle + 1;
    input_.pop();
    const QuadOperation& q = operation(slot);
    const std::uint32_t pixels = locked_pixels(q);
    if (pixels == 0) return queue_requests(number, State::kLoading, cycle);
    if (order_ != nullptr) slot.ordinals = order_->arrive(slot.batch->pass, q.quad_id, q.pixels);
    table_.add(number, q.quad_id, pixels);
    slot.state = State::kWaiting;
    if (spins())
        queue_requests(number, State::kTrying, cycle);
    else if (!table_.preceded(number))
        grant(number, cycle);
}

void InterlockPartition::grant(std::uint32_t number, std::uint64_t cycle) {
    if (order_ != nullptr) record_grant(number);
    table_.grant(number);
    if (spins()) return queue_requests(number, State::kLoading, cycle);
    label(slots_[number], cycle, StageLabel::kBusy);
    slots_[number].state = State::kBeginning;
    set_timer(number, cycle + config_.interlock.begin_cycles);
}

void InterlockPartition::record_grant(std::uint32_t number) {
    const Slot& slot = slots_[number];
    const QuadOperation& q = operation(slot);
    std::uint64_t overtaken = 0;
    table_.for_overtaken(number, [&](std::uint32_t other) {
        overtaken += static_cast<std::uint64_t>(
            std::popcount(static_cast<unsigned>(operation(slots_[other]).pixels & q.pixels)));
    });
    order_->operate(slot.batch->pass, q.quad_id, q.pixels, slot.ordinals, overtaken);
}

// The pixels are free; where hardware keeps the order, the next in line get them.
void InterlockPartition::release(std::uint32_t number, std::uint64_t cycle) {
    granted_.clear();
    table_.release(number, [this](std::uint32_t next) { granted_.push_back(next); });
    if (spins()) return;
    for (const std::uint32_t next : granted_) grant(next, cycle);
}

void InterlockPartition::leave(std::uint32_t number, std::uint64_t cycle) {
    Slot& slot = slots_[number];
    label(slot, cycle, StageLabel::kIdle);
    slot.state = State::kFree;
    if (--slot.batch->unfinished == 0) source_.release(slot.batch);
    slot.batch = nullptr;
    free_slots_.push_back(number);
    ++quads_done_;
    last_cycle_ = std::max(last_cycle_, cycle);
    input_.done(slot.warp);
}

void InterlockPartition::set_timer(std::uint32_t slot, std::uint64_t cycle) {
    timers_.push_back({cycle, timer_number_++, slot});
    std::ranges::push_heap(timers_, std::greater{});
}

void InterlockPartition::run_timers(std::uint64_t cycle) {
    while (!timers_.empty() && timers_.front().cycle <= cycle) {
        const std::uint32_t slot = timers_.front().slot;
        std::ranges::pop_heap(timers_, std::greater{});
        timers_.pop_back();
        timer_done(slot, cycle);
    }
}

void InterlockPartition::timer_done(std::uint32_t number, std::uint64_t cycle) {
    Slot& slot = slots_[number];
    switch (slot.state) {
        case State::kLockKnown:
            if (!table_.held(number)) return grant(number, cycle);
            ++retries_;
            slot.state = State::kBackingOff;
            return set_timer(number, cycle + config_.interlock.retry_cycles);
        case State::kBackingOff:
            return queue_requests(number, State::kTrying, cycle);
        case State::kBeginning:
            return queue_requests(number, State::kLoading, cycle);
        case State::kExecuting:
            return queue_requests(number, State::kStoring, cycle);
        case State::kEnding:
            if (spins()) return queue_requests(number, State::kUnlocking, cycle);
            release(number, cycle);
            return leave(number, cycle);
        default:
            CHECK(false, "slot {} in state {}", number, static_cast<int>(slot.state));
    }
}

// What follows when all requests of a state have been made and answered.
void InterlockPartition::requests_done(std::uint32_t number, std::uint64_t cycle) {
    Slot& slot = slots_[number];
    const std::uint64_t known = cycle + (slot.moved ? config_.interlock.memory_latency : 0);
    switch (slot.state) {
        case State::kTrying:
            slot.state = State::kLockKnown;
            return set_timer(number, known);
        case State::kLoading:
            label(slot, known, StageLabel::kBusy);
            slot.state = State::kExecuting;
            return set_timer(number, known + operation(slot).latency);
        case State::kStoring:
            return stored(number, cycle);
        case State::kUnlocking:
            release(number, cycle);
            return leave(number, cycle);
        default:
            CHECK(false, "slot {} in state {}", number, static_cast<int>(slot.state));
    }
}

// Who has nothing to give back ends with its last store; who has waits until the others can see it.
void InterlockPartition::stored(std::uint32_t number, std::uint64_t cycle) {
    Slot& slot = slots_[number];
    if (locked_pixels(operation(slot)) == 0) return leave(number, cycle);
    const std::uint64_t known = cycle + (slot.moved ? config_.interlock.memory_latency : 0);
    label(slot, known, StageLabel::kBusy);
    slot.state = State::kEnding;
    set_timer(number, known + (spins() ? 0 : config_.interlock.end_cycles));
}

bool InterlockPartition::drained() const {
    return input_.finished() && input_.empty() && free_slots_.size() == slots_.size() &&
           port.in_flight() == 0;
}

void InterlockPartition::finish(std::uint64_t total_cycles) {
    CHECK(drained() && queue_count_ == 0, "partition {} stopped with {} queued, {} quads, {} requests",
          number_, input_.size(), slots_.size() - free_slots_.size(), port.in_flight());
    port_account_.finish(total_cycles);
}

}  // namespace ropsim
