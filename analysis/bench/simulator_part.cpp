// The simulator against itself: what each fidelity and sample costs the host, and how wrong it is.
#include "analysis/bench/bench.h"
#include "analysis/pareto_front.h"
#include "traces/trace.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr const char* kTruth = "timed";
// Per cent of the frame.
constexpr int kShares[] = {2, 5, 10, 20};

// Blending, nodes and stored samples: one operation a fragment, one with long chains, one with many surfaces.
std::vector<std::string> simulated_techniques(bool quick) {
    if (quick) return {"alpha_blend", "adaptive:nodes=8"};
    return {"alpha_blend", "adaptive:nodes=8", "stochastic:samples=8"};
}

std::vector<BenchCase> modes_of(const BenchCase& frame) {
    std::vector<BenchCase> modes;
    const auto add = [&](const std::string& mode, const std::vector<std::string>& options, bool sampled,
                         double share) {
        BenchCase c = frame;
        c.mode = mode;
        c.options = options;
        c.sampled = sampled;
        c.x = share;
        modes.push_back(std::move(c));
    };
    add("count", {"--fidelity", "count"}, false, 100);
    add("cached", {"--fidelity", "cached"}, false, 100);
    for (const int share : kShares)
        add(fmt::format("timed {}%", share),
            {"--fidelity", "timed", "--sample-tiles", fmt::format("{}%", share)}, true, share);
    add(kTruth, {"--fidelity", "timed"}, false, 100);
    return modes;
}

// Root mean square and largest of relative errors over the repeats.
struct Errors {
    Measured rms, largest;
};
Errors errors_of(const BenchCase& c, Measured BenchRepeat::*quantity, double truth) {
    double squares = 0;
    double largest = 0;
    if (c.repeats.empty() || truth <= 0) return {};
    for (const BenchRepeat& repeat : c.repeats) {
        const Measured& value = repeat.*quantity;
        if (!value) return {};
        const double error = *value / truth - 1;
        squares += error * error;
        largest = std::max(largest, std::abs(error));
    }
    return {std::sqrt(squares / static_cast<double>(c.repeats.size())), largest};
}

bool holds(const RecordedInterval& interval, double truth) {
    return interval.low <= truth && truth <= interval.high;
}

void count_intervals(SimulatorRow& row, const BenchCase& c, double cycles, double pins) {
    for (const BenchRepeat& repeat : c.repeats) {
        if (!repeat.cycles_interval || !repeat.pin_interval) continue;
        ++row.intervals;
        row.cycles_held += holds(*repeat.cycles_interval, cycles) ? 1 : 0;
        row.pins_held += holds(*repeat.pin_interval, pins) ? 1 : 0;
    }
}

SimulatorRow row_of(const BenchCase& c, const BenchCase& truth) {
    SimulatorRow row{c.series, c.technique, c.mode, 0, {}, {}, {}, {}, {}, {}, 0, 0, 0, false};
    row.seconds = median_interval(over_repeats(c, &BenchRepeat::processor_seconds)).estimate;
    if (truth.repeats.empty()) return row;
    row.processor_ratio = median_interval(paired_ratios(c, truth, &BenchRepeat::processor_seconds));
    row.wall_ratio = median_interval(paired_ratios(c, truth, &BenchRepeat::wall_seconds));
    const double cycles = truth.repeats[0].cycles.value_or(0);
    const double pins = truth.repeats[0].pin_bytes.value_or(0);
    const Errors of_cycles = errors_of(c, &BenchRepeat::cycles, cycles);
    const Errors of_pins = errors_of(c, &BenchRepeat::pin_bytes, pins);
    row.cycles_rms = of_cycles.rms;
    row.cycles_largest = of_cycles.largest;
    row.pins_rms = of_pins.rms;
    row.pins_largest = of_pins.largest;
    count_intervals(row, c, cycles, pins);
    return row;
}

bool same_frame(const SimulatorRow& a, const SimulatorRow& b) {
    return a.trace == b.trace && a.technique == b.technique;
}

// Of the rows of one frame that say something about cycles.
void mark_front(std::vector<SimulatorRow>& rows, std::size_t first, std::size_t end) {
    std::vector<CostAndError> points;
    std::vector<SimulatorRow*> owners;
    for (std::size_t i = first; i < end; ++i) {
        if (!rows[i].cycles_rms) continue;
        points.push_back({rows[i].seconds, *rows[i].cycles_rms});
        owners.push_back(&rows[i]);
    }
    const std::vector<bool> front = pareto_front(points);
    for (std::size_t i = 0; i < owners.size(); ++i) owners[i]->front = front[i];
}

}  // namespace

std::vector<BenchGroup> simulator_groups(const BenchOptions& options,
                                         const std::vector<std::string>& traces) {
    std::vector<BenchGroup> groups;
    for (const std::string& trace : traces) {
        const TraceReader reader(trace);
        BenchCase frame;
        frame.part = "simulator";
        frame.series = std::filesystem::path(trace).stem().string();
        frame.trace = trace;
        frame.trace_hash = reader.hash();
        frame.fragments = static_cast<double>(reader.fragment_count());
        for (const std::string& technique : simulated_techniques(options.quick)) {
            frame.technique = technique;
            groups.push_back({fmt::format("{} {}", frame.series, technique), modes_of(frame)});
        }
    }
    return groups;
}

std::vector<SimulatorRow> simulator_rows(const std::vector<BenchCase>& cases) {
    std::vector<SimulatorRow> rows;
    for (const BenchCase& c : cases) {
        if (c.part != "simulator" || c.repeats.empty()) continue;
        const auto truth = std::ranges::find_if(cases, [&](const BenchCase& other) {
            return other.part == c.part && other.mode == kTruth && other.trace == c.trace &&
                   other.technique == c.technique;
        });
        if (truth != cases.end()) rows.push_back(row_of(c, *truth));
    }
    for (std::size_t first = 0; first < rows.size();) {
        std::size_t end = first;
        while (end < rows.size() && same_frame(rows[first], rows[end])) ++end;
        mark_front(rows, first, end);
        first = end;
    }
    return rows;
}

}  // namespace ropsim
