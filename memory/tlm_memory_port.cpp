// The initiator's side of a memory channel: see tlm_memory_port.h.
#include "memory/tlm_memory_port.h"

#include "base/error.h"

#include <algorithm>

namespace ropsim {

struct TlmMemoryPort::Slot : tlm::tlm_generic_payload {
    explicit Slot(Manager& manager);
    // The tag is part of the slot: the payload must not delete it.
    ~Slot() override { clear_extension(&tag); }
    RequestTag tag;
};

// Gives a payload back to the pool once nobody holds it: the target may do so later than the client.
struct TlmMemoryPort::Manager : tlm::tlm_mm_interface {
    explicit Manager(TlmMemoryPort& of) : port(of) {}
    void free(tlm::tlm_generic_payload* payload) override {
        port.free_.push_back(static_cast<Slot*>(payload));
        port.place_free();
    }
    TlmMemoryPort& port;
    // Targets that do move data read and write here; nobody looks at it.
    unsigned char data[kMaxRequestBytes] = {};
};

TlmMemoryPort::Slot::Slot(Manager& manager) : tlm::tlm_generic_payload(&manager) {
    set_data_ptr(manager.data);
    set_extension(&tag);
}

TlmMemoryPort::TlmMemoryPort(const sc_core::sc_module_name& name, EventWheel& wheel, MemoryPortClient& client,
                             int requests)
    : sc_core::sc_module(name),
      socket("socket"),
      wheel_(wheel),
      client_(client),
      wheel_id_(wheel.add(*this)),
      manager_(std::make_unique<Manager>(*this)),
      capacity_(static_cast<std::size_t>(requests)) {
    CHECK(requests > 0, "{} requests", requests);
    for (int i = 0; i < requests; ++i) pool_.push_back(std::make_unique<Slot>(*manager_));
    for (auto slot = pool_.rbegin(); slot != pool_.rend(); ++slot) free_.push_back(slot->get());
    due_.reserve(pool_.size());
    socket.register_nb_transport_bw(this, &TlmMemoryPort::backward);
}

TlmMemoryPort::~TlmMemoryPort() = default;

bool TlmMemoryPort::issue(const MemoryRequest& request) {
    CHECK(can_issue(), "{} requests in flight", in_flight());
    ++in_flight_;
    if (linked_ == nullptr) return issue_by_phases(request);
    const LinkedMemory::Answer answer = linked_->request(*this, request);
    waits_ = answer == LinkedMemory::Answer::kHeld;
    if (answer != LinkedMemory::Answer::kDone) return false;
    --in_flight_;
    return true;
}

void TlmMemoryPort::request_taken() {
    waits_ = false;
    client_.memory_port_free();
}

void TlmMemoryPort::request_done(std::uint32_t id, bool write) {
    place_free();
    client_.memory_done(id, write);
}

// The place of a request that is done.
void TlmMemoryPort::place_free() {
    if (in_flight_-- == capacity_ && !issuing_ && !waits_) client_.memory_port_free();
}

bool TlmMemoryPort::issue_by_phases(const MemoryRequest& request) {
    Slot& slot = *free_.back();
    free_.pop_back();
    slot.acquire();
    slot.set_command(request.write ? tlm::TLM_WRITE_COMMAND : tlm::TLM_READ_COMMAND);
    slot.set_address(request.address);
    slot.set_data_length(request.bytes);
    slot.set_streaming_width(request.bytes);
    slot.set_response_status(tlm::TLM_INCOMPLETE_RESPONSE);
    slot.tag.id = request.id;
    slot.tag.surface = request.surface;
    slot.tag.cause = request.cause;
    slot.tag.masked = request.masked;
    slot.tag.has_enables = request.enables != nullptr;
    if (slot.tag.has_enables) slot.tag.enables = *request.enables;

    tlm::tlm_phase phase = tlm::BEGIN_REQ;
    sc_core::sc_time delay = wheel_.local_delay();
    waiting_ = &slot;
    waits_ = true;
    issuing_ = true;
    const std::uint64_t inside = wheel_.inside_calls().forward;
    const tlm::tlm_sync_enum answer = socket->nb_transport_fw(slot, phase, delay);
    if (wheel_.inside_calls().forward == inside) wheel_.called_outside();
    issuing_ = false;
    if (answer == tlm::TLM_ACCEPTED) return false;
    waiting_ = nullptr;
    waits_ = false;
    if (answer == tlm::TLM_UPDATED && phase == tlm::END_REQ) return false;
    const Picoseconds time = wheel_.local_moment(delay);
    if (answer == tlm::TLM_UPDATED) {
        CHECK(phase == tlm::BEGIN_RESP, "phase {}", phase.get_name());
        phase = tlm::END_RESP;
        socket->nb_transport_fw(slot, phase, delay);
    }
    if (time > wheel_.now()) {
        respond_at(slot, time);
        return false;
    }
    CHECK(slot.is_response_ok(), "{}", slot.get_response_string());
    issuing_ = true;
    slot.release();
    issuing_ = false;
    return true;
}

tlm::tlm_sync_enum TlmMemoryPort::backward(tlm::tlm_generic_payload& payload, tlm::tlm_phase& phase,
                                           sc_core::sc_time& delay) {
    ++wheel_.inside_calls().backward;
    if (waiting_ == &payload) {
        // END_REQ, or a response that implies it.
        waiting_ = nullptr;
        waits_ = false;
        if (!issuing_) client_.memory_port_free();
    }
    if (phase == tlm::END_REQ) return tlm::TLM_ACCEPTED;
    CHECK(phase == tlm::BEGIN_RESP, "phase {}", phase.get_name());
    Slot& slot = static_cast<Slot&>(payload);
    const Picoseconds time = wheel_.local_moment(delay);
    if (time > wheel_.now() || issuing_)
        respond_at(slot, std::max(time, wheel_.now()));
    else
        finish(slot);
    return tlm::TLM_COMPLETED;
}

// Keeps a response for later.
void TlmMemoryPort::respond_at(Slot& slot, Picoseconds time) {
    const auto later = [](const Due& a, const Due& b) { return a.time > b.time; };
    const Due due{time, &slot};
    // Before those of the same time, so that those leave first.
    due_.insert(std::lower_bound(due_.begin(), due_.end(), due, later), due);
    wheel_.arm(wheel_id_, time);
}

void TlmMemoryPort::finish(Slot& slot) {
    CHECK(slot.is_response_ok(), "{}", slot.get_response_string());
    const std::uint32_t id = slot.tag.id;
    const bool write = slot.is_write();
    slot.release();
    client_.memory_done(id, write);
}

Picoseconds TlmMemoryPort::step(Picoseconds now) {
    while (!due_.empty() && due_.back().time <= now) {
        Slot& slot = *due_.back().slot;
        due_.pop_back();
        finish(slot);
    }
    return due_.empty() ? kNever : due_.back().time;
}

}  // namespace ropsim
