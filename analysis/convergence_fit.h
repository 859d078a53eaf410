// Statistics of errors that fall with a parameter: power-law slopes with their confidence, means and ratios
// over seeds.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace ropsim {

// Mean and sample standard deviation (n - 1 in the denominator) of `values`, at least one.
struct MeanSd {
    double mean = 0;
    std::optional<double> sd;  // absent for one value
};
MeanSd mean_sd(const std::vector<double>& values);

// The t above which Student's distribution with `degrees_of_freedom` >= 1 has 2.5% of its mass: the factor of
// a two-sided 95% interval.
double student_t95(int degrees_of_freedom);

// All measurements y at one x: replicates of each other.
struct Replicates {
    double x = 0;
    std::vector<double> y;
};

struct LineFit {
    double slope = 0;
    double intercept = 0;
    double slope_half_width = 0;  // of the 95% interval: slope +- this
    int degrees_of_freedom = 0;
    bool from_replicates = false;  // where the interval comes from, see fit_line
};

// Ordinary least squares of y on x over all points, and a 95% interval of the slope by Student's t.
// Where every x has two replicates or more, the interval is that of the scatter of replicates about their own
// mean
// ("pure error", points - values of x degrees of freedom): repeated with new replicates at the same x, 95% of
// such intervals hold the slope of the line fitted to the expected y, whether or not those lie on a line. It
// takes the scatter as independent and of one variance at all x. Where an x has a single point, it is the
// textbook interval from the residuals (points - 2 degrees of freedom), which takes the expected y to lie on
// a line. At least 3 values of x, not all equal, each with a point (CHECK).
LineFit fit_line(const std::vector<Replicates>& points);

// error = coefficient * value^slope, fitted as a line through log(error) over log(value).
struct PowerLaw {
    LineFit line;  // of natural logarithms; the slope is that of any base
    double coefficient = 0;
    double largest_departure_percent = 0;  // of a value's geometric mean error from the law
};

// A power law, or why there is none: fewer than 3 values, or an error of 0, which has no logarithm.
struct PowerLawFit {
    std::optional<PowerLaw> law;
    std::string why_not;  // one line; empty with a law
};
// x is the value (> 0), y its errors (>= 0), one a seed. `key` names the parameter in why_not.
PowerLawFit fit_power_law(const std::string& key, const std::vector<Replicates>& errors);

// error / base, pair by pair; a list of one stands for as many as the other has (a technique without
// randomness runs one seed). Absent where a base is 0.
std::optional<MeanSd> paired_ratio(const std::vector<double>& error, const std::vector<double>& base);

}  // namespace ropsim
