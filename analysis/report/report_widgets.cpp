// Tables and plots as markup and data; what scripts do with them is in report/.
#include "analysis/report/report_widgets.h"

#include "analysis/comparison_table.h"
#include "analysis/html.h"
#include "base/error.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kLongText = 48;  // characters from which a cell may break into lines

Json number(const Measured& value) {
    return value && std::isfinite(*value) ? Json(*value) : Json(nullptr);
}

std::string heading_cell(const ReportColumn& column) {
    const std::string unit =
        column.unit.empty() ? "" : fmt::format("<small>{}</small>", html_escape(column.unit));
    const char* kind = column.kind == CellKind::kNumber   ? "number"
                       : column.kind == CellKind::kChoice ? "choice"
                                                          : "text";
    return fmt::format(
        "<th scope=\"col\" data-kind=\"{}\" data-name=\"{}\"{}{}>{}{}</th>", kind,
        html_escape(column.heading), column.kind == CellKind::kNumber ? "" : " class=\"left\"",
        column.meaning.empty() ? "" : fmt::format(" title=\"{}\"", html_escape(column.meaning)),
        html_escape(column.heading), unit);
}

std::string body_cell(const ReportColumn& column, const ReportCell& cell, bool first) {
    std::string style = cell.style;
    const auto add = [&](const char* name) { style += (style.empty() ? "" : " ") + std::string(name); };
    if (column.kind != CellKind::kNumber) add("left");
    if (cell.text.size() > kLongText) add("long");
    std::string attributes = style.empty() ? "" : fmt::format(" class=\"{}\"", style);
    if (cell.value && std::isfinite(*cell.value))
        attributes += fmt::format(" data-value=\"{}\"", *cell.value);
    return fmt::format("<{0}{1}>{2}</{3}>", first ? "th scope=\"row\"" : "td", attributes,
                       html_escape(cell.text), first ? "th" : "td");
}

bool measured_anywhere(const ReportPlot& plot, std::size_t axis) {
    return std::any_of(plot.points.begin(), plot.points.end(),
                       [&](const PlotPoint& point) { return point.values[axis].has_value(); });
}

const char* better_name(Better better) {
    return better == Better::kSmaller ? "smaller" : better == Better::kLarger ? "larger" : "neither";
}

// Enough digits to tell points apart.
std::string plain_number(const Measured& value) {
    if (!value || !std::isfinite(*value)) return report_absent();
    const double size = std::abs(*value);
    const int decimals = size >= 1000 || size == std::floor(size) ? 0 : size >= 10 ? 2 : size >= 0.1 ? 3 : 5;
    return format_measured(value, decimals, "\u202f", report_absent());
}

std::string numbers_of(const ReportPlot& plot, const std::vector<std::size_t>& axes) {
    ReportTable table{plot.id + "-numbers", "", {{"name"}}, {}};
    for (const std::string& grouping : plot.groupings) table.columns.push_back({grouping, CellKind::kChoice});
    for (const std::size_t axis : axes)
        table.columns.push_back({plot.axes[axis].name, CellKind::kNumber, plot.axes[axis].unit});
    for (const PlotPoint& point : plot.points) {
        std::vector<ReportCell> row{{point.name}};
        for (const std::string& group : point.groups) row.push_back({group});
        for (const std::size_t axis : axes)
            row.push_back({plain_number(point.values[axis]), point.values[axis]});
        table.rows.push_back(std::move(row));
    }
    return fmt::format("<details><summary>The plot’s numbers as a table</summary>\n{}</details>\n",
                       report_table(table).html);
}

void check_shape(const ReportPlot& plot) {
    std::set<std::string> names;
    for (const PlotAxis& axis : plot.axes) CHECK(names.insert(axis.name).second, "two axes {}", axis.name);
    for (const PlotPoint& point : plot.points) {
        CHECK(point.values.size() == plot.axes.size(), "{}: {} values", point.name, point.values.size());
        CHECK(point.groups.size() == plot.groupings.size(), "{}: {} groups", point.name, point.groups.size());
    }
}

}  // namespace

const char* report_absent() {
    return "–";
}

std::string report_command(const std::string& command) {
    if (command.empty()) return {};
    return fmt::format(
        "<details class=\"command\" data-print><summary>To repeat it</summary><code>{}</code></details>\n",
        html_escape(command));
}

ReportWidget report_table(const ReportTable& table) {
    std::string out = fmt::format("<div class=\"filtered\" data-widget=\"table\" id=\"{}\">\n", table.id);
    if (!table.caption.empty()) out += fmt::format("<p class=\"note\">{}</p>\n", html_escape(table.caption));
    out +=
        "<div class=\"scroll\" role=\"region\" tabindex=\"0\" aria-label=\"table\"><table "
        "class=\"wide\">\n<thead><tr>";
    for (const ReportColumn& column : table.columns) out += heading_cell(column);
    out += "</tr></thead>\n<tbody>\n";
    for (const auto& row : table.rows) {
        CHECK(row.size() == table.columns.size(), "{} cells, {} columns", row.size(), table.columns.size());
        out += "<tr>";
        for (std::size_t c = 0; c < row.size(); ++c) out += body_cell(table.columns[c], row[c], c == 0);
        out += "</tr>\n";
    }
    return {out + "</tbody></table></div>\n</div>\n", {}};
}

ReportWidget report_plot(const ReportPlot& plot) {
    check_shape(plot);
    std::vector<std::size_t> axes;
    for (std::size_t i = 0; i < plot.axes.size(); ++i)
        if (measured_anywhere(plot, i)) axes.push_back(i);
    if (axes.size() < 2) return {};
    Json json;
    const auto measured = [&](const std::string& name) {
        return std::any_of(axes.begin(), axes.end(),
                           [&](std::size_t axis) { return plot.axes[axis].name == name; });
    };
    json["x"] = measured(plot.x) ? plot.x : plot.axes[axes[0]].name;
    json["y"] = measured(plot.y) ? plot.y : plot.axes[axes[1]].name;
    json["log_x"] = plot.log_x;
    json["log_y"] = plot.log_y;
    json["groupings"] = plot.groupings;
    json["within"] = plot.within;
    json["axes"] = Json::array();
    for (const std::size_t axis : axes)
        json["axes"].push_back({{"name", plot.axes[axis].name},
                                {"unit", plot.axes[axis].unit},
                                {"better", better_name(plot.axes[axis].better)}});
    json["points"] = Json::array();
    for (const PlotPoint& point : plot.points) {
        Json values = Json::array();
        for (const std::size_t axis : axes) values.push_back(number(point.values[axis]));
        json["points"].push_back({{"name", point.name}, {"groups", point.groups}, {"values", values}});
    }
    std::string html = fmt::format(
        "<figure class=\"plot\" data-widget=\"plot\" data-source=\"{0}-data\" id=\"{0}\">\n"
        "<figcaption>{1}</figcaption>\n<div class=\"stage\"></div>\n{2}{3}</figure>\n",
        plot.id, html_escape(plot.caption), numbers_of(plot, axes), report_command(plot.command));
    return {std::move(html),
            {{plot.id + "-data", json.dump(-1, ' ', false, Json::error_handler_t::replace)}}};
}

}  // namespace ropsim
