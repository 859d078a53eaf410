// Claims as a table, as JSON and as the page of the documentation.
#include "analysis/claims/output.h"

#include "analysis/text_table.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

// Four digits, and all of a count.
std::string shown(double value) {
    if (!std::isfinite(value)) return "-";
    const double size = std::abs(value);
    // Sums that cancel, or should be whole, leave something in the last bits.
    const bool whole = std::abs(value - std::round(value)) <= 1e-12 * std::max(1.0, size);
    if (whole && size < 1e7) return fmt::format("{:.0f}", std::round(value) + 0.0);
    if (size < 1e-4) return fmt::format("{:.2g}", value);
    return fmt::format("{:.{}f}", value, size < 1 ? 4 : size < 10 ? 3 : size < 1000 ? 2 : 0);
}

std::string shown(const std::vector<double>& values) {
    if (values.empty()) return "-";
    std::string text;
    for (const double value : values) text += (text.empty() ? "" : ", ") + shown(value);
    return text;
}

constexpr const char* kIntroduction =
    R"(# What the papers claim, and what comes out here

Written by `ropsim claims -o DIR` (`DIR/claims.md`). A row can be run alone (`ropsim claims st-passes`), or those whose ids
begin alike (`ropsim claims 'lk-*'`); `--json` has how each was measured, `--quick` smaller images.

* *Worst case*: what techniques declare, nothing cached. *Measured*: what runs gave on this project's scenes (bytes with caches
  and compression on), or what an exact enumeration gives. A dash: there is no such value.
* The verdict is judged from the numbers, by the row's *rule*. *Within the printed digits*: within half a unit of the last one,
  an exact half either way. *To one significant digit*, of "about" and "roughly": within half a unit of the first. *Equal*:
  counts and formulas. *Within P %* of the printed number: a tolerance that the row declares, its own and no paper's. *Not
  below*, *not above*: a bound, the paper's or, where the printed text is words, the one that it is "taken as". *Statement*:
  holds or not, as the row says.
* *reproduced*: the text as it stands gives the printed value. *Reproduced under* a reading: it does not, but what the row names
  does, where the text leaves something open or is at odds with itself, or on this project's scene where the paper's own would be
  needed. *Does not follow from its own definition*: enumeration, or a run with nothing in it but what the paper defines,
  contradicts it. *Not reproducible without its assets*: the number is of a scene, a view or a part that cannot be had, or of
  formats that are not printed, and ours differ or are no evidence.
* No technique, machine or tolerance is fitted to a printed result. Scenes that stand for scenes of papers are made to the
  fragments and the depth which the papers print of those: such rows are calibration, are not judged by our value and count as
  not reproducible. What a reading fills in for a figure that is missing, a number of samples or a format, is chosen by the
  printed number: it shows that one exists, not that it is the paper's.
* Run times are simulated at fewer pixels than the papers': a quarter (`time-*`), a sixteenth (`at-speed-*`, `at-msaa-time`), a
  thirty-sixth (`mm-table1-*`). [Published run times](published-timings.md) has those of `time-*` at full size and says why they
  differ.

)";

std::string verdict_of(const ClaimResult& result) {
    return result.failure.empty() ? result.judgement.text() : "failed";
}

// Readings are sentences: those of JSON and of the page.
std::string short_verdict(const ClaimResult& result) {
    const bool under = result.failure.empty() && result.judgement.verdict == Verdict::kReproducedUnder;
    return under ? "reproduced under a reading" : verdict_of(result);
}

Json json_of(const std::vector<double>& values) {
    if (values.empty()) return nullptr;
    if (values.size() == 1) return values[0];
    return values;
}

Json printed_json(const Printed& printed) {
    if (printed.numbers.empty()) return printed.text;
    std::vector<double> values;
    for (const Printed::Number& number : printed.numbers) values.push_back(number.value);
    return json_of(values);
}

Json table_json(const ClaimTable& table) {
    if (table.columns.empty()) return nullptr;
    return {{"columns", table.columns}, {"rows", table.rows}};
}

std::string table_row(const std::vector<std::string>& cells) {
    std::string text = "|";
    for (const std::string& cell : cells) {
        std::string escaped;
        for (const char c : cell) escaped += c == '|' ? std::string("\\|") : std::string(1, c);
        text += " " + escaped + " |";
    }
    return text + "\n";
}

std::string rule_line(std::size_t columns) {
    std::string text = "|";
    for (std::size_t i = 0; i < columns; ++i) text += "---|";
    return text + "\n";
}

// With the bound, where the printed text is words that mean a number.
std::string rule_of(const Claim& claim) {
    const std::string text = claim.rule.text();
    const auto& numbers = claim.printed.numbers;
    const bool words = std::ranges::none_of(claim.printed.text, [](char c) { return c >= '0' && c <= '9'; });
    if (claim.rule.kind == Rule::Kind::kStatement || numbers.size() != 1 || !words) return text;
    if (claim.rule.kind == Rule::Kind::kDigits)
        return fmt::format("within {:g} of {:g}", numbers[0].half, numbers[0].value);
    return fmt::format("{}: {:g}", text, numbers[0].value);
}

// The tolerances that rows declare, and how many do: the reader sees what they have decided.
std::string tolerances_line(const std::vector<ClaimResult>& results) {
    std::map<double, int> rows;
    for (const ClaimResult& result : results)
        if (result.claim->rule.kind == Rule::Kind::kWithin) ++rows[result.claim->rule.fraction];
    std::string text;
    for (const auto& [fraction, count] : rows)
        text += fmt::format("{}{:g} % ({} row{})", text.empty() ? "" : ", ", 100 * fraction, count,
                            count == 1 ? "" : "s");
    return text.empty() ? "" : fmt::format("\nTolerances of *within*: {}.\n", text);
}

std::string counts_line(const std::vector<ClaimResult>& results) {
    std::map<Verdict, int> counts;
    for (const ClaimResult& result : results)
        if (result.failure.empty()) ++counts[result.judgement.verdict];
    return fmt::format(
        "{} claims: {} reproduced, {} reproduced under a reading that the row names, {} do not follow from "
        "their own "
        "definition, {} not reproducible without the paper's assets.\n",
        results.size(), counts[Verdict::kReproduced], counts[Verdict::kReproducedUnder],
        counts[Verdict::kDoesNotFollow], counts[Verdict::kNotReproducible]);
}

}  // namespace

std::string claims_table(const std::vector<ClaimResult>& results) {
    std::vector<std::vector<std::string>> rows{{"id", "printed", "worst case", "measured", "verdict"}};
    for (const ClaimResult& result : results)
        rows.push_back({result.claim->id, result.claim->printed.text, shown(result.finding.worst_case),
                        shown(result.finding.measured), short_verdict(result)});
    std::string text = aligned_table(rows) + counts_line(results);
    for (const ClaimResult& result : results)
        if (!result.failure.empty()) text += fmt::format("{}: {}\n", result.claim->id, result.failure);
    return text;
}

std::string claims_json(const std::vector<ClaimResult>& results, bool quick) {
    Json json = Json::array();
    for (const ClaimResult& result : results) {
        const Claim& claim = *result.claim;
        const bool failed = !result.failure.empty();
        json.push_back({{"id", claim.id},
                        {"paper", claim.paper},
                        {"place", claim.place},
                        {"claim", claim.claim},
                        {"printed", printed_json(claim.printed)},
                        {"printed_text", claim.printed.text},
                        {"rule", claim.rule.text()},
                        {"how", claim.how},
                        {"worst_case", failed ? Json(nullptr) : json_of(result.finding.worst_case)},
                        {"measured", failed ? Json(nullptr) : json_of(result.finding.measured)},
                        {"verdict", failed ? Json(nullptr) : Json(result.judgement.text())},
                        {"why", failed ? result.failure : result.finding.why},
                        {"details", failed ? Json(nullptr) : table_json(result.finding.details)},
                        {"quick", quick}});
    }
    return json.dump(2) + "\n";
}

std::string claims_markdown(const std::vector<ClaimResult>& results, bool quick) {
    std::string text = std::string(kIntroduction) + counts_line(results) + tolerances_line(results);
    if (quick) text += "\nFrom a quick run: smaller images, fewer fragments.\n";
    std::string details;
    std::string paper;
    for (const ClaimResult& result : results) {
        const Claim& claim = *result.claim;
        if (claim.paper != paper) {
            paper = claim.paper;
            text += fmt::format("\n## {}\n\n", paper);
            text += table_row(
                {"id", "place", "claim", "printed", "rule", "worst case", "measured", "verdict", "why"});
            text += rule_line(9);
        }
        text += table_row({"`" + claim.id + "`", claim.place, claim.claim, claim.printed.text, rule_of(claim),
                           shown(result.finding.worst_case), shown(result.finding.measured),
                           verdict_of(result), result.failure.empty() ? result.finding.why : result.failure});
        const ClaimTable& table = result.finding.details;
        if (table.columns.empty() || !result.failure.empty()) continue;
        details += fmt::format("\n### `{}`\n\n{}: {}.\n\n", claim.id, claim.place, claim.claim);
        details += table_row(table.columns) + rule_line(table.columns.size());
        for (const auto& row : table.rows) details += table_row(row);
        if (const std::string& plot = result.finding.plot.name; !plot.empty())
            details += fmt::format("\n![{}](images/{}.png)\n", claim.claim, plot);
    }
    if (!details.empty()) text += "\n## What rows stand on\n" + details;
    return text;
}

}  // namespace ropsim
