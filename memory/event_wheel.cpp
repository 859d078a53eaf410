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
    if (units_.size() % kGroup == 0) {
        next_.resize(units_.size() + kGroup, kNever);
        group_next_.push_back(kNever);
    }
    units_.push_back(&unit);
    return static_cast<int>(units_.size()) - 1;
}

void EventWheel::arm(int id, Picoseconds time) {
    CHECK(time >= now(), "unit {} armed for {} ps at {} ps", id, time, now());
    const auto unit = static_cast<std::size_t>(id);
    if (time >= next_[unit]) return;
    next_[unit] = time;
    group_next_[unit / kGroup] = std::min(group_next_[unit / kGroup], time);
    // The kernel keeps only the earliest notification of an event; a later one that it drops is made again by
    // run().
    if (!running_) rearmed_.notify(sc_core::sc_time::from_value(time - sc_core::sc_time_stamp().value()));
}

sc_core::sc_time EventWheel::local_delay() const {
    return sc_core::sc_time::from_value(now() - sc_core::sc_time_stamp().value());
}

namespace {

// The earliest of a group, without branches: which unit is next is as good as random.
template <std::size_t kCount>
Picoseconds earliest(const Picoseconds* times) {
    Picoseconds least = times[0];
    for (std::size_t i = 1; i < kCount; ++i) least = times[i] < least ? times[i] : least;
    return least;
}

}  // namespace

void EventWheel::run() {
    const Picoseconds kernel = sc_core::sc_time_stamp().value();
    Picoseconds last = kernel;
    Picoseconds kernel_next = kNever;
    running_ = true;
    kernel_known_ = false;
    Picoseconds time = kNever;
    while (true) {
        const auto group = std::min_element(group_next_.begin(), group_next_.end());
        if (group == group_next_.end() || *group == kNever) {
            time = last > kernel ? last : kNever;  // let the kernel's clock catch up before everything ends
            break;
        }
        time = *group;
        if (!kernel_known_) {
            const Picoseconds ahead = sc_core::sc_time_to_pending_activity().value();
            kernel_next = ahead > kNever - kernel ? kNever : kernel + ahead;
            kernel_known_ = true;
        }
        // At the time of a kernel event, step only once the kernel's clock is there.
        if (time > kernel && time >= kernel_next) break;
        last = now_ = time;
        std::size_t unit = static_cast<std::size_t>(group - group_next_.begin()) * kGroup;
        const std::size_t first = unit;
        while (next_[unit] != time) ++unit;
        // The group's earliest time is stale until the step is over; arm() can only lower it further.
        next_[unit] = kNever;
        const Picoseconds wanted = units_[unit]->step(time);
        next_[unit] = std::min(next_[unit], wanted);
        *group = earliest<kGroup>(&next_[first]);
    }
    running_ = false;
    if (time != kNever) rearmed_.notify(sc_core::sc_time::from_value(time - kernel));
}

}  // namespace ropsim
