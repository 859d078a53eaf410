// Error against bytes as a picture: gnuplot draws, the places of names are found here.
#include "analysis/gnuplot.h"
#include "analysis/label_placement.h"
#include "analysis/standard_techniques.h"
#include "analysis/tradeoff_output.h"
#include "analysis/tradeoff_sheet.h"
#include "base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr const char* kFrontColor = "#a0a0a0";
constexpr double kMarkRadius = 6;
constexpr double kNameSize = 11;     // of the font
constexpr double kGlyphWidth = 0.6;  // mean of DejaVu Sans, a share of its size
constexpr std::array<int, 7> kHollow = {6, 4, 8, 12, 10, 14, 6};

std::string margins(const TradeoffSheet& sheet, const PlotBox& box) {
    return fmt::format(
        "set lmargin at screen {}\nset rmargin at screen {}\nset bmargin at screen {}\nset tmargin at screen "
        "{}\n",
        box.left / sheet.width, box.right / sheet.width, box.bottom / sheet.height, box.top / sheet.height);
}

std::string names_of(const TradeoffSheet& sheet, const TradeoffPanel& panel) {
    PlotObstacles obstacles{{}, kMarkRadius, {}};
    std::vector<NamedPoint> names;
    std::vector<const TradeoffMark*> named;
    for (const TradeoffMark& mark : panel.marks) {
        const PicturePoint place = panel.place(mark);
        obstacles.marks.push_back(place);
        if (!mark.named()) continue;
        if (mark.front && !obstacles.line.empty())
            obstacles.line.push_back({place.x, obstacles.line.back().y});
        if (mark.front) obstacles.line.push_back(place);
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
        const PicturePoint start = nearest_of(box, names[i].at);
        if (std::hypot(start.x - names[i].at.x, start.y - names[i].at.y) < 3 * kMarkRadius) continue;
        text += fmt::format(
            "set arrow from screen {},{} to screen {},{} nohead linewidth 0.75 linecolor rgb '#909090' "
            "back\n",
            start.x / sheet.width, start.y / sheet.height, names[i].at.x / sheet.width,
            names[i].at.y / sheet.height);
    }
    return text;
}

// The second line, by ascending bytes, which are not those that the marks are sorted by.
std::vector<const TradeoffMark*> second_line(const TradeoffPanel& panel) {
    std::vector<const TradeoffMark*> line;
    for (const TradeoffMark& mark : panel.marks)
        if (mark.fixed_front) line.push_back(&mark);
    std::stable_sort(line.begin(), line.end(), [](const TradeoffMark* a, const TradeoffMark* b) {
        return a->second() != b->second() ? a->second() < b->second() : a->error > b->error;
    });
    return line;
}

// Bytes beside others, and what joins the two: pairs of points with an empty line between.
std::string beside_blocks(const TradeoffPanel& panel, std::size_t number) {
    std::string ends = fmt::format("$beside_{} << EOD\n", number);
    std::string joins = fmt::format("$joins_{} << EOD\n", number);
    for (const TradeoffMark& mark : panel.marks) {
        if (mark.beside <= 0) continue;
        const double error = std::max(mark.error, panel.error_low);
        ends += fmt::format("{} {}\n", mark.beside, error);
        if (mark.named()) joins += fmt::format("{} {}\n{} {}\n\n", mark.bytes, error, mark.beside, error);
    }
    return ends + "EOD\n" + joins + "EOD\n";
}

bool has_beside(const TradeoffPanel& panel) {
    return std::ranges::any_of(panel.marks, [](const TradeoffMark& mark) { return mark.beside > 0; });
}

std::string panel_blocks(const TradeoffPanel& panel, std::size_t number) {
    std::string text = has_beside(panel) ? beside_blocks(panel, number) : "";
    text += fmt::format("$front_{} << EOD\n", number);
    for (const TradeoffMark& mark : panel.marks)
        if (mark.front) text += fmt::format("{} {}\n", mark.bytes, std::max(mark.error, panel.error_low));
    text += fmt::format("EOD\n$fixed_{} << EOD\n", number);
    for (const TradeoffMark* mark : second_line(panel))
        text += fmt::format("{} {}\n", mark->second(), std::max(mark->error, panel.error_low));
    text += "EOD\n";
    for (std::size_t f = 0; f < technique_families().size(); ++f)
        for (const bool front : {false, true}) {
            text += fmt::format("${}_{}_{} << EOD\n", front ? "best" : "rest", number, f);
            for (const TradeoffMark& mark : panel.marks)
                if (mark.family == f && mark.named() == front)
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

std::string panel_plot(const TradeoffSheet& sheet, std::size_t number) {
    const TradeoffPanel& panel = sheet.panels[number];
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
    text += fmt::format(
        "plot $fixed_{0} with steps dashtype 2 linewidth 1.5 linecolor rgb '{1}' notitle, \\\n  $front_{0} "
        "with "
        "steps linewidth 1.5 linecolor rgb '{1}' notitle",
        number, kFrontColor);
    if (has_beside(panel))
        text += fmt::format(
            ", \\\n  $joins_{0} with lines linewidth 0.75 linecolor rgb '#d0d0d0' notitle, \\\n  $beside_{0} "
            "with "
            "points pointtype 7 pointsize 0.45 linecolor rgb '#b0b0b0' notitle",
            number);
    for (const bool front : {false, true})
        for (std::size_t f = 0; f < technique_families().size(); ++f)
            text += points(fmt::format("${}_{}_{}", front ? "best" : "rest", number, f), f, front);
    return text + "\n";
}

// By hand: gnuplot leaves out entries of a key that it finds too large.
std::string key_plot(const TradeoffSheet& sheet) {
    std::string text =
        "unset label\nunset arrow\nunset title\nunset xlabel\nunset ylabel\nunset border\nunset tics\nunset "
        "grid\nunset logscale\nset xrange [0:1]\nset yrange [0:1]\n";
    const std::vector<PicturePoint> places = key_places(sheet);
    for (std::size_t i = 0; i < places.size(); ++i) {
        const double x = places[i].x / sheet.width;
        const double y = places[i].y / sheet.height;
        std::string name;
        if (i < sheet.fronts.size()) {
            text += fmt::format(
                "set arrow from screen {},{} to screen {},{} nohead dashtype {} linewidth 1.5 linecolor rgb "
                "'{}'\n",
                x - 12 / sheet.width, y, x + 12 / sheet.width, y, i + 1, kFrontColor);
            name = sheet.fronts[i];
        } else {
            const std::size_t family = sheet.families[i - sheet.fronts.size()];
            const PlotLook& look = kPlotLooks[family % kPlotLooks.size()];
            text += fmt::format(
                "set label '' at screen {},{} point pointtype {} pointsize 1.1 linecolor rgb '{}'\n", x, y,
                look.marker, look.color);
            name = technique_families()[family];
        }
        text +=
            fmt::format("set label {} at screen {},{} left\n", gnuplot_quoted(name), x + 20 / sheet.width, y);
    }
    return text + margins(sheet, {20, 2, sheet.width - 20, sheet.key_height}) + "plot NaN notitle\n";
}

}  // namespace

bool has_plot(const Tradeoff& tradeoff) {
    return !tradeoff_sheet(tradeoff).panels.empty();
}

std::string tradeoff_plot_script(const Tradeoff& tradeoff, const std::string& svg, const std::string& png) {
    const TradeoffSheet sheet = tradeoff_sheet(tradeoff);
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

void write_tradeoff_plot(const Tradeoff& tradeoff, const std::string& directory, const std::string& name) {
    CHECK(has_plot(tradeoff));
    draw_plot(directory, name, [&](const std::string& svg, const std::string& png) {
        return tradeoff_plot_script(tradeoff, svg, png);
    });
}

}  // namespace ropsim
