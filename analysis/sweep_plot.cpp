// A sweep as a picture: cycles and bytes against what is swept, a line a technique.
#include "analysis/comparison_table.h"
#include "analysis/gnuplot.h"
#include "analysis/sweep.h"
#include "base/error.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <numeric>

#include <fmt/ranges.h>

namespace ropsim {
namespace {

constexpr double kPanelWidth = 560;
constexpr double kPanelHeight = 330;
constexpr double kKeyRow = 24;
constexpr double kBelow = 16;

struct Quantity {
    const char* axis;
    double scale;
    Measured (*value)(const RunRecord&);
};

constexpr Quantity kCycles = {"million ROP cycles", 1e-6, [](const RunRecord& r) { return r.cycles; }};
constexpr Quantity kPins = {"MB on the pins", 1e-6,
                            [](const RunRecord& r) { return sum_of(r.total.pin_read, r.total.pin_write); }};
constexpr Quantity kTouched = {"MB touched", 1e-6,
                               [](const RunRecord& r) { return sum_of(r.total.read, r.total.write); }};

// Colours and markers begin again with another dash.
std::size_t dash_of(std::size_t line) {
    return 1 + line / kPlotLooks.size();
}

Measured measured(const SweepPoint& point, const Quantity& quantity) {
    if (!point.run.failure.empty()) return {};
    Measured value = quantity.value(point.run);
    if (value) *value *= quantity.scale;
    return value;
}

// Those of the points' fidelity.
std::vector<Quantity> quantities_of(const Sweep& sweep) {
    std::vector<Quantity> shown;
    for (const Quantity& quantity : {kCycles, kPins})
        if (std::ranges::any_of(sweep.points,
                                [&](const SweepPoint& p) { return measured(p, quantity).has_value(); }))
            shown.push_back(quantity);
    if (shown.empty()) shown.push_back(kTouched);
    return shown;
}

// Where the values of the axis lie: numbers where they are, on a logarithmic axis if they span a factor
// of 4; words side by side.
struct Places {
    std::vector<double> at;
    bool logarithmic = false;
    bool numbers = true;
};

Places places_of(const SweepAxis& axis) {
    Places places;
    for (const std::string& value : axis.values) {
        double number = 0;
        const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
        places.numbers = places.numbers && error == std::errc() && end == value.data() + value.size();
        places.at.push_back(number);
    }
    if (!places.numbers)
        for (std::size_t i = 0; i < places.at.size(); ++i) places.at[i] = static_cast<double>(i);
    const auto [low, high] = std::ranges::minmax(places.at);
    places.logarithmic = places.numbers && low > 0 && high >= 4 * low;
    return places;
}

std::string name_of_value(const SweepAxis& axis, const std::string& value) {
    return axis.option.empty() ? std::filesystem::path(value).stem().string() : value;
}

struct Line {
    std::string name;
    std::vector<const SweepPoint*> points;  // by value of the plotted axis
};

struct Panel {
    std::string title;
    std::vector<Line> lines;
};

// A panel a trace, unless traces are what is plotted; in each the same lines.
std::vector<Panel> panels_of(const Sweep& sweep, std::size_t x) {
    std::vector<Panel> panels;
    for (const SweepPoint& point : sweep.points) {
        const std::string title = x == 0 ? "" : name_of_value(sweep.axes[0], point.values[0]);
        auto panel = std::ranges::find(panels, title, &Panel::title);
        if (panel == panels.end()) panel = panels.insert(panel, {title, {}});
        std::vector<std::string> parts;
        for (std::size_t a = 1; a < sweep.axes.size(); ++a) {
            if (a == x || (sweep.axes[a].values.size() == 1 && a != 1)) continue;
            const bool named = a == 1 || sweep.axes[a].option != "--set";
            parts.push_back(named ? point.values[a] : sweep.axes[a].name + "=" + point.values[a]);
        }
        const std::string name = fmt::format("{}", fmt::join(parts, ", "));
        auto line = std::ranges::find(panel->lines, name, &Line::name);
        if (line == panel->lines.end()) line = panel->lines.insert(line, {name, {}});
        line->points.push_back(&point);
    }
    return panels;
}

struct Sheet {
    const Sweep& sweep;
    const SweepAxis& axis;
    Places places;
    std::vector<Panel> panels;
    std::vector<Quantity> quantities;
    double key_columns, key_rows, width, height;
};

Sheet sheet_of(const Sweep& sweep) {
    const std::optional<std::size_t> x = plotted_axis(sweep);
    CHECK(x.has_value());
    Sheet sheet{
        sweep, sweep.axes[*x], places_of(sweep.axes[*x]), panels_of(sweep, *x), quantities_of(sweep), 1, 1, 0,
        0};
    sheet.width = kPanelWidth * static_cast<double>(sheet.panels.size());
    std::size_t longest = 0;
    for (const Line& line : sheet.panels.front().lines) longest = std::max(longest, line.name.size());
    sheet.key_columns = std::max(1.0, std::floor(sheet.width / (60 + 8.5 * static_cast<double>(longest))));
    sheet.key_rows = std::ceil(static_cast<double>(sheet.panels.front().lines.size()) / sheet.key_columns);
    sheet.height =
        kPanelHeight * static_cast<double>(sheet.quantities.size()) + kKeyRow * sheet.key_rows + kBelow;
    return sheet;
}

std::string data_of(const Sheet& sheet, const Line& line, const Quantity& quantity, const std::string& name) {
    std::string text = fmt::format("${} << EOD\n", name);
    std::vector<std::size_t> order(line.points.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return sheet.places.at[i]; });
    for (const std::size_t i : order) {
        const Measured value = measured(*line.points[i], quantity);
        // A gap where a point failed.
        text += value ? fmt::format("{} {}\n", sheet.places.at[i], *value) : "\n";
    }
    return text + "EOD\n";
}

std::string x_axis(const Sheet& sheet) {
    const auto [low, high] = std::ranges::minmax(sheet.places.at);
    std::string tics;
    for (std::size_t i = 0; i < sheet.axis.values.size(); ++i)
        tics +=
            fmt::format("{}{} {}", i == 0 ? "" : ", ",
                        gnuplot_quoted(name_of_value(sheet.axis, sheet.axis.values[i])), sheet.places.at[i]);
    const double room = sheet.places.numbers ? 0.05 * (high - low) : 0.5;
    const double factor = std::pow(high / std::max(low, 1e-300), 0.05);
    return fmt::format("set xtics nomirror ({})\nset xlabel {}\n{}\nset xrange [{}:{}]\n", tics,
                       gnuplot_quoted(sheet.axis.name),
                       sheet.places.logarithmic ? "set logscale x" : "unset logscale x",
                       sheet.places.logarithmic ? low / factor : low - room,
                       sheet.places.logarithmic ? high * factor : high + room);
}

// From 0; on a logarithmic axis where lines would lie on it.
std::string y_axis(const Panel& panel, const Quantity& quantity) {
    double low = HUGE_VAL;
    double high = 0;
    for (const Line& line : panel.lines) {
        for (const SweepPoint* point : line.points) {
            const Measured value = measured(*point, quantity);
            if (!value) continue;
            low = std::min(low, *value);
            high = std::max(high, *value);
        }
    }
    std::string text = fmt::format("set ylabel {} offset 1,0\n", gnuplot_quoted(quantity.axis));
    if (low > 0 && high > 10 * low && high < HUGE_VAL) {
        const double room = std::pow(high / low, 0.06);
        return text + fmt::format("set logscale y\nset yrange [{}:{}]\nset ytics nomirror ({})\n", low / room,
                                  high * room, log_tics(low / room, high * room));
    }
    return text + fmt::format("unset logscale y\nset yrange [0:{}]\nset ytics nomirror autofreq\n",
                              high > 0 ? 1.08 * high : 1.0);
}

std::string panel_of(const Sheet& sheet, std::size_t column, std::size_t row) {
    const Panel& panel = sheet.panels[column];
    const Quantity& quantity = sheet.quantities[row];
    const double left = kPanelWidth * static_cast<double>(column);
    const double top = sheet.height - kPanelHeight * static_cast<double>(row);
    std::string text = fmt::format(
        "set lmargin at screen {}\nset rmargin at screen {}\nset bmargin at screen {}\nset tmargin at screen "
        "{}\n",
        (left + 84) / sheet.width, (left + kPanelWidth - 24) / sheet.width,
        (top - kPanelHeight + 62) / sheet.height, (top - 34) / sheet.height);
    text += row == 0 && !panel.title.empty()
                ? fmt::format("set title {} offset 0,-0.4\n", gnuplot_quoted(panel.title))
                : "unset title\n";
    std::string plots;
    for (std::size_t l = 0; l < panel.lines.size(); ++l) {
        const std::string name = fmt::format("line_{}_{}_{}", column, row, l);
        text += data_of(sheet, panel.lines[l], quantity, name);
        const PlotLook& look = kPlotLooks[l % kPlotLooks.size()];
        // Words have no order that a line could follow.
        const std::string style =
            sheet.places.numbers ? fmt::format("linespoints dashtype {} linewidth 2", dash_of(l)) : "points";
        plots += fmt::format("{}${} with {} pointtype {} pointsize 1 linecolor rgb '{}' notitle",
                             l == 0 ? "" : ", \\\n  ", name, style, look.marker, look.color);
    }
    return text + x_axis(sheet) + y_axis(panel, quantity) + "plot " + plots + "\n";
}

// By hand, below all panels.
std::string key_of(const Sheet& sheet) {
    std::string text =
        "unset title\nunset xlabel\nunset ylabel\nunset border\nunset tics\nunset grid\nunset logscale\nset "
        "xrange "
        "[0:1]\nset yrange [0:1]\n";
    const std::vector<Line>& lines = sheet.panels.front().lines;
    const auto columns = static_cast<std::size_t>(sheet.key_columns);
    for (std::size_t l = 0; l < lines.size(); ++l) {
        const double x =
            (40 + sheet.width / sheet.key_columns * static_cast<double>(l % columns)) / sheet.width;
        const double y = (kKeyRow * (sheet.key_rows - static_cast<double>(l / columns)) - 6) / sheet.height;
        const PlotLook& look = kPlotLooks[l % kPlotLooks.size()];
        if (sheet.places.numbers)
            text += fmt::format(
                "set arrow from screen {},{} to screen {},{} nohead dashtype {} linewidth 2 linecolor rgb "
                "'{}'\n",
                x - 14 / sheet.width, y, x + 14 / sheet.width, y, dash_of(l), look.color);
        text += fmt::format(
            "set label '' at screen {},{} point pointtype {} pointsize 1 linecolor rgb '{}'\n"
            "set label {} at screen {},{} left\n",
            x, y, look.marker, look.color, gnuplot_quoted(lines[l].name), x + 22 / sheet.width, y);
    }
    return text + "plot NaN notitle\n";
}

}  // namespace

std::optional<std::size_t> plotted_axis(const Sweep& sweep) {
    std::optional<std::size_t> option;
    for (std::size_t a = 2; a < sweep.axes.size(); ++a) {
        if (sweep.axes[a].values.size() < 2) continue;
        if (sweep.axes[a].option == "--set") return a;
        if (!option) option = a;
    }
    if (option) return option;
    for (const std::size_t a : {1, 0})
        if (sweep.axes[a].values.size() > 1) return a;
    return std::nullopt;
}

bool has_plot(const Sweep& sweep) {
    return plotted_axis(sweep) && std::ranges::any_of(sweep.points, [](const SweepPoint& point) {
               return measured(point, kCycles) || measured(point, kPins) || measured(point, kTouched);
           });
}

std::string sweep_plot_script(const Sweep& sweep, const std::string& svg, const std::string& png) {
    const Sheet sheet = sheet_of(sweep);
    std::string drawing =
        "reset\nset encoding utf8\nset multiplot\nset border 3 linewidth 1\nset grid ytics linecolor rgb "
        "'#e0e0e0' "
        "linewidth 0.75\n";
    for (std::size_t column = 0; column < sheet.panels.size(); ++column)
        for (std::size_t row = 0; row < sheet.quantities.size(); ++row)
            drawing += panel_of(sheet, column, row);
    drawing += key_of(sheet) + "unset multiplot\nset output\n";
    return svg_terminal(sheet.width, sheet.height, svg) + drawing +
           png_terminal(sheet.width, sheet.height, png) + drawing;
}

void write_sweep_plot(const Sweep& sweep, const std::string& directory) {
    draw_plot(directory, "sweep", [&](const std::string& svg, const std::string& png) {
        return sweep_plot_script(sweep, svg, png);
    });
}

}  // namespace ropsim
