#include "analysis/stress/stress_summary.h"

#include "analysis/stress/largest.h"

#include <algorithm>
#include <cmath>

namespace ropsim {
namespace {

std::size_t kind_of(const StressInput& input) {
    const auto found = std::ranges::find(kStressKinds, input.kind);
    return static_cast<std::size_t>(found - kStressKinds.begin());
}

void add(VariantSummary& summary, const StressResult& r, std::size_t kind) {
    ++summary.combinations;
    ++summary.by_hazard[static_cast<std::size_t>(r.hazard)];
    summary.faults[static_cast<std::size_t>(r.hazard)] += r.faults;
    if (r.hazard == StressHazard::kFormat) {
        summary.narrow[kind] = true;
        take_larger(summary.hazard_rounding, r.worst_rounding);
    }
    summary.other_paths += r.other_paths;
    if (is_larger(r.worst_rounding, summary.worst_rounding)) {
        summary.worst_rounding = r.worst_rounding;
        summary.worst_input = r.input;
    }
    take_larger(summary.rounding[kind], r.worst_rounding);
    take_larger(summary.error[kind], r.worst_error);
    take_larger(summary.rise, r.rise);
    take_larger(summary.rise_exact, r.rise_exact);
    take_larger(summary.outside, r.outside);
    take_larger(summary.order_change, r.order_change);
    take_larger(summary.white_loss, r.white_loss);
    take_larger(summary.white_rounding, r.white_rounding);
}

}  // namespace

std::vector<VariantSummary> stress_summaries(const StressStudy& study) {
    std::vector<VariantSummary> summaries;
    for (const StressResult& r : study.results) {
        if (summaries.empty() || summaries.back().technique != r.technique ||
            summaries.back().variant != r.variant) {
            VariantSummary& fresh = summaries.emplace_back();
            fresh.technique = r.technique;
            fresh.variant = r.variant;
            fresh.rounding.fill(-1);
            fresh.error.fill(-1);
        }
        if (!r.left_out) add(summaries.back(), r, kind_of(study.inputs[r.input]));
    }
    return summaries;
}

std::optional<std::size_t> fewest_bits(const StressStudy& study, const std::vector<VariantSummary>& summaries,
                                       std::size_t technique, std::size_t kind) {
    std::optional<std::size_t> best;
    const std::vector<StressVariant>& variants = study.techniques[technique].variants;
    for (std::size_t s = 0; s < summaries.size(); ++s) {
        const VariantSummary& summary = summaries[s];
        const double rounding = summary.rounding[kind];
        if (summary.technique != technique || summary.narrow[kind] || summary.faults[0].all() > 0) continue;
        if (!(rounding >= 0 && rounding <= kRoundingBound)) continue;
        const auto rank = [&](std::size_t i) {
            return std::pair(variants[summaries[i].variant].all_bits(), summaries[i].rounding[kind]);
        };
        if (!best || rank(s) < rank(*best)) best = s;
    }
    return best;
}

}  // namespace ropsim
