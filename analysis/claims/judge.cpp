// Printed numbers against ours.
#include "analysis/claims/claims.h"
#include "base/error.h"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace ropsim {
namespace {

// Ours are doubles: a value on the edge of the printed digits is on it.
constexpr double kArithmetic = 1e-9;

bool digit(const std::string& text, std::size_t i) {
    return i < text.size() && std::isdigit(static_cast<unsigned char>(text[i])) != 0;
}

// The number that begins at `i`, which moves behind it. A comma before three digits parts thousands.
Printed::Number number_at(const std::string& text, std::size_t& i) {
    std::string digits;
    int decimals = 0;
    bool point = false;
    const auto thousands = [&] {
        return text[i] == ',' && digit(text, i + 1) && digit(text, i + 2) && digit(text, i + 3) &&
               !digit(text, i + 4) && !point;
    };
    for (; i < text.size(); ++i) {
        if (digit(text, i)) {
            digits += text[i];
            decimals += point ? 1 : 0;
        } else if (text[i] == '.' && !point && digit(text, i + 1)) {
            digits += '.';
            point = true;
        } else if (!thousands()) {
            break;
        }
    }
    const double unit = std::pow(10.0, -decimals);
    return {std::stod(digits), unit / 2, unit};
}

// A unit of the first significant digit.
double leading_digit(double value) {
    return value == 0 ? 0 : std::pow(10.0, std::floor(std::log10(std::abs(value)) + kArithmetic));
}

bool near(double ours, double printed, double tolerance) {
    return std::abs(ours - printed) <= tolerance + kArithmetic * std::max(1.0, std::abs(printed));
}

bool holds_one(const Printed::Number& printed, const Rule& rule, double ours, double noise) {
    if (!std::isfinite(ours)) return false;
    const double slack = noise + kArithmetic * std::max(1.0, std::abs(printed.value));
    switch (rule.kind) {
        case Rule::Kind::kDigits:
            return near(ours, printed.value, printed.half + noise);
        case Rule::Kind::kExact:
            return near(ours, printed.value, noise);
        case Rule::Kind::kAbout:
            return near(ours, printed.value, leading_digit(printed.value) / 2 + noise);
        case Rule::Kind::kWithin:
            return near(ours, printed.value, rule.fraction * std::abs(printed.value) + noise);
        case Rule::Kind::kAtLeast:
            return ours >= printed.value - slack;
        case Rule::Kind::kAtMost:
            return ours <= printed.value + slack;
        case Rule::Kind::kStatement:
            break;
    }
    return false;
}

}  // namespace

Printed Printed::numbers_of(const std::string& text) {
    Printed printed{text, {}};
    for (std::size_t i = 0; i < text.size();) {
        const bool fraction = text[i] == '.' && digit(text, i + 1);
        if (!digit(text, i) && !fraction) {
            ++i;
            continue;
        }
        const bool negative = i > 0 && text[i - 1] == '-' && (i == 1 || !digit(text, i - 2));
        printed.numbers.push_back(number_at(text, i));
        if (negative) printed.numbers.back().value *= -1;
    }
    CHECK(!printed.numbers.empty(), "no number in '{}'", text);
    return printed;
}

Printed Printed::formula(const std::string& text, const std::vector<double>& values) {
    Printed printed{text, {}};
    for (const double value : values) printed.numbers.push_back({value, 0, 0});
    return printed;
}

std::string Rule::text() const {
    switch (kind) {
        case Kind::kDigits:
            return "within the printed digits";
        case Kind::kExact:
            return "equal";
        case Kind::kAbout:
            return "to one significant digit";
        case Kind::kWithin:
            return fmt::format("within {:g} %", 100 * fraction);
        case Kind::kAtLeast:
            return "not below";
        case Kind::kAtMost:
            return "not above";
        case Kind::kStatement:
            break;
    }
    return "statement";
}

bool holds(const Printed& printed, const Rule& rule, const Reading& reading) {
    if (rule.kind == Rule::Kind::kStatement) return reading.holds;
    CHECK(reading.values.size() == printed.numbers.size(), "{} values for {}", reading.values.size(),
          printed.text);
    CHECK(reading.noises.empty() || reading.noises.size() == reading.values.size(), "{}", printed.text);
    for (std::size_t i = 0; i < reading.values.size(); ++i) {
        const double noise = reading.noise + (reading.noises.empty() ? 0 : reading.noises[i]);
        if (!holds_one(printed.numbers[i], rule, reading.values[i], noise)) return false;
    }
    return true;
}

Judgement judge(const Printed& printed, const Rule& rule, Basis basis, const Finding& finding) {
    CHECK(!finding.readings.empty() || basis == Basis::kAssets, "nothing to hold against '{}'", printed.text);
    for (const Reading& reading : finding.readings) {
        if (!holds(printed, rule, reading)) continue;
        if (reading.name.empty()) {
            CHECK(basis == Basis::kDefinition, "'{}' needs to say with what it holds", printed.text);
            return {Verdict::kReproduced, ""};
        }
        return {Verdict::kReproducedUnder, reading.name};
    }
    return {basis == Basis::kDefinition ? Verdict::kDoesNotFollow : Verdict::kNotReproducible, ""};
}

std::string Judgement::text() const {
    switch (verdict) {
        case Verdict::kReproduced:
            return "reproduced";
        case Verdict::kReproducedUnder:
            return "reproduced under " + reading;
        case Verdict::kDoesNotFollow:
            return "does not follow from its own definition";
        case Verdict::kNotReproducible:
            return "not reproducible without its assets";
    }
    return {};
}

}  // namespace ropsim
