// The next-time wheel: cycle models that run inside one SystemC process, in exact time order.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include <systemc>

namespace ropsim {

using Picoseconds = std::uint64_t;  // simulated time; SystemC's resolution is set to 1 ps
inline constexpr Picoseconds kNever = std::numeric_limits<Picoseconds>::max();

// A model that is stepped by the wheel. step(now) does everything due at `now` and returns when it next wants to be
// stepped (> now, or kNever until somebody arms it).
class WheelUnit {
   public:
    virtual ~WheelUnit() = default;
    virtual Picoseconds step(Picoseconds now) = 0;
};

// One SC_METHOD for all units: an event costs nanoseconds, not a kernel activation. The wheel never runs past the
// kernel's next pending activity, so models outside it (plugged in over TLM) see and keep exact times. At equal times
// units are stepped in order of registration.
class EventWheel : public sc_core::sc_module {
   public:
    explicit EventWheel(const sc_core::sc_module_name& name);
    // Returns the unit's id. Call before simulation starts.
    int add(WheelUnit& unit);
    // Asks for `id` to be stepped at `time` at the latest (>= now()). Callable from inside a step, or from a kernel
    // process (a TLM call of an outside model).
    void arm(int id, Picoseconds time);
    // Local time: inside a step, the time of that step; else the kernel's.
    Picoseconds now() const { return now_; }
    // Local time minus kernel time: the delay argument of TLM calls made inside a step.
    sc_core::sc_time local_delay() const;

   private:
    void run();
    sc_core::sc_event rearmed_;
    std::vector<WheelUnit*> units_;
    std::vector<Picoseconds> next_;
    Picoseconds now_ = 0;
    bool running_ = false;
};

}  // namespace ropsim
