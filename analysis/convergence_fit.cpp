// Least squares, Student's t and ratios.
#include "analysis/convergence_fit.h"

#include "base/error.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ropsim {
namespace {

// Mass of Student's distribution between -t and t for whole degrees of freedom: a finite sum in the angle
// atan(t / sqrt(degrees)) (Abramowitz and Stegun 1964, 26.7.3 and 26.7.4).
double student_central_mass(double t, int degrees) {
    const double angle = std::atan(t / std::sqrt(static_cast<double>(degrees)));
    const double sine = std::sin(angle);
    const double cosine = std::cos(angle);
    const bool odd = degrees % 2 != 0;
    double term = odd ? cosine : 1.0;
    double sum = 0;
    for (int k = odd ? 1 : 0; k <= degrees - 2; k += 2) {
        sum += term;
        term *= cosine * cosine * (k + 1.0) / (k + 2.0);
    }
    return odd ? (angle + sine * sum) * 2.0 / std::numbers::pi : sine * sum;
}

double mean_of(const std::vector<double>& values) {
    double sum = 0;
    for (const double v : values) sum += v;
    return sum / static_cast<double>(values.size());
}

double squares_about(const std::vector<double>& values, double centre) {
    double sum = 0;
    for (const double v : values) sum += (v - centre) * (v - centre);
    return sum;
}

}  // namespace

MeanSd mean_sd(const std::vector<double>& values) {
    CHECK(!values.empty());
    MeanSd result{mean_of(values), {}};
    if (values.size() > 1)
        result.sd = std::sqrt(squares_about(values, result.mean) / static_cast<double>(values.size() - 1));
    return result;
}

double student_t95(int degrees_of_freedom) {
    CHECK(degrees_of_freedom >= 1, "{} degrees of freedom", degrees_of_freedom);
    constexpr double kMass = 0.95;
    double low = 0;
    double high = 16;  // one degree of freedom needs 12.7
    for (int i = 0; i < 64; ++i) {
        const double middle = (low + high) / 2;
        (student_central_mass(middle, degrees_of_freedom) < kMass ? low : high) = middle;
    }
    return high;
}

LineFit fit_line(const std::vector<Replicates>& points) {
    CHECK(points.size() >= 3, "{} values", points.size());
    double count = 0;
    double mean_x = 0;
    double mean_y = 0;
    LineFit fit;
    fit.from_replicates = true;
    for (const Replicates& p : points) {
        CHECK(!p.y.empty(), "no point at {}", p.x);
        const auto n = static_cast<double>(p.y.size());
        count += n;
        mean_x += n * p.x;
        mean_y += n * mean_of(p.y);
        fit.from_replicates = fit.from_replicates && p.y.size() > 1;
    }
    mean_x /= count;
    mean_y /= count;
    double xx = 0;
    double xy = 0;
    for (const Replicates& p : points) {
        const auto n = static_cast<double>(p.y.size());
        xx += n * (p.x - mean_x) * (p.x - mean_x);
        xy += n * (p.x - mean_x) * (mean_of(p.y) - mean_y);
    }
    CHECK(xx > 0, "all values are {}", mean_x);
    fit.slope = xy / xx;
    fit.intercept = mean_y - fit.slope * mean_x;
    double squares = 0;
    for (const Replicates& p : points)
        squares += squares_about(p.y, fit.from_replicates ? mean_of(p.y) : fit.intercept + fit.slope * p.x);
    fit.degrees_of_freedom =
        static_cast<int>(count) - (fit.from_replicates ? static_cast<int>(points.size()) : 2);
    fit.slope_half_width =
        student_t95(fit.degrees_of_freedom) * std::sqrt(squares / fit.degrees_of_freedom / xx);
    return fit;
}

PowerLawFit fit_power_law(const std::string& key, const std::vector<Replicates>& errors) {
    for (const Replicates& p : errors)
        if (std::any_of(p.y.begin(), p.y.end(), [](double e) { return e == 0; }))
            return {{}, fmt::format("the error is 0 at {}={}, which has no logarithm", key, p.x)};
    if (errors.size() < 3)
        return {{},
                fmt::format("{} {} of {}; a slope needs 3", errors.size(),
                            errors.size() == 1 ? "value" : "values", key)};
    std::vector<Replicates> logs = errors;
    for (Replicates& p : logs) {
        p.x = std::log(p.x);
        for (double& y : p.y) y = std::log(y);
    }
    PowerLaw law{fit_line(logs), 0, 0};
    law.coefficient = std::exp(law.line.intercept);
    for (const Replicates& p : logs) {
        const double departure = mean_of(p.y) - (law.line.intercept + law.line.slope * p.x);
        law.largest_departure_percent =
            std::max(law.largest_departure_percent, 100.0 * std::abs(std::expm1(departure)));
    }
    return {law, {}};
}

std::optional<MeanSd> paired_ratio(const std::vector<double>& error, const std::vector<double>& base) {
    CHECK(!error.empty() && !base.empty());
    CHECK(error.size() == base.size() || error.size() == 1 || base.size() == 1, "{} errors over {}",
          error.size(), base.size());
    std::vector<double> ratios;
    for (std::size_t i = 0; i < std::max(error.size(), base.size()); ++i) {
        const double below = base[base.size() == 1 ? 0 : i];
        if (below == 0) return {};
        ratios.push_back(error[error.size() == 1 ? 0 : i] / below);
    }
    return mean_sd(ratios);
}

}  // namespace ropsim
