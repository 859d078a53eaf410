// How run time and memory grow with fragments, pixels, depth complexity and threads, each alone.
#include "analysis/bench/bench.h"
#include "analysis/bench/layered_traces.h"
#include "base/parallel.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr int kLayers = 16;
constexpr int kLargestEdge = 8192;
// Beyond, a run takes minutes: `timed` is left out, and the others are not repeated more than three times.
constexpr double kLarge = 2e7;

constexpr const char* kTechniques[] = {"alpha_blend", "adaptive:nodes=8"};

std::vector<std::string> fidelities(bool quick) {
    if (quick) return {"count", "timed"};
    return {"count", "cached", "timed"};
}

struct Value {
    double x;
    LayeredSize size;
};

int edge_of(double pixels) {
    return std::max(1, static_cast<int>(std::lround(std::sqrt(pixels))));
}

// As many layers everywhere, so the image grows with the fragments.
std::vector<Value> fragment_series(double largest) {
    std::vector<Value> values;
    const double smallest = std::min(1e5, largest / 8);
    for (int i = 0; i < 4; ++i) {
        const int edge = edge_of(smallest * std::pow(largest / smallest, i / 3.0) / kLayers);
        values.push_back({static_cast<double>(edge) * edge * kLayers, {edge, kLayers, edge}});
    }
    return values;
}

// The same fragments in the corner of a larger image: pixels without any.
std::vector<Value> resolution_series(double fragments, bool quick) {
    std::vector<Value> values;
    const int edge = edge_of(fragments / kLayers);
    for (int image = edge; image <= std::min(edge * (quick ? 4 : 8), kLargestEdge); image *= 2)
        values.push_back({static_cast<double>(image) * image, {edge, kLayers, image}});
    return values;
}

// As many fragments on fewer pixels.
std::vector<Value> depth_series(double fragments, bool quick) {
    std::vector<Value> values;
    for (int layers = 4; layers <= (quick ? 64 : 256); layers *= 4) {
        const int edge = edge_of(fragments / layers);
        values.push_back({static_cast<double>(layers), {edge, layers, edge}});
    }
    return values;
}

BenchCase case_of(const std::string& series, const Value& value, const BenchOptions& options) {
    BenchCase c;
    c.part = "scaling";
    c.series = series;
    c.x = value.x;
    c.trace = layered_trace(options.directory + "/traces", value.size);
    c.layers = value.size;
    c.fragments = static_cast<double>(value.size.fragments());
    if (c.fragments > kLarge) c.most_repeats = 3;
    return c;
}

// One technique and fidelity; the traces are not there yet.
BenchGroup group_of(const std::string& series, const std::vector<Value>& values, const std::string& technique,
                    const std::string& fidelity, const BenchOptions& options) {
    BenchGroup group{fmt::format("{}, {} {}", series, technique, fidelity), {}};
    for (const Value& value : values) {
        BenchCase c = case_of(series, value, options);
        if (fidelity == "timed" && c.fragments > kLarge) continue;
        c.technique = technique;
        c.mode = fidelity;
        c.options = {"--fidelity", fidelity};
        group.cases.push_back(std::move(c));
    }
    return group;
}

BenchGroup thread_group(const Value& value, const std::string& technique, const std::string& fidelity,
                        const BenchOptions& options) {
    BenchGroup group{fmt::format("threads, {} {}", technique, fidelity), {}};
    const int cores = default_threads();
    for (int threads = 1; threads <= cores;
         threads = threads == cores ? cores + 1 : std::min(2 * threads, cores)) {
        BenchCase c = case_of("threads", value, options);
        c.technique = technique;
        c.mode = fidelity;
        c.options = {"--fidelity", fidelity};
        c.threads = threads;
        c.x = threads;
        group.cases.push_back(std::move(c));
    }
    return group;
}

std::vector<Replicates> replicates_of(const std::vector<const BenchCase*>& line,
                                      double BenchRepeat::*quantity) {
    std::vector<Replicates> points;
    for (const BenchCase* c : line) points.push_back({c->x, over_repeats(*c, quantity)});
    return points;
}

bool same_line(const BenchCase& a, const BenchCase& b) {
    return a.part == b.part && a.series == b.series && a.technique == b.technique && a.mode == b.mode;
}

}  // namespace

std::vector<BenchGroup> scaling_groups(const BenchOptions& options) {
    const double fragments = static_cast<double>(options.fragments) / (options.quick ? 4 : 1);
    std::vector<BenchGroup> groups;
    for (const auto& [series, values] :
         {std::pair{"fragments", fragment_series(static_cast<double>(options.largest))},
          {"pixels", resolution_series(fragments, options.quick)},
          {"depth complexity", depth_series(fragments, options.quick)}})
        for (const char* technique : kTechniques)
            for (const std::string& fidelity : fidelities(options.quick))
                groups.push_back(group_of(series, values, technique, fidelity, options));
    const int edge = edge_of(fragments / kLayers);
    for (const char* technique : kTechniques)
        for (const std::string& fidelity : fidelities(options.quick))
            groups.push_back(thread_group({1, {edge, kLayers, edge}}, technique, fidelity, options));
    return groups;
}

std::vector<ScalingFit> scaling_fits(const std::vector<BenchCase>& cases) {
    std::vector<ScalingFit> fits;
    for (std::size_t first = 0; first < cases.size();) {
        std::vector<const BenchCase*> line;
        std::size_t end = first;
        for (; end < cases.size() && same_line(cases[first], cases[end]); ++end)
            if (!cases[end].repeats.empty()) line.push_back(&cases[end]);
        const BenchCase& c = cases[first];
        if (c.part == "scaling" && c.series != "threads")
            fits.push_back({c.series, c.technique, c.mode,
                            fit_power_law(c.series, replicates_of(line, &BenchRepeat::processor_seconds)),
                            fit_power_law(c.series, replicates_of(line, &BenchRepeat::peak_rss_bytes))});
        first = end;
    }
    return fits;
}

std::vector<ThreadRow> thread_rows(const std::vector<BenchCase>& cases) {
    std::vector<ThreadRow> rows;
    for (const BenchCase& c : cases) {
        if (c.series != "threads" || c.repeats.empty()) continue;
        const auto one = std::ranges::find_if(
            cases, [&](const BenchCase& other) { return same_line(c, other) && other.threads == 1; });
        if (one == cases.end() || one->repeats.empty()) continue;
        rows.push_back({c.technique, c.mode, c.threads,
                        median_interval(paired_ratios(*one, c, &BenchRepeat::wall_seconds)),
                        median_interval(paired_ratios(c, *one, &BenchRepeat::processor_seconds))});
    }
    return rows;
}

}  // namespace ropsim
