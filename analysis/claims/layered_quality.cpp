// Claims of Wyman 2016 about quality, over alpha and over the order of arrival.
#include "analysis/claims/list.h"
#include "rop/image_metrics.h"
#include "traces/image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace ropsim {
namespace {

constexpr const char* kPaper = "Wyman 2016";
constexpr const char* kHow =
    "RMSE over 20 layers of one or of mixed alphas in three orders of arrival, and over scenes";

using Values = std::vector<double>;

// What errors are measured on.
struct Condition {
    std::string name;
    ClaimTrace trace;
};

std::vector<Condition> layer_conditions() {
    std::vector<Condition> conditions;
    for (const auto& [order, order_name] :
         {std::pair{"", "random order"}, std::pair{"near_to_far", "near to far"},
          std::pair{"far_to_near", "far to near"}}) {
        for (const double alpha : {.1, .3, .6, 0.}) {
            ClaimTrace trace{"layers", "64x64", "32x32"};
            trace.layers = 20;
            trace.alpha = alpha;
            trace.order = order;
            conditions.push_back(
                {fmt::format("{}, {}", alpha > 0 ? fmt::format("alpha {:g}", alpha) : "mixed alpha",
                             order_name),
                 trace});
        }
    }
    return conditions;
}

std::vector<Condition> all_conditions() {
    std::vector<Condition> conditions = layer_conditions();
    for (const char* scene : {"power_plant", "motor", "forest", "smoke", "hair"})
        conditions.push_back({fmt::format("scene {}", scene), {scene, "640x360", "80x45"}});
    return conditions;
}

double error_of(ClaimRuns& runs, const Condition& condition, const std::string& technique) {
    return number_of(runs.run({condition.trace, technique + ",format=float32"}).rmse8);
}

std::string slab(const std::string& bits) {
    return "slab:layers=8,composite=normalised,bits=" + bits;
}
std::string samples(int count) {
    return fmt::format("stochastic:method=depth_based,samples={}", count);
}

// Under how many conditions a claim holds, and which: it is judged over all of them.
std::string held(const std::vector<std::string>& where, std::size_t conditions) {
    return fmt::format("{} of {} conditions{}{}", where.size(), conditions, where.empty() ? "" : ": ",
                       fmt::join(where, "; "));
}

// The noise of one image, without its bias: the spread over seeds. Two images of one expectation differ by
// sqrt(2) times it.
double noise_of(ClaimRuns& runs, const Condition& condition, const std::string& technique) {
    std::array<std::string, 2> files;
    for (int seed = 0; seed < 2; ++seed) {
        ClaimRun run{condition.trace, technique + ",format=float32"};
        run.seed = seed;
        run.image = true;
        const RunRecord& record = runs.run(run);
        if (record.failure.empty()) files[static_cast<std::size_t>(seed)] = record.directory + "/image.exr";
    }
    if (!runs.executed() || files[0].empty() || files[1].empty()) return NAN;
    return image_error(read_exr(files[0]), read_exr(files[1])).rmse8 / std::sqrt(2.);
}

using Measure = double (*)(ClaimRuns&, const Condition&, const std::string&);

// `better` has less error, or noise, than `worse` under all conditions.
Finding less_of(Measure measure, const std::string& what, ClaimRuns& runs, const std::string& better,
                const std::string& worse, const std::string& why,
                const std::vector<std::string>& beside = {}) {
    ClaimTable table{{what, better, worse}, {}};
    table.columns.insert(table.columns.end(), beside.begin(), beside.end());
    std::vector<std::string> where;
    Values ratios;
    const std::vector<Condition> conditions = all_conditions();
    for (const Condition& condition : conditions) {
        const double a = measure(runs, condition, better);
        const double b = measure(runs, condition, worse);
        std::vector<std::string> row{condition.name, fmt::format("{:.2f}", a), fmt::format("{:.2f}", b)};
        for (const std::string& technique : beside)
            row.push_back(fmt::format("{:.2f}", measure(runs, condition, technique)));
        table.rows.push_back(row);
        ratios.push_back(a / b);
        if (a < b) where.push_back(condition.name);
    }
    const auto [least, most] = std::ranges::minmax(ratios);
    return {{},
            {least, most},
            {{"", {}, where.size() == conditions.size()}},
            fmt::format("{}; measured: least and greatest ratio; holds in {}", why,
                        held(where, conditions.size())),
            table};
}

// Errors that agree within this are those of the same result: twice what 4096 pixels scatter.
constexpr double kSame = 0.05;

// One way to read a claim that two techniques are the same.
struct SamePair {
    std::string reading;
    std::string one, other;
};

Finding same_error(ClaimRuns& runs, const std::vector<Condition>& conditions,
                   const std::vector<SamePair>& pairs, const std::string& why) {
    Finding finding;
    finding.why = why;
    finding.details.columns = {"RMSE"};
    for (const Condition& condition : conditions) finding.details.rows.push_back({condition.name});
    for (const auto& [reading, one, other] : pairs) {
        finding.details.columns.insert(finding.details.columns.end(), {one, other});
        std::vector<std::string> where;
        Values ratios;
        for (std::size_t i = 0; i < conditions.size(); ++i) {
            const double a = error_of(runs, conditions[i], one);
            const double b = error_of(runs, conditions[i], other);
            finding.details.rows[i].push_back(fmt::format("{:.2f}", a));
            finding.details.rows[i].push_back(fmt::format("{:.2f}", b));
            ratios.push_back(a / b);
            if (std::abs(a / b - 1) <= kSame) where.push_back(conditions[i].name);
        }
        const auto [least, most] = std::ranges::minmax(ratios);
        finding.measured.insert(finding.measured.end(), {least, most});
        finding.readings.push_back({reading, {}, where.size() == conditions.size()});
        finding.why += fmt::format("; {}within {:g} % in {}", reading.empty() ? "" : reading + ", ",
                                   100 * kSame, held(where, conditions.size()));
    }
    finding.why += "; measured: least and greatest ratio of errors";
    return finding;
}

template <class Find>
void add(std::vector<Claim>& claims, const char* id, const char* place, const char* claim,
         const char* printed, Find find) {
    claims.push_back({id, kPaper, place, claim, Printed::statement(printed), rule::statement(),
                      Basis::kDefinition, kHow, true, find});
}

void add_quality(std::vector<Claim>& claims) {
    add(claims, "slab-32x", "abstract", "8 layers with b = 16 have less error than 32 stochastic samples",
        "quality better than 32x samples per pixel", [](ClaimRuns& runs) {
            return less_of(
                error_of, "RMSE", runs, slab("16"), samples(32),
                "thin layers are too many for 8 nodes, and near to far the far ones are not tried again",
                {samples(8), slab("8"), slab("32"), slab("inf"), "mlab:layers=8"});
        });
    add(claims, "slab-less-noise", "section 3",
        "With as many layers as samples it has significantly less noise", "significantly less noise",
        [](ClaimRuns& runs) {
            return less_of(noise_of, "standard deviation over seeds", runs, slab("16"), samples(8),
                           "8 layers with b = 16 against 8 samples: the spread over seeds, without bias");
        });
}

void add_ends(std::vector<Claim>& claims) {
    add(claims, "slab-b-inf", "section 2.1", "With infinitely many bits it becomes k-buffering",
        "becomes k-buffering", [](ClaimRuns& runs) {
            return same_error(runs, layer_conditions(), {{"", "slab:layers=8,bits=inf", "k_buffer:layers=8"}},
                              "direct colour");
        });
    add(claims, "slab-b-n", "section 2.1", "With b = n it is stochastic transparency",
        "b ranging from [n..inf] transitions between stochastic transparency and k-buffering",
        [](ClaimRuns& runs) {
            return same_error(
                runs, layer_conditions(),
                {{"", slab("8"), samples(8)},
                 {"coverage masks, one pass each", "slab:layers=8,bits=8,coverage=discrete",
                  "stochastic:samples=8"}},
                "continuous alphas, as in his Figure 1, or masks, where what arrives in front does not push "
                "hidden layers out, which then hold nodes");
        });
}

// Mean signed error of one pass, of which stochastic transparency has none.
void add_bias(std::vector<Claim>& claims) {
    add(claims, "slab-unbiased", "section 1", "In one pass its convergence is unbiased",
        "consistent and (optionally) unbiased convergence", [](ClaimRuns& runs) {
            ClaimTable table{{"mean signed error, 8-bit units", "continuous", "masks", "4 standard errors"},
                             {}};
            std::vector<std::string> continuous;
            std::vector<std::string> masks;
            double most = 0;
            const std::vector<Condition> conditions = layer_conditions();
            for (const Condition& condition : conditions) {
                const auto run = [&](const char* technique) -> const RunRecord& {
                    return runs.run({condition.trace, technique});
                };
                const RunRecord& a = run("slab:layers=8,bits=8,format=float32");
                const RunRecord& b = run("slab:layers=8,bits=8,coverage=discrete,format=float32");
                const double pixels = number_of(a.width) * number_of(a.height);
                const auto limit = [&](const RunRecord& r) {
                    return 4 * number_of(r.rmse8) / std::sqrt(3 * pixels);
                };
                const double mean_a = number_of(a.mean_signed8);
                const double mean_b = number_of(b.mean_signed8);
                table.rows.push_back({condition.name, fmt::format("{:.2f}", mean_a),
                                      fmt::format("{:.2f}", mean_b),
                                      fmt::format("{:.2f}, {:.2f}", limit(a), limit(b))});
                if (std::abs(mean_a) < limit(a)) continuous.push_back(condition.name);
                if (std::abs(mean_b) < limit(b)) masks.push_back(condition.name);
                most = std::max({most, std::abs(mean_a), std::abs(mean_b)});
            }
            return Finding{
                {},
                {most},
                {{"", {}, continuous.size() == conditions.size()},
                 {"coverage masks", {}, masks.size() == conditions.size()}},
                fmt::format(
                    "b = n = 8, colour straight from the layers; measured: the largest mean error; no "
                    "bias with alphas in {}; with masks in {}",
                    held(continuous, conditions.size()), held(masks, conditions.size())),
                table};
        });
}

}  // namespace

void add_layered_quality_claims(std::vector<Claim>& claims) {
    add_quality(claims);
    add_ends(claims);
    add_bias(claims);
}

}  // namespace ropsim
