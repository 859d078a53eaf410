// A convergence study as aligned plain text.
#include "analysis/comparison_table.h"
#include "analysis/convergence_output.h"
#include "analysis/text_table.h"

#include <fmt/format.h>

namespace ropsim {
namespace {

using Row = std::vector<std::string>;

std::string shown(const std::optional<double>& value, int decimals) {
    return format_measured(value, decimals, ",", "-");
}

std::string mean_of(const ConvergenceAtValue& at, double ConvergenceRun::*member, int decimals) {
    return shown(mean_sd(at.all(member)).mean, decimals);
}

Row row_of(const ConvergenceOfTechnique& technique, const ConvergenceAtValue& at, bool with_ratio) {
    const MeanSd rmse = mean_sd(at.all(&ConvergenceRun::rmse8));
    Row row{technique.technique,
            at.text,
            shown(rmse.mean, 3),
            shown(rmse.sd, 3),
            mean_of(at, &ConvergenceRun::rmse8_covered, 3),
            mean_of(at, &ConvergenceRun::mean_signed8, 3),
            mean_of(at, &ConvergenceRun::worst_case_bytes_per_fragment, 2),
            mean_of(at, &ConvergenceRun::touched_bytes_per_fragment, 2),
            shown(at.storage_bits_per_pixel, 0)};
    if (!with_ratio) return row;
    row.push_back(at.ratio ? shown(at.ratio->mean, 3) : "-");
    row.push_back(at.ratio ? shown(at.ratio->sd, 3) : "-");
    return row;
}

std::string slope_line(const ConvergenceOfTechnique& technique, const std::string& key) {
    if (!technique.fit.law)
        return fmt::format("{}: no slope: {}\n", technique.technique, technique.fit.why_not);
    const PowerLaw& law = *technique.fit.law;
    return fmt::format(
        "{}: RMSE = {:.3f} {}^({:.3f} +- {:.3f}), 95% from {}, {} degrees of freedom; values depart from "
        "it by {:.1f}% at most\n",
        technique.technique, law.coefficient, key, law.line.slope, law.line.slope_half_width,
        law.line.from_replicates ? "seeds" : "residuals", law.line.degrees_of_freedom,
        law.largest_departure_percent);
}

}  // namespace

std::string convergence_table(const Convergence& c) {
    const bool with_ratio = c.techniques.size() > 1;
    std::vector<Row> rows{{"technique", c.options.key, "RMSE", "sd", "covered RMSE", "signed", "worst case",
                           "touched", "storage"},
                          {"", "", "/255", "/255", "/255", "/255", "B/frag", "B/frag", "bit/px"}};
    if (with_ratio) {
        rows[0].insert(rows[0].end(), {"to first", "sd"});
        rows[1].insert(rows[1].end(), {"", ""});
    }
    for (const ConvergenceOfTechnique& technique : c.techniques)
        for (const ConvergenceAtValue& at : technique.values)
            rows.push_back(row_of(technique, at, with_ratio));
    std::string text = aligned_table(rows) + "\n";
    for (const ConvergenceOfTechnique& technique : c.techniques) text += slope_line(technique, c.options.key);
    return text;
}

}  // namespace ropsim
