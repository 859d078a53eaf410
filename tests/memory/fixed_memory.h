// A memory of somebody else's, as small as it gets: fixed latency, fixed bandwidth, a limit on requests in
// flight. The example of docs/plug-in-memory.md.
#pragma once

#include <tlm>

#include <tlm_utils/peq_with_get.h>
#include <tlm_utils/simple_target_socket.h>

namespace ropsim {

class FixedMemory : public sc_core::sc_module {
 public:
    SC_HAS_PROCESS(FixedMemory);
    FixedMemory(const sc_core::sc_module_name& name, sc_core::sc_time latency, sc_core::sc_time time_per_byte,
                int most_in_flight)
        : sc_module(name),
          socket("socket"),
          latency_(latency),
          time_per_byte_(time_per_byte),
          most_in_flight_(most_in_flight),
          done_("done") {
        socket.register_nb_transport_fw(this, &FixedMemory::forward);
        SC_METHOD(respond);
        sensitive << done_.get_event();
        dont_initialize();
    }

    tlm_utils::simple_target_socket<FixedMemory> socket;

 private:
    // `delay` counts from the kernel's time: the port may be ahead of the kernel.
    tlm::tlm_sync_enum forward(tlm::tlm_generic_payload& payload, tlm::tlm_phase& phase,
                               sc_core::sc_time& delay) {
        if (phase == tlm::END_RESP) return tlm::TLM_COMPLETED;  // our port has answered BEGIN_RESP at once
        payload.acquire();
        if (in_flight_ == most_in_flight_) {
            waiting_ = &payload;  // full: END_REQ comes later, and no other request before it
            return tlm::TLM_ACCEPTED;
        }
        take(payload, sc_core::sc_time_stamp() + delay);
        phase = tlm::END_REQ;
        return tlm::TLM_UPDATED;
    }

    void take(tlm::tlm_generic_payload& payload, const sc_core::sc_time& now) {
        ++in_flight_;
        bus_free_ = (now > bus_free_ ? now : bus_free_) + time_per_byte_ * payload.get_data_length();
        done_.notify(payload, bus_free_ + latency_ - sc_core::sc_time_stamp());
    }

    void respond() {
        while (tlm::tlm_generic_payload* payload = done_.get_next_transaction()) {
            payload->set_response_status(tlm::TLM_OK_RESPONSE);
            tlm::tlm_phase phase = tlm::BEGIN_RESP;
            sc_core::sc_time delay;
            socket->nb_transport_bw(*payload, phase, delay);
            payload->release();
            --in_flight_;
            if (waiting_ != nullptr) accept_waiting();
        }
    }

    void accept_waiting() {
        tlm::tlm_generic_payload* payload = waiting_;
        waiting_ = nullptr;
        take(*payload, sc_core::sc_time_stamp());
        tlm::tlm_phase phase = tlm::END_REQ;
        sc_core::sc_time delay;
        socket->nb_transport_bw(*payload, phase, delay);
    }

    sc_core::sc_time latency_;
    sc_core::sc_time time_per_byte_;
    int most_in_flight_;
    int in_flight_ = 0;
    sc_core::sc_time bus_free_;
    tlm::tlm_generic_payload* waiting_ = nullptr;
    tlm_utils::peq_with_get<tlm::tlm_generic_payload> done_;
};

}  // namespace ropsim
