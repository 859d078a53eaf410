// What a target on the wheel keeps of the initiators bound to its one socket: requests held back, and
// responses that wait for an END_RESP.
#pragma once

#include "base/error.h"
#include "memory/event_wheel.h"

#include <algorithm>
#include <cstdint>
#include <tlm>
#include <vector>

namespace ropsim {

// Requests whose END_REQ is withheld, in order of their times and of arrival; each initiator has one at most.
// `Request` is what the target has to keep of one.
template <class Request>
class HeldRequests {
 public:
    struct Held {
        Request request;
        Picoseconds from = 0;  // its BEGIN_REQ's time: now, or later than now
    };
    bool empty() const { return requests_.empty(); }
    const Held& front() const { return requests_.front(); }
    Held& front() { return requests_.front(); }
    // One that has come by `now` waits: later ones queue up behind it.
    bool due(Picoseconds now) const { return !requests_.empty() && requests_.front().from <= now; }
    // Whether `matches` holds for any of them.
    template <class Matches>
    bool any(Matches matches) const {
        return std::any_of(requests_.begin(), requests_.end(),
                           [&](const Held& held) { return matches(held.request); });
    }
    void hold(const Request& request, Picoseconds from) {
        const auto place = std::upper_bound(requests_.begin(), requests_.end(), from,
                                            [](Picoseconds time, const Held& h) { return time < h.from; });
        requests_.insert(place, {request, from});
    }
    Held take() {
        const Held first = requests_.front();
        requests_.erase(requests_.begin());
        return first;
    }

 private:
    std::vector<Held> requests_;
};

// The base protocol allows an initiator one response at a time: the next waits for END_RESP. Others do not
// wait for it.
class ResponseGates {
 public:
    struct Response {
        tlm::tlm_generic_payload* payload;
        std::uint32_t number;  // the target's own
    };

    // Before the first call.
    void resize(std::size_t initiators) { gates_.resize(initiators); }
    // Of all responses.
    bool empty() const { return waiting_ == 0; }
    // `send(initiator, payload)` calls the initiator with BEGIN_RESP and returns its answer, `done(response)`
    // follows: at once, or from send_waiting() after the END_RESP of the one before.
    template <class Send, class Done>
    void respond(int initiator, const Response& response, Send send, Done done) {
        Gate& gate = gates_[static_cast<std::size_t>(initiator)];
        if (gate.shut || !gate.waiting.empty()) [[unlikely]] {
            gate.waiting.push_back(response);
            ++waiting_;
            return;
        }
        pass(gate, initiator, response, send, done);
    }
    void end_response(int initiator) { gates_[static_cast<std::size_t>(initiator)].shut = false; }
    template <class Send, class Done>
    void send_waiting(Send send, Done done) {
        if (waiting_ == 0) [[likely]]
            return;
        for (std::size_t i = 0; i < gates_.size(); ++i)
            while (!gates_[i].shut && !gates_[i].waiting.empty()) {
                const Response response = gates_[i].waiting.front();
                gates_[i].waiting.erase(gates_[i].waiting.begin());
                --waiting_;
                pass(gates_[i], static_cast<int>(i), response, send, done);
            }
    }

 private:
    struct Gate {
        bool shut = false;  // BEGIN_RESP sent, END_RESP not yet seen
        std::vector<Response> waiting;
    };
    // END_RESP may come while the initiator is being called.
    template <class Send, class Done>
    static void pass(Gate& gate, int initiator, const Response& response, Send send, Done done) {
        gate.shut = true;
        if (send(initiator, *response.payload) != tlm::TLM_ACCEPTED) gate.shut = false;
        done(response);
    }

    std::vector<Gate> gates_;
    std::size_t waiting_ = 0;
};

}  // namespace ropsim
