#include "analysis/claims/adaptive_figure.h"

#include "analysis/claims/adaptive.h"
#include "analysis/claims/declared_cost.h"
#include "analysis/gnuplot.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

namespace ropsim::adaptive_figure {
namespace {

constexpr const char* kStochastic = "stochastic:samples=16,method=depth_based";
constexpr double kPixels720 = 1280.0 * 720;

// The figure's curves.
struct Curve {
    const char* name;
    const char* technique;
};
constexpr std::array<Curve, kCurves> kCurveList{
    {{"VRB", "adaptive:memory=variable"}, {"AT8", "adaptive:nodes=8"}, {"ST16", kStochastic}}};

// Bytes of a fragment when nothing is cached, as declared.
double list_bytes(int spatial_samples) {
    // With the two traversals of section 4.1, which resolve makes.
    return declared_cost(kCurveList[0].technique, spatial_samples).bytes() +
           2 * stored_list_bytes(spatial_samples).node;
}
// Total transmittance and colour a spatial sample (4.2), depths a pixel: from what both cost once and in
// every stored sample.
double stochastic_bytes(int spatial_samples) {
    const double once = declared_cost(kStochastic).bytes();
    const double each =
        declared_cost(fmt::format("{},total_alpha=sample,accumulator=sample", kStochastic)).bytes();
    return once + (spatial_samples - 1) * (each - once) / 15;
}
Point point_of(ClaimRuns& runs, std::size_t curve, int samples, int layers) {
    ClaimTrace trace{"surfaces", "640x360", "160x96"};
    trace.samples = samples;
    trace.alpha = 0.3;
    trace.layers = layers;
    ClaimRun run{trace, kCurveList[curve].technique};
    run.fidelity = "cached";
    const RunRecord& record = runs.run(run);
    const double pixels = number_of(record.width) * number_of(record.height);
    Point point{layers};
    point.fragments = number_of(record.fragments) / pixels;
    point.model = point.fragments * model_bytes(curve, samples);
    point.touched = (number_of(record.total.read) + number_of(record.total.write)) / pixels;
    point.pins = (number_of(record.total.pin_read) + number_of(record.total.pin_write)) / pixels;
    return point;
}

std::string csv_of(const Figure& figure) {
    std::string text =
        "spatial_samples,curve,technique,layers,fragments_per_pixel,worst_case_bytes_per_pixel,"
        "touched_bytes_per_pixel,pin_bytes_per_pixel\n";
    for (std::size_t s = 0; s < kSamples.size(); ++s)
        for (std::size_t c = 0; c < kCurves; ++c)
            for (const Point& p : figure[s][c])
                text += fmt::format("{},{},\"{}\",{},{:.6g},{:.6g},{:.6g},{:.6g}\n", kSamples[s],
                                    kCurveList[c].name, kCurveList[c].technique, p.layers, p.fragments,
                                    p.model, p.touched, p.pins);
    return text;
}

std::string panel_of(const Figure& figure, std::size_t s, double low, double high) {
    const double megabytes = 1e-6 * kPixels720;
    std::string text = fmt::format(
        "set origin {},0\nset size 0.5,1\nset title '{}'\nset yrange [{}:{}]\nset ytics nomirror ({})\n"
        "set y2range [{}:{}]\nset y2tics ({})\n",
        0.5 * static_cast<double>(s),
        s == 0 ? "one spatial sample"
               : "4 spatial samples; ST16 keeps its sums in each in the model, once in runs",
        low, high, log_tics(low, high), low * megabytes, high * megabytes,
        log_tics(low * megabytes, high * megabytes));
    std::string plots;
    for (std::size_t c = 0; c < kCurves; ++c) {
        const PlotLook& look = kPlotLooks[c];
        text += fmt::format("$p_{}_{} << EOD\n", s, c);
        for (const Point& p : figure[s][c]) text += fmt::format("{} {} {}\n", p.fragments, p.model, p.pins);
        text += "EOD\n";
        plots += fmt::format(
            "{}$p_{}_{} using 1:2 with lines dashtype 2 linewidth 1.5 linecolor rgb '{}' title '{}, worst "
            "case', "
            "$p_{}_{} using 1:3 with linespoints linewidth 2 pointtype {} pointsize 1 linecolor rgb '{}' "
            "title '{}, on the pins'",
            plots.empty() ? "plot " : ", ", s, c, look.color, kCurveList[c].name, s, c, look.marker,
            look.color, kCurveList[c].name);
    }
    return text + plots + "\n";
}

}  // namespace

double model_bytes(std::size_t curve, int spatial_samples) {
    if (curve == 0) return list_bytes(spatial_samples);
    if (curve == 1) return declared_cost(kCurveList[1].technique, spatial_samples).bytes();
    return stochastic_bytes(spatial_samples);
}

Figure figure_of(ClaimRuns& runs) {
    Figure figure;
    const std::vector<int> all = runs.quick() ? std::vector{1, 4, 16} : std::vector{1, 2, 4, 8, 16, 32};
    for (std::size_t s = 0; s < kSamples.size(); ++s)
        for (std::size_t c = 0; c < kCurves; ++c)
            for (const int layers : all) figure[s][c].push_back(point_of(runs, c, kSamples[s], layers));
    return figure;
}

ClaimTable table_of(const Figure& figure) {
    // A frame's clear and resolve are in what is touched, and not in the model.
    ClaimTable table{
        {"spatial samples", "fragments a pixel", "VRB: worst case", "touched with clear and resolve", "pins",
         "AT8: worst case", "touched", "pins", "ST16: worst case", "touched", "pins"},
        {}};
    for (std::size_t s = 0; s < kSamples.size(); ++s)
        for (std::size_t i = 0; i < figure[s][0].size(); ++i) {
            std::vector<std::string> row{std::to_string(kSamples[s]),
                                         fmt::format("{:.2f}", figure[s][0][i].fragments)};
            for (const auto& curve : figure[s])
                for (const double bytes : {curve[i].model, curve[i].touched, curve[i].pins})
                    row.push_back(fmt::format("{:.0f}", bytes));
            table.rows.push_back(row);
        }
    return table;
}

ClaimPlot plot_of(const Figure& figure) {
    double low = HUGE_VAL;
    double high = 0;
    double most = 0;
    for (const auto& samples : figure)
        for (const auto& curve : samples)
            for (const Point& p : curve) {
                low = std::min({low, p.model, p.pins});
                high = std::max({high, p.model, p.pins});
                most = std::max(most, p.fragments);
            }
    std::string drawing = fmt::format(
        "reset\nset encoding utf8\nset multiplot\nset logscale x 2\nset logscale y\nset logscale y2\n"
        "set grid ytics linecolor rgb '#e0e0e0' linewidth 0.75\nset border 11 linewidth 1\n"
        "set xrange [{}:{}]\nset xtics nomirror\nset key top left reverse Left samplen 2\n"
        "set xlabel 'transparent fragments a pixel'\nset ylabel 'bytes read and written, a pixel'\n"
        "set y2label 'MB a frame of 1280x720'\n",
        0.9, most * 1.15);
    for (std::size_t s = 0; s < kSamples.size(); ++s) drawing += panel_of(figure, s, low / 1.3, high * 1.3);
    return {"at-figure-10", 1240, 560, drawing + "unset multiplot\nset output\n", csv_of(figure)};
}

}  // namespace ropsim::adaptive_figure
