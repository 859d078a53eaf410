#include "model/tile_sample_cycles.h"

#include "base/random.h"

#include <algorithm>
#include <cmath>

namespace ropsim {

namespace {

constexpr int kDraws = 4000;

double bytes_of(const SampleRow& row) {
    return row.empty() ? 0 : row[kPinReads] + row[kPinWrites];
}
double quads_of(const SampleRow& row) {
    return row.empty() ? 0 : row[kQuads];
}

// Cycles a quad and a byte.
struct Prices {
    double quad = 0;
    double byte = 0;
    double of(const SampleRow& row) const { return quad * quads_of(row) + byte * bytes_of(row); }
};

struct PartitionCycles {
    Prices prices;
    double cycles = 0;
    double variance = 0;
    double degrees = 1e6;
};

// Least squares with weights 1 / quads, so that residuals sum to nought; a price is not negative.
Prices fit_prices(const std::vector<const SampleRow*>& rows, const std::vector<double>& cycles) {
    double qq = 0, qb = 0, bb = 0, qc = 0, bc = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const double q = quads_of(*rows[i]);
        const double b = bytes_of(*rows[i]);
        qq += q;
        qb += b;
        bb += b * b / q;
        qc += cycles[i];
        bc += b * cycles[i] / q;
    }
    const double determinant = qq * bb - qb * qb;
    if (determinant > 1e-9 * qq * bb && rows.size() > 4) {
        const Prices both{(qc * bb - bc * qb) / determinant, (qq * bc - qb * qc) / determinant};
        if (both.quad >= 0 && both.byte >= 0) return both;
        if (both.quad < 0) return {0, qc / qb};
    }
    return {qc / qq, 0};
}

PartitionCycles partition_cycles(const SampleStream& stream, const std::vector<TimedStretch>& timed) {
    std::vector<const SampleRow*> rows;
    std::vector<double> cycles;
    const SampleRow total = stream.total();
    const bool whole = stream.stretches().size() == 1 && stream.stretches()[0].measured.empty();
    for (std::size_t i = 0; i < timed.size(); ++i) {
        rows.push_back(whole ? &total : &stream.stretches()[i].measured);
        cycles.push_back(static_cast<double>(timed[i].cycles));
    }
    PartitionCycles result;
    if (rows.empty() || quads_of(total) == 0) return result;
    result.prices = fit_prices(rows, cycles);
    result.cycles = result.prices.of(total);
    double second = 0, fourth = 0, quads = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const double e = cycles[i] - result.prices.of(*rows[i]);
        second += e * e;
        fourth += e * e * e * e;
        quads += quads_of(*rows[i]);
    }
    const auto n = static_cast<double>(rows.size());
    const double share = std::min(1.0, quads / quads_of(total));
    if (n > 2 && share < 1) {
        result.variance = second * n / (n - 2) * (1 - share) / (share * share);
        if (fourth > 0) result.degrees = second * second / fourth;
    }
    return result;
}

// Standard normal to within what 12 uniform numbers can say; arithmetic only.
class Normal {
 public:
    explicit Normal(std::uint64_t seed) : key_(seed) {}
    double next() {
        double sum = -6;
        for (int i = 0; i < 12; ++i) sum += random_unit(key_, draw_++);
        return sum;
    }

 private:
    std::uint64_t key_;
    std::uint32_t draw_ = 0;
};

// Widens a normal deviation to the quantile of Student's t.
double deviation(double variance, double degrees) {
    return std::sqrt(variance) * student_t_975(degrees) / student_t_975(1e6);
}

Estimate of_draws(std::vector<double>& draws) {
    double sum = 0;
    for (const double d : draws) sum += d;
    std::ranges::sort(draws);
    const auto at = [&](double quantile) {
        return draws[static_cast<std::size_t>(quantile * static_cast<double>(draws.size() - 1))];
    };
    return {sum / static_cast<double>(draws.size()), at(0.025), at(0.975)};
}

}  // namespace

CycleEstimate estimate_cycles(const std::vector<std::unique_ptr<SampleStream>>& streams,
                              const SampledTiming& timing, const SampleSquares& squares,
                              const SamplePlan& plan, double front_end_cycles) {
    std::vector<double> square_cycles(squares.size());
    std::vector<const PartitionCycles*> known(static_cast<std::size_t>(squares.partitions()), nullptr);
    std::vector<PartitionCycles> sampled;
    sampled.reserve(streams.size());
    double time_variance = 0;
    for (std::size_t i = 0; i < streams.size(); ++i) {
        const PartitionCycles& p = sampled.emplace_back(partition_cycles(*streams[i], timing.stretches[i]));
        known[static_cast<std::size_t>(streams[i]->partition())] = &p;
        time_variance += p.variance;
        const std::vector<SampleRow>& rows = streams[i]->rows();
        for (std::size_t s = 0; s < rows.size(); ++s) square_cycles[s] += p.prices.of(rows[s]);
    }
    const auto count = static_cast<double>(streams.size());
    const SampleSquares::Fit fit = squares.fit(square_cycles);
    const double spread = deviation(fit.variance, fit.degrees);
    // Of the fit as a whole: the sampled partitions' own residuals, and their time.
    const double common = std::sqrt((fit.variance + time_variance / count) / count) * spread /
                          std::sqrt(std::max(fit.variance, 1e-9));
    Normal normal(mix64(plan.seed));
    std::vector<double> slowest(kDraws);
    std::vector<double> mean(kDraws);
    for (int d = 0; d < kDraws; ++d) {
        const double shift = common * normal.next();
        double largest = front_end_cycles;
        double sum = 0;
        for (int p = 0; p < squares.partitions(); ++p) {
            const PartitionCycles* k = known[static_cast<std::size_t>(p)];
            const double cycles = k != nullptr
                                      ? k->cycles + deviation(k->variance, k->degrees) * normal.next()
                                      : squares.predicted(fit, p) + shift + spread * normal.next();
            largest = std::max(largest, cycles);
            sum += cycles;
        }
        slowest[static_cast<std::size_t>(d)] = largest;
        mean[static_cast<std::size_t>(d)] = sum / squares.partitions();
    }
    return {of_draws(slowest), of_draws(mean)};
}

}  // namespace ropsim
