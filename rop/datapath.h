// The arithmetic of framebuffer operations. A technique is a template over the datapath: PlainDatapath is
// values only and costs nothing; ChargedDatapath computes the same values, counts the units used and finds
// the longest dependence chain, so that cost is measured from the code that makes the image.
#pragma once

#include "base/error.h"
#include "base/random.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <string_view>
#include <vector>

namespace ropsim {

enum class Unit : std::uint8_t {
    kAdder,              // float add or subtract
    kMultiplier,         // float multiply
    kDivider,            // float divide or reciprocal
    kComparator,         // float or integer compare
    kMux,                // 2:1 select of one word
    kIntegerAdder,       // 32-bit add, and float-to-integer rounding
    kIntegerMultiplier,  // 32 x 32 -> 32 or 64
    kLogic,              // bitwise operation or shift on a word, bit reversal, population count
    kConverter,          // stored format to or from float
    kRandom,             // one 32-bit draw of the counter-based generator
    kTable,              // one read of a constant table
    kTranscendental,     // logarithm, exponential, sine, cosine, square root
    kFetchStage,         // wait for bytes whose fetch depends on bytes fetched before
    kCount,
};
inline constexpr int kUnitCount = static_cast<int>(Unit::kCount);
inline constexpr std::array<std::string_view, kUnitCount> kUnitNames = {
    "adder",         "multiplier",         "divider",    "comparator", "mux",
    "integer_adder", "integer_multiplier", "logic",      "converter",  "random",
    "table",         "transcendental",     "fetch_stage"};

// Latency of each unit in ROP cycles and how many of each a pixel lane has (0: as many as the operation
// needs).
struct DatapathShape {
    std::array<int, kUnitCount> latency{};
    std::array<int, kUnitCount> budget{};
};

using UnitCounts = std::array<std::uint32_t, kUnitCount>;

// What one stretch of an operation used.
struct Work {
    UnitCounts units{};
    int latency = 0;  // cycles along the longest chain

    bool operator==(const Work&) const = default;
};

// Where charged wires charge. One is active a thread while a charged operation runs.
class Ledger {
 public:
    explicit Ledger(const DatapathShape& shape) : shape_(shape), previous_(active_) { active_ = this; }
    ~Ledger() { active_ = previous_; }
    Ledger(const Ledger&) = delete;
    Ledger& operator=(const Ledger&) = delete;

    static Ledger& active() {
        CHECK(active_ != nullptr);
        return *active_;
    }
    // Uses one `unit` on operands ready at `ready`; returns when the result is.
    int charge(Unit unit, int ready) {
        ++work_.units[static_cast<std::size_t>(unit)];
        const int done = ready + shape_.latency[static_cast<std::size_t>(unit)];
        work_.latency = std::max(work_.latency, done);
        return done;
    }
    const Work& work() const { return work_; }
    const DatapathShape& shape() const { return shape_; }

 private:
    // NOLINTNEXTLINE(readability-identifier-naming): a private member like the others
    static inline thread_local Ledger* active_ = nullptr;
    const DatapathShape& shape_;
    Ledger* previous_;
    Work work_;
};

// A value and the cycle it is ready. Constants and fragment attributes are ready at once.
template <class T>
struct Wire {
    T value{};
    int ready = 0;
    Wire() = default;
    Wire(T v) : value(v) {}  // NOLINT: constants become wires by themselves
    Wire(T v, int r) : value(v), ready(r) {}
};

struct PlainDatapath {
    static constexpr bool kCharged = false;
    using Real = float;
    using Uint = std::uint32_t;
    using Bool = bool;
    static bool decide(bool condition) { return condition; }
    template <class Body>
    void steps(int kind, std::uint32_t count, Body body) {
        step_count[static_cast<std::size_t>(kind)] += count;
        for (std::uint32_t i = 0; i < count; ++i) body(i);
    }
    // A loop that the plain datapath replaces by a shortcut still reports its steps.
    void count_steps(int kind, std::uint32_t count) { step_count[static_cast<std::size_t>(kind)] += count; }
    std::array<std::uint32_t, 2> step_count{};
};

// Decisions are taken from the values, or, while the control paths are enumerated, from a script.
class ChargedDatapath {
 public:
    static constexpr bool kCharged = true;
    using Real = Wire<float>;
    using Uint = Wire<std::uint32_t>;
    using Bool = Wire<bool>;

    ChargedDatapath() = default;
    explicit ChargedDatapath(std::vector<bool>* script) : script_(script) {}

    bool enumerating() const { return script_ != nullptr; }

    // A point where hardware takes one of two control paths. The condition's own units are already charged.
    bool decide(Wire<bool> condition) {
        if (script_ == nullptr) return condition.value;
        if (next_ == script_->size()) script_->push_back(false);
        return (*script_)[next_++];
    }

    // `count` repetitions of one step of a list, charged apart from the rest: the body's work is taken once
    // (and must be the same every time), the count is reported. While enumerating, one step is run.
    template <class Body>
    void steps(int kind, std::uint32_t count, Body body) {
        const auto k = static_cast<std::size_t>(kind);
        step_count[k] += count;
        const std::uint32_t repetitions = enumerating() ? 1 : count;
        for (std::uint32_t i = 0; i < repetitions; ++i) {
            Ledger step(Ledger::active().shape());
            body(i);
            CHECK(!step_known[k] || step_work[k] == step.work(), "step kind {} costs vary", kind);
            step_work[k] = step.work();
            step_known[k] = true;
        }
    }
    void count_steps(int, std::uint32_t) {}

    std::array<std::uint32_t, 2> step_count{};
    std::array<Work, 2> step_work{};
    std::array<bool, 2> step_known{};

 private:
    std::vector<bool>* script_ = nullptr;
    std::size_t next_ = 0;
};

namespace detail {
template <class R, class A, class B>
Wire<R> binary(Unit unit, R value, const Wire<A>& a, const Wire<B>& b) {
    return {value, Ledger::active().charge(unit, std::max(a.ready, b.ready))};
}
}  // namespace detail

inline Wire<float> operator+(Wire<float> a, Wire<float> b) {
    return detail::binary(Unit::kAdder, a.value + b.value, a, b);
}
inline Wire<float> operator-(Wire<float> a, Wire<float> b) {
    return detail::binary(Unit::kAdder, a.value - b.value, a, b);
}
inline Wire<float> operator*(Wire<float> a, Wire<float> b) {
    return detail::binary(Unit::kMultiplier, a.value * b.value, a, b);
}
inline Wire<float> operator/(Wire<float> a, Wire<float> b) {
    return detail::binary(Unit::kDivider, a.value / b.value, a, b);
}
inline Wire<bool> operator<(Wire<float> a, Wire<float> b) {
    return detail::binary(Unit::kComparator, a.value < b.value, a, b);
}
inline Wire<bool> operator<=(Wire<float> a, Wire<float> b) {
    return detail::binary(Unit::kComparator, a.value <= b.value, a, b);
}
inline Wire<bool> operator<(Wire<std::uint32_t> a, Wire<std::uint32_t> b) {
    return detail::binary(Unit::kComparator, a.value < b.value, a, b);
}
inline Wire<bool> operator==(Wire<std::uint32_t> a, Wire<std::uint32_t> b) {
    return detail::binary(Unit::kComparator, a.value == b.value, a, b);
}
inline Wire<std::uint32_t> operator+(Wire<std::uint32_t> a, Wire<std::uint32_t> b) {
    return detail::binary(Unit::kIntegerAdder, a.value + b.value, a, b);
}
inline Wire<std::uint32_t> operator-(Wire<std::uint32_t> a, Wire<std::uint32_t> b) {
    return detail::binary(Unit::kIntegerAdder, a.value - b.value, a, b);
}
inline Wire<std::uint32_t> operator*(Wire<std::uint32_t> a, Wire<std::uint32_t> b) {
    return detail::binary(Unit::kIntegerMultiplier, a.value * b.value, a, b);
}
inline Wire<std::uint32_t> operator^(Wire<std::uint32_t> a, Wire<std::uint32_t> b) {
    return detail::binary(Unit::kLogic, a.value ^ b.value, a, b);
}
inline Wire<std::uint32_t> operator|(Wire<std::uint32_t> a, Wire<std::uint32_t> b) {
    return detail::binary(Unit::kLogic, a.value | b.value, a, b);
}
inline Wire<std::uint32_t> operator&(Wire<std::uint32_t> a, Wire<std::uint32_t> b) {
    return detail::binary(Unit::kLogic, a.value & b.value, a, b);
}
inline Wire<bool> both(Wire<bool> a, Wire<bool> b) {
    return detail::binary(Unit::kLogic, a.value && b.value, a, b);
}
inline bool both(bool a, bool b) {
    return a && b;
}
inline Wire<bool> either(Wire<bool> a, Wire<bool> b) {
    return detail::binary(Unit::kLogic, a.value || b.value, a, b);
}
inline bool either(bool a, bool b) {
    return a || b;
}
// Inverters are free: they fold into the logic they feed.
inline Wire<bool> inverse(Wire<bool> a) {
    return {!a.value, a.ready};
}
inline bool inverse(bool a) {
    return !a;
}

template <class T>
Wire<T> select(Wire<bool> condition, Wire<T> a, Wire<T> b) {
    const int ready = std::max({condition.ready, a.ready, b.ready});
    return {condition.value ? a.value : b.value, Ledger::active().charge(Unit::kMux, ready)};
}
template <class T>
T select(bool condition, T a, T b) {
    return condition ? a : b;
}

// A selector of one word out of `inputs`, all ready at `ready`: a tree of 2:1 muxes. Returns when its output
// is.
inline int charge_selector(int inputs, int ready) {
    for (; inputs > 1; inputs = (inputs + 1) / 2) {
        int done = ready;
        for (int i = 0; i < inputs / 2; ++i) done = Ledger::active().charge(Unit::kMux, ready);
        ready = done;
    }
    return ready;
}

// The sign bit is a wire.
inline Wire<float> negative(const Wire<float>& a) {
    return {-a.value, a.ready};
}
inline float negative(float a) {
    return -a;
}
inline Wire<float> magnitude(const Wire<float>& a) {
    return {a.value < 0.0f ? -a.value : a.value, a.ready};
}
inline float magnitude(float a) {
    return a < 0.0f ? -a : a;
}

// The larger and smaller of two: a comparator and a mux.
inline Wire<float> minimum(Wire<float> a, Wire<float> b) {
    return select(a < b, a, b);
}
inline float minimum(float a, float b) {
    return a < b ? a : b;
}
inline Wire<float> maximum(Wire<float> a, Wire<float> b) {
    return select(a < b, b, a);
}
inline float maximum(float a, float b) {
    return a < b ? b : a;
}

inline std::uint32_t reverse_bits(std::uint32_t x) {
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0F0F0F0Fu) | ((x & 0x0F0F0F0Fu) << 4);
    x = ((x >> 8) & 0x00FF00FFu) | ((x & 0x00FF00FFu) << 8);
    return (x >> 16) | (x << 16);
}
// Wires crossed, no gates.
inline Wire<std::uint32_t> reverse_bits(Wire<std::uint32_t> x) {
    return {reverse_bits(x.value), x.ready};
}

// By a constant: wiring.
constexpr std::uint32_t shifted_right(std::uint32_t x, int shift) {
    return x >> shift;
}
inline Wire<std::uint32_t> shifted_right(const Wire<std::uint32_t>& x, int shift) {
    return {x.value >> shift, x.ready};
}

inline std::uint32_t population_count(std::uint32_t x) {
    return static_cast<std::uint32_t>(std::popcount(x));
}
inline Wire<std::uint32_t> population_count(Wire<std::uint32_t> x) {
    return {population_count(x.value), Ledger::active().charge(Unit::kLogic, x.ready)};
}

// floor of a non-negative float: a shift by the exponent, charged as an integer adder.
inline std::uint32_t floor_to_uint(float x) {
    return static_cast<std::uint32_t>(x);
}
inline Wire<std::uint32_t> floor_to_uint(Wire<float> x) {
    return {floor_to_uint(x.value), Ledger::active().charge(Unit::kIntegerAdder, x.ready)};
}

// An integer below 2^24 as a float: the shift that floor_to_uint makes, the other way.
inline float to_real(std::uint32_t x) {
    return static_cast<float>(x);
}
inline Wire<float> to_real(const Wire<std::uint32_t>& x) {
    return {to_real(x.value), Ledger::active().charge(Unit::kIntegerAdder, x.ready)};
}

// Bit `index` (a constant) of a mask: wiring.
inline bool bit(std::uint32_t mask, int index) {
    return ((mask >> index) & 1u) != 0;
}
inline Wire<bool> bit(Wire<std::uint32_t> mask, int index) {
    return {bit(mask.value, index), mask.ready};
}

// One 32-bit draw of the generator keyed by a fragment.
template <class D>
typename D::Uint draw_bits(std::uint64_t key, std::uint32_t draw) {
    const std::uint32_t value = random_bits(key, draw);
    if constexpr (D::kCharged)
        return {value, Ledger::active().charge(Unit::kRandom, 0)};
    else
        return value;
}
// Uniform in [0, 1).
template <class D>
typename D::Real draw_unit(std::uint64_t key, std::uint32_t draw) {
    const float value = random_unit(key, draw);
    if constexpr (D::kCharged)
        return {value, Ledger::active().charge(Unit::kRandom, 0)};
    else
        return value;
}

template <class T>
T value_of(const Wire<T>& wire) {
    return wire.value;
}
inline float value_of(float v) {
    return v;
}
inline std::uint32_t value_of(std::uint32_t v) {
    return v;
}
inline bool value_of(bool v) {
    return v;
}

}  // namespace ropsim
