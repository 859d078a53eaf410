// A cycle-ticked DRAM simulator's library behind a TLM socket. The second example of docs/plug-in-memory.md.
#pragma once

#include <cstdint>
#include <deque>
#include <tlm>
#include <unordered_map>

#include <tlm_utils/simple_target_socket.h>

namespace ropsim {

// `Simulator` has what such libraries share, under whatever names:
//   bool will_accept(std::uint64_t address, bool write)
//   void add(std::uint64_t address, bool write)      one block of `block` bytes
//   void tick()                                      one cycle; calls on_read(address) for each block read
//   std::function<void(std::uint64_t address)> on_read
// Writes are posted: done when the library has them. The library is not ticked while nothing is in flight;
// cycles that passed meanwhile are made up for at the next request, so that its refreshes keep their times.
template <class Simulator>
class TickedMemory : public sc_core::sc_module {
 public:
    SC_HAS_PROCESS(TickedMemory);
    TickedMemory(const sc_core::sc_module_name& name, Simulator& simulator, sc_core::sc_time cycle,
                 std::uint32_t block)
        : sc_module(name), socket("socket"), simulator_(simulator), cycle_(cycle), block_(block) {
        simulator_.on_read = [this](std::uint64_t address) { read_done(address); };
        socket.register_nb_transport_fw(this, &TickedMemory::forward);
        SC_METHOD(tick);
        sensitive << clock_;
        dont_initialize();
    }

    tlm_utils::simple_target_socket<TickedMemory> socket;

 private:
    tlm::tlm_sync_enum forward(tlm::tlm_generic_payload& payload, tlm::tlm_phase& phase,
                               sc_core::sc_time& delay) {
        if (phase == tlm::END_RESP) return tlm::TLM_COMPLETED;
        payload.acquire();
        next_ = &payload;
        next_block_ = payload.get_address() / block_ * block_;
        wake(delay);
        return tlm::TLM_ACCEPTED;
    }

    // At the next edge of the clock from `delay` on.
    void wake(const sc_core::sc_time& delay) {
        const std::uint64_t moment = (sc_core::sc_time_stamp() + delay).value();
        const std::uint64_t edge = (moment + cycle_.value() - 1) / cycle_.value() * cycle_.value();
        clock_.notify(sc_core::sc_time::from_value(edge) - sc_core::sc_time_stamp());
    }

    void tick() {
        const std::uint64_t now = sc_core::sc_time_stamp().value() / cycle_.value();
        for (; ticked_ < now; ++ticked_) simulator_.tick();
        offer();
        if (next_ != nullptr || !reads_.empty()) clock_.notify(cycle_);
    }

    // Hands over the waiting request's blocks as far as the library takes them.
    void offer() {
        while (next_ != nullptr) {
            tlm::tlm_generic_payload& payload = *next_;
            const std::uint64_t end = payload.get_address() + payload.get_data_length();
            for (; next_block_ < end; next_block_ += block_) {
                if (!simulator_.will_accept(next_block_, payload.is_write())) return;
                if (payload.is_read()) {
                    reads_[next_block_].push_back(&payload);
                    ++blocks_left_[&payload];
                }
                simulator_.add(next_block_, payload.is_write());
            }
            next_ = nullptr;
            if (payload.is_read() && blocks_left_[&payload] != 0) {
                call(payload, tlm::END_REQ);
            } else {
                blocks_left_.erase(&payload);
                respond(payload);  // implies END_REQ
            }
        }
    }

    void read_done(std::uint64_t address) {
        const auto at = reads_.find(address);
        tlm::tlm_generic_payload* payload = at->second.front();
        at->second.pop_front();
        if (at->second.empty()) reads_.erase(at);
        if (--blocks_left_[payload] != 0 || payload == next_) return;
        blocks_left_.erase(payload);
        respond(*payload);
    }

    void respond(tlm::tlm_generic_payload& payload) {
        payload.set_response_status(tlm::TLM_OK_RESPONSE);
        call(payload, tlm::BEGIN_RESP);
        payload.release();
    }
    void call(tlm::tlm_generic_payload& payload, tlm::tlm_phase phase) {
        sc_core::sc_time delay;
        socket->nb_transport_bw(payload, phase, delay);
    }

    Simulator& simulator_;
    sc_core::sc_time cycle_;
    std::uint32_t block_;
    sc_core::sc_event clock_;
    std::uint64_t ticked_ = 0;
    tlm::tlm_generic_payload* next_ = nullptr;  // waits to be taken
    std::uint64_t next_block_ = 0;              // of its blocks, the first not handed over
    std::unordered_map<std::uint64_t, std::deque<tlm::tlm_generic_payload*>> reads_;  // by block
    std::unordered_map<tlm::tlm_generic_payload*, int> blocks_left_;
};

}  // namespace ropsim
