// What the papers claim, each claim with its printed value, our values, and a verdict that is judged from
// them.
#pragma once

#include "analysis/claims/runs.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace ropsim {

// What a paper prints: the text, and the numbers in it with the half width of their last digit. "1.5x" has
// 1.5 within .05, "12,870" is one number, "(0.10, 0.17)" two.
struct Printed {
    struct Number {
        double value = 0;
        double half = 0;        // half a unit of the last digit
        double last_digit = 1;  // a unit of it
    };
    std::string text;
    std::vector<Number> numbers;  // empty: a statement in words

    static Printed numbers_of(const std::string& text);
    static Printed statement(const std::string& text) { return {text, {}}; }
    // A formula, or several places of the text, with the exact numbers that they mean.
    static Printed formula(const std::string& text, const std::vector<double>& values);
    // In words or as a formula: what number it means, and within how much.
    static Printed meaning(const std::string& text, double value, double half) {
        return {text, {{value, half, 2 * half}}};
    }
};

// How our numbers are held against the printed ones.
struct Rule {
    enum class Kind : std::uint8_t {
        kDigits,     // equal within the printed digits; an exact half may be rounded either way
        kExact,      // equal: counts, and what is defined to the last digit
        kAbout,      // equal to one significant digit: "about 10 %", "roughly 1", "halves"
        kWithin,     // within a fraction of the printed value that the row declares
        kAtLeast,    // not below
        kAtMost,     // not above
        kStatement,  // nothing printed to compare with: each reading says whether it holds
    };
    Kind kind = Kind::kDigits;
    double fraction = 0;  // of kWithin
    std::string text() const;
};
namespace rule {
inline Rule digits() {
    return {};
}
inline Rule exact() {
    return {Rule::Kind::kExact, 0};
}
inline Rule about() {
    return {Rule::Kind::kAbout, 0};
}
inline Rule within(double fraction) {
    return {Rule::Kind::kWithin, fraction};
}
inline Rule at_least() {
    return {Rule::Kind::kAtLeast, 0};
}
inline Rule at_most() {
    return {Rule::Kind::kAtMost, 0};
}
inline Rule statement() {
    return {Rule::Kind::kStatement, 0};
}
}  // namespace rule

// Our values by one reading of the paper's text.
struct Reading {
    std::string name;                 // how the text is read; empty: as it stands
    std::vector<double> values;       // one for each printed number
    bool holds = false;               // of a statement
    double noise = 0;                 // how far sampling may have moved each value: widens the comparison
    std::vector<double> noises = {};  // the same of each value by itself
};

struct ClaimTable {
    std::vector<std::string> columns;
    std::vector<std::vector<std::string>> rows;
};

// A picture of a row's numbers, drawn with the results.
struct ClaimPlot {
    std::string name;  // of the files, without ending; empty: none
    double width = 0, height = 0;
    std::string drawing;  // gnuplot's commands, without the terminal
    std::string csv;      // the numbers in it
};

// What was found out about a claim.
struct Finding {
    std::vector<double> worst_case;  // without caches, from what techniques declare; empty: no such value
    std::vector<double> measured;    // from runs (bytes: with caches and compression on), or enumerated
    // In the order in which they are tried, the plain one first. None: ours is no evidence, of kAssets only.
    std::vector<Reading> readings;
    std::string why;          // one line
    ClaimTable details = {};  // what the row stands on, where a line is not enough
    ClaimPlot plot = {};
};

// What it takes for our value to stand for the paper's.
enum class Basis : std::uint8_t {
    kDefinition,  // follows, or not, from what the paper defines
    kAssets,      // a number of the paper's scene or machine: ours are others
};

struct Claim {
    std::string id;     // "st-passes"
    std::string paper;  // "Enderton et al. 2011"
    std::string place;  // "section 3.5"
    std::string claim;  // one line
    Printed printed;
    Rule rule;
    Basis basis = Basis::kDefinition;
    std::string how;         // how it is measured here, one line
    bool simulates = false;  // asks for runs; then it is called twice, see ClaimRuns
    std::function<Finding(ClaimRuns&)> measure;
};

enum class Verdict : std::uint8_t { kReproduced, kReproducedUnder, kDoesNotFollow, kNotReproducible };

struct Judgement {
    Verdict verdict = Verdict::kDoesNotFollow;
    std::string reading;  // of kReproducedUnder
    std::string text() const;
};

// Of a claim by definition: reproduced by the first reading that holds, else it does not follow. Of a number
// of the paper's own scene or machine: a reading that holds must say with what it does, else it is not
// reproducible without them; nor is it without a reading, where ours was made to the number.
Judgement judge(const Printed& printed, const Rule& rule, Basis basis, const Finding& finding);
// Whether a reading's values are the printed ones.
bool holds(const Printed& printed, const Rule& rule, const Reading& reading);

struct ClaimResult {
    const Claim* claim = nullptr;
    Finding finding;
    Judgement judgement;
    std::string failure;  // why there is no finding; empty: there is
};

struct ClaimsOptions {
    std::vector<std::string> ids;  // as given: an id, or the beginning of some with * behind it; empty: all
    ClaimRunsOptions runs;
};

const std::vector<Claim>& all_claims();

// Throws UserError, naming ids like it, for an id that does not exist.
std::vector<const Claim*> chosen_claims(const std::vector<Claim>& claims,
                                        const std::vector<std::string>& ids);

// Runs what the chosen claims need, once each, then judges them, in the order of the list.
std::vector<ClaimResult> run_claims(const ClaimsOptions& options);

}  // namespace ropsim
