// The next-time wheel: see event_wheel.h.
#include "memory/event_wheel.h"

#include "base/error.h"
#include "memory/simulate.h"

#include <algorithm>
#include <exception>
#include <utility>

// libsystemc has a main() of its own that calls this one. Programs here have their own main(); weak, so that
// one may define it all the same.
extern "C" __attribute__((weak)) int sc_main(int, char**) {
    return 0;
}

namespace ropsim {
namespace {

// Of the process, as SystemC's kernel is.
std::exception_ptr& step_failure() {
    static std::exception_ptr failure;
    return failure;
}

}  // namespace

void use_picosecond_resolution() {
    static bool done = false;
    if (done) return;
    sc_core::sc_set_time_resolution(1.0, sc_core::SC_PS);
    done = true;
}

EventWheel::EventWheel(const sc_core::sc_module_name& name) : sc_core::sc_module(name) {
    CHECK(sc_core::sc_time::from_value(1000) == sc_core::sc_time(1.0, sc_core::SC_NS),
          "SystemC's resolution is not 1 ps");
    next_.fill(kNever);
    group_next_.fill(kNever);
    block_next_.fill(kNever);
    SC_HAS_PROCESS(EventWheel);
    SC_METHOD(run);
    sensitive << rearmed_;
}

int EventWheel::add(Stepped unit) {
    CHECK(units_.size() < kMaxUnits, "{} units", units_.size());
    units_.push_back(unit);
    blocks_ = (units_.size() + kBlock * kGroup - 1) / (kBlock * kGroup) * kGroup;
    return static_cast<int>(units_.size()) - 1;
}

// A tree without branches: which unit is next is as good as random.
EventWheel::Entry EventWheel::earliest(const Entry* group) {
    static_assert(kGroup == 4);
    const auto least = [](Entry a, Entry b) { return a < b ? a : b; };
    return least(least(group[0], group[1]), least(group[2], group[3]));
}

inline EventWheel::Entry EventWheel::earliest_of_all() const {
    Entry first = kNever;
    for (std::size_t block = 0; block < blocks_; block += kGroup)
        first = std::min(first, earliest(&block_next_[block]));
    return first;
}

// It is to be stepped no more.
inline void EventWheel::take(std::size_t unit) {
    next_[unit] = kNever;
    group_next_[unit / kGroup] = earliest(&next_[unit / kGroup * kGroup]);
    block_next_[unit / kBlock] = earliest(&group_next_[unit / kBlock * kGroup]);
}

void simulate() {
    sc_core::sc_start();
    if (step_failure()) std::rethrow_exception(std::exchange(step_failure(), nullptr));
}

void EventWheel::run() {
    const Picoseconds kernel = kernel_ = sc_core::sc_time_stamp().value();
    Picoseconds last = kernel;
    running_ = true;
    pause_at_ = 0;
    Picoseconds time = kNever;
    Entry first = earliest_of_all();
    while (true) {
        if (first == kNever) {
            time = last > kernel ? last : kNever;  // let the kernel's clock catch up before everything ends
            break;
        }
        time = first >> kUnitBits;
        if (time >= pause_at_) [[unlikely]] {
            const Picoseconds ahead = sc_core::sc_time_to_pending_activity().value();
            // At the time of a kernel event, step only once the kernel's clock is there.
            const Picoseconds kernel_next =
                std::max(ahead > kNever - kernel ? kNever : kernel + ahead, kernel + 1);
            if (time >= kernel_next) break;
            if (time > observe_at_) observe_at_ = observer_->observe(time);
            pause_at_ = std::min(kernel_next, std::min(observe_at_, kNever - 1) + 1);
        }
        last = now_ = time;
        const std::size_t unit = first & ((std::size_t{1} << kUnitBits) - 1);
        // Who comes after it is known, but for what the step arms, before the step: nothing waits for it
        // then.
        take(unit);
        const Entry second = earliest_of_all();
        armed_ = kNever;
        Picoseconds wanted = kNever;
        try {
            wanted = units_[unit].step(units_[unit].unit, time);
        } catch (...) {
            step_failure() = std::current_exception();
            running_ = false;
            sc_core::sc_pause();  // ends sc_start(), and says nothing on stdout as sc_stop() does
            return;
        }
        const Entry next = entry(wanted, unit);
        if (next < next_[unit]) lower(unit, next);
        first = std::min({second, next, armed_});
    }
    running_ = false;
    if (time != kNever) rearmed_.notify(sc_core::sc_time::from_value(time - kernel));
}

}  // namespace ropsim
