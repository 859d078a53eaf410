// JSON rows become tables and plots.
#include "analysis/report/report_rows.h"

#include "analysis/comparison_table.h"
#include "analysis/html.h"
#include "analysis/report/report_widgets.h"
#include "base/error.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostGroups = 24;  // different strings up to which points may be coloured by them

Json parsed_rows(const std::string& text, const std::string& name) {
    Json rows = Json::parse(text, nullptr, false);
    if (!rows.is_array() ||
        !std::all_of(rows.begin(), rows.end(), [](const Json& row) { return row.is_object(); }))
        throw UserError(name, "is not a JSON array of objects; give what --json prints");
    return rows;
}

Measured value_of(const Json& json) {
    if (json.is_number()) return json.get<double>();
    if (json.is_object() && json.contains("value")) return value_of(json["value"]);
    return {};
}

std::string number_text(double value) {
    if (value == std::floor(value) && std::abs(value) < 1e15)
        return format_measured(value, 0, "\u202f", report_absent());
    if (std::abs(value) < 1e-12) return "0";  // what sums that cancel leave in their last bits
    return fmt::format("{:.5g}", value);
}

// A cell for people: strings as they are, numbers rounded, estimates with their interval.
std::string shown(const Json& json) {
    if (json.is_null()) return report_absent();
    if (json.is_string()) return json.get<std::string>();
    if (json.is_boolean()) return json.get<bool>() ? "yes" : "no";
    if (json.is_number()) return number_text(json.get<double>());
    if (json.is_object() && json.contains("value") && json.contains("ci95") && json["ci95"].size() == 2)
        return fmt::format("{} ({} to {})", shown(json["value"]), shown(json["ci95"][0]),
                           shown(json["ci95"][1]));
    std::string out;
    for (const auto& [key, value] : json.items())
        out += (out.empty() ? "" : "; ") + (json.is_object() ? key + " " : "") + shown(value);
    return out;
}

// Keys in the order of their first appearance.
std::vector<std::string> keys_of(const Json& rows) {
    std::vector<std::string> keys;
    for (const Json& row : rows)
        for (const auto& [key, value] : row.items())
            if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
    return keys;
}

const Json& entry(const Json& row, const std::string& key) {
    static const Json null;
    const auto found = row.find(key);
    return found == row.end() ? null : *found;
}

enum class Role { kName, kGroup, kText, kNumber };

std::vector<std::pair<std::string, Role>> roles_of(const Json& rows) {
    std::vector<std::pair<std::string, Role>> roles;
    const std::vector<std::string> keys = keys_of(rows);
    std::string name = std::find(keys.begin(), keys.end(), "name") != keys.end() ? "name" : "";
    for (const std::string& key : keys) {
        std::set<std::string> strings;
        bool numbers = false;
        for (const Json& row : rows) {
            const Json& value = entry(row, key);
            if (value_of(value)) numbers = true;
            if (value.is_string() || value.is_boolean()) strings.insert(shown(value));
        }
        Role role = Role::kText;
        if (numbers && strings.empty())
            role = Role::kNumber;
        else if (key == name || (name.empty() && !strings.empty()))
            role = Role::kName, name = key;
        else if (!strings.empty() && strings.size() <= kMostGroups)
            role = Role::kGroup;
        roles.emplace_back(key, role);
    }
    return roles;
}

// The kind of a verdict, and the reading that it names, if any.
struct VerdictText {
    std::string kind, reading;
};
VerdictText verdict_text(const std::string& verdict) {
    constexpr std::string_view kUnder = "reproduced under ";
    if (!verdict.starts_with(kUnder)) return {verdict, ""};
    return {"reproduced under a reading", verdict.substr(kUnder.size())};
}

std::string verdict_style(const std::string& kind) {
    if (kind.starts_with("reproduced")) return "good";
    return kind.starts_with("does not follow") ? "bad" : "";
}

std::string verdict_counts(const Json& rows) {
    std::map<std::string, std::pair<std::size_t, std::string>> counts;
    for (const Json& row : rows) {
        const std::string verdict = verdict_text(shown(entry(row, "verdict"))).kind;
        counts[verdict].first += 1;
        counts[verdict].second = verdict_style(verdict);
    }
    std::string out = fmt::format("<div class=\"counts\"><span><b>{}</b> {}</span>", rows.size(),
                                  rows.size() == 1 ? "claim" : "claims");
    for (const auto& [verdict, count] : counts)
        out += fmt::format("<span class=\"{}\"><b>{}</b> {}</span>", count.second, count.first,
                           html_escape(verdict));
    return out + "</div>\n";
}

// A table of `bench --json` as objects; a row is named by its technique and mode.
Json rows_of(const Json& plot) {
    Json rows = Json::array();
    for (const Json& values : plot.at("rows")) {
        Json row = Json::object();
        for (std::size_t i = 0; i < values.size(); ++i)
            row[plot.at("columns").at(i).get<std::string>()] = values[i];
        if (row.contains("technique") && row.contains("mode"))
            row["name"] = shown(row["technique"]) + ", " + shown(row["mode"]);
        rows.push_back(std::move(row));
    }
    return rows;
}

}  // namespace

ReportSection claims_section(const std::string& text, const std::string& command, const std::string& name) {
    const Json rows = parsed_rows(text, name);
    // What is claimed and what came of it first: the rest may be off a narrow screen.
    ReportTable table{"claims-table",
                      "",
                      {{"id"},
                       {"claim"},
                       {"printed", CellKind::kNumber, "", "what the paper prints"},
                       {"worst case", CellKind::kNumber, "", "every control path at its costliest"},
                       {"measured", CellKind::kNumber, "", "on captured frames, or enumerated"},
                       {"verdict", CellKind::kChoice},
                       {"why"},
                       {"paper", CellKind::kChoice},
                       {"place"}},
                      {}};
    constexpr std::size_t kVerdict = 5, kWhy = 6;
    const char* const keys[] = {"id",      "claim", "printed", "worst_case", "measured",
                                "verdict", "why",   "paper",   "place"};
    for (const Json& row : rows) {
        std::vector<ReportCell> cells;
        for (const char* key : keys) {
            const Json& value = entry(row, key);
            const bool prose = std::string_view(key) == "why" && value.is_null();
            cells.push_back({prose ? "" : shown(value), value_of(value)});
            if (value.is_null()) cells.back().style = "none";
        }
        const VerdictText verdict = verdict_text(cells[kVerdict].text);
        cells[kVerdict].text = verdict.kind;
        cells[kVerdict].style = verdict_style(verdict.kind);
        if (!verdict.reading.empty()) cells[kWhy].text = "Under " + verdict.reading + ". " + cells[kWhy].text;
        table.rows.push_back(std::move(cells));
    }
    ReportSection section{"claims", "Published claims"};
    section += verdict_counts(rows);
    section += report_table(table);
    section += report_command(command);
    return section;
}

ReportSection rows_section(const std::string& text, const RowsSection& wanted, const std::string& name) {
    const Json rows = parsed_rows(text, name);
    const auto roles = roles_of(rows);
    ReportPlot plot;
    plot.id = wanted.id + "-plot";
    plot.caption = wanted.caption;
    plot.command = wanted.command;
    plot.x = wanted.x;
    plot.y = wanted.y;
    plot.log_x = wanted.log_x;
    plot.log_y = wanted.log_y;
    ReportTable table{wanted.id + "-table", "", {}, {}};
    for (const auto& [key, role] : roles) {
        if (role == Role::kNumber) plot.axes.push_back({key});
        if (role == Role::kGroup) plot.groupings.push_back(key);
        table.columns.push_back({key, role == Role::kNumber  ? CellKind::kNumber
                                      : role == Role::kGroup ? CellKind::kChoice
                                                             : CellKind::kText});
    }
    for (const Json& row : rows) {
        PlotPoint point;
        std::vector<ReportCell> cells;
        for (const auto& [key, role] : roles) {
            const Json& value = entry(row, key);
            cells.push_back({shown(value), value_of(value), value.is_null() ? "none" : ""});
            if (role == Role::kNumber) point.values.push_back(value_of(value));
            if (role == Role::kGroup) point.groups.push_back(shown(value));
            if (role == Role::kName) point.name = shown(value);
        }
        if (point.name.empty()) point.name = fmt::format("row {}", table.rows.size() + 1);
        plot.points.push_back(std::move(point));
        table.rows.push_back(std::move(cells));
    }
    ReportSection section{wanted.id, wanted.heading};
    ReportWidget drawn = report_plot(plot);
    const bool nothing = drawn.html.empty();
    section += std::move(drawn);
    if (nothing && !rows.empty()) {
        section += report_table(table);
        section += report_command(wanted.command);
    }
    return section;
}

std::string claims_report(const std::string& rows, const std::string& command) {
    ReportPage page("Published claims, measured",
                    "what papers print, the worst case by their own model, and what a captured frame takes");
    page.add(claims_section(rows, command));
    return page.html();
}

std::string bench_report(const std::string& bench, const std::string& command) {
    const Json json = Json::parse(bench, nullptr, false);
    if (!json.is_object() || !json.contains("plots") || !json["plots"].is_array())
        throw UserError("bench", "has no plots; give what `ropsim bench --json` prints");
    ReportPage page("Run time against error", "techniques, the simulator's fidelities and samples, scaling");
    std::size_t number = 0;
    try {
        for (const Json& plot : json["plots"]) {
            ++number;
            page.add(rows_section(
                rows_of(plot).dump(),
                {number == 1 ? "bench" : fmt::format("bench-{}", number), plot.at("title").get<std::string>(),
                 "Pick the axes.", command, plot.at("x").get<std::string>(), plot.at("y").get<std::string>()},
                "bench"));
        }
    } catch (const Json::exception& e) {
        throw UserError("bench",
                        fmt::format("plot {}: {}; give what `ropsim bench --json` prints", number, e.what()));
    }
    return page.html();
}

}  // namespace ropsim
