// Every number of a convergence study for programs.
#include "analysis/convergence_output.h"

#include "analysis/text_table.h"
#include "base/version.h"
#include "model/run.h"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

constexpr struct {
    const char* key;
    double ConvergenceRun::*member;
    const char* unit;
} kMeasured[] = {
    {"rmse8", &ConvergenceRun::rmse8, "1/255 of linear full scale, all pixels"},
    {"rmse8_covered", &ConvergenceRun::rmse8_covered,
     "1/255 of linear full scale, pixels with a transparent fragment"},
    {"mean_signed8", &ConvergenceRun::mean_signed8, "1/255 of linear full scale, all pixels"},
    {"worst_case_bytes_per_fragment", &ConvergenceRun::worst_case_bytes_per_fragment,
     "bytes read and written if every fragment took its costliest path, a fragment of the trace"},
    {"touched_bytes_per_fragment", &ConvergenceRun::touched_bytes_per_fragment,
     "bytes read and written that the run asked for before caches, a fragment of the trace"},
};

Json number(double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json mean_sd_json(const MeanSd& m) {
    return {{"mean", number(m.mean)}, {"sd", m.sd ? number(*m.sd) : Json(nullptr)}};
}

Json units_json(const ConvergenceOptions& options) {
    Json json = {{"value", fmt::format("of the parameter {}", options.key)}};
    for (const auto& m : kMeasured) json[m.key] = m.unit;
    json["mean, sd"] = "over seeds, in the unit of their quantity; sd with n - 1, null for one seed";
    json["storage_bits_per_pixel"] = "bits a pixel, pools left out";
    json["rmse8_ratio_to_first"] = "rmse8 over the first technique's, paired by seed";
    json["slope"] =
        fmt::format("exponent of {} in rmse8 = coefficient_rmse8 * {}^slope", options.key, options.key);
    json["slope_ci95"] =
        "exponents: slope -+ Student's t times standard error. slope_ci95_from \"seeds\": from the scatter "
        "of "
        "log(rmse8) over seeds about each value's mean, so that with other seeds at the same values 95% of "
        "such "
        "intervals hold the slope fitted to the expected log(rmse8), straight or not; \"residuals\" (one "
        "seed): from "
        "the residuals about the line, taking the expected values to lie on it";
    json["coefficient_rmse8"] = fmt::format("1/255 of linear full scale, of the line at {} = 1", options.key);
    json["largest_departure_percent"] = "percent, of a value's geometric mean rmse8 from the line";
    return json;
}

Json fit_json(const PowerLawFit& fit) {
    if (!fit.law)
        return {{"slope", nullptr},
                {"slope_ci95", nullptr},
                {"slope_ci95_from", nullptr},
                {"degrees_of_freedom", nullptr},
                {"coefficient_rmse8", nullptr},
                {"largest_departure_percent", nullptr},
                {"why_null", fit.why_not}};
    const LineFit& line = fit.law->line;
    return {{"slope", line.slope},
            {"slope_ci95", {line.slope - line.slope_half_width, line.slope + line.slope_half_width}},
            {"slope_ci95_from", line.from_replicates ? "seeds" : "residuals"},
            {"degrees_of_freedom", line.degrees_of_freedom},
            {"coefficient_rmse8", fit.law->coefficient},
            {"largest_departure_percent", fit.law->largest_departure_percent},
            {"why_null", nullptr}};
}

Json value_json(const ConvergenceAtValue& at) {
    Json json = {{"value", at.value}};
    for (const auto& m : kMeasured) json[m.key] = mean_sd_json(mean_sd(at.all(m.member)));
    json["storage_bits_per_pixel"] = at.storage_bits_per_pixel;
    json["rmse8_ratio_to_first"] = at.ratio ? mean_sd_json(*at.ratio) : Json(nullptr);
    json["runs"] = Json::array();
    for (const ConvergenceRun& run : at.runs) {
        Json entry = {{"seed", run.seed}};
        for (const auto& m : kMeasured) entry[m.key] = number(run.*m.member);
        json["runs"].push_back(entry);
    }
    return json;
}

}  // namespace

std::string convergence_json(const Convergence& c, bool plotted) {
    Json values = Json::array();
    if (!c.techniques.empty())
        for (const ConvergenceAtValue& at : c.techniques[0].values) values.push_back(at.value);
    Json json;
    json["ropsim"] = kVersion;
    json["trace"] = {{"file", c.options.trace}, {"hash", c.trace_hash}, {"scene", c.scene},
                     {"width", c.width},        {"height", c.height},   {"samples", c.samples},
                     {"fragments", c.fragments}};
    json["configuration"] = {
        {"techniques", c.options.techniques}, {"key", c.options.key}, {"values", values},
        {"seeds", c.options.seeds},           {"fidelity", "count"},  {"hardware", RunOptions().hardware}};
    json["units"] = units_json(c.options);
    json["techniques"] = Json::array();
    for (const ConvergenceOfTechnique& technique : c.techniques) {
        Json entry = {{"technique", technique.technique},
                      {"technique_parameters", technique.parameters},
                      {"random", technique.random},
                      {"fit", fit_json(technique.fit)},
                      {"values", Json::array()}};
        for (const ConvergenceAtValue& at : technique.values) entry["values"].push_back(value_json(at));
        json["techniques"].push_back(entry);
    }
    json["plot"] = plotted ? Json{"convergence.svg", "convergence.png"} : Json(nullptr);
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string convergence_csv(const Convergence& c) {
    std::string text = "technique,key,value,seed";
    for (const auto& m : kMeasured) text += fmt::format(",{}", m.key);
    text += ",storage_bits_per_pixel\n";
    for (const ConvergenceOfTechnique& technique : c.techniques)
        for (const ConvergenceAtValue& at : technique.values)
            for (const ConvergenceRun& run : at.runs) {
                text += fmt::format("{},{},{},{}", csv_field(technique.technique), csv_field(c.options.key),
                                    at.value, run.seed);
                for (const auto& m : kMeasured) {
                    const double measured = run.*m.member;
                    text += std::isfinite(measured) ? fmt::format(",{}", measured) : ",";
                }
                text += fmt::format(",{}\n", at.storage_bits_per_pixel);
            }
    return text;
}

}  // namespace ropsim
