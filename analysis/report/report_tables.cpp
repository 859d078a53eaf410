// Tables and lists of a report.
#include "analysis/report/report_tables.h"

#include "analysis/child_process.h"
#include "analysis/html.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>

namespace ropsim {
namespace {

// A technique's name that a narrow column may break before its parameters.
std::string breakable(const std::string& technique) {
    std::string out;
    for (const char c : html_escape(technique)) {
        out += c;
        if (c == ':' || c == ',') out += "<wbr>";
    }
    return out;
}

bool any_measured(const ComparisonColumn& column, const std::vector<RunRecord>& runs) {
    return std::any_of(runs.begin(), runs.end(), [&](const RunRecord& run) {
        return run.failure.empty() && column.value(run).has_value();
    });
}

// A row above the headings, where columns belong together.
std::string group_row(const std::vector<const ComparisonColumn*>& columns) {
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

}  // namespace

std::string report_number(const Measured& value, int decimals) {
    const std::string text = format_measured(value, decimals, "\u202f", "–");
    return text == "inf" ? "∞" : text;
}

std::string number_table(const std::vector<RunRecord>& runs, const std::vector<ComparisonColumn>& all) {
    std::vector<const ComparisonColumn*> columns;
    for (const ComparisonColumn& column : all)
        if (any_measured(column, runs)) columns.push_back(&column);
    if (columns.empty()) return {};
    std::string out = "<div class=\"scroll\"><table class=\"wide\">\n<thead>" + group_row(columns) +
                      "<tr><th scope=\"col\">technique</th>";
    for (const ComparisonColumn* column : columns)
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
            for (const ComparisonColumn* column : columns) {
                const std::string text = report_number(column->value(run), column->decimals);
                out += fmt::format("<td{}>{}</td>", text == "–" ? " class=\"none\"" : "", text);
            }
        out += "</tr>\n";
    }
    return out + "</tbody></table></div>\n";
}

std::string sample_notes(const std::vector<RunRecord>& runs) {
    std::string out;
    for (const RunRecord& run : runs)
        if (!run.sample.empty())
            out += fmt::format("<p>{}: {}.</p>\n", html_escape(run.technique), html_escape(run.sample));
    return out;
}

std::string path_table(const std::vector<RunRecord>& runs) {
    std::string rows;
    for (const RunRecord& run : runs) {
        if (!run.failure.empty()) continue;
        bool first = true;
        for (const RecordedPath& path : run.paths) {
            if (path.count.value_or(0.0) <= 0) continue;
            rows += fmt::format(
                "<tr{}><th scope=\"row\">{}</th><td style=\"text-align:left\">{}</td><td>{}</td><td>{}"
                "</td><td>{}</td></tr>\n",
                first ? "" : " class=\"more\"", first ? breakable(run.technique) : "", html_escape(path.path),
                report_number(path.count, 0), report_number(path.latency_cycles, 0),
                report_number(path.interval_cycles, 0));
            first = false;
        }
    }
    if (rows.empty()) return {};
    return "<h3>Control paths taken</h3>\n<details data-print><summary>How often each, latency and "
           "interval</summary>\n<div class=\"scroll\"><table>\n<thead><tr><th "
           "scope=\"col\">technique</th>"
           "<th scope=\"col\" style=\"text-align:left\">path</th><th "
           "scope=\"col\">taken<small>times</small></th>"
           "<th scope=\"col\">latency<small>cycles</small></th><th "
           "scope=\"col\">interval<small>cycles</small></th>"
           "</tr></thead>\n<tbody>\n" +
           rows + "</tbody></table></div>\n</details>\n";
}

std::string configuration_list(const std::vector<RunRecord>& runs) {
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
    if (!common.empty())
        out +=
            "<h3>Configuration</h3>\n<details data-print><summary>Keys that all runs share</summary>\n"
            "<dl class=\"keys\">\n" +
            common + "</dl></details>\n";
    if (!own.empty())
        out += "<details data-print><summary>What differs between the techniques</summary>\n" + own +
               "</details>\n";
    return out;
}

std::string command_list(const std::vector<RunRecord>& runs) {
    std::string out = "<h3>To repeat a run</h3>\n<dl class=\"commands\">\n";
    for (const RunRecord& run : runs)
        out += fmt::format("<dt>{}</dt><dd><code>{}</code></dd>\n", html_escape(run.technique),
                           html_escape(shell_line(run.command)));
    return out + "</dl>\n";
}

}  // namespace ropsim
