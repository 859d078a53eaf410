// gnuplot's script and its child process.
#include "analysis/convergence_plot.h"

#include "base/error.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

namespace ropsim {
namespace {

namespace fs = std::filesystem;

constexpr double kWidth = 900;
constexpr const char* kGuideColor = "#808080";

struct Extent {
    double low = 0;
    double high = 0;
};

Extent extent_of_values(const Convergence& c) {
    const auto& values = c.techniques[0].values;
    return {values.front().value, values.back().value};
}

Extent extent_of_errors(const Convergence& c) {
    Extent e{HUGE_VAL, 0};
    for (const ConvergenceOfTechnique& technique : c.techniques)
        for (const ConvergenceAtValue& at : technique.values) {
            const MeanSd m = mean_sd(at.all(&ConvergenceRun::rmse8));
            if (m.mean <= 0) continue;
            e.low = std::min(e.low, m.mean);
            e.high = std::max(e.high, m.mean + m.sd.value_or(0));
        }
    return e;
}

std::string legend_of(const ConvergenceOfTechnique& technique) {
    if (!technique.fit.law)
        return fmt::format("{}:  no slope, {}", technique.technique, technique.fit.why_not);
    const LineFit& line = technique.fit.law->line;
    return fmt::format("{}:  slope {}{:.3f} \u00b1 {:.3f}", technique.technique,
                       line.slope < 0 ? "\u2212" : "", std::abs(line.slope), line.slope_half_width);
}

// Means with their bars, and the two ends of the law, as gnuplot's named blocks.
std::string data_blocks(const Convergence& c, const Extent& x) {
    std::string text;
    for (std::size_t t = 0; t < c.techniques.size(); ++t) {
        text += fmt::format("$points_{} << EOD\n", t);
        for (const ConvergenceAtValue& at : c.techniques[t].values) {
            const MeanSd m = mean_sd(at.all(&ConvergenceRun::rmse8));
            if (m.mean <= 0) continue;
            const double sd = m.sd.value_or(0);
            // A bar down to 0 or below would have no end on this axis.
            text += fmt::format("{} {} {} {}\n", at.value, m.mean, std::max(m.mean - sd, m.mean / 100),
                                m.mean + sd);
        }
        text += "EOD\n";
        if (const auto& law = c.techniques[t].fit.law) {
            text += fmt::format("$law_{} << EOD\n", t);
            for (const double value : {x.low, x.high})
                text += fmt::format("{} {}\n", value, law->coefficient * std::pow(value, law->line.slope));
            text += "EOD\n";
        }
    }
    return text;
}

// Both from one point above the data, so that their lines cross it.
std::string guides(const Extent& x, double start) {
    std::string text;
    for (const auto& [name, slope] : {std::pair{"half", -0.5}, {"one", -1.0}}) {
        const double end = start * std::pow(x.high / x.low, slope);
        text += fmt::format("$guide_{} << EOD\n{} {}\n{} {}\nEOD\n", name, x.low, start, x.high, end);
        text += fmt::format("set label 'slope {}' at {},{} left offset 0.6,0 textcolor rgb '{}'\n",
                            slope == -1.0 ? "\u22121" : "\u2212\u00bd", x.high, end, kGuideColor);
    }
    return text;
}

std::string plot_command(const Convergence& c) {
    std::string text = fmt::format(
        "plot $guide_half with lines dashtype 2 linewidth 1.5 linecolor rgb '{0}' notitle, \\\n"
        "  $guide_one with lines dashtype 3 linewidth 1.5 linecolor rgb '{0}' notitle",
        kGuideColor);
    for (std::size_t t = 0; t < c.techniques.size(); ++t) {
        const PlotLook& look = kPlotLooks[t % kPlotLooks.size()];
        const bool law = c.techniques[t].fit.law.has_value();
        if (law)
            text += fmt::format(", \\\n  $law_{} with lines linewidth 2 linecolor rgb '{}' notitle", t,
                                look.color);
        text += fmt::format(
            ", \\\n  $points_{} using 1:2:3:4 with yerrorbars pointtype {} pointsize 1 linewidth 1.5 "
            "linecolor rgb '{}' notitle",
            t, look.marker, look.color);
        text += fmt::format(
            ", \\\n  NaN with {} linewidth 2 pointtype {} pointsize 1 linecolor rgb '{}' title {}",
            law ? "linespoints" : "points", look.marker, look.color,
            gnuplot_quoted(legend_of(c.techniques[t])));
    }
    return text + "\n";
}

std::string captions(const Convergence& c) {
    const auto random = [](const ConvergenceOfTechnique& technique) { return technique.random; };
    std::string seeds;
    if (c.options.seeds > 1 && std::any_of(c.techniques.begin(), c.techniques.end(), random))
        seeds = fmt::format(", {} seeds, bars \u00b1 1 sd", c.options.seeds);
    return fmt::format(
        "set title {}\nset xlabel {} offset 0,0.4\nset ylabel {}\n",
        gnuplot_quoted(fmt::format("{}: error against {}  ({}\u00d7{} pixels, {} spatial sample{}{})",
                                   fs::path(c.options.trace).stem().string(), c.options.key, c.width,
                                   c.height, c.samples, c.samples == 1 ? "" : "s", seeds)),
        gnuplot_quoted(c.options.key == "samples" ? "stored samples S a pixel" : c.options.key),
        gnuplot_quoted("RMSE over all pixels, 8-bit units (linear full scale = 255)"));
}

}  // namespace

bool has_plot(const Convergence& convergence) {
    return extent_of_errors(convergence).high > 0;
}

std::string convergence_plot_script(const Convergence& c, const std::string& svg, const std::string& png) {
    const Extent x = extent_of_values(c);
    const Extent errors = extent_of_errors(c);
    const double start = 1.4 * errors.high;
    // Below the data and the steeper guide, with room for a decade's part around.
    const Extent y{0.75 * std::min(errors.low, start * x.low / x.high), 1.4 * start};
    std::string text =
        "set encoding utf8\nset logscale xy\nset border 3 linewidth 1\nset grid linecolor rgb '#d0d0d0' "
        "linewidth 0.75\n";
    text += captions(c);
    // Room on the right for what the guides are called.
    const double room = std::pow(std::max(x.high / x.low, 2.0), 0.04);
    text += fmt::format("set xrange [{}:{}]\nset yrange [{}:{}]\n", x.low / room, x.high * std::pow(room, 3),
                        y.low, y.high);
    std::string tics;
    for (const ConvergenceAtValue& at : c.techniques[0].values)
        tics += fmt::format("{}{} {}", tics.empty() ? "" : ", ", gnuplot_quoted(at.text), at.value);
    text += fmt::format("set xtics nomirror ({})\nset ytics nomirror ({})\n", tics, log_tics(y.low, y.high));
    text +=
        "set key below left vertical maxcols 1 reverse Left width 2 spacing 1.3 title 'Least-squares slopes "
        "with 95% intervals' left\n";
    text += data_blocks(c, x) + guides(x, start) + plot_command(c);
    const double height = 580 + 26 * static_cast<double>(c.techniques.size());
    return svg_terminal(kWidth, height, svg) + text + png_terminal(kWidth, height, png) +
           "replot\nset output\n";
}

void write_convergence_plot(const Convergence& convergence, const std::string& directory) {
    CHECK(has_plot(convergence));
    draw_plot(directory, "convergence", [&](const std::string& svg, const std::string& png) {
        return convergence_plot_script(convergence, svg, png);
    });
}

}  // namespace ropsim
