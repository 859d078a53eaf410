// A pixel's visibility functions for programs, for readers, and as a picture.
#include "analysis/comparison_table.h"
#include "analysis/gnuplot.h"
#include "analysis/text_table.h"
#include "analysis/visibility_curve.h"
#include "base/version.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kWidth = 900;
constexpr std::array<int, 3> kDashes = {1, 2, 4};  // one for each turn through the colours

constexpr struct {
    const char* key;
    double CurveError::*member;
    const char* unit;
} kErrors[] = {
    {"max", &CurveError::max, "visibility: largest |representation - exact| over the shown depths"},
    {"area", &CurveError::area,
     "visibility times window depth: integral of |representation - exact| over the shown range"},
    {"mean", &CurveError::mean, "visibility: area over the length of the range"},
    {"fragments_mean", &CurveError::fragments_mean,
     "visibility: mean of |representation - exact| at the depths of the fragments, in each sample they "
     "cover"},
    {"fragments_rms", &CurveError::fragments_rms, "visibility: the same, root mean square"},
    {"fragments_max", &CurveError::fragments_max, "visibility: the same, largest"},
};

Json number(double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

// The shortest decimals that give the float again.
Json number(float value) {
    return std::isfinite(value) ? Json(std::stod(fmt::format("{}", value))) : Json(nullptr);
}

template <class T>
Json numbers(const std::vector<T>& values) {
    Json list = Json::array();
    for (const T value : values) list.push_back(number(value));
    return list;
}

// Decimals of the tics of an axis of this length, which has about seven.
int depth_decimals(double length) {
    return std::clamp(static_cast<int>(std::ceil(-std::log10(std::max(length, 1e-7) / 7))), 1, 8);
}

constexpr double kNoChange = 0.002;  // less than a line's width on the axis

// The depth up to which the picture goes: behind it neither the exact function nor a technique's changes. The
// whole range unless that saves a quarter of it.
double shown_end(const VisibilityCurve& curve) {
    const auto changes = [&](std::size_t i) {
        const auto differs = [&](const CurveOfTechnique& t) {
            return !(std::abs(t.visibility[i] - t.visibility.back()) < static_cast<float>(kNoChange));
        };
        return std::abs(curve.truth[i] - curve.truth.back()) >= kNoChange ||
               std::any_of(curve.techniques.begin(), curve.techniques.end(), differs);
    };
    std::size_t last = curve.depths.size() - 1;
    while (last > 0 && !changes(last)) --last;
    const double low = static_cast<double>(curve.depths.front());
    const double high = static_cast<double>(curve.depths.back());
    const double end = low + (static_cast<double>(curve.depths[last]) - low) * 1.15;
    return end - low < 0.75 * (high - low) ? end : high;
}

std::string blocks(const VisibilityCurve& curve) {
    std::string text = "$exact << EOD\n";
    for (std::size_t i = 0; i < curve.depths.size(); ++i)
        text += fmt::format("{} {}\n", curve.depths[i], curve.truth[i]);
    text += "EOD\n$fragments << EOD\n";
    for (const float z : curve.truth_depths) text += fmt::format("{}\n", z);
    text += "EOD\n";
    for (std::size_t t = 0; t < curve.techniques.size(); ++t) {
        text += fmt::format("$technique_{} << EOD\n", t);
        for (std::size_t i = 0; i < curve.depths.size(); ++i)
            text += fmt::format("{} {}\n", curve.depths[i], curve.techniques[t].visibility[i]);
        text += "EOD\n";
    }
    return text;
}

std::string plot_command(const VisibilityCurve& curve) {
    std::string text =
        "plot $exact with lines linewidth 5 linecolor rgb '#c0c0c0' title 'exact', \\\n"
        "  $fragments using 1:(-0.045):(0):(0.03) with vectors nohead linewidth 0.75 linecolor rgb '#606060' "
        "notitle";
    for (std::size_t t = 0; t < curve.techniques.size(); ++t) {
        const CurveOfTechnique& technique = curve.techniques[t];
        const std::size_t turn = t / kPlotLooks.size() % kDashes.size();
        text += fmt::format(
            ", \\\n  $technique_{} with lines linewidth 1.75 dashtype {} linecolor rgb '{}' title {}", t,
            kDashes[turn], kPlotLooks[t % kPlotLooks.size()].color,
            gnuplot_quoted(fmt::format("{}:  mean error {:.4f}, at fragments {:.4f}", technique.technique,
                                       technique.error.mean, technique.error.fragments_mean)));
    }
    return text + "\n";
}

}  // namespace

std::string curve_json(const VisibilityCurve& curve) {
    Json json;
    json["ropsim"] = kVersion;
    json["trace"] = {{"file", curve.options.trace}, {"hash", curve.trace_hash}, {"scene", curve.scene},
                     {"width", curve.width},        {"height", curve.height},   {"samples", curve.samples}};
    json["pixel"] = {{"x", curve.pixel.x},
                     {"y", curve.pixel.y},
                     {"fragments", curve.pixel.fragments.size()},
                     {"hidden", curve.pixel.hidden}};
    json["configuration"] = {{"seed", curve.options.seed}};
    Json units = {
        {"depth, depths", "window depth, 0 near, 1 far"},
        {"visibility, exact", "transmittance of what is strictly in front of each depth, mean over samples"},
        {"steps", "where the exact function falls: depth, and its value just behind"},
        {"hidden", "fragments of the pixel behind the opaque layer"}};
    for (const auto& e : kErrors) units[fmt::format("error.{}", e.key)] = e.unit;
    json["units"] = units;
    json["steps"] = Json::array();
    for (std::size_t i = 0; i < curve.truth_depths.size(); ++i)
        json["steps"].push_back({number(curve.truth_depths[i]), number(curve.truth_behind[i])});
    json["techniques"] = Json::array();
    for (const CurveOfTechnique& t : curve.techniques) {
        Json error;
        for (const auto& e : kErrors) error[e.key] = number(t.error.*e.member);
        json["techniques"].push_back({{"technique", t.technique},
                                      {"technique_parameters", t.parameters},
                                      {"error", error},
                                      {"visibility", numbers(t.visibility)}});
    }
    json["depths"] = numbers(curve.depths);
    json["exact"] = numbers(curve.truth);
    return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string curve_table(const VisibilityCurve& curve) {
    std::vector<std::vector<std::string>> rows{{"technique", "max", "mean", "fragments mean", "rms", "max"}};
    for (const CurveOfTechnique& t : curve.techniques) {
        rows.push_back({t.technique});
        for (const double value : {t.error.max, t.error.mean, t.error.fragments_mean, t.error.fragments_rms,
                                   t.error.fragments_max})
            rows.back().push_back(format_measured(value, 5, "", "-"));
    }
    return fmt::format("pixel {},{}: {} fragments, exact visibility behind all {:.6f}; |vis - exact|:\n",
                       curve.pixel.x, curve.pixel.y, curve.pixel.fragments.size(),
                       curve.truth_behind.back()) +
           aligned_table(rows);
}

std::string curve_plot_script(const VisibilityCurve& curve, const std::string& svg, const std::string& png) {
    const double low = static_cast<double>(curve.depths.front());
    const double high = shown_end(curve);
    std::string text =
        "set encoding utf8\nset border 3 linewidth 1\nset grid linecolor rgb '#d0d0d0' linewidth 0.75\n"
        "set yrange [-0.05:1.03]\nset ytics nomirror 0,0.2,1\n"
        "set ylabel 'visibility in front of depth z'\n";
    const auto cut = std::count_if(curve.truth_depths.begin(), curve.truth_depths.end(),
                                   [high](float z) { return static_cast<double>(z) > high; });
    text += fmt::format(
        "set xlabel {} offset 0,0.4\n",
        gnuplot_quoted(
            cut == 0 ? "window depth z (ticks: fragments)"
                     : fmt::format("window depth z (ticks: fragments; {} more behind, where nothing changes)",
                                   cut)));
    text += fmt::format(
        "set title {}\nset xrange [{}:{}]\nset format x '%.{}f'\nset xtics nomirror\n",
        gnuplot_quoted(fmt::format(
            "{}, pixel {},{}: {} fragments{}", std::filesystem::path(curve.options.trace).stem().string(),
            curve.pixel.x, curve.pixel.y, curve.pixel.fragments.size(),
            curve.samples == 1 ? "" : fmt::format(", {} spatial samples", curve.samples))),
        low, high, depth_decimals(high - low));
    text += "set key below left vertical maxcols 1 reverse Left width 2 spacing 1.3\n";
    text += blocks(curve) + plot_command(curve);
    const double height = 560 + 26 * static_cast<double>(curve.techniques.size() + 1);
    return svg_terminal(kWidth, height, svg) + text + png_terminal(kWidth, height, png) +
           "replot\nset output\n";
}

void write_curve_plot(const VisibilityCurve& curve, const std::string& directory) {
    draw_plot(directory, "curve", [&](const std::string& svg, const std::string& png) {
        return curve_plot_script(curve, svg, png);
    });
}

}  // namespace ropsim
