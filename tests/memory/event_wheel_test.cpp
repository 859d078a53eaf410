// The wheel: order, re-arming, and exactness towards models with events of their own.
#include "memory/event_wheel.h"

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using testing::ElementsAre;
using Log = std::vector<std::pair<Picoseconds, std::string>>;

struct Unit {
    Unit(EventWheel& wheel, std::string unit_name, Log& unit_log)
        : name(std::move(unit_name)), log(unit_log), id(wheel.add(*this)) {}
    Picoseconds step(Picoseconds now) {
        log.emplace_back(now, name);
        return then ? then(now) : kNever;
    }
    std::string name;
    Log& log;
    std::function<Picoseconds(Picoseconds)> then;
    int id;
};

TEST(EventWheel, StepsInOrderOfTimeThenRegistration) {
    use_picosecond_resolution();
    EventWheel wheel("wheel");
    Log log;
    Unit a(wheel, "a", log), b(wheel, "b", log), c(wheel, "c", log);
    a.then = [](Picoseconds now) { return now < 30 ? now + 10 : kNever; };
    b.then = [](Picoseconds now) { return now < 30 ? now + 15 : kNever; };
    wheel.arm(c.id, 25);
    wheel.arm(b.id, 0);
    wheel.arm(a.id, 0);
    sc_core::sc_start();
    EXPECT_EQ(log,
              (Log{{0, "a"}, {0, "b"}, {10, "a"}, {15, "b"}, {20, "a"}, {25, "c"}, {30, "a"}, {30, "b"}}));
    EXPECT_EQ(sc_core::sc_time_stamp().value(), 30u);
}

TEST(EventWheel, ArmedForNowIsSteppedAgainNow) {
    use_picosecond_resolution();
    EventWheel wheel("wheel");
    Log log;
    Unit a(wheel, "a", log), b(wheel, "b", log);
    b.then = [&](Picoseconds now) {
        if (now == 10) wheel.arm(a.id, now);  // a is registered first and was stepped at 10 already
        return now == 10 ? 500 : kNever;
    };
    a.then = [&](Picoseconds) {
        if (log.size() == 1) wheel.arm(b.id, 700);  // later than what b has: no effect
        return kNever;
    };
    wheel.arm(a.id, 10);
    wheel.arm(b.id, 10);
    wheel.arm(b.id, 900);
    sc_core::sc_start();
    EXPECT_EQ(log, (Log{{10, "a"}, {10, "b"}, {10, "a"}, {500, "b"}}));
}

// A unit arms itself while it is being stepped: the earlier of that and what step() returns holds.
TEST(EventWheel, SelfArmingCounts) {
    use_picosecond_resolution();
    EventWheel wheel("wheel");
    Log log;
    Unit a(wheel, "a", log);
    a.then = [&](Picoseconds now) {
        if (now == 5) wheel.arm(a.id, 8);
        return now == 5 ? 50 : kNever;
    };
    wheel.arm(a.id, 5);
    sc_core::sc_start();
    EXPECT_EQ(log, (Log{{5, "a"}, {8, "a"}}));
}

// A foreign module with timed events of its own, which also arms units.
struct Foreign : sc_core::sc_module {
    SC_HAS_PROCESS(Foreign);
    Foreign(const sc_core::sc_module_name& n, EventWheel& w, Log& l) : sc_module(n), wheel(w), log(l) {
        SC_THREAD(run);
    }
    void run() {
        for (int i = 1; i <= 5; ++i) {
            wait(sc_core::sc_time::from_value(100));
            EXPECT_EQ(wheel.now(), sc_core::sc_time_stamp().value());
            log.emplace_back(wheel.now(), "foreign");
            wheel.arm(unit, wheel.now() + 7);
        }
    }
    EventWheel& wheel;
    Log& log;
    int unit = 0;
};

TEST(EventWheel, NeverOvertakesTheKernel) {
    use_picosecond_resolution();
    EventWheel wheel("wheel");
    Log log;
    Unit ticker(wheel, "tick", log), armed(wheel, "armed", log);
    ticker.then = [](Picoseconds now) { return now < 640 ? now + 40 : kNever; };
    Foreign foreign("foreign", wheel, log);
    foreign.unit = armed.id;
    wheel.arm(ticker.id, 0);
    sc_core::sc_start();
    Picoseconds last = 0;
    int foreign_seen = 0, armed_seen = 0;
    for (const auto& [time, name] : log) {
        EXPECT_GE(time, last);  // one order of time over both worlds
        last = time;
        if (name == "foreign") {
            EXPECT_EQ(time, static_cast<Picoseconds>(++foreign_seen * 100));
        } else if (name == "armed") {
            EXPECT_EQ(time, static_cast<Picoseconds>(++armed_seen * 100 + 7));
        }
    }
    EXPECT_EQ(foreign_seen, 5);
    EXPECT_EQ(armed_seen, 5);
    EXPECT_EQ(log.size(), 17u + 10u);
    EXPECT_EQ(sc_core::sc_time_stamp().value(), 640u);
}

// A step notifies a kernel event nearer than the wheel's next step: the wheel must yield to it.
struct Listener : sc_core::sc_module {
    SC_HAS_PROCESS(Listener);
    Listener(const sc_core::sc_module_name& n, EventWheel& w, Log& l) : sc_module(n), wheel(w), log(l) {
        SC_METHOD(heard);
        sensitive << event;
        dont_initialize();
    }
    void heard() { log.emplace_back(wheel.now(), "heard"); }
    EventWheel& wheel;
    Log& log;
    sc_core::sc_event event;
};

TEST(EventWheel, YieldsToEventsMadeInsideAStep) {
    use_picosecond_resolution();
    EventWheel wheel("wheel");
    Log log;
    Listener listener("listener", wheel, log);
    Unit a(wheel, "a", log);
    a.then = [&](Picoseconds now) {
        // A call of an outside model carries the local delay; the model acts 3 ps later.
        if (now == 1000) {
            wheel.called_outside();
            listener.event.notify(wheel.local_delay() + sc_core::sc_time::from_value(3));
        }
        return now < 1010 ? now + 1 : kNever;
    };
    wheel.arm(a.id, 990);
    sc_core::sc_start();
    std::vector<Picoseconds> heard;
    std::size_t position = 0;
    for (std::size_t i = 0; i < log.size(); ++i)
        if (log[i].second == "heard") heard.push_back(log[i].first), position = i;
    EXPECT_THAT(heard, ElementsAre(1003));
    EXPECT_LE(log[position - 1].first, 1003u);
    EXPECT_GE(log[position + 1].first, 1003u);
}

void arm_in_the_past() {
    use_picosecond_resolution();
    EventWheel wheel("wheel");
    Log log;
    Unit a(wheel, "a", log), b(wheel, "b", log);
    a.then = [&](Picoseconds now) {
        wheel.arm(b.id, now - 1);
        return kNever;
    };
    wheel.arm(a.id, 5);
    sc_core::sc_start();
}

TEST(EventWheelDeathTest, RefusesThePast) {
    EXPECT_DEATH(arm_in_the_past(), "armed for 4 ps at 5 ps");
}

}  // namespace
}  // namespace ropsim
