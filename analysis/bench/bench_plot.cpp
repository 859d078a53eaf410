// The simulator's run time as pictures: panels of lines and points on logarithmic axes.
#include "analysis/bench/bench_output.h"
#include "analysis/gnuplot.h"
#include "analysis/tradeoff_output.h"
#include "base/error.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr double kPanelWidth = 380;
constexpr double kPanelHeight = 310;
constexpr double kKeyRow = 24;

struct Line {
    std::string name;
    std::vector<std::pair<double, double>> points;  // the line goes through all of them, unless
    std::vector<std::pair<double, double>> front;   // it goes through these
    std::vector<std::string> labels;                // of the points; empty: none
};

struct Panel {
    std::string title, x, y;
    std::vector<Line> lines;
};

struct Sheet {
    std::vector<Panel> panels;
    std::size_t columns = 1;
    std::vector<std::string> names;  // of lines, in the order of their looks

    std::size_t look_of(const std::string& name) const {
        return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
    }
};

Line& line_of(Sheet& sheet, const std::string& title, const std::string& x, const std::string& y,
              const std::string& name) {
    if (std::ranges::find(sheet.names, name) == sheet.names.end()) sheet.names.push_back(name);
    auto panel = std::ranges::find(sheet.panels, title, &Panel::title);
    if (panel == sheet.panels.end()) panel = sheet.panels.insert(panel, {title, x, y, {}});
    auto line = std::ranges::find(panel->lines, name, &Line::name);
    if (line == panel->lines.end()) line = panel->lines.insert(line, {name, {}, {}, {}});
    return *line;
}

// Errors of 0, which have no logarithm, stand on the floor.
constexpr double kFloorPercent = 0.01;

Sheet simulator_sheet(const Bench& bench) {
    Sheet sheet;
    for (const SimulatorRow& row : bench.simulator) {
        if (!row.cycles_rms) continue;
        Line& line =
            line_of(sheet, row.trace, "processor seconds", "error of the cycles, % (RMS)", row.technique);
        line.points.emplace_back(row.seconds, std::max(kFloorPercent, 100 * *row.cycles_rms));
        line.labels.push_back(row.mode.substr(row.mode.find(' ') + 1));  // of "timed 5%" the share
        if (row.front) line.front.push_back(line.points.back());
        std::ranges::sort(line.front);
    }
    sheet.columns = std::clamp<std::size_t>(sheet.panels.size(), 1, 3);
    return sheet;
}

Sheet scaling_sheet(const Bench& bench) {
    Sheet sheet;
    for (const bool memory : {false, true})
        for (const BenchCase& c : bench.cases) {
            if (c.part != "scaling" || c.repeats.empty()) continue;
            const double value =
                memory ? median_interval(over_repeats(c, &BenchRepeat::peak_rss_bytes)).estimate / (1 << 20)
                : c.series == "threads"
                    ? median_interval(over_repeats(c, &BenchRepeat::wall_seconds)).estimate
                    : median_interval(over_repeats(c, &BenchRepeat::processor_seconds)).estimate;
            const char* y = memory                  ? "peak memory, MiB"
                            : c.series == "threads" ? "wall seconds"
                                                    : "processor seconds";
            line_of(sheet, c.series + (memory ? ": memory" : ": time"), c.series, y,
                    c.technique + " " + c.mode)
                .points.emplace_back(c.x, value);
        }
    sheet.columns = std::max<std::size_t>(1, sheet.panels.size() / 2);
    return sheet;
}

double width_of(const Sheet& sheet) {
    return kPanelWidth * static_cast<double>(sheet.columns);
}

std::size_t key_columns(const Sheet& sheet) {
    std::size_t longest = 0;
    for (const std::string& name : sheet.names) longest = std::max(longest, name.size());
    return std::max<std::size_t>(
        1, static_cast<std::size_t>(width_of(sheet) / (60 + 8.5 * static_cast<double>(longest))));
}

double key_height(const Sheet& sheet) {
    return 16 + kKeyRow * std::ceil(static_cast<double>(sheet.names.size()) /
                                    static_cast<double>(key_columns(sheet)));
}

double height_of(const Sheet& sheet) {
    return key_height(sheet) + kPanelHeight * std::ceil(static_cast<double>(sheet.panels.size()) /
                                                        static_cast<double>(sheet.columns));
}

// Below a narrow panel there is room for the powers of ten of a long axis alone.
std::string decades(double low, double high) {
    std::string tics;
    for (int power = static_cast<int>(std::ceil(std::log10(low))); std::pow(10.0, power) <= high; ++power)
        tics += fmt::format("{0}'1e{1}' 1e{1}", tics.empty() ? "" : ", ", power);
    return tics;
}

std::string axis(const char* name, const std::string& label, double low, double high) {
    const double room = std::pow(std::max(high / low, 4.0), 0.07);
    const bool across = *name == 'x' && high > 200 * low;
    const std::string tics = across ? decades(low / room, high * room) : log_tics(low / room, high * room);
    return fmt::format("set {0}range [{1}:{2}]\nset {0}tics nomirror ({3})\nset {0}label {4}\n", name,
                       low / room, high * room, tics, gnuplot_quoted(label));
}

std::string look_text(std::size_t look) {
    const PlotLook& l = kPlotLooks[look % kPlotLooks.size()];
    return fmt::format("pointtype {} pointsize 1 linecolor rgb '{}'", l.marker, l.color);
}

std::string line_block(const std::string& name, const Line& line) {
    std::string text = name + " << EOD\n";
    for (const auto& [x, y] : line.front.empty() ? line.points : line.front)
        text += fmt::format("{} {}\n", x, y);
    return text + "EOD\n";
}

std::string panel_text(const Sheet& sheet, std::size_t number) {
    const Panel& panel = sheet.panels[number];
    const double width = width_of(sheet);
    const double height = height_of(sheet);
    const double left = kPanelWidth * static_cast<double>(number % sheet.columns);
    const std::size_t row = number / sheet.columns;
    const double top = height - kPanelHeight * static_cast<double>(row);
    std::string text = fmt::format(
        "set lmargin at screen {}\nset rmargin at screen {}\nset bmargin at screen {}\nset tmargin at screen "
        "{}\nset title {}\n",
        (left + 84) / width, (left + kPanelWidth - 24) / width, (top - kPanelHeight + 62) / height,
        (top - 34) / height, gnuplot_quoted(panel.title));
    double x_low = HUGE_VAL, x_high = 0, y_low = HUGE_VAL, y_high = 0;
    std::string plots;
    for (std::size_t l = 0; l < panel.lines.size(); ++l) {
        const Line& line = panel.lines[l];
        const std::string block = fmt::format("$line_{}_{}", number, l);
        text += block + " << EOD\n";
        for (std::size_t i = 0; i < line.points.size(); ++i) {
            const auto& [x, y] = line.points[i];
            text += fmt::format("{} {} \"{}\"\n", x, y, line.labels.empty() ? "" : line.labels[i]);
            x_low = std::min(x_low, x), x_high = std::max(x_high, x);
            y_low = std::min(y_low, y), y_high = std::max(y_high, y);
        }
        text += "EOD\n" + line_block(block + "_through", line);
        const std::string look = look_text(sheet.look_of(line.name));
        plots += fmt::format(
            "{0}{1}_through with lines linewidth 1.5 {3} notitle, \\\n  {1} with points {2} notitle",
            l == 0 ? "" : ", \\\n  ", block, look, look.substr(look.find("linecolor")));
        if (!line.labels.empty())
            plots += fmt::format(
                ", \\\n  {} using 1:2:3 with labels font 'DejaVu Sans,8' left offset 0.7,0.5 notitle", block);
    }
    return text + axis("x", panel.x, x_low, x_high) + axis("y", panel.y, y_low, y_high) + "plot " + plots +
           "\n";
}

// By hand: gnuplot leaves out entries of a key that it finds too large.
std::string key_text(const Sheet& sheet) {
    const double width = width_of(sheet);
    const double height = height_of(sheet);
    const std::size_t columns = key_columns(sheet);
    const double column = (width - 60) / static_cast<double>(columns);
    std::string text =
        "unset title\nunset xlabel\nunset ylabel\nunset border\nunset tics\nunset grid\nunset logscale\nset "
        "xrange [0:1]\nset yrange [0:1]\n";
    for (std::size_t i = 0; i < sheet.names.size(); ++i) {
        const double x = 40 + column * static_cast<double>(i % columns);
        const std::size_t row = i / columns;
        const double y = key_height(sheet) - 16 - kKeyRow * static_cast<double>(row);
        text += fmt::format("set label '' at screen {},{} point {}\nset label {} at screen {},{} left\n",
                            x / width, y / height, look_text(i), gnuplot_quoted(sheet.names[i]),
                            (x + 16) / width, y / height);
    }
    return text + fmt::format(
                      "set lmargin at screen 0.01\nset rmargin at screen 0.99\nset bmargin at screen "
                      "0.001\nset tmargin at screen {}\nplot NaN notitle\n",
                      key_height(sheet) / height);
}

void draw(const Sheet& sheet, const std::string& directory, const std::string& name) {
    std::string drawing =
        "reset\nset multiplot\nset logscale xy\nset border 3\nset grid linecolor rgb '#e0e0e0'\n";
    for (std::size_t p = 0; p < sheet.panels.size(); ++p) drawing += panel_text(sheet, p);
    drawing += key_text(sheet) + "unset multiplot\nset output\n";
    draw_plot(directory, name, [&](const std::string& svg, const std::string& png) {
        return "set encoding utf8\n" + svg_terminal(width_of(sheet), height_of(sheet), svg) + drawing +
               png_terminal(width_of(sheet), height_of(sheet), png) + drawing;
    });
}

constexpr const char* kTechniques = "bench-techniques";
constexpr const char* kSimulator = "bench-simulator";
constexpr const char* kScaling = "bench-scaling";

}  // namespace

std::vector<std::string> bench_pictures(const Bench& bench) {
    std::vector<std::string> names;
    if (bench.techniques && has_plot(*bench.techniques)) names.emplace_back(kTechniques);
    if (!simulator_sheet(bench).panels.empty()) names.emplace_back(kSimulator);
    if (!scaling_sheet(bench).panels.empty()) names.emplace_back(kScaling);
    return names;
}

void write_bench_pictures(const Bench& bench, const std::string& directory) {
    for (const std::string& name : bench_pictures(bench)) {
        if (name == kTechniques)
            write_tradeoff_plot(*bench.techniques, directory, name);
        else
            draw(name == kSimulator ? simulator_sheet(bench) : scaling_sheet(bench), directory, name);
    }
}

}  // namespace ropsim
