// The next-time wheel: see event_wheel.h.
#include "memory/event_wheel.h"

#include "base/error.h"

#include <algorithm>

// libsystemc has a main() of its own that calls this one. Programs here have their own main(); weak, so that
// one may define it all the same.
extern "C" __attribute__((weak)) int sc_main(int, char**) {
    return 0;
}

namespace ropsim {

void use_picosecond_resolution() {
    static bool done = false;
    if (done) return;
    sc_core::sc_set_time_resolution(1.0, sc_core::SC_PS);
    done = true;
}

EventWheel::EventWheel(const sc_core::sc_module_name& name) : sc_core::sc_module(name) {
    CHECK(sc_core::sc_time::from_value(1000) == sc_core::sc_time(1.0, sc_core::SC_NS),
          "SystemC's resolution is not 1 ps");
    SC_HAS_PROCESS(EventWheel);
    SC_METHOD(run);
    sensitive << rearmed_;
}

int EventWheel::add(WheelUnit& unit) {
    units_.push_back(&unit);
    next_.push_back(kNever);
    return static_cast<int>(units_.size()) - 1;
}

void EventWheel::arm(int id, Picoseconds time) {
    CHECK(time >= now(), "unit {} armed for {} ps at {} ps", id, time, now());
    Picoseconds& next = next_[static_cast<std::size_t>(id)];
    if (time >= next) return;
    next = time;
    // The kernel keeps only the earliest notification of an event; a later one that it drops is made again by
    // run().
    if (!running_) rearmed_.notify(sc_core::sc_time::from_value(time - sc_core::sc_time_stamp().value()));
}

sc_core::sc_time EventWheel::local_delay() const {
    return sc_core::sc_time::from_value(now() - sc_core::sc_time_stamp().value());
}

void EventWheel::run() {
    const Picoseconds kernel = sc_core::sc_time_stamp().value();
    Picoseconds last = kernel;
    running_ = true;
    Picoseconds time = kNever;
    while (true) {
        const auto first = std::min_element(next_.begin(), next_.end());
        if (first == next_.end() || *first == kNever) {
            time = last > kernel ? last : kNever;  // let the kernel's clock catch up before everything ends
            break;
        }
        time = *first;
        // At the time of a kernel event, step only once the kernel's clock is there.
        if (time > kernel && time - kernel >= sc_core::sc_time_to_pending_activity().value()) break;
        last = now_ = time;
        *first = kNever;
        const std::size_t unit = static_cast<std::size_t>(first - next_.begin());
        const Picoseconds wanted = units_[unit]->step(time);
        next_[unit] = std::min(next_[unit], wanted);
    }
    running_ = false;
    if (time != kNever) rearmed_.notify(sc_core::sc_time::from_value(time - kernel));
}

}  // namespace ropsim
