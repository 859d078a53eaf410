// Bars are flex boxes with widths in percent: they scale to the page and need no script.
#include "analysis/report/report_bars.h"

#include "analysis/comparison_table.h"
#include "analysis/html.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr std::size_t kHues = 7;  // classes h0..h6 of the style sheet; "rest" beyond

struct Segment {
    std::string style;  // class
    double value;
    std::string title;  // shown by a pointer that rests on it
};

// Names and their classes, the largest total first.
class Legend {
 public:
    void add(const std::string& name, double value) { totals_[name] += value; }
    void close() {
        std::vector<std::pair<double, std::string>> order;
        for (const auto& [name, total] : totals_) order.emplace_back(-total, name);
        std::sort(order.begin(), order.end());
        for (const auto& [total, name] : order) {
            names_.push_back(name);
            const std::size_t place = names_.size() - 1;
            classes_[name] = place < kHues ? fmt::format("h{}", place) : "rest";
        }
    }
    const std::vector<std::string>& names() const { return names_; }
    const std::string& style(const std::string& name) const { return classes_.at(name); }
    std::string html() const {
        std::string out;
        for (std::size_t i = 0; i < std::min(kHues, names_.size()); ++i)
            out += fmt::format("<span><i class=\"h{}\"></i>{}</span>", i, html_escape(names_[i]));
        if (names_.size() > kHues) out += "<span><i class=\"rest\"></i>others</span>";
        return out;
    }

 private:
    std::map<std::string, double> totals_;
    std::map<std::string, std::string> classes_;
    std::vector<std::string> names_;
};

std::string bar(const std::string& label, const std::vector<Segment>& segments, double full,
                const std::string& value) {
    std::string out = fmt::format("<span class=\"label\">{}</span><span class=\"bar\">", html_escape(label));
    for (const Segment& segment : segments) {
        if (segment.value <= 0) continue;
        out += fmt::format("<i class=\"{}\" style=\"width:{:.3f}%\" title=\"{}\"></i>", segment.style,
                           100.0 * segment.value / full, html_escape(segment.title));
    }
    return out + fmt::format("</span><span class=\"value\">{}</span>\n", value);
}

// The bars of one technique.
std::string group(const std::string& technique, const std::string& rows) {
    if (rows.empty()) return {};
    return fmt::format("<div><h4>{}</h4>\n<div class=\"rows\">\n{}</div></div>\n", html_escape(technique),
                       rows);
}

// The three kinds of count, from the most pessimistic to what memory sees.
struct Kind {
    const char* label;
    Measured RecordedTraffic::*read;
    Measured RecordedTraffic::*write;
};
constexpr Kind kKinds[] = {
    {"worst case", &RecordedTraffic::worst_case_read, &RecordedTraffic::worst_case_write},
    {"touched", &RecordedTraffic::read, &RecordedTraffic::write},
    {"pins", &RecordedTraffic::pin_read, &RecordedTraffic::pin_write},
};

bool countable(const RunRecord& run) {
    return run.failure.empty() && run.fragments.value_or(0.0) > 0;
}

double bytes_per_fragment(const RunRecord& run, const Kind& kind) {
    double sum = 0;
    for (const RecordedTraffic& surface : run.surfaces)
        sum += sum_of(surface.*kind.read, surface.*kind.write).value_or(0.0);
    return sum / *run.fragments;
}

std::string traffic_rows(const RunRecord& run, const Legend& legend, double full) {
    std::string out;
    for (const Kind& kind : kKinds) {
        std::vector<Segment> segments;
        for (const std::string& name : legend.names()) {
            for (const RecordedTraffic& surface : run.surfaces) {
                if (surface.surface != name) continue;
                const Measured bytes = sum_of(surface.*kind.read, surface.*kind.write);
                if (!bytes) continue;
                const auto share = [&](const Measured& part) {
                    return format_measured(part ? Measured(*part / *run.fragments) : part, 2, "\u202f", "–");
                };
                segments.push_back({legend.style(name), *bytes / *run.fragments,
                                    fmt::format("{}: {} B read, {} B written per fragment", name,
                                                share(surface.*kind.read), share(surface.*kind.write))});
            }
        }
        if (segments.empty()) continue;
        out +=
            bar(kind.label, segments, full, format_measured(bytes_per_fragment(run, kind), 1, "\u202f", "–"));
    }
    return out;
}

double stage_total(const RecordedStage& stage) {
    double total = stage.busy.value_or(0.0) + stage.idle.value_or(0.0);
    for (const auto& [reason, cycles] : stage.stalls) total += cycles;
    return total;
}

std::string stage_row(const RecordedStage& stage, const Legend& legend) {
    const double total = stage_total(stage);
    if (total <= 0) return {};
    const auto title = [&](const std::string& name, double cycles) {
        return fmt::format("{}: {} cycles, {:.1f}%", name, format_measured(cycles, 0, "\u202f", "–"),
                           100 * cycles / total);
    };
    std::vector<Segment> segments{
        {"busy", stage.busy.value_or(0.0), title("busy", stage.busy.value_or(0.0))}};
    for (const std::string& reason : legend.names())
        for (const auto& [name, cycles] : stage.stalls)
            if (name == reason)
                segments.push_back({legend.style(reason), cycles, title("stall, " + reason, cycles)});
    segments.push_back({"idle", stage.idle.value_or(0.0), title("idle", stage.idle.value_or(0.0))});
    return bar(stage.stage, segments, total, fmt::format("{:.0f}%", 100 * stage.busy.value_or(0.0) / total));
}

}  // namespace

std::string traffic_bars(const std::vector<RunRecord>& runs) {
    Legend legend;
    double full = 0;
    for (const RunRecord& run : runs) {
        if (!countable(run)) continue;
        for (const Kind& kind : kKinds) full = std::max(full, bytes_per_fragment(run, kind));
        for (const RecordedTraffic& surface : run.surfaces)
            legend.add(surface.surface, sum_of(surface.read, surface.write).value_or(0.0) / *run.fragments);
    }
    if (full <= 0) return {};
    legend.close();
    std::string out =
        "<figure class=\"bars\"><figcaption><b>Bytes by surface</b>, bytes per fragment of the trace, reads "
        "and writes "
        "together, clear, copy and resolve included</figcaption>\n<div class=\"legend\">" +
        legend.html() + "</div>\n<div class=\"groups\">\n";
    for (const RunRecord& run : runs)
        if (countable(run)) out += group(run.technique, traffic_rows(run, legend, full));
    return out + "</div></figure>\n";
}

std::string stage_bars(const std::vector<RunRecord>& runs) {
    Legend legend;
    bool any = false;
    for (const RunRecord& run : runs) {
        if (!run.failure.empty()) continue;
        for (const RecordedStage& stage : run.stages) {
            any = any || stage_total(stage) > 0;
            for (const auto& [reason, cycles] : stage.stalls) legend.add(reason, cycles);
        }
    }
    if (!any) return {};
    legend.close();
    std::string out =
        "<figure class=\"bars cycles\"><figcaption><b>Where the cycles went</b>, share of each stage’s "
        "cycles; at the right "
        "the share it was busy</figcaption>\n<div class=\"legend\"><span><i class=\"busy\"></i>busy</span>" +
        legend.html() + "<span><i class=\"idle\"></i>idle</span></div>\n<div class=\"groups\">\n";
    for (const RunRecord& run : runs) {
        if (!run.failure.empty()) continue;
        std::string rows;
        for (const RecordedStage& stage : run.stages) rows += stage_row(stage, legend);
        out += group(run.technique, rows);
    }
    return out + "</div></figure>\n";
}

}  // namespace ropsim
