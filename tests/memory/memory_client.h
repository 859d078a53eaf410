// A wheel unit that issues a list of requests through a TlmMemoryPort and records when each was done.
#pragma once

#include "memory/tlm_memory_port.h"

#include <cstdint>
#include <utility>
#include <vector>

namespace ropsim {

class MemoryClient : public MemoryPortClient {
 public:
    struct Item {
        Picoseconds time;  // not before
        MemoryRequest request;
    };

    MemoryClient(EventWheel& wheel, int in_flight, const char* name = "port")
        : port(name, wheel, *this, in_flight), wheel_(wheel), id_(wheel.add(*this)) {}

    // `items` in order of time; their ids become their indices.
    void start(std::vector<Item> items) {
        items_ = std::move(items);
        done.assign(items_.size(), kNever);
        wheel_.arm(id_, items_.front().time);
    }
    Picoseconds step(Picoseconds now) {
        while (next_ < items_.size()) {
            Item& item = items_[next_];
            if (item.time > now) return item.time;
            if (!port.can_issue()) {
                ++refusals;
                return kNever;  // woken by memory_port_free() or memory_done()
            }
            item.request.id = static_cast<std::uint32_t>(next_++);
            if (port.issue(item.request)) done[item.request.id] = now;
        }
        return kNever;
    }
    void memory_done(std::uint32_t id, bool) override {
        done[id] = wheel_.now();
        wheel_.arm(id_, wheel_.now());
    }
    void memory_port_free() override {
        ++freed;
        wheel_.arm(id_, wheel_.now());
    }

    TlmMemoryPort port;
    std::vector<Picoseconds> done;  // by item
    int refusals = 0;
    int freed = 0;

 private:
    EventWheel& wheel_;
    int id_;
    std::vector<Item> items_;
    std::size_t next_ = 0;
};

}  // namespace ropsim
