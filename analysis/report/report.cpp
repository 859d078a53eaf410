// Puts the parts of the page together.
#include "analysis/report/report.h"

#include "analysis/comparison_table.h"
#include "analysis/html.h"
#include "analysis/report/report_bars.h"
#include "analysis/report/report_page.h"
#include "analysis/report/report_tables.h"
#include "analysis/report/report_widgets.h"
#include "analysis/standard_techniques.h"
#include "base/atomic_file.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <fmt/format.h>

namespace ropsim {
namespace {

std::string failures_only(const std::vector<RunRecord>& runs) {
    std::string out;
    for (const RunRecord& run : runs)
        if (!run.failure.empty())
            out +=
                fmt::format("<p>{}: failed: {}</p>\n", html_escape(run.technique), html_escape(run.failure));
    return out;
}

std::string facts(const ComparisonOfOneTrace& comparison) {
    double covered = 0, layers = 0, most = 0, ties = 0;
    const Image& reference = comparison.reference;
    const int layer_channel = reference.channel("layers"), tie_channel = reference.channel("ties");
    if (layer_channel >= 0) {
        for (int y = 0; y < reference.height; ++y)
            for (int x = 0; x < reference.width; ++x) {
                const double here = reference.pixel(x, y)[layer_channel];
                covered += here > 0 ? 1 : 0;
                layers += here;
                most = std::max(most, here);
                if (tie_channel >= 0) ties += reference.pixel(x, y)[tie_channel];
            }
    }
    std::string out = "<div class=\"facts\">";
    const auto fact = [&](const std::string& text) { out += "<span>" + html_escape(text) + "</span>"; };
    if (!comparison.scene.empty()) fact(comparison.scene);
    fact(fmt::format("{} × {} pixels, {} {} each", comparison.width, comparison.height, comparison.samples,
                     comparison.samples == 1 ? "sample" : "samples"));
    fact(report_number(comparison.fragments, 0) + " fragments");
    if (covered > 0) {
        const double pixels = static_cast<double>(reference.width) * reference.height;
        fact(fmt::format("{:.1f}% of pixels covered, {:.1f} visible layers there on average, {:.0f} at most",
                         100 * covered / pixels, layers / covered, most));
        if (ties > 0) fact(report_number(ties, 0) + " pairs of equal depth");
    }
    fact("hash " + comparison.hash);
    return out + "</div>\n";
}

// Every number of the comparison's table as an axis.
std::vector<PlotAxis> axes_of(const std::vector<ComparisonColumn>& columns) {
    std::vector<PlotAxis> axes;
    for (const ComparisonColumn& column : columns) {
        const bool larger = column.heading == "PSNR" || column.group == "simulator";
        axes.push_back({column.group == "traffic"     ? "bytes, " + column.heading
                        : column.group == "simulator" ? "simulator's " + column.heading
                                                      : column.heading,
                        column.unit, larger ? Better::kLarger : Better::kSmaller});
    }
    return axes;
}

void add_points(ReportPlot& plot, const ComparisonOfOneTrace& comparison, bool with_scene) {
    for (const RunRecord& run : comparison.runs) {
        if (!run.failure.empty()) continue;
        PlotPoint point{run.technique, {technique_families()[family_of(run.technique)], run.technique}, {}};
        if (with_scene) {
            point.name += ", " + comparison.name;
            point.groups.insert(point.groups.begin(), comparison.name);
        }
        for (const ComparisonColumn& column : comparison_columns()) {
            const Measured value = column.value(run);
            point.values.push_back(value && std::isfinite(*value) ? value : Measured());
        }
        plot.points.push_back(std::move(point));
    }
}

// Error over bytes, those on the pins where they were measured.
ReportPlot comparison_plot(const std::vector<const ComparisonOfOneTrace*>& comparisons, const std::string& id,
                           const std::string& command) {
    ReportPlot plot;
    plot.id = id;
    plot.caption = "Pick what stands on the axes; arrow keys step through the points.";
    plot.axes = axes_of(comparison_columns());
    plot.groupings = {"family", "technique"};
    if (comparisons.size() > 1) {
        plot.groupings.insert(plot.groupings.begin(), "scene");
        plot.within = "scene";
    }
    plot.command = command;
    for (const ComparisonOfOneTrace* comparison : comparisons)
        add_points(plot, *comparison, comparisons.size() > 1);
    plot.y = "RMSE";
    for (const char* name : {"bytes, touched", "bytes, pins"}) {
        const auto axis = std::find_if(plot.axes.begin(), plot.axes.end(),
                                       [&](const PlotAxis& candidate) { return candidate.name == name; });
        const std::ptrdiff_t place = axis - plot.axes.begin();
        if (std::any_of(plot.points.begin(), plot.points.end(), [&](const PlotPoint& point) {
                return point.values[static_cast<std::size_t>(place)].has_value();
            }))
            plot.x = name;
    }
    return plot;
}

ReportSection section_of(const ComparisonOfOneTrace& comparison, const std::string& id,
                         const ReportOptions& options, std::size_t sections) {
    ReportSection section{id, comparison.name};
    section += facts(comparison);
    const std::string table = number_table(comparison.runs, comparison_columns());
    section += table.empty() ? failures_only(comparison.runs) : table;
    section += sample_notes(comparison.runs);
    section +=
        "<p class=\"note\">Errors are of linear values against exact compositing; bytes are per fragment of "
        "the trace. A dash was not measured.</p>\n";
    ReportWidget plot = report_plot(comparison_plot({&comparison}, id + "-plot", options.command));
    if (!plot.html.empty()) section += "<h3>What each gives for what it takes</h3>\n";
    section += std::move(plot);
    const ReportBudget share{options.budget.picture_bytes / sections,
                             options.budget.inspector_bytes / sections};
    section += report_views(comparison, id, options.inspect, share);
    const std::string repeat = report_command(options.command);
    section += repeat;
    for (const std::string& bars : {traffic_bars(comparison.runs), stage_bars(comparison.runs)})
        if (!bars.empty()) section += bars + repeat;
    std::vector<RunRecord> successful;
    std::copy_if(comparison.runs.begin(), comparison.runs.end(), std::back_inserter(successful),
                 [](const RunRecord& run) { return run.failure.empty(); });
    const std::string memory = number_table(successful, memory_columns());
    if (!memory.empty()) section += "<h3>Memory system</h3>\n" + memory;
    section += path_table(comparison.runs) + configuration_list(comparison.runs);
    section += command_list(comparison.runs);
    return section;
}

}  // namespace

std::string report_html(const std::vector<ComparisonOfOneTrace>& comparisons, const ReportOptions& options) {
    ReportPage page(
        options.title.empty() ? "Transparency techniques compared" : options.title,
        "framebuffer operations simulated on captured fragments, judged against exact compositing.");
    if (comparisons.size() > 1) {
        std::vector<const ComparisonOfOneTrace*> all;
        all.reserve(comparisons.size());
        for (const ComparisonOfOneTrace& comparison : comparisons) all.push_back(&comparison);
        ReportSection section{"all-traces", "All traces"};
        section += report_plot(comparison_plot(all, "all-traces-plot", options.command));
        if (!section.html.empty()) page.add(std::move(section));
    }
    for (std::size_t i = 0; i < comparisons.size(); ++i)
        page.add(section_of(comparisons[i], fmt::format("trace-{}", i + 1), options, comparisons.size()));
    return page.html();
}

void write_report(const std::vector<ComparisonOfOneTrace>& comparisons, const ReportOptions& options,
                  const std::string& path) {
    write_file(path, report_html(comparisons, options));
}

}  // namespace ropsim
