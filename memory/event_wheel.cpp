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
    SC_HAS_PROCESS(EventWheel);
    SC_METHOD(run);
    sensitive << rearmed_;
}

int EventWheel::add(WheelUnit& unit) {
    if (units_.size() % kGroup == 0) next_.resize(units_.size() + kGroup, kNever);
    if (units_.size() % kBlock == 0) {
        group_next_.resize(group_next_.size() + kGroup, kNever);
        if (units_.size() / kBlock % kGroup == 0) block_next_.resize(block_next_.size() + kGroup, kNever);
    }
    CHECK(units_.size() < std::size_t{1} << kUnitBits, "{} units", units_.size());
    units_.push_back(&unit);
    return static_cast<int>(units_.size()) - 1;
}

// A tree without branches: which unit is next is as good as random.
EventWheel::Entry EventWheel::earliest(const Entry* group) {
    static_assert(kGroup == 4);
    const auto least = [](Entry a, Entry b) { return a < b ? a : b; };
    return least(least(group[0], group[1]), least(group[2], group[3]));
}

void simulate() {
    sc_core::sc_start();
    if (step_failure()) std::rethrow_exception(std::exchange(step_failure(), nullptr));
}

void EventWheel::run() {
    const Picoseconds kernel = kernel_ = sc_core::sc_time_stamp().value();
    Picoseconds last = kernel;
    Picoseconds kernel_next = kNever;
    running_ = true;
    kernel_known_ = false;
    Picoseconds time = kNever;
    while (true) {
        Entry first = kNever;
        for (std::size_t block = 0; block < block_next_.size(); block += kGroup)
            first = std::min(first, earliest(&block_next_[block]));
        if (first == kNever) {
            time = last > kernel ? last : kNever;  // let the kernel's clock catch up before everything ends
            break;
        }
        time = first >> kUnitBits;
        if (!kernel_known_) {
            const Picoseconds ahead = sc_core::sc_time_to_pending_activity().value();
            kernel_next = ahead > kNever - kernel ? kNever : kernel + ahead;
            kernel_known_ = true;
        }
        // At the time of a kernel event, step only once the kernel's clock is there.
        if (time > kernel && time >= kernel_next) break;
        if (time > observe_at_) [[unlikely]]
            observe_at_ = observer_->observe(time);
        last = now_ = time;
        const std::size_t unit = first & ((std::size_t{1} << kUnitBits) - 1);
        // The entries of the group and the block are stale until the step is over; arm() can only lower them.
        next_[unit] = kNever;
        Picoseconds wanted = kNever;
        try {
            wanted = units_[unit]->step(time);
        } catch (...) {
            step_failure() = std::current_exception();
            running_ = false;
            sc_core::sc_pause();  // ends sc_start(), and says nothing on stdout as sc_stop() does
            return;
        }
        next_[unit] = std::min(next_[unit], entry(wanted, unit));
        group_next_[unit / kGroup] = earliest(&next_[unit / kGroup * kGroup]);
        block_next_[unit / kBlock] = earliest(&group_next_[unit / kBlock * kGroup]);
    }
    running_ = false;
    if (time != kNever) rearmed_.notify(sc_core::sc_time::from_value(time - kernel));
}

}  // namespace ropsim
