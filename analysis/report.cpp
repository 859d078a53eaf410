// Puts the parts of the page together.
#include "analysis/report.h"

#include "analysis/child_process.h"
#include "analysis/comparison_table.h"
#include "analysis/html.h"
#include "analysis/report_bars.h"
#include "analysis/report_pictures.h"
#include "analysis/report_style.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "base/version.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <optional>

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr const char* kThinSpace = "\u202f";

std::string number(const Measured& value, int decimals) {
    const std::string text = format_measured(value, decimals, kThinSpace, "–");
    return text == "inf" ? "∞" : text;
}

// A technique's name that a narrow column may break before its parameters.
std::string breakable(const std::string& technique) {
    std::string out;
    for (const char c : html_escape(technique)) {
        out += c;
        if (c == ':' || c == ',') out += "<wbr>";
    }
    return out;
}

bool any_measured(const Column& column, const std::vector<RunRecord>& runs) {
    return std::any_of(runs.begin(), runs.end(), [&](const RunRecord& run) {
        return run.failure.empty() && column.value(run).has_value();
    });
}

// A row above the headings, where columns belong together.
std::string group_row(const std::vector<const Column*>& columns) {
    std::string out = "<tr class=\"over\"><td></td>";
    bool any = false;
    for (std::size_t i = 0; i < columns.size();) {
        std::size_t end = i + 1;
        while (end < columns.size() && columns[end]->group == columns[i]->group) ++end;
        any = any || !columns[i]->group.empty();
        out += fmt::format("<th scope=\"colgroup\" colspan=\"{}\"><span>{}</span></th>", end - i,
                           html_escape(columns[i]->group));
        i = end;
    }
    return any ? out + "</tr>\n" : "";
}

// Columns that no run measured are left out.
std::string number_table(const std::vector<RunRecord>& runs, const std::vector<Column>& all) {
    std::vector<const Column*> columns;
    for (const Column& column : all)
        if (any_measured(column, runs)) columns.push_back(&column);
    if (columns.empty()) return {};
    std::string out = "<div class=\"scroll\"><table class=\"wide\">\n<thead>" + group_row(columns) +
                      "<tr><th scope=\"col\">technique</th>";
    for (const Column* column : columns)
        out += fmt::format("<th scope=\"col\" title=\"{}\">{}<small>{}</small></th>",
                           html_escape(column->meaning), html_escape(column->heading),
                           html_escape(column->unit));
    out += "</tr></thead>\n<tbody>\n";
    for (const RunRecord& run : runs) {
        out += fmt::format("<tr><th scope=\"row\">{}</th>", breakable(run.technique));
        if (!run.failure.empty())
            out += fmt::format("<td class=\"failed\" colspan=\"{}\">failed: {}</td>", columns.size(),
                               html_escape(run.failure));
        else
            for (const Column* column : columns) {
                const std::string text = number(column->value(run), column->decimals);
                out += fmt::format("<td{}>{}</td>", text == "–" ? " class=\"none\"" : "", text);
            }
        out += "</tr>\n";
    }
    return out + "</tbody></table></div>\n";
}

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
    fact(number(comparison.fragments, 0) + " fragments");
    if (covered > 0) {
        const double pixels = static_cast<double>(reference.width) * reference.height;
        fact(fmt::format("{:.1f}% of pixels covered, {:.1f} visible layers there on average, {:.0f} at most",
                         100 * covered / pixels, layers / covered, most));
        if (ties > 0) fact(number(ties, 0) + " pairs of equal depth");
    }
    fact("hash " + comparison.hash);
    return out + "</div>\n";
}

// A picture stored once in the page and drawn wherever it is used.
std::string stored(const std::string& id, const Picture& picture) {
    return fmt::format(
        "<svg class=\"store\" aria-hidden=\"true\"><defs><image id=\"{}\" width=\"{}\" height=\"{}\" "
        "href=\"{}\"/></defs></svg>\n",
        id, picture.width, picture.height, data_uri(picture));
}

std::string used(const std::string& id, const Region& region, int reduction, const char* style) {
    return fmt::format(
        "<svg class=\"reference{}\" role=\"img\" aria-label=\"reference\" viewBox=\"0 0 {} {}\">"
        "<use href=\"#{}\"/></svg>",
        style, (region.width + reduction - 1) / reduction, (region.height + reduction - 1) / reduction, id);
}

std::string embedded(const Picture& picture, const std::string& text, const char* style) {
    return fmt::format("<img class=\"{}\" width=\"{}\" height=\"{}\" alt=\"{}\" src=\"{}\">", style,
                       picture.width, picture.height, html_escape(text), data_uri(picture));
}

struct Views {
    Region whole, detail;
    int reduction;
    std::string id;
};

std::string triple(const Image& image, const Image& reference, const Region& region, int reduction,
                   const std::string& id, const std::string& name, bool pixels) {
    const char* style = pixels ? "pixels" : "";
    return "<div class=\"triple\">" + embedded(image_picture(image, region, reduction), name, style) +
           embedded(difference_picture(image, reference, region, reduction), name + ", difference times 8",
                    style) +
           used(id, region, reduction, pixels ? " pixels" : "") + "</div>\n";
}

std::string pictures_of(const RunRecord& run, const Image& image, const Image& reference,
                        const Views& views) {
    std::string out =
        fmt::format("<div class=\"pictures\"><div class=\"head\"><h4>{}</h4><span class=\"soft\">",
                    html_escape(run.technique));
    out += fmt::format("RMSE {} · PSNR {} dB · FLIP {}</span></div>\n", number(run.rmse8, 3),
                       number(run.psnr_db, 2), number(run.flip, 4));
    out += triple(image, reference, views.whole, views.reduction, views.id, run.technique,
                  views.whole.width < 320);
    if (views.detail.width > 0)
        out +=
            "<div style=\"height:8px\"></div>" +
            triple(image, reference, views.detail, 1, views.id + "-detail", run.technique + ", detail", true);
    return out + "</div>\n";
}

std::string pictures_section(const ComparisonOfOneTrace& comparison, const std::string& id) {
    std::vector<const RunRecord*> runs;
    std::vector<Image> images;
    std::string unreadable;
    for (const RunRecord& run : comparison.runs) {
        if (!run.failure.empty()) continue;
        const std::string file = (std::filesystem::path(run.directory) / "image.exr").string();
        try {
            Image image = read_exr(file);
            if (image.width != comparison.reference.width || image.height != comparison.reference.height ||
                image.channel("R") < 0 || image.channel("G") < 0 || image.channel("B") < 0)
                throw UserError(file, "is not an image of this trace");
            images.push_back(std::move(image));
            runs.push_back(&run);
        } catch (const UserError& error) {
            unreadable += fmt::format("<p class=\"note\">{}: {}</p>\n", html_escape(error.where()),
                                      html_escape(error.what()));
        }
    }
    if (images.empty()) return unreadable;
    std::vector<const Image*> all;
    for (const Image& image : images) all.push_back(&image);
    const Image& reference = comparison.reference;
    const Views views{{0, 0, reference.width, reference.height},
                      detail_region(all, reference),
                      reduction_for(reference.width),
                      id};
    std::string out =
        "<h3>Pictures</h3>\n<p class=\"note\">From left to right: the technique, its difference from the "
        "reference (8 times, linear, around grey: brighter is too bright), the reference.";
    if (views.reduction > 1)
        out += fmt::format(" Reduced {}:1; the difference keeps the largest of each {} pixels.",
                           views.reduction, views.reduction * views.reduction);
    if (views.detail.width > 0)
        out += fmt::format(" Below each, the {} × {} pixels from ({}, {}) where the techniques err most.",
                           views.detail.width, views.detail.height, views.detail.x, views.detail.y);
    out += "</p>\n" + stored(id, image_picture(reference, views.whole, views.reduction));
    if (views.detail.width > 0) out += stored(id + "-detail", image_picture(reference, views.detail, 1));
    for (std::size_t i = 0; i < images.size(); ++i) out += pictures_of(*runs[i], images[i], reference, views);
    return out + unreadable;
}

std::string path_table(const std::vector<RunRecord>& runs) {
    std::string rows;
    for (const RunRecord& run : runs) {
        if (!run.failure.empty()) continue;
        bool first = true;
        for (const PathCost& path : run.paths) {
            if (path.count.value_or(0.0) <= 0) continue;
            rows += fmt::format(
                "<tr{}><th scope=\"row\">{}</th><td style=\"text-align:left\">{}</td><td>{}</td><td>{}"
                "</td><td>{}</td></tr>\n",
                first ? "" : " class=\"more\"", first ? breakable(run.technique) : "", html_escape(path.path),
                number(path.count, 0), number(path.latency_cycles, 0), number(path.interval_cycles, 0));
            first = false;
        }
    }
    if (rows.empty()) return {};
    return "<h3>Control paths taken</h3>\n<div class=\"scroll\"><table>\n<thead><tr><th "
           "scope=\"col\">technique</th>"
           "<th scope=\"col\" style=\"text-align:left\">path</th><th "
           "scope=\"col\">taken<small>times</small></th>"
           "<th scope=\"col\">latency<small>cycles</small></th><th "
           "scope=\"col\">interval<small>cycles</small></th>"
           "</tr></thead>\n<tbody>\n" +
           rows + "</tbody></table></div>\n";
}

// Keys with one value in all runs that have them stand once; the others stand with their technique.
std::string configuration(const std::vector<RunRecord>& runs) {
    std::map<std::string, std::map<std::string, int>> values;
    int successful = 0;
    for (const RunRecord& run : runs) {
        if (!run.failure.empty()) continue;
        ++successful;
        for (const auto& [key, value] : run.configuration) ++values[key][value];
    }
    std::string common, own;
    const auto entry = [](const std::string& key, const std::string& value) {
        return fmt::format("<div><dt>{}</dt><dd>{}</dd></div>\n", html_escape(key), html_escape(value));
    };
    const auto shared = [&](const std::string& key) {
        return values[key].size() == 1 && values[key].begin()->second == successful;
    };
    for (const auto& [key, found] : values)
        if (shared(key)) common += entry(key, found.begin()->first);
    for (const RunRecord& run : runs) {
        if (!run.failure.empty()) continue;
        std::string entries;
        for (const auto& [key, value] : run.configuration)
            if (!shared(key)) entries += entry(key, value);
        if (!entries.empty())
            own += fmt::format("<h4>{}</h4>\n<dl class=\"keys\">\n{}</dl>\n", html_escape(run.technique),
                               entries);
    }
    std::string out;
    if (!common.empty()) out += "<h3>Configuration</h3>\n<dl class=\"keys\">\n" + common + "</dl>\n";
    if (!own.empty())
        out += "<details><summary>What differs between the techniques</summary>\n" + own + "</details>\n";
    return out;
}

std::string commands(const std::vector<RunRecord>& runs) {
    std::string out = "<h3>To repeat a run</h3>\n<dl class=\"commands\">\n";
    for (const RunRecord& run : runs)
        out += fmt::format("<dt>{}</dt><dd><code>{}</code></dd>\n", html_escape(run.technique),
                           html_escape(shell_line(run.command)));
    return out + "</dl>\n";
}

std::string section(const ComparisonOfOneTrace& comparison, std::size_t index) {
    const std::string id = fmt::format("trace-{}", index + 1);
    std::string out = fmt::format("<section id=\"{}\">\n<h2>{}</h2>\n", id, html_escape(comparison.name));
    out += facts(comparison);
    const std::string table = number_table(comparison.runs, comparison_columns());
    out += table.empty() ? failures_only(comparison.runs) : table;
    out +=
        "<p class=\"note\">Errors are of linear values against exact compositing; bytes are per fragment of "
        "the trace. "
        "A dash was not measured.</p>\n";
    const std::string traffic = traffic_bars(comparison.runs), cycles = stage_bars(comparison.runs);
    out += traffic + cycles + pictures_section(comparison, id + "-reference");
    std::vector<RunRecord> successful;
    std::copy_if(comparison.runs.begin(), comparison.runs.end(), std::back_inserter(successful),
                 [](const RunRecord& run) { return run.failure.empty(); });
    const std::string memory = number_table(successful, memory_columns());
    if (!memory.empty()) out += "<h3>Memory system</h3>\n" + memory;
    out += path_table(comparison.runs) + configuration(comparison.runs) + commands(comparison.runs);
    return out + "</section>\n";
}

}  // namespace

std::string report_html(const std::vector<ComparisonOfOneTrace>& comparisons, const std::string& title) {
    const std::string heading = title.empty() ? "Transparency techniques compared" : title;
    std::string out =
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
        "content=\"width=device-width, initial-scale=1\">\n";
    out += fmt::format("<title>{}</title>\n<style>\n{}</style>\n</head>\n<body>\n<header><h1>{}</h1>\n",
                       html_escape(heading), kReportStyle, html_escape(heading));
    out += fmt::format(
        "<p class=\"soft\">ropsim {}: framebuffer operations simulated on captured fragments, judged "
        "against exact compositing.</p>\n",
        kVersion);
    if (comparisons.size() > 1) {
        out += "<nav>";
        for (std::size_t i = 0; i < comparisons.size(); ++i)
            out += fmt::format("<a href=\"#trace-{}\">{}</a>", i + 1, html_escape(comparisons[i].name));
        out += "</nav>\n";
    }
    out += "</header>\n<main>\n";
    for (std::size_t i = 0; i < comparisons.size(); ++i) out += section(comparisons[i], i);
    return out + "</main>\n</body>\n</html>\n";
}

void write_report(const std::vector<ComparisonOfOneTrace>& comparisons, const std::string& title,
                  const std::string& path) {
    write_file(path, report_html(comparisons, title));
}

}  // namespace ropsim
