// Everything measured, for readers.
#include "analysis/bench/bench_output.h"
#include "analysis/comparison_table.h"
#include "analysis/text_table.h"

#include <fmt/format.h>

namespace ropsim {
namespace {

using Rows = std::vector<std::vector<std::string>>;

std::string ratio_text(const std::optional<RankInterval>& ratio) {
    if (!ratio) return "-";
    if (ratio->confidence == 0) return fmt::format("{:.3g}", ratio->estimate);  // of one repeat
    return fmt::format("{:.3g} ({:.3g} to {:.3g})", ratio->estimate, ratio->low, ratio->high);
}

std::string percent(Measured share) {
    if (share) *share *= 100;
    return format_measured(share, 2, ",", "-");
}

std::string technique_table(const Tradeoff& tradeoff, std::size_t s) {
    Rows rows{{tradeoff.scenes[s].name, "frame ms", "pins B/fragment", "RMSE /255", "RMSE covered", "front"}};
    const std::vector<bool> time = scene_front(tradeoff, s, TradeoffBytes::kFrameTime);
    const std::vector<bool> pins = scene_front(tradeoff, s, TradeoffBytes::kPins);
    for (std::size_t i = 0; i < tradeoff.techniques.size(); ++i) {
        const TradeoffPoint& point = tradeoff.techniques[i].at[s];
        if (!point.failure.empty()) {
            rows.push_back({tradeoff.techniques[i].technique + "  " + point.failure});
            continue;
        }
        std::string front = time[i] ? "time" : "";
        if (pins[i]) front += front.empty() ? "bytes" : ", bytes";
        rows.push_back({tradeoff.techniques[i].technique, format_measured(point.frame_ms, 4, ",", "-"),
                        format_measured(point.pins, 1, ",", "-"), format_measured(point.rmse8, 3, ",", "-"),
                        format_measured(point.rmse8_covered, 3, ",", "-"), front});
    }
    return aligned_table(rows);
}

std::string held_text(const SimulatorRow& row, int held) {
    return row.intervals == 0 ? "-" : fmt::format("{} of {}", held, row.intervals);
}

std::string simulator_table(const std::vector<SimulatorRow>& simulator) {
    Rows rows{{"trace, technique, mode", "processor s", "ratio to timed (median, interval)", "cycles: RMS %",
               "largest %", "held", "pin bytes: RMS %", "largest %", "held", "front"}};
    for (const SimulatorRow& row : simulator)
        rows.push_back({fmt::format("{} {} {}", row.trace, row.technique, row.mode),
                        fmt::format("{:.3f}", row.seconds), ratio_text(row.processor_ratio),
                        percent(row.cycles_rms), percent(row.cycles_largest), held_text(row, row.cycles_held),
                        percent(row.pins_rms), percent(row.pins_largest), held_text(row, row.pins_held),
                        row.front ? "*" : ""});
    return aligned_table(rows);
}

std::string scaling_table(const std::vector<BenchCase>& cases) {
    Rows rows{{"series, technique, mode", "x", "fragments", "processor s (median, interval)", "wall s",
               "M fragments/s", "peak MiB", "repeats"}};
    for (const BenchCase& c : cases) {
        if (c.part != "scaling" || c.repeats.empty()) continue;
        const RankInterval wall = median_interval(over_repeats(c, &BenchRepeat::wall_seconds));
        rows.push_back(
            {fmt::format("{}, {} {}", c.series, c.technique, c.mode), fmt::format("{:.4g}", c.x),
             format_measured(c.fragments, 0, ",", "-"),
             ratio_text(median_interval(over_repeats(c, &BenchRepeat::processor_seconds))),
             fmt::format("{:.3g}", wall.estimate), fmt::format("{:.2f}", 1e-6 * c.fragments / wall.estimate),
             fmt::format("{:.0f}",
                         median_interval(over_repeats(c, &BenchRepeat::peak_rss_bytes)).estimate / (1 << 20)),
             fmt::format("{}", c.repeats.size())});
    }
    return aligned_table(rows);
}

std::string exponent_text(const PowerLawFit& fit) {
    if (!fit.law) return fit.why_not;
    return fmt::format("{:.3f} +- {:.3f}", fit.law->line.slope, fit.law->line.slope_half_width);
}

std::string fit_table(const std::vector<ScalingFit>& fits) {
    Rows rows{{"series, technique, mode", "exponent of processor time", "departs by %", "of memory"}};
    for (const ScalingFit& fit : fits)
        rows.push_back({fmt::format("{}, {} {}", fit.series, fit.technique, fit.mode),
                        exponent_text(fit.time),
                        fit.time.law ? fmt::format("{:.0f}", fit.time.law->largest_departure_percent) : "-",
                        exponent_text(fit.memory)});
    return aligned_table(rows);
}

std::string thread_table(const std::vector<ThreadRow>& threads) {
    Rows rows{{"technique, mode", "threads", "speed-up (median, interval)", "processor time, ratio"}};
    for (const ThreadRow& row : threads)
        rows.push_back({fmt::format("{} {}", row.technique, row.mode), fmt::format("{}", row.threads),
                        ratio_text(row.speed_up), ratio_text(row.processor_ratio)});
    return aligned_table(rows);
}

std::string failures(const std::vector<BenchCase>& cases) {
    std::string text;
    for (const BenchCase& c : cases)
        if (!c.failure.empty()) text += fmt::format("{}: {}\n", c.id(), c.failure);
    return text;
}

}  // namespace

std::string bench_tables(const Bench& bench) {
    std::string text;
    const auto add = [&text](const std::string& table) {
        if (!table.empty()) text += (text.empty() ? "" : "\n") + table;
    };
    if (bench.techniques)
        for (std::size_t s = 0; s < bench.techniques->scenes.size(); ++s)
            add(technique_table(*bench.techniques, s));
    if (!bench.simulator.empty()) add(simulator_table(bench.simulator));
    if (!bench.fits.empty()) add(scaling_table(bench.cases) + "\n" + fit_table(bench.fits));
    if (!bench.threads.empty()) add(thread_table(bench.threads));
    add(failures(bench.cases));
    return text;
}

}  // namespace ropsim
