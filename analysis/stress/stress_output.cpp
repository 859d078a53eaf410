// The stability study for programs and for readers.
#include "analysis/stress/stress_hazards.h"
#include "analysis/stress/stress_page.h"
#include "analysis/stress/stress_study.h"
#include "analysis/stress/stress_summary.h"
#include "analysis/stress/stress_tables.h"
#include "analysis/text_table.h"
#include "base/version.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
    return value >= 0 && std::isfinite(value) ? Json(value) : Json(nullptr);
}
std::string field(double value) {
    return value == -1 ? "" : fmt::format("{:.6g}", value);
}
std::string small(double value) {
    return value == -1 ? "-" : value == 0 ? "0" : fmt::format("{:.1e}", value);
}

std::string bits_of(const StressVariant& variant) {
    return bits_text(variant.bits, variant.node_bits);
}

const VariantSummary* find(const StressStudy& study, const std::vector<VariantSummary>& summaries,
                           std::size_t technique, const std::string& formats) {
    for (const VariantSummary& s : summaries)
        if (s.technique == technique && study.techniques[technique].variants[s.variant].formats == formats)
            return &s;
    return nullptr;
}

void add_rounding_table(std::string& text, const StressStudy& study, const std::vector<std::size_t>& rows,
                        const std::vector<VariantSummary>& summaries) {
    text += "\n## Rounding\n\n";
    std::vector<std::string> heading{"technique", "bits"};
    for (const std::string_view kind : kStressKinds) heading.emplace_back(kind);
    for (const char* more : {"float32", "worst at", "algorithm: scenes", "other paths"})
        heading.emplace_back(more);
    add_heading(text, heading);
    for (const std::size_t t : rows) {
        const VariantSummary* paper = find(study, summaries, t, "paper");
        const VariantSummary* single = find(study, summaries, t, "float32");
        if (paper == nullptr) continue;
        std::vector<std::string> row{fmt::format("`{}`", study.techniques[t].settings),
                                     bits_of(study.techniques[t].variants[paper->variant])};
        for (const double rounding : paper->rounding) row.push_back(in_255(rounding));
        row.push_back(single == nullptr ? "-" : in_255(single->worst_rounding));
        row.push_back(study.inputs[paper->worst_input].name);
        row.push_back(single == nullptr ? "-" : in_255(single->error[1]));
        row.push_back(single == nullptr ? "-" : std::to_string(single->other_paths));
        add_row(text, row);
    }
}

void add_bits_table(std::string& text, const StressStudy& study, const std::vector<std::size_t>& rows,
                    const std::vector<VariantSummary>& summaries) {
    text += "\n## Fewest bits within 1/255\n\n";
    std::vector<std::string> heading{"technique", "paper"};
    for (const std::string_view kind : kStressKinds) heading.emplace_back(kind);
    add_heading(text, heading);
    for (const std::size_t t : rows) {
        const VariantSummary* paper = find(study, summaries, t, "paper");
        if (paper == nullptr) continue;
        const std::vector<StressVariant>& variants = study.techniques[t].variants;
        std::vector<std::string> row{fmt::format("`{}`", study.techniques[t].settings),
                                     bits_of(variants[paper->variant])};
        for (std::size_t kind = 0; kind < kStressKinds.size(); ++kind) {
            if (std::ranges::none_of(study.inputs,
                                     [&](const StressInput& i) { return i.kind == kStressKinds[kind]; })) {
                row.emplace_back("-");
                continue;
            }
            const auto best = fewest_bits(study, summaries, t, kind);
            row.push_back(best ? fmt::format("{} ({})", bits_of(variants[summaries[*best].variant]),
                                             variants[summaries[*best].variant].formats)
                               : "none");
        }
        add_row(text, row);
    }
}

void add_drift_table(std::string& text, const StressStudy& study, const std::string& kind,
                     const std::string& formats) {
    std::vector<std::size_t> columns;
    for (std::size_t i = 0; i < study.inputs.size(); ++i)
        if (study.inputs[i].kind == kind) columns.push_back(i);
    if (columns.empty()) return;
    text += fmt::format("\n## Drift with layers: {}, {}\n\n", kind, formats);
    std::vector<std::string> heading{"technique"};
    for (const std::size_t i : columns) heading.push_back(std::to_string(study.inputs[i].layers));
    add_heading(text, heading);
    for (std::size_t t = 0; t < study.techniques.size(); ++t) {
        std::vector<std::string> row{fmt::format("`{}`", study.techniques[t].settings)};
        for (const std::size_t i : columns)
            for (const StressResult& r : study.results)
                if (r.technique == t && r.input == i &&
                    study.techniques[t].variants[r.variant].formats == formats)
                    row.push_back(in_255(r.worst_rounding));
        if (row.size() == heading.size()) add_row(text, row);
    }
}

void add_law_table(std::string& text, const StressStudy& study,
                   const std::vector<VariantSummary>& summaries) {
    text += "\n## Laws\n\n";
    add_heading(text, {"technique", "order, float32", "order, paper", "white, float32", "white, rounding",
                       "rise, float32", "rise, double", "outside [0, 1]"});
    for (std::size_t t = 0; t < study.techniques.size(); ++t) {
        const VariantSummary* paper = find(study, summaries, t, "paper");
        const VariantSummary* single = find(study, summaries, t, "float32");
        if (paper == nullptr || single == nullptr) continue;
        add_row(text, {fmt::format("`{}`", study.techniques[t].settings), small(single->order_change),
                       small(paper->order_change), small(single->white_loss), small(single->white_rounding),
                       small(single->rise), small(single->rise_exact), small(single->outside)});
    }
}

std::string matrix_line(const StressStudy& study, const std::vector<VariantSummary>& summaries) {
    return fmt::format(
        "{} combinations: {} configurations of techniques in {} formats, {} inputs, seed {}.\n",
        study.measured(), study.techniques.size(), summaries.size(), study.inputs.size(), study.seed);
}

Json faults_json(const VariantSummary& s, StressHazard hazard) {
    const StressFaults& faults = s.faults_of(hazard);
    return {{"combinations", s.by_hazard[static_cast<std::size_t>(hazard)]},
            {"not_numbers", faults.not_numbers},
            {"infinite", faults.infinite},
            {"negative", faults.negative},
            {"too_bright", faults.too_bright}};
}

Json variant_json(const StressStudy& study, const VariantSummary& s) {
    const StressVariant& variant = study.techniques[s.technique].variants[s.variant];
    Json json = {{"settings", study.techniques[s.technique].settings},
                 {"technique", variant.technique},
                 {"formats", variant.formats},
                 {"bits_per_pixel", variant.bits},
                 {"bits_per_node", variant.node_bits},
                 {"combinations", s.combinations}};
    for (std::size_t k = 0; k < kStressKinds.size(); ++k) {
        json["rounding"][std::string(kStressKinds[k])] = number(s.rounding[k]);
        json["error"][std::string(kStressKinds[k])] = number(s.error[k]);
    }
    json["worst_rounding"] = number(s.worst_rounding);
    json["worst_input"] = study.inputs[s.worst_input].name;
    json["order_change"] = number(s.order_change);
    json["white_loss"] = number(s.white_loss);
    json["white_rounding"] = number(s.white_rounding);
    json["visibility"] = {
        {"rise", number(s.rise)}, {"rise_double", number(s.rise_exact)}, {"outside", number(s.outside)}};
    json["faults"] = faults_json(s, StressHazard::kNone);
    json["hazards"] = {{"format", faults_json(s, StressHazard::kFormat)},
                       {"light", faults_json(s, StressHazard::kLight)}};
    json["other_paths"] = s.other_paths;
    return json;
}

}  // namespace

std::string stress_csv(const StressStudy& study) {
    std::string text =
        "settings,formats,bits,node_bits,input,left_out,hazard,worst_error,mean_error,worst_rounding,mean_"
        "rounding,"
        "worst_algorithm,other_paths,values,not_numbers,infinite,negative,too_bright,rise,rise_double,"
        "outside,order_change,white_loss,white_rounding\n";
    for (const StressResult& r : study.results) {
        const StressTechnique& technique = study.techniques[r.technique];
        const StressVariant& variant = technique.variants[r.variant];
        text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n",
                            csv_field(technique.settings), variant.formats, variant.bits, variant.node_bits,
                            study.inputs[r.input].name, r.left_out ? 1 : 0,
                            kStressHazardNames[static_cast<std::size_t>(r.hazard)], field(r.worst_error),
                            field(r.mean_error), field(r.worst_rounding), field(r.mean_rounding),
                            field(r.worst_algorithm), r.other_paths, r.values, r.faults.not_numbers,
                            r.faults.infinite, r.faults.negative, r.faults.too_bright, field(r.rise),
                            field(r.rise_exact), field(r.outside), field(r.order_change), field(r.white_loss),
                            field(r.white_rounding));
    }
    return text;
}

std::string stress_json(const StressStudy& study) {
    const std::vector<VariantSummary> summaries = stress_summaries(study);
    Json json = {{"version", kVersion},
                 {"seed", study.seed},
                 {"combinations", study.measured()},
                 {"unit", "of the pixel's brightest colour, at least 1"}};
    Json& inputs = json["inputs"] = Json::array();
    for (const StressInput& input : study.inputs)
        inputs.push_back({{"name", input.name},
                          {"kind", input.kind},
                          {"pixels", input.pixels.size()},
                          {"most_fragments", input.most_fragments()}});
    Json& variants = json["variants"] = Json::array();
    for (const VariantSummary& s : summaries) variants.push_back(variant_json(study, s));
    json["host"] = {{"seconds", study.seconds}};
    return json.dump(2) + "\n";
}

std::vector<StressBlock> stress_blocks(const StressStudy& study) {
    const std::vector<VariantSummary> summaries = stress_summaries(study);
    // The first configuration of each technique.
    std::vector<std::size_t> rows;
    std::set<std::string> names;
    for (std::size_t t = 0; t < study.techniques.size(); ++t) {
        const std::string& settings = study.techniques[t].settings;
        if (names.insert(settings.substr(0, settings.find(':'))).second) rows.push_back(t);
    }
    std::vector<StressBlock> blocks;
    for (const std::string_view name : kStressMatrixBlocks) blocks.emplace_back(name, "");
    blocks[0].second = matrix_line(study, summaries);
    add_fault_tables(blocks[0].second, study, summaries);
    add_rounding_table(blocks[1].second, study, rows, summaries);
    add_bits_table(blocks[2].second, study, rows, summaries);
    blocks[3].second = stress_hazards_markdown();
    return blocks;
}

std::string stress_markdown(const StressStudy& study) {
    const std::vector<VariantSummary> summaries = stress_summaries(study);
    std::string text = "# Numerical stability\n\n" + matrix_line(study, summaries);
    std::vector<std::size_t> all(study.techniques.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    add_fault_tables(text, study, summaries);
    add_rounding_table(text, study, all, summaries);
    add_bits_table(text, study, all, summaries);
    add_drift_table(text, study, "thin", "paper");
    add_drift_table(text, study, "even", "paper");
    add_drift_table(text, study, "even", "float32");
    add_law_table(text, study, summaries);
    text += stress_hazards_markdown();
    return text;
}

}  // namespace ropsim
