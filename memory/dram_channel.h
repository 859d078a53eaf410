// A DRAM channel behind a TLM-2.0 socket: queues, FR-FCFS command scheduling, refresh, exact accounting.
#pragma once

#include "memory/clock_period.h"
#include "memory/dram_device.h"
#include "memory/dram_scheduler.h"
#include "memory/dram_statistics.h"
#include "memory/event_wheel.h"
#include "memory/initiators.h"
#include "memory/memory_link.h"

#include <cstdint>
#include <string>
#include <tlm>
#include <vector>

#include <tlm_utils/multi_passthrough_target_socket.h>

namespace ropsim {

// nb_transport (AT base protocol): a request is one contiguous byte range. BEGIN_REQ is answered by
// TLM_UPDATED with END_REQ when queued, by TLM_COMPLETED for a write (posted: done when queued), or by
// TLM_ACCEPTED when the queue is full, END_REQ (BEGIN_RESP for a write) following when there is room; a
// second request before that breaks the base protocol. A read's BEGIN_RESP comes when its last data do. Times
// are exact: delays are relative to the kernel's time.
//
// Any number of initiators may be bound to the socket, or linked to the channel, which is the same but for
// the payloads (memory_link.h). Requests that are held back go in order of arrival, whoever sent them; while
// one waits, none overtakes it. An initiator that withholds END_RESP delays only its own responses.
//
// b_transport is approximate: unloaded closed-row latency plus the time earlier blocking requests hold the
// data bus. It neither sees nor delays nb_transport traffic and is counted apart (blocking_*).
//
// The commands are not issued when simulated time comes to them, but before anybody can see what they did: a
// new request, a response's time, an observer that asks. A request that is held back bars all others, so
// then the commands run ahead of time up to the one that lets it in.
//
// Data pointers are not followed: this is a timing model. Addresses are the channel's own, from 0 to capacity
// - 1; others get TLM_ADDRESS_ERROR_RESPONSE.
class DramChannel : public sc_core::sc_module, public LinkedMemory {
 public:
    DramChannel(const sc_core::sc_module_name& name, EventWheel& wheel, const DramConfig& config);

    tlm_utils::multi_passthrough_target_socket<DramChannel> socket;

    const DramConfig& config() const { return config_; }
    // Closes the accounting at `end` (not before the last data) and checks it. Call once, after the
    // simulation.
    void finish(Picoseconds end);
    const DramStatistics& statistics() const { return scheduler_.statistics(); }
    // For observers: what is queued, open and drained when settle() was last called, or while a request is
    // held back when it will be let in.
    const DramScheduler& scheduler() const { return scheduler_; }
    // Issues all commands before `time`, no later than the wheel's next step.
    void settle(Picoseconds time) {
        if (!ahead()) run(cycle_at(time));
    }
    // Every command from now on is reported to `trace` (nullptr: none).
    void set_trace(DramCommandTrace* trace) { scheduler_.set_trace(trace); }
    // Nothing queued, in flight or held back.
    bool empty() const;

    Picoseconds step(Picoseconds now);
    Answer request(LinkedPort& from, const MemoryRequest& request) override;

 private:
    // Whose a request is: a payload's, acquired while the channel has it, or a linked port's.
    struct Owner {
        tlm::tlm_generic_payload* payload;
        LinkedPort* port;
        std::uint32_t number;  // the payload's initiator, or the port's id of the request
    };
    struct Waiting {
        Owner owner;
        DramRequest request;
    };
    struct Response {
        Picoseconds time;
        Owner to;
    };
    void end_of_elaboration() override { gates_.resize(socket.size()); }
    tlm::tlm_sync_enum forward(int initiator, tlm::tlm_generic_payload& payload, tlm::tlm_phase& phase,
                               sc_core::sc_time& delay);
    void blocking(int initiator, tlm::tlm_generic_payload& payload, sc_core::sc_time& delay);
    bool refuse(tlm::tlm_generic_payload& payload) const;
    static DramRequest request_of(const tlm::tlm_generic_payload& payload);
    bool queue_or_hold(const Owner& owner, DramRequest& request, Picoseconds moment);
    bool try_queue(const Owner& owner, DramRequest& request, DramCycle arrival, DramCycle now);
    void add_response(Picoseconds time, const Owner& to);
    // Issues the commands before `end`.
    void run(DramCycle end) {
        scheduler_.run(end);
        collect_finished();
    }
    // Whether the commands have run ahead to the one that lets the first request in that is held back.
    bool ahead() const { return let_in_ != kNoCycle; }
    void run_ahead();
    Picoseconds next_known() const;
    Picoseconds next_step() const;
    void rearm();
    void let_in(Picoseconds now);
    void tell_taken(const Waiting& taken);
    void respond(const Owner& to);
    void send_responses(Picoseconds now);
    tlm::tlm_sync_enum call(int initiator, tlm::tlm_generic_payload& payload, tlm::tlm_phase phase);
    // What the gates send a response with, and what follows.
    auto sender() {
        return [this](int initiator, tlm::tlm_generic_payload& payload) {
            payload.set_response_status(tlm::TLM_OK_RESPONSE);
            return call(initiator, payload, tlm::BEGIN_RESP);
        };
    }
    static void release(const ResponseGates::Response& response) { response.payload->release(); }
    // Moves reads whose data are scheduled to the responses.
    void collect_finished() {
        if (!scheduler_.finished().empty()) take_finished();
    }
    void take_finished();
    DramCycle cycle_at(Picoseconds time) const { return clock_.cycle_from(time); }

    ClockPeriod clock_;
    Picoseconds tck_;      // ps
    Picoseconds service_;  // the shortest
    EventWheel& wheel_;
    int wheel_id_;
    Picoseconds armed_ = kNever;  // the wheel steps this unit then, or before
    std::vector<Owner> reads_;    // by request number, while in the scheduler
    std::vector<std::uint32_t> free_reads_;
    std::vector<Response> responses_;  // ring of a power of two, in order of time
    std::size_t response_head_ = 0;
    std::size_t response_count_ = 0;
    Picoseconds next_response_ = kNever;  // the first one's time
    ResponseGates gates_;
    HeldRequests<Waiting> held_;
    DramCycle let_in_ = kNoCycle;  // when the first of those finds room
    DramCycle held_since_ = 0;     // when the last of them went
    Picoseconds blocking_free_ = 0;
    DramConfig config_;
    DramScheduler scheduler_;
};

}  // namespace ropsim
