// The next-time wheel: cycle models that run inside one SystemC process, in exact time order.
#pragma once

#include "base/error.h"

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <systemc>
#include <vector>

namespace ropsim {

using Picoseconds = std::uint64_t;  // simulated time; SystemC's resolution is set to 1 ps
inline constexpr Picoseconds kNever = std::numeric_limits<Picoseconds>::max();

// Sets SystemC's time resolution to 1 ps. Call before the first sc_time or sc_object is created; a second
// call is harmless.
void use_picosecond_resolution();

// A model that is stepped by the wheel. step(now) does everything due at `now` and returns when it next wants
// to be stepped (> now, or kNever until somebody arms it).
template <class Unit>
concept WheelUnit = requires(Unit& unit, Picoseconds now) {
    { unit.step(now) } -> std::same_as<Picoseconds>;
};

// Looks on between steps and changes nothing that a unit can see. observe(before) is called when everything
// due before `before` is done and nothing at it, the first time at which a step is due after the time that
// the last call asked for: what it sees has been so since the last step. Returns the time it next wants to
// see (kNever: no more).
class WheelObserver {
 public:
    virtual ~WheelObserver() = default;
    virtual Picoseconds observe(Picoseconds before) = 0;
};

// One SC_METHOD for all units: an event costs nanoseconds, not a kernel activation. The wheel never runs past
// the kernel's next pending activity, so models outside it (plugged in over TLM) see and keep exact times. At
// equal times units are stepped in order of registration; a unit that is armed for the current time during
// somebody's step is stepped (again) at that time. When nothing is left to do, the kernel's clock has caught
// up with the wheel's. sc_start() with a duration does not stop the wheel in between.
class EventWheel : public sc_core::sc_module {
 public:
    explicit EventWheel(const sc_core::sc_module_name& name);
    // Returns the unit's id. Call before simulation starts. Every unit is first stepped when it is armed.
    template <WheelUnit Unit>
    int add(Unit& unit) {
        return add({&unit, [](void* of, Picoseconds now) { return static_cast<Unit*>(of)->step(now); }});
    }
    // One at most, before simulation starts. It takes no part: without work for units time does not go on.
    void set_observer(WheelObserver& observer) {
        observer_ = &observer;
        observe_at_ = 0;
    }
    // Asks for `id` to be stepped at `time` at the latest (>= now()). Callable before simulation, from inside
    // a step, or from a kernel process (a TLM call of an outside model).
    void arm(int id, Picoseconds time) {
        CHECK(time >= now(), "unit {} armed for {} ps at {} ps", id, time, now());
        const auto unit = static_cast<std::size_t>(id);
        const Entry next = entry(time, unit);
        if (next >= next_[unit]) return;
        lower(unit, next);
        armed_ = std::min(armed_, next);
        // The kernel keeps only the earliest notification of an event; a later one that it drops is made
        // again by run().
        if (!running_) rearmed_.notify(sc_core::sc_time::from_value(time - sc_core::sc_time_stamp().value()));
    }
    // A step has called out to a model that may not be on the wheel, which may have notified a kernel event.
    // The kernel's next activity is looked up again before the wheel goes on; but for this and when the
    // observer has looked on it is not.
    void called_outside() { pause_at_ = 0; }
    // Memory models on this wheel count the calls they receive, forward and backward: they make no kernel
    // events. A caller that sees its count unchanged has called outside.
    struct InsideCalls {
        std::uint64_t forward = 0;
        std::uint64_t backward = 0;
    };
    InsideCalls& inside_calls() { return inside_calls_; }
    // Local time: inside a step, the time of that step; else the kernel's.
    Picoseconds now() const { return running_ ? now_ : sc_core::sc_time_stamp().value(); }
    // The kernel's time plus `delay`, the moment that a TLM call with this annotation speaks of.
    static Picoseconds moment(const sc_core::sc_time& delay) {
        return sc_core::sc_time_stamp().value() + delay.value();
    }
    // The same from inside a step, where the kernel's time is known.
    Picoseconds local_moment(const sc_core::sc_time& delay) const {
        return running_ ? kernel_ + delay.value() : moment(delay);
    }
    // Local time minus kernel time: the delay argument of TLM calls made inside a step.
    const sc_core::sc_time& local_delay() {
        const Picoseconds delay = now() - (running_ ? kernel_ : sc_core::sc_time_stamp().value());
        if (delay_.value() != delay) delay_ = sc_core::sc_time::from_value(delay);
        return delay_;
    }

 private:
    // A unit and its step(). Not a virtual call: that would wait for the unit's own memory, of which nothing
    // is near, to know where to go.
    struct Stepped {
        void* unit;
        Picoseconds (*step)(void* unit, Picoseconds now);
    };
    int add(Stepped unit);

    // A unit's next time and its number in one word, so that the least word names the unit to step: the
    // earlier time, of equal times the lower number.
    using Entry = std::uint64_t;
    static constexpr std::size_t kGroup = 4;  // units
    static constexpr std::size_t kBlock = kGroup * kGroup;
    static constexpr int kUnitBits = 10;
    static constexpr std::size_t kMaxUnits = std::size_t{1} << kUnitBits;
    static Entry entry(Picoseconds time, std::size_t unit) {
        return time >= kNever >> kUnitBits ? kNever : time << kUnitBits | unit;
    }
    static Entry earliest(const Entry* group);
    Entry earliest_of_all() const;
    void take(std::size_t unit);
    void lower(std::size_t unit, Entry next) {
        next_[unit] = next;
        group_next_[unit / kGroup] = std::min(group_next_[unit / kGroup], next);
        block_next_[unit / kBlock] = std::min(block_next_[unit / kBlock], next);
    }
    void run();

    sc_core::sc_event rearmed_;
    std::vector<Stepped> units_;
    std::array<Entry, kMaxUnits> next_;                 // by unit
    std::array<Entry, kMaxUnits / kGroup> group_next_;  // the least of each group
    std::array<Entry, kMaxUnits / kBlock> block_next_;  // the least of each block
    std::size_t blocks_ = 0;                            // with units, rounded up to whole groups
    Entry armed_ = kNever;                              // the least that arm() has set during this step
    WheelObserver* observer_ = nullptr;
    Picoseconds observe_at_ = kNever;
    Picoseconds kernel_ = 0;    // its time, while running
    sc_core::sc_time delay_;    // local_delay()'s last
    Picoseconds pause_at_ = 0;  // nothing but units is due before this time; 0: unknown
    InsideCalls inside_calls_;
    Picoseconds now_ = 0;
    bool running_ = false;
};

}  // namespace ropsim
