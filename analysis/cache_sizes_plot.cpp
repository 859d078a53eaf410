// Bytes against cache sizes as a picture: a panel a scene, two side by side, the key below.
#include "analysis/cache_sizes_output.h"
#include "analysis/gnuplot.h"
#include "base/error.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace ropsim {
namespace {

// Of the SVG, in pixels.
constexpr double kPanelWidth = 760;
constexpr double kPanelHeight = 520;
constexpr double kKeyRow = 24;
constexpr double kKeyColumn = 330;
constexpr const char* kGrey = "#a0a0a0";

// Places of the models without a cache, in doublings left of the smallest size, and of the endless cache
// right of the largest.
constexpr double kWorstCase = 3.6, kTouched = 2.45, kBursts = 1.3, kEndless = 1.2;

struct Sheet {
    const CacheSizes& study;
    std::vector<const CacheSizesScene*> scenes;  // with results
    double columns, rows, key_rows, key_columns, width, height;
};

Sheet sheet_of(const CacheSizes& study) {
    Sheet sheet{study, {}, 1, 1, 1, 1, 0, 0};
    for (const CacheSizesScene& scene : study.scenes)
        if (std::any_of(scene.runs.begin(), scene.runs.end(),
                        [](const CacheSizesRun& run) { return run.failure.empty(); }))
            sheet.scenes.push_back(&scene);
    CHECK(!sheet.scenes.empty());
    sheet.columns = sheet.scenes.size() == 1 ? 1 : 2;
    sheet.rows = std::ceil(static_cast<double>(sheet.scenes.size()) / sheet.columns);
    sheet.width = kPanelWidth * sheet.columns;
    sheet.key_columns = std::floor(sheet.width / kKeyColumn);
    // Three entries more for the kinds of lines.
    sheet.key_rows = std::ceil(static_cast<double>(study.options.techniques.size() + 3) / sheet.key_columns);
    sheet.height = kPanelHeight * sheet.rows + kKeyRow * sheet.key_rows + 16;
    return sheet;
}

double place(double bytes) {
    return std::log2(bytes / 1024);
}

std::string block(const CacheSizesScene& scene, const CacheSizesRun& run, std::size_t number) {
    const double first = place(run.sweep.caches.front().size_bytes);
    const double last = place(run.sweep.caches.back().size_bytes);
    std::string text = fmt::format("$none_{} << EOD\n", number);
    for (const auto& [left, bytes] :
         {std::pair{kWorstCase, run.worst_case}, {kTouched, run.touched}, {kBursts, run.uncached}})
        text += fmt::format("{} {}\n", first - left, scene.per_fragment(bytes));
    text += fmt::format("EOD\n$endless_{} << EOD\n{} {}\nEOD\n$cache_{} << EOD\n", number, last + kEndless,
                        scene.per_fragment(run.floor()), number);
    for (std::size_t i = 0; i < run.sweep.caches.size(); ++i)
        text +=
            fmt::format("{} {}\n", place(run.sweep.caches[i].size_bytes), scene.per_fragment(run.pins(i)));
    text += fmt::format("EOD\n$ideal_{} << EOD\n", number);
    for (std::size_t i = 0; i + 1 < run.sweep.ideal.size(); ++i) {
        const auto size = static_cast<double>(run.sweep.ideal[i].size_bytes);
        if (place(size) >= first && place(size) <= last)
            text += fmt::format("{} {}\n", place(size), scene.per_fragment(run.ideal(i)));
    }
    // The papers' model as a level across the panel.
    text += fmt::format("EOD\n$level_{} << EOD\n", number);
    for (const double x : {first - kWorstCase, last + kEndless})
        text += fmt::format("{} {}\n", x, scene.per_fragment(run.worst_case));
    return text + "EOD\n";
}

struct Range {
    double low = HUGE_VAL, high = 0;
};

Range range_of(const CacheSizesScene& scene) {
    Range range;
    for (const CacheSizesRun& run : scene.runs) {
        if (!run.failure.empty()) continue;
        std::vector<ReadWriteBytes> shown{run.worst_case, run.touched, run.uncached, run.floor()};
        for (std::size_t i = 0; i < run.sweep.caches.size(); ++i) shown.push_back(run.pins(i));
        for (const ReadWriteBytes& bytes : shown) {
            range.low = std::min(range.low, scene.per_fragment(bytes));
            range.high = std::max(range.high, scene.per_fragment(bytes));
        }
    }
    // A frame that moves nothing has no logarithm.
    range.high = std::max(range.high, 1.0);
    range.low = std::clamp(range.low, range.high * 1e-6, range.high / 2);
    const double room = std::pow(range.high / range.low, 0.06);
    return {range.low / room, range.high * room};
}

std::string tics(const CacheSizes& study, double first, double last) {
    std::string text = fmt::format("\"worst\\ncase\" {}, \"touched\" {}, \"bursts\" {}", first - kWorstCase,
                                   first - kTouched, first - kBursts);
    for (const int kibibytes : study.options.kibibytes)
        text += fmt::format(", '{}' {}", kibibytes, std::log2(kibibytes));
    return text + fmt::format(", \"endless\" {}", last + kEndless);
}

std::string axes(const CacheSizes& study, const CacheSizesScene& scene) {
    const double first = std::log2(study.options.kibibytes.front());
    const double last = std::log2(study.options.kibibytes.back());
    const Range y = range_of(scene);
    const double gigabytes = 1e-9 * static_cast<double>(scene.fragments);
    std::string text =
        fmt::format("set title {} offset 0,-0.4\nset xrange [{}:{}]\nset xtics nomirror ({})\n",
                    gnuplot_quoted(fmt::format(
                        "{}  ({}\u00d7{} pixels, {:.3g} million fragments{})", scene.name, scene.width,
                        scene.height, 1e-6 * static_cast<double>(scene.fragments),
                        scene.samples == 1 ? "" : fmt::format(", {} spatial samples", scene.samples))),
                    first - kWorstCase - 0.5, last + kEndless + 0.5, tics(study, first, last));
    text += fmt::format("set yrange [{}:{}]\nset ytics nomirror ({})\nset y2range [{}:{}]\nset y2tics ({})\n",
                        y.low, y.high, log_tics(y.low, y.high), y.low * gigabytes, y.high * gigabytes,
                        log_tics(y.low * gigabytes, y.high * gigabytes));
    text += "set ylabel 'bytes read and written, a fragment'\nset y2label 'GB a frame' offset -0.5,0\n";
    for (const auto& [at, name] :
         {std::pair{first - kTouched, "no cache"}, {(first + last) / 2, "ROP cache of a partition, KiB"}})
        text += fmt::format("set label '{}' at first {},graph -0.145 center\n", name, at);
    for (const double border : {first - 0.65, last + kEndless / 2})
        text += fmt::format("set arrow from {0},{1} to {0},{2} nohead dashtype 3 linecolor rgb '{3}' back\n",
                            border, y.low, y.high, kGrey);
    return text;
}

std::string panel(const Sheet& sheet, std::size_t number) {
    const CacheSizesScene& scene = *sheet.scenes[number];
    const double left = kPanelWidth * static_cast<double>(number % static_cast<std::size_t>(sheet.columns));
    const double top = sheet.height - kPanelHeight * std::floor(static_cast<double>(number) / sheet.columns);
    std::string text = fmt::format(
        "unset arrow\nunset label\nset lmargin at screen {}\nset rmargin at screen {}\nset bmargin at screen "
        "{}\nset "
        "tmargin at screen {}\n",
        (left + 76) / sheet.width, (left + kPanelWidth - 92) / sheet.width,
        (top - kPanelHeight + 74) / sheet.height, (top - 38) / sheet.height);
    for (std::size_t r = 0; r < scene.runs.size(); ++r)
        if (scene.runs[r].failure.empty()) text += block(scene, scene.runs[r], r);
    text += axes(sheet.study, scene) + "plot ";
    bool more = false;
    for (std::size_t r = 0; r < scene.runs.size(); ++r) {
        if (!scene.runs[r].failure.empty()) continue;
        const PlotLook& look = kPlotLooks[r % kPlotLooks.size()];
        text += fmt::format(
            "{}$level_{} with lines dashtype 3 linewidth 0.75 linecolor rgb '{}' notitle, \\\n"
            "  $ideal_{} with lines dashtype 2 linewidth 1.5 linecolor rgb '{}' notitle, \\\n"
            "  $cache_{} with linespoints linewidth 2 pointtype {} pointsize 1 linecolor rgb '{}' notitle, "
            "\\\n"
            "  $none_{} with points pointtype {} pointsize 1 linecolor rgb '{}' notitle, \\\n"
            "  $endless_{} with points pointtype {} pointsize 1 linecolor rgb '{}' notitle",
            more ? ", \\\n  " : "", r, look.color, r, look.color, r, look.marker, look.color, r, look.marker,
            look.color, r, look.marker, look.color);
        more = true;
    }
    return text + "\n";
}

// By hand, as a key of all panels.
std::string key(const Sheet& sheet) {
    std::string text =
        "unset label\nunset arrow\nunset title\nunset xlabel\nunset ylabel\nunset y2label\nunset "
        "border\nunset tics\nunset y2tics\nunset grid\nunset logscale\nset xrange [0:1]\nset yrange [0:1]\n";
    const std::size_t techniques = sheet.study.options.techniques.size();
    for (std::size_t i = 0; i < techniques + 3; ++i) {
        const auto columns = static_cast<std::size_t>(sheet.key_columns);
        const double x = (40 + kKeyColumn * static_cast<double>(i % columns)) / sheet.width;
        const double y =
            (kKeyRow * (sheet.key_rows - std::floor(static_cast<double>(i) / sheet.key_columns)) - 6) /
            sheet.height;
        const bool kind = i >= techniques;
        const PlotLook& look = kPlotLooks[i % kPlotLooks.size()];
        text += fmt::format(
            "set arrow from screen {},{} to screen {},{} nohead dashtype {} linewidth 2 linecolor rgb '{}'\n",
            x - 14 / sheet.width, y, x + 14 / sheet.width, y, 1 + i - std::min(i, techniques),
            kind ? kGrey : look.color);
        if (!kind)
            text += fmt::format(
                "set label '' at screen {},{} point pointtype {} pointsize 1 linecolor rgb '{}'\n", x, y,
                look.marker, look.color);
        const std::string name = i == techniques       ? fmt::format("on the pins, {} ways", sheet.study.ways)
                                 : i == techniques + 1 ? "fully associative"
                                 : i == techniques + 2 ? "no cache, worst case"
                                                       : sheet.study.options.techniques[i];
        text +=
            fmt::format("set label {} at screen {},{} left\n", gnuplot_quoted(name), x + 22 / sheet.width, y);
    }
    return text + "plot NaN notitle\n";
}

}  // namespace

std::string cache_sizes_plot_script(const CacheSizes& study, const std::string& svg, const std::string& png) {
    const Sheet sheet = sheet_of(study);
    std::string drawing =
        "reset\nset encoding utf8\nset multiplot\nset logscale y\nset logscale y2\nset border 11 linewidth "
        "1\nset grid ytics linecolor rgb '#e0e0e0' linewidth 0.75\n";
    for (std::size_t p = 0; p < sheet.scenes.size(); ++p) drawing += panel(sheet, p);
    drawing += key(sheet) + "unset multiplot\nset output\n";
    return svg_terminal(sheet.width, sheet.height, svg) + drawing +
           png_terminal(sheet.width, sheet.height, png) + drawing;
}

void write_cache_sizes_plot(const CacheSizes& study, const std::string& directory) {
    draw_plot(directory, "cache-sizes", [&](const std::string& svg, const std::string& png) {
        return cache_sizes_plot_script(study, svg, png);
    });
}

}  // namespace ropsim
