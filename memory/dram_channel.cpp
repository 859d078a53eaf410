// The TLM side of a DRAM channel: admission, responses, blocking access.
#include "memory/dram_channel.h"

#include "base/error.h"
#include "memory/request_tag.h"

#include <algorithm>

namespace ropsim {

DramChannel::DramChannel(const sc_core::sc_module_name& name, EventWheel& wheel, const DramConfig& config)
    : sc_core::sc_module(name),
      socket("socket"),
      clock_(config.tck_ps),
      tck_(config.tck_ps),
      service_(std::min(config.read_cycles() + config.back_cycles, config.write_cycles()) * tck_),
      wheel_(wheel),
      wheel_id_(wheel.add(*this)),
      reads_(config.max_reads()),
      responses_(128),
      config_(config),
      scheduler_(config) {
    socket.register_nb_transport_fw(this, &DramChannel::forward);
    socket.register_b_transport(this, &DramChannel::blocking);
    for (std::uint32_t i = config.max_reads(); i > 0; --i) free_reads_.push_back(i - 1);
}

// False: it is held back, until there is room or `moment` has come.
[[gnu::always_inline]] inline bool DramChannel::queue_or_hold(const Owner& owner, DramRequest& request,
                                                              Picoseconds moment) {
    const bool now = moment <= wheel_.now() && !held_.due(moment);
    const DramCycle cycle = cycle_at(moment);
    if (now) run(cycle);
    const bool queued = now && try_queue(owner, request, cycle, cycle);
    if (!queued) {
        held_.hold({owner, request}, moment);
        if (now) run_ahead();
    }
    rearm();
    return queued;
}

// A read gets a number.
inline bool DramChannel::try_queue(const Owner& owner, DramRequest& request, DramCycle arrival,
                                   DramCycle now) {
    if (!request.write) {
        if (free_reads_.empty()) {
            scheduler_.expect_any_chance();
            return false;
        }
        request.number = free_reads_.back();
    }
    if (!scheduler_.push(request, arrival, now)) return false;
    if (request.write) return true;
    free_reads_.pop_back();
    reads_[request.number] = owner;
    collect_finished();
    return true;
}

tlm::tlm_sync_enum DramChannel::forward(int initiator, tlm::tlm_generic_payload& payload,
                                        tlm::tlm_phase& phase, sc_core::sc_time& delay) {
    ++wheel_.inside_calls().forward;
    const Picoseconds moment = wheel_.local_moment(delay);
    if (phase == tlm::END_RESP) {
        gates_.end_response(initiator);
        wheel_.arm(wheel_id_, std::max(moment, wheel_.now()));
        return tlm::TLM_COMPLETED;
    }
    CHECK(phase == tlm::BEGIN_REQ, "phase {}", phase.get_name());
    const auto number = static_cast<std::uint32_t>(initiator);
    CHECK(
        !held_.any([&](const Waiting& w) { return w.owner.payload != nullptr && w.owner.number == number; }),
        "a second request before END_REQ");
    if (refuse(payload)) return tlm::TLM_COMPLETED;
    payload.acquire();
    DramRequest request = request_of(payload);
    if (!queue_or_hold({&payload, nullptr, number}, request, moment)) return tlm::TLM_ACCEPTED;
    if (payload.is_write()) {
        payload.set_response_status(tlm::TLM_OK_RESPONSE);
        payload.release();
        return tlm::TLM_COMPLETED;
    }
    phase = tlm::END_REQ;
    return tlm::TLM_UPDATED;
}

LinkedMemory::Answer DramChannel::request(LinkedPort& from, const MemoryRequest& request) {
    const std::uint64_t capacity = scheduler_.capacity();
    CHECK(request.bytes != 0 && request.address < capacity && capacity - request.address >= request.bytes,
          "{} bytes at {:#x}", request.bytes, request.address);
    DramRequest asked{
        request.address, request.bytes, request.write, request.masked, request.surface, request.cause, 0};
    if (!queue_or_hold({nullptr, &from, request.id}, asked, wheel_.now())) return Answer::kHeld;
    return request.write ? Answer::kDone : Answer::kQueued;
}

// Sets an error response on a request that this channel cannot serve.
bool DramChannel::refuse(tlm::tlm_generic_payload& payload) const {
    const std::uint64_t address = payload.get_address();
    const unsigned int bytes = payload.get_data_length();
    if (payload.is_read() == payload.is_write())
        payload.set_response_status(tlm::TLM_COMMAND_ERROR_RESPONSE);
    else if (bytes == 0 || bytes > kMaxRequestBytes || payload.get_streaming_width() < bytes)
        payload.set_response_status(tlm::TLM_BURST_ERROR_RESPONSE);
    else if (address >= scheduler_.capacity() || scheduler_.capacity() - address < bytes)
        payload.set_response_status(tlm::TLM_ADDRESS_ERROR_RESPONSE);
    else
        return false;
    return true;
}

DramRequest DramChannel::request_of(const tlm::tlm_generic_payload& payload) {
    DramRequest request;
    request.address = payload.get_address();
    request.bytes = payload.get_data_length();
    request.write = payload.is_write();
    request.masked = payload.get_byte_enable_ptr() != nullptr;
    if (request.write) request.cause = MemoryCause::kWriteBack;
    if (const RequestTag* tag = payload.get_extension<RequestTag>()) {
        CHECK(tag->surface < kMaxSurfaces, "surface {}", tag->surface);
        request.surface = tag->surface;
        request.cause = tag->cause;
        request.masked |= tag->masked;
    }
    return request;
}

// The responses stay in order of time.
inline void DramChannel::take_finished() {
    for (const DramScheduler::Finished& finished : scheduler_.finished()) {
        free_reads_.push_back(finished.number);
        add_response(finished.cycle * tck_, reads_[finished.number]);
    }
    scheduler_.finished().clear();
}

inline void DramChannel::add_response(Picoseconds time, const Owner& to) {
    if (response_count_ == responses_.size()) {
        std::rotate(responses_.begin(), responses_.begin() + static_cast<std::ptrdiff_t>(response_head_),
                    responses_.end());
        response_head_ = 0;
        responses_.resize(2 * responses_.size());
    }
    const std::size_t mask = responses_.size() - 1;
    std::size_t place = response_head_ + response_count_++;
    // Only forwarded reads come out of order, and not by much.
    for (; place != response_head_ && responses_[(place - 1) & mask].time > time; --place)
        responses_[place & mask] = responses_[(place - 1) & mask];
    Response& response = responses_[place & mask];
    response.time = time;
    response.to = to;
    next_response_ = std::min(next_response_, time);
}

tlm::tlm_sync_enum DramChannel::call(int initiator, tlm::tlm_generic_payload& payload, tlm::tlm_phase phase) {
    const std::uint64_t inside = wheel_.inside_calls().backward;
    sc_core::sc_time delay = wheel_.local_delay();
    const tlm::tlm_sync_enum answer = socket[initiator]->nb_transport_bw(payload, phase, delay);
    if (wheel_.inside_calls().backward == inside) wheel_.called_outside();
    return answer;
}

// Sends a read's response; a payload's as soon as its initiator's gate is open.
inline void DramChannel::respond(const Owner& to) {
    if (to.port != nullptr) return to.port->request_done(to.number, false);
    gates_.respond(static_cast<int>(to.number), {to.payload, 0}, sender(), release);
}

void DramChannel::send_responses(Picoseconds now) {
    gates_.send_waiting(sender(), release);
    while (next_response_ <= now) {
        CHECK(now - next_response_ < tck_, "data of {} ps are sent at {} ps", next_response_, now);
        const Owner to = responses_[response_head_].to;
        response_head_ = (response_head_ + 1) & (responses_.size() - 1);
        next_response_ = --response_count_ == 0 ? kNever : responses_[response_head_].time;
        respond(to);
    }
}

// Lets time go on to when the first request that is held back finds room: each time that something has left
// that could have kept it out, it tries.
void DramChannel::run_ahead() {
    auto& first = held_.front();
    while (true) {
        const DramCycle now = scheduler_.run_to_chance();
        collect_finished();
        if (!try_queue(first.request.owner, first.request.request, cycle_at(first.from), now)) continue;
        let_in_ = now;
        return;
    }
}

// A request that was held back gets its END_REQ now that it is queued; a write is done, and its response says
// both. Those behind it try.
void DramChannel::let_in(Picoseconds now) {
    const DramCycle cycle = cycle_at(now);
    while (held_.due(now)) {
        auto& first = held_.front();
        const DramCycle arrival = cycle_at(first.from);
        // Whoever is told may send the next request in answer, which may have to wait in turn.
        if (ahead() && let_in_ > cycle) return;
        if (!ahead() && !try_queue(first.request.owner, first.request.request, arrival, cycle))
            return run_ahead();
        let_in_ = kNoCycle;
        scheduler_.count_blocked(cycle - std::max(arrival, held_since_));
        held_since_ = cycle;
        tell_taken(held_.take().request);
    }
}

inline void DramChannel::tell_taken(const Waiting& taken) {
    const Owner& owner = taken.owner;
    if (owner.port != nullptr) {
        owner.port->request_taken();
        if (taken.request.write) owner.port->request_done(owner.number, true);
    } else if (taken.request.write) {
        respond(owner);
    } else {
        call(static_cast<int>(owner.number), *owner.payload, tlm::END_REQ);
    }
}

// Of what is known already, the first time at which anybody outside can see it.
inline Picoseconds DramChannel::next_known() const {
    const Picoseconds next = next_response_;
    if (ahead()) return std::min(next, let_in_ * tck_);
    return held_.empty() ? next : std::min(next, held_.front().from);
}

// ... or something that the commands may bring.
inline Picoseconds DramChannel::next_step() const {
    const Picoseconds next = next_known();
    if (ahead()) return next;
    const DramCycle soonest = scheduler_.soonest_outcome();
    if (soonest == kNoCycle || soonest * tck_ >= next) return next;
    return std::min(next, scheduler_.next_outcome() * tck_);
}

// After a request: nothing comes of it before it can have been served.
inline void DramChannel::rearm() {
    if (armed_ <= wheel_.now() + service_ && armed_ <= next_known()) return;
    const Picoseconds next = next_step();
    if (next >= armed_) return;
    armed_ = std::max(next, wheel_.now());
    wheel_.arm(wheel_id_, armed_);
}

Picoseconds DramChannel::step(Picoseconds now) {
    settle(now + 1);
    if (next_response_ <= now || !gates_.empty()) send_responses(now);
    if (ahead() ? let_in_ * tck_ <= now : held_.due(now)) let_in(now);
    Picoseconds next = next_step();
    // The run lasts until the last data have passed.
    if (next == kNever && scheduler_.last_data() * tck_ > now) next = scheduler_.last_data() * tck_;
    armed_ = next;
    return next;
}

void DramChannel::blocking(int, tlm::tlm_generic_payload& payload, sc_core::sc_time& delay) {
    if (refuse(payload)) return;
    const Picoseconds moment = wheel_.local_moment(delay);
    const std::uint64_t first = payload.get_address() / config_.burst_bytes();
    const std::uint64_t last =
        (payload.get_address() + payload.get_data_length() - 1) / config_.burst_bytes();
    const Picoseconds occupancy = (last - first + 1) * config_.column_interval() * tck_;
    const std::uint64_t latency = payload.is_write()
                                      ? config_.activate_to_write() + config_.write_cycles() - config_.burst
                                      : config_.activate_to_read() + config_.read_cycles() - config_.burst;
    const Picoseconds start = std::max(moment, blocking_free_);
    blocking_free_ = start + occupancy;
    const Picoseconds end = start + latency * tck_ + occupancy;
    scheduler_.count_blocking_request(payload.get_data_length());
    delay += sc_core::sc_time::from_value(end - moment);
    payload.set_response_status(tlm::TLM_OK_RESPONSE);
}

bool DramChannel::empty() const {
    return scheduler_.idle() && response_count_ == 0 && gates_.empty() && held_.empty();
}

void DramChannel::finish(Picoseconds end) {
    CHECK(empty(), "{} responses pending", response_count_);
    scheduler_.finish(cycle_at(end));
}

}  // namespace ropsim
