// Error against bytes as a picture: gnuplot draws, the places of names are found here.
#include "analysis/gnuplot.h"
#include "analysis/label_placement.h"
#include "analysis/standard_techniques.h"
#include "analysis/tradeoff_output.h"
#include "base/error.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace ropsim {
namespace {

// Of the SVG, in pixels.
constexpr double kPanelWidth = 760;
constexpr double kPanelHeight = 560;
constexpr double kKeyColumn = 300;  // one entry
constexpr double kKeyRow = 24;
constexpr double kMarkRadius = 6;
constexpr double kNameSize = 11;     // of the font
constexpr double kGlyphWidth = 0.6;  // mean of DejaVu Sans, a share of its size
constexpr std::array<int, 7> kHollow = {6, 4, 8, 12, 10, 14, 6};

struct Mark {
    double bytes = 0;
    double error = 0;
    bool front = false;
    std::size_t family = 0;
    const std::string* name = nullptr;
};

// What a scene's panel shows and where it lies; pixels with y up, as gnuplot's screen has it.
struct Panel {
    const TradeoffScene* scene = nullptr;
    std::vector<Mark> marks;  // ascending in bytes, then descending in error
    PlotBox box;              // of the axes
    double bytes_low = 1, bytes_high = 10;
    double error_low = 1, error_high = 10;
    bool zero = false;  // some error is 0 and stands on the floor

    PlotPoint place(const Mark& mark) const {
        const auto share = [](double value, double low, double high) {
            return std::log(value / low) / std::log(high / low);
        };
        return {box.left + (box.right - box.left) * share(mark.bytes, bytes_low, bytes_high),
                box.bottom +
                    (box.top - box.bottom) * share(std::max(mark.error, error_low), error_low, error_high)};
    }
};

struct Sheet {
    double width = 0, height = 0;
    double key_height = 0;   // at the bottom
    const char* bytes = "";  // what the axis is called
    std::vector<Panel> panels;
    std::vector<std::size_t> families;  // that have a mark, for the key
};

std::size_t key_columns(const Sheet& sheet) {
    return static_cast<std::size_t>(sheet.width / kKeyColumn);
}

std::vector<Mark> marks_of(const Tradeoff& tradeoff, std::size_t scene) {
    std::vector<Mark> marks;
    const auto member = bytes_kind(tradeoff.options.bytes).member;
    for (const TradeoffTechnique& technique : tradeoff.techniques) {
        const TradeoffPoint& point = technique.at[scene];
        const Measured& bytes = point.*member;
        if (!point.rmse8 || !bytes || *bytes <= 0) continue;
        marks.push_back({*bytes, *point.rmse8, point.front, technique.family, &technique.technique});
    }
    std::stable_sort(marks.begin(), marks.end(), [](const Mark& a, const Mark& b) {
        return a.bytes != b.bytes ? a.bytes < b.bytes : a.error > b.error;
    });
    return marks;
}

void set_ranges(Panel& panel) {
    double low = HUGE_VAL, high = 0, error_low = HUGE_VAL, error_high = 0;
    for (const Mark& mark : panel.marks) {
        low = std::min(low, mark.bytes);
        high = std::max(high, mark.bytes);
        error_high = std::max(error_high, mark.error);
        if (mark.error > 0)
            error_low = std::min(error_low, mark.error);
        else
            panel.zero = true;
    }
    if (error_high == 0) error_low = error_high = 1;  // only zeros: any axis will do
    // Room for marks and names at the ends.
    const double wide = std::pow(std::max(high / low, 4.0), 0.06);
    panel.bytes_low = low / wide;
    panel.bytes_high = high * wide;
    const double tall = std::pow(std::max(error_high / error_low, 4.0), 0.07);
    panel.error_low = error_low / (panel.zero ? std::pow(tall, 2.5) : tall);
    panel.error_high = error_high * tall;
}

Sheet sheet_of(const Tradeoff& tradeoff) {
    Sheet sheet;
    sheet.bytes = bytes_kind(tradeoff.options.bytes).axis;
    for (std::size_t s = 0; s < tradeoff.scenes.size(); ++s) {
        Panel panel;
        panel.scene = &tradeoff.scenes[s];
        panel.marks = marks_of(tradeoff, s);
        if (panel.marks.empty()) continue;
        set_ranges(panel);
        sheet.panels.push_back(std::move(panel));
    }
    const std::size_t columns = sheet.panels.size() == 1 ? 1 : 2;
    const std::size_t rows = (sheet.panels.size() + columns - 1) / columns;
    sheet.width = kPanelWidth * static_cast<double>(columns);
    for (std::size_t f = 0; f < technique_families().size(); ++f) {
        const auto shows = [f](const Panel& panel) {
            return std::any_of(panel.marks.begin(), panel.marks.end(),
                               [f](const Mark& mark) { return mark.family == f; });
        };
        if (std::any_of(sheet.panels.begin(), sheet.panels.end(), shows)) sheet.families.push_back(f);
    }
    // The line of the front is an entry too.
    const std::size_t key_rows = sheet.families.size() / key_columns(sheet) + 1;
    sheet.key_height = kKeyRow * static_cast<double>(key_rows) + 16;
    sheet.height = kPanelHeight * static_cast<double>(rows) + sheet.key_height;
    for (std::size_t p = 0; p < sheet.panels.size(); ++p) {
        const double left = kPanelWidth * static_cast<double>(p % columns);
        const double top = sheet.height - kPanelHeight * static_cast<double>(p / columns);
        sheet.panels[p].box = {left + 80, top - kPanelHeight + 62, left + kPanelWidth - 20, top - 40};
    }
    return sheet;
}

std::string margins(const Sheet& sheet, const PlotBox& box) {
    return fmt::format(
        "set lmargin at screen {}\nset rmargin at screen {}\nset bmargin at screen {}\nset tmargin at screen "
        "{}\n",
        box.left / sheet.width, box.right / sheet.width, box.bottom / sheet.height, box.top / sheet.height);
}

std::string names_of(const Sheet& sheet, const Panel& panel) {
    PlotObstacles obstacles{{}, kMarkRadius, {}};
    std::vector<NamedPoint> names;
    std::vector<const Mark*> named;
    for (const Mark& mark : panel.marks) {
        const PlotPoint place = panel.place(mark);
        obstacles.marks.push_back(place);
        if (!mark.front) continue;
        if (!obstacles.line.empty()) obstacles.line.push_back({place.x, obstacles.line.back().y});
        obstacles.line.push_back(place);
        named.push_back(&mark);
        names.push_back(
            {place, kGlyphWidth * kNameSize * static_cast<double>(mark.name->size()), 1.25 * kNameSize});
    }
    const PlotBox inside{panel.box.left + 4, panel.box.bottom + 4, panel.box.right - 4, panel.box.top - 4};
    const std::vector<PlotBox> boxes = place_names(inside, obstacles, names);
    std::string text;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const PlotBox& box = boxes[i];
        text += fmt::format("set label {} at screen {},{} left font 'DejaVu Sans,{}' boxed front\n",
                            gnuplot_quoted(*named[i]->name), box.left / sheet.width,
                            (box.bottom + box.top) / 2 / sheet.height, kNameSize);
        const PlotPoint start = nearest_of(box, names[i].at);
        if (std::hypot(start.x - names[i].at.x, start.y - names[i].at.y) < 3 * kMarkRadius) continue;
        text += fmt::format(
            "set arrow from screen {},{} to screen {},{} nohead linewidth 0.75 linecolor rgb '#909090' "
            "back\n",
            start.x / sheet.width, start.y / sheet.height, names[i].at.x / sheet.width,
            names[i].at.y / sheet.height);
    }
    return text;
}

std::string panel_blocks(const Panel& panel, std::size_t number) {
    std::string text = fmt::format("$front_{} << EOD\n", number);
    for (const Mark& mark : panel.marks)
        if (mark.front) text += fmt::format("{} {}\n", mark.bytes, std::max(mark.error, panel.error_low));
    text += "EOD\n";
    for (std::size_t f = 0; f < technique_families().size(); ++f)
        for (const bool front : {false, true}) {
            text += fmt::format("${}_{}_{} << EOD\n", front ? "best" : "rest", number, f);
            for (const Mark& mark : panel.marks)
                if (mark.family == f && mark.front == front)
                    text += fmt::format("{} {}\n", mark.bytes, std::max(mark.error, panel.error_low));
            text += "EOD\n";
        }
    return text;
}

std::string points(const std::string& what, std::size_t family, bool front) {
    return fmt::format(
        ", \\\n  {} with points pointtype {} pointsize {} linewidth {} linecolor rgb '{}' notitle", what,
        front ? kPlotLooks[family % kPlotLooks.size()].marker : kHollow[family % 7], front ? 1.1 : 0.9,
        front ? 1 : 1.5, kPlotLooks[family % kPlotLooks.size()].color);
}

std::string fragments_text(double fragments) {
    return fragments >= 1e5 ? fmt::format("{:.1f} million fragments", fragments * 1e-6)
                            : fmt::format("{:.0f} fragments", fragments);
}

std::string panel_plot(const Sheet& sheet, std::size_t number) {
    const Panel& panel = sheet.panels[number];
    const TradeoffScene& scene = *panel.scene;
    std::string text = "unset label\nunset arrow\nunset key\n" + margins(sheet, panel.box);
    text += fmt::format("set title {} offset 0,-0.4\n",
                        gnuplot_quoted(fmt::format(
                            "{}  ({}\u00d7{} pixels, {}{})", scene.name, scene.width, scene.height,
                            fragments_text(scene.fragments),
                            scene.samples == 1 ? "" : fmt::format(", {} spatial samples", scene.samples))));
    text += fmt::format("set xrange [{}:{}]\nset yrange [{}:{}]\n", panel.bytes_low, panel.bytes_high,
                        panel.error_low, panel.error_high);
    std::string error_tics = log_tics(panel.error_low * (panel.zero ? 1.3 : 1), panel.error_high);
    if (panel.zero) error_tics += fmt::format("{}'0' {}", error_tics.empty() ? "" : ", ", panel.error_low);
    text += fmt::format("set xtics nomirror ({})\nset ytics nomirror ({})\n",
                        log_tics(panel.bytes_low, panel.bytes_high), error_tics);
    text += fmt::format("set xlabel {} offset 0,0.4\nset ylabel 'RMSE over all pixels, 8-bit units'\n",
                        gnuplot_quoted(sheet.bytes));
    text += names_of(sheet, panel);
    text += fmt::format("plot $front_{} with steps linewidth 1.5 linecolor rgb '#a0a0a0' notitle", number);
    for (const bool front : {false, true})
        for (std::size_t f = 0; f < technique_families().size(); ++f)
            text += points(fmt::format("${}_{}_{}", front ? "best" : "rest", number, f), f, front);
    return text + "\n";
}

// By hand: gnuplot leaves out entries of a key that it finds too large.
std::string key_plot(const Sheet& sheet) {
    std::string text =
        "unset label\nunset arrow\nunset title\nunset xlabel\nunset ylabel\nunset border\nunset tics\nunset "
        "grid\nunset logscale\nset xrange [0:1]\nset yrange [0:1]\n";
    const std::size_t columns = key_columns(sheet);
    const double indent = (sheet.width - kKeyColumn * static_cast<double>(columns)) / 2 + 40;
    for (std::size_t i = 0; i <= sheet.families.size(); ++i) {
        const double x = (indent + kKeyColumn * static_cast<double>(i % columns)) / sheet.width;
        const double y = (sheet.key_height - 16 - kKeyRow * static_cast<double>(i / columns)) / sheet.height;
        std::string name = "filled: none has less of both";
        if (i == 0) {
            text += fmt::format(
                "set arrow from screen {},{} to screen {},{} nohead linewidth 1.5 linecolor rgb '#a0a0a0'\n",
                x - 12 / sheet.width, y, x + 12 / sheet.width, y);
        } else {
            const PlotLook& look = kPlotLooks[sheet.families[i - 1] % kPlotLooks.size()];
            text += fmt::format(
                "set label '' at screen {},{} point pointtype {} pointsize 1.1 linecolor rgb '{}'\n", x, y,
                look.marker, look.color);
            name = technique_families()[sheet.families[i - 1]];
        }
        text +=
            fmt::format("set label {} at screen {},{} left\n", gnuplot_quoted(name), x + 20 / sheet.width, y);
    }
    return text + margins(sheet, {20, 2, sheet.width - 20, sheet.key_height}) + "plot NaN notitle\n";
}

}  // namespace

bool has_plot(const Tradeoff& tradeoff) {
    for (std::size_t s = 0; s < tradeoff.scenes.size(); ++s)
        if (!marks_of(tradeoff, s).empty()) return true;
    return false;
}

std::string tradeoff_plot_script(const Tradeoff& tradeoff, const std::string& svg, const std::string& png) {
    const Sheet sheet = sheet_of(tradeoff);
    std::string data = "set encoding utf8\n";
    for (std::size_t p = 0; p < sheet.panels.size(); ++p) data += panel_blocks(sheet.panels[p], p);
    std::string drawing =
        "reset\nset multiplot\nset logscale xy\nset border 3 linewidth 1\nset grid linecolor rgb '#e0e0e0' "
        "linewidth 0.75\nset style textbox opaque fillcolor rgb 'white' noborder margins 0.5,0.2\n";
    for (std::size_t p = 0; p < sheet.panels.size(); ++p) drawing += panel_plot(sheet, p);
    drawing += key_plot(sheet) + "unset multiplot\nset output\n";
    return data + svg_terminal(sheet.width, sheet.height, svg) + drawing +
           png_terminal(sheet.width, sheet.height, png) + drawing;
}

void write_tradeoff_plot(const Tradeoff& tradeoff, const std::string& directory) {
    CHECK(has_plot(tradeoff));
    draw_plot(directory, "tradeoff", [&](const std::string& svg, const std::string& png) {
        return tradeoff_plot_script(tradeoff, svg, png);
    });
}

}  // namespace ropsim
