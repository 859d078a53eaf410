// The initiator's side of a memory channel: issues requests over TLM-2.0 without allocation, from inside
// wheel steps.
#pragma once

#include "memory/dram_device.h"
#include "memory/event_wheel.h"
#include "memory/memory_link.h"
#include "memory/request_tag.h"

#include <cstdint>
#include <memory>
#include <string>
#include <tlm>
#include <vector>

#include <tlm_utils/simple_initiator_socket.h>

namespace ropsim {

// Gets word from a port. Both are called at wheel time now(), never from inside the client's own issue(); do
// the bookkeeping there and arm() the client's unit.
class MemoryPortClient {
 public:
    virtual ~MemoryPortClient() = default;
    // The request is done: a read's data are here, a write was taken over.
    virtual void memory_done(std::uint32_t id, bool write) = 0;
    // can_issue() was false, because the port held a request or all were in flight, and is true again.
    virtual void memory_port_free() = 0;
};

// Speaks the AT base protocol (nb_transport): BEGIN_REQ, END_REQ withheld while the target is full,
// BEGIN_RESP answered by TLM_COMPLETED. Accepts targets that finish early or annotate delays. A target's
// error response is our bug and stops the program.
//
// bind() binds the socket to a memory on the same wheel that knows plain calls: requests then go to it, and
// come back, by those, at the same times.
class TlmMemoryPort : public sc_core::sc_module, private LinkedPort {
 public:
    // `requests`: how many may be in flight.
    TlmMemoryPort(const sc_core::sc_module_name& name, EventWheel& wheel, MemoryPortClient& client,
                  int requests);
    ~TlmMemoryPort() override;

    tlm_utils::simple_initiator_socket<TlmMemoryPort> socket;

    // Before simulation starts.
    template <class Memory>
    void bind(Memory& memory) {
        socket.bind(memory.socket);
        linked_ = &memory;
    }

    // False while an earlier request has not been accepted, or all are in flight.
    bool can_issue() const { return !waits_ && in_flight_ < capacity_; }
    // Returns true when the request is done at once (a posted write): no memory_done() follows. Requires
    // can_issue().
    bool issue(const MemoryRequest& request);
    int in_flight() const { return static_cast<int>(in_flight_); }

    Picoseconds step(Picoseconds now);

 private:
    struct Slot;
    struct Manager;
    struct Due {
        Picoseconds time;
        Slot* slot;
    };
    tlm::tlm_sync_enum backward(tlm::tlm_generic_payload& payload, tlm::tlm_phase& phase,
                                sc_core::sc_time& delay);
    bool issue_by_phases(const MemoryRequest& request);
    void respond_at(Slot& slot, Picoseconds time);
    void finish(Slot& slot);
    void place_free();
    void request_taken() override;
    void request_done(std::uint32_t id, bool write) override;

    EventWheel& wheel_;
    MemoryPortClient& client_;
    int wheel_id_;
    std::vector<Slot*> free_;
    std::unique_ptr<Manager> manager_;
    std::vector<std::unique_ptr<Slot>> pool_;
    std::vector<Due> due_;  // responses of targets that annotate delays, latest first
    LinkedMemory* linked_ = nullptr;
    std::size_t capacity_;  // requests in flight
    std::size_t in_flight_ = 0;
    bool waits_ = false;                           // a request has been sent and is not yet accepted
    tlm::tlm_generic_payload* waiting_ = nullptr;  // that request, by phases
    bool issuing_ = false;
};

}  // namespace ropsim
