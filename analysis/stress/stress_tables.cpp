#include "analysis/stress/stress_tables.h"

#include "analysis/stress/largest.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <tuple>

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr std::string_view range_name(ValueRange range) {
    switch (range) {
        case ValueRange::kUnit:
            return "0 to 1";
        case ValueRange::kSignedUnit:
            return "-1 to 1";
        case ValueRange::kColor:
            return "colour";
        case ValueRange::kSum:
            return "sum";
        case ValueRange::kSignedSum:
            return "signed sum";
    }
    return "";
}

const StressVariant& variant_of(const StressStudy& study, const VariantSummary& s) {
    return study.techniques[s.technique].variants[s.variant];
}

std::vector<std::string> counts(const StressFaults& faults) {
    return {std::to_string(faults.not_numbers), std::to_string(faults.infinite),
            std::to_string(faults.negative), std::to_string(faults.too_bright)};
}

// Of the same configuration, the fewest bits whose formats hold what is declared on every scene.
std::optional<std::size_t> cure(const StressStudy& study, const std::vector<VariantSummary>& summaries,
                                const VariantSummary& hazard) {
    std::optional<std::size_t> best;
    for (std::size_t i = 0; i < summaries.size(); ++i) {
        if (summaries[i].technique != hazard.technique) continue;
        const StressVariant& variant = variant_of(study, summaries[i]);
        if (!variant.narrow_if_bright.empty() || summaries[i].faults[0].all() > 0) continue;
        if (!best || variant.all_bits() < variant_of(study, summaries[*best]).all_bits()) best = i;
    }
    return best;
}

std::string more_bits(const StressVariant& a, const StressVariant& b) {
    return more_bits_text(a.bits - b.bits, a.node_bits - b.node_bits);
}

struct NarrowRow {
    std::uint64_t combinations = 0;
    StressFaults faults;
    double rounding = -1;
    std::set<Format> formats;
    std::size_t example = 0;
};
using NarrowKey = std::tuple<std::string, std::string, ValueRange>;

std::map<NarrowKey, NarrowRow> narrow_rows(const StressStudy& study,
                                           const std::vector<VariantSummary>& summaries) {
    std::map<NarrowKey, NarrowRow> rows;
    constexpr auto kFormat = static_cast<std::size_t>(StressHazard::kFormat);
    for (std::size_t i = 0; i < summaries.size(); ++i) {
        const VariantSummary& s = summaries[i];
        if (s.by_hazard[kFormat] == 0) continue;
        const StressVariant& variant = variant_of(study, s);
        const NarrowField& field = (variant.narrow.empty() ? variant.narrow_if_bright : variant.narrow)[0];
        const std::string name = variant.technique.substr(0, variant.technique.find(':'));
        const auto [row, fresh] = rows.try_emplace({name, field.surface, field.range});
        if (fresh) row->second.example = i;
        row->second.formats.insert(field.format);
        row->second.combinations += s.by_hazard[kFormat];
        row->second.faults += s.faults[kFormat];
        take_larger(row->second.rounding, s.hazard_rounding);
    }
    return rows;
}

void add_narrow_table(std::string& text, const StressStudy& study,
                      const std::vector<VariantSummary>& summaries) {
    const std::map<NarrowKey, NarrowRow> rows = narrow_rows(study, summaries);
    if (rows.empty()) return;
    text +=
        "\n## Formats too narrow\n\nBy surface and what it is declared to hold; *colour* is too "
        "wide for a format that ends at 1 where a scene has colours above 1. The cure is the configuration's "
        "state of fewest bits that holds everything.\n\n";
    add_heading(text, {"technique", "surface", "holds", "in", "combinations", "NaN", "infinite", "negative",
                       "too bright", "rounding", "bits", "cure", "bits more"});
    for (const auto& [key, row] : rows) {
        const VariantSummary& example = summaries[row.example];
        const StressVariant& variant = variant_of(study, example);
        std::string in;
        for (const Format format : row.formats)
            in += (in.empty() ? "" : ", ") + std::string(format_info(format).name);
        std::vector<std::string> fields{fmt::format("`{}`", std::get<0>(key)), std::get<1>(key),
                                        std::string(range_name(std::get<2>(key))), in,
                                        std::to_string(row.combinations)};
        for (const std::string& count : counts(row.faults)) fields.push_back(count);
        fields.push_back(in_255(row.rounding));
        fields.push_back(fmt::format("{} ({})", bits_text(variant.bits, variant.node_bits), variant.formats));
        const auto cured = cure(study, summaries, example);
        fields.push_back(cured ? variant_of(study, summaries[*cured]).formats : "none");
        fields.push_back(cured ? more_bits(variant_of(study, summaries[*cured]), variant) : "-");
        add_row(text, fields);
    }
}

void add_light_table(std::string& text, const StressStudy& study,
                     const std::vector<VariantSummary>& summaries) {
    struct Row {
        std::uint64_t combinations = 0;
        StressFaults faults;
    };
    std::map<std::pair<std::size_t, LightLaw>, Row> rows;
    constexpr auto kLight = static_cast<std::size_t>(StressHazard::kLight);
    for (const VariantSummary& s : summaries) {
        if (s.by_hazard[kLight] == 0) continue;
        Row& row = rows[{s.technique, variant_of(study, s).light}];
        row.combinations += s.by_hazard[kLight];
        row.faults += s.faults[kLight];
    }
    if (rows.empty()) return;
    text +=
        "\n## Formulas that add light\n\n*Scaled*: resolve scales the sum of all light to the total alpha, "
        "and light without alpha with it; of scenes with such light. *Added*: a published form, of all "
        "scenes.\n\n";
    add_heading(text, {"technique", "light", "combinations", "NaN", "infinite", "negative", "too bright"});
    for (const auto& [key, row] : rows) {
        std::vector<std::string> fields{fmt::format("`{}`", study.techniques[key.first].settings),
                                        key.second == LightLaw::kAdded ? "added" : "scaled",
                                        std::to_string(row.combinations)};
        for (const std::string& count : counts(row.faults)) fields.push_back(count);
        add_row(text, fields);
    }
}

}  // namespace

void add_row(std::string& text, const std::vector<std::string>& fields) {
    text += "|";
    for (const std::string& f : fields) text += fmt::format(" {} |", f);
    text += "\n";
}
void add_heading(std::string& text, const std::vector<std::string>& fields) {
    add_row(text, fields);
    text += "|---|";
    for (std::size_t i = 1; i < fields.size(); ++i) text += "---:|";
    text += "\n";
}

std::string in_255(double value) {
    if (value == -1) return "-";
    if (std::isnan(value)) return "NaN";
    const double scaled = 255 * value;
    if (scaled == 0) return "0";
    if (scaled < 0.001) return "<.001";
    return scaled < 0.1 ? fmt::format("{:.3f}", scaled)
                        : fmt::format("{:.{}f}", scaled,
                                      scaled < 10    ? 2
                                      : scaled < 100 ? 1
                                                     : 0);
}

void add_fault_tables(std::string& text, const StressStudy& study,
                      const std::vector<VariantSummary>& summaries) {
    text += "\n## Values that are none\n\n";
    std::uint64_t values = 0;
    for (const StressResult& r : study.results)
        if (r.hazard == StressHazard::kNone) values += r.values;
    const StressFaults all = study.faults();
    text += fmt::format(
        "In {} combinations the formats hold what is declared for their surfaces and the formula adds no "
        "light. Of their {} channels {} are NaN, {} infinite, {} negative and {} too bright.\n",
        study.held(), values, all.not_numbers, all.infinite, all.negative, all.too_bright);
    if (all.all() > 0) {
        text += "\n";
        add_heading(text, {"technique", "formats", "NaN", "infinite", "negative", "too bright"});
        for (const VariantSummary& s : summaries) {
            if (s.faults[0].all() == 0) continue;
            std::vector<std::string> fields{fmt::format("`{}`", study.techniques[s.technique].settings),
                                            variant_of(study, s).formats};
            for (const std::string& count : counts(s.faults[0])) fields.push_back(count);
            add_row(text, fields);
        }
    }
    add_narrow_table(text, study, summaries);
    add_light_table(text, study, summaries);
}

}  // namespace ropsim
