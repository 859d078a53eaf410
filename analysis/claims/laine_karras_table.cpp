// Claims of Laine and Karras 2011, section 5: Table 1 and what it is said to show.
#include "analysis/claims/declared_cost.h"
#include "analysis/claims/list.h"
#include "analysis/convergence_fit.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr const char* kPaper = "Laine and Karras 2011";

using Values = std::vector<double>;

struct Cell {
    const char* scene;
    int samples;
    double ours, comparison;
    const char* ratio;
};
constexpr Cell kCells[] = {{"motor", 4, 29.5, 36.3, "0.81"},  {"motor", 8, 17.9, 25.3, "0.71"},
                           {"motor", 16, 10.3, 17.2, "0.60"}, {"motor", 32, 6.3, 12.1, "0.52"},
                           {"motor", 64, 4.0, 8.7, "0.46"},   {"cloth", 4, 17.0, 19.3, "0.88"},
                           {"cloth", 8, 9.7, 12.3, "0.79"},   {"cloth", 16, 5.6, 8.4, "0.67"},
                           {"cloth", 32, 3.3, 5.8, "0.57"},   {"cloth", 64, 2.0, 4.1, "0.49"}};

// The paper does not say where a pixel's samples lie. Both are measured: all at its centre, and at up to 16
// places, where the triangles of a surface share a pixel's samples.
enum class Places : std::uint8_t { kCentre, kSpread };

struct Errors {
    double ours = 0, comparison = 0;
    double ratio() const { return ours / comparison; }
};
Errors errors_of(ClaimRuns& runs, const std::string& scene, int samples, Places places) {
    const ClaimTrace trace = places == Places::kCentre
                                 ? ClaimTrace{scene, "500x500", "80x80"}
                                 : ClaimTrace{scene, "250x250", "80x80", std::min(samples, 16)};
    const auto error = [&](const char* technique) {
        return number_of(runs.run({trace, fmt::format(fmt::runtime(technique), samples)}).rmse8);
    };
    return {error("laine_karras:samples={}"), error("stochastic:samples={},depth_test=first")};
}

std::string our_scene(const char* scene, Places places) {
    return fmt::format(
        "our scene {}, {}", scene,
        places == Places::kCentre ? "all samples at the pixel's centre" : "samples spread in the pixel");
}

void add_cells(std::vector<Claim>& claims) {
    for (const Cell& cell : kCells) {
        claims.push_back(
            {fmt::format("lk-table1-{}-{}", cell.scene, cell.samples), kPaper, "Table 1",
             fmt::format("RMSE in 8-bit units, ours and the comparison's, {} samples, {}", cell.samples,
                         cell.scene),
             Printed::numbers_of(fmt::format("{:.1f}, {:.1f}", cell.ours, cell.comparison)), rule::digits(),
             Basis::kAssets, "two runs on this project's scene of that name", true, [cell](ClaimRuns& runs) {
                 const Errors c = errors_of(runs, cell.scene, cell.samples, Places::kCentre);
                 const Errors s = errors_of(runs, cell.scene, cell.samples, Places::kSpread);
                 return Finding{{},
                                {c.ours, c.comparison, s.ours, s.comparison},
                                {{our_scene(cell.scene, Places::kCentre), {c.ours, c.comparison}},
                                 {our_scene(cell.scene, Places::kSpread), {s.ours, s.comparison}}},
                                "the model, the camera and the image's size are not public; measured: "
                                "samples at the centre, then spread"};
             }});
        claims.push_back({fmt::format("lk-ratio-{}-{}", cell.scene, cell.samples), kPaper, "Table 1",
                          fmt::format("RMSE over the comparison's, {} samples, {}", cell.samples, cell.scene),
                          Printed::numbers_of(cell.ratio), rule::digits(), Basis::kAssets, "the same runs",
                          true, [cell](ClaimRuns& runs) {
                              const double c =
                                  errors_of(runs, cell.scene, cell.samples, Places::kCentre).ratio();
                              const double s =
                                  errors_of(runs, cell.scene, cell.samples, Places::kSpread).ratio();
                              return Finding{{},
                                             {c, s},
                                             {{our_scene(cell.scene, Places::kCentre), {c}},
                                              {our_scene(cell.scene, Places::kSpread), {s}}},
                                             "measured: samples at the centre, then spread"};
                          }});
    }
    claims.push_back(
        {"lk-table1-ratios", kPaper, "Table 1", "The ten ratios are the quotients of the errors beside them",
         Printed::numbers_of("0.81, 0.71, 0.60, 0.52, 0.46, 0.88, 0.79, 0.67, 0.57, 0.49"), rule::digits(),
         Basis::kDefinition, "arithmetic on the printed errors", false, [](ClaimRuns&) {
             Values ratios;
             for (const Cell& cell : kCells) ratios.push_back(cell.ours / cell.comparison);
             return Finding{{}, ratios, {{"", ratios}}, "within the digits, all ten"};
         }});
}

// How fast errors fall with samples: the exponent of a power law.
double exponent(const std::vector<std::pair<int, double>>& errors) {
    std::vector<Replicates> points;
    for (const auto& [samples, error] : errors) points.push_back({std::log(samples), {std::log(error)}});
    return fit_line(points).slope;
}

void add_slopes(std::vector<Claim>& claims) {
    for (const char* scene : {"motor", "cloth"}) {
        claims.push_back(
            {fmt::format("lk-slope-{}", scene), kPaper, "Table 1",
             fmt::format("The RMSE improves faster with samples than the comparison's, {}", scene),
             Printed::statement("our RMSE improves faster"), rule::statement(), Basis::kAssets,
             "exponents of power laws through the errors at 4 to 64 samples", true, [scene](ClaimRuns& runs) {
                 std::vector<std::pair<int, double>> ours, theirs, printed_ours, printed_theirs;
                 for (const Cell& cell : kCells) {
                     if (std::string(cell.scene) != scene) continue;
                     const Errors e = errors_of(runs, scene, cell.samples, Places::kCentre);
                     ours.emplace_back(cell.samples, e.ours);
                     theirs.emplace_back(cell.samples, e.comparison);
                     printed_ours.emplace_back(cell.samples, cell.ours);
                     printed_theirs.emplace_back(cell.samples, cell.comparison);
                 }
                 const double a = exponent(ours);
                 const double b = exponent(theirs);
                 return Finding{{},
                                {a, b},
                                {{our_scene(scene, Places::kCentre), {}, a < b}},
                                fmt::format("exponents; the printed errors have {:.3f} and {:.3f}",
                                            exponent(printed_ours), exponent(printed_theirs))};
             }});
    }
}

void add_statements(std::vector<Claim>& claims) {
    claims.push_back(
        {"lk-half-at-64", kPaper, "Table 1", "At 64 samples the method about halves the noise, motor",
         Printed::meaning("about halves", 0.5, 0.05), rule::about(), Basis::kAssets,
         "RMSE over the comparison's, two runs", true, [](ClaimRuns& runs) {
             const double c = errors_of(runs, "motor", 64, Places::kCentre).ratio();
             const double s = errors_of(runs, "motor", 64, Places::kSpread).ratio();
             return Finding{
                 {},
                 {c, s},
                 {{our_scene("motor", Places::kCentre), {c}}, {our_scene("motor", Places::kSpread), {s}}},
                 "measured: samples at the centre, then spread"};
         }});
    claims.push_back({"lk-16-for-64", kPaper, "section 5",
                      "16 samples are quite close to the comparison's 64, motor",
                      Printed::numbers_of("10.3 / 8.7"), rule::statement(), Basis::kAssets,
                      "RMSE with 16 samples over the comparison's with 64; no worse than the printed 1.18",
                      true, [](ClaimRuns& runs) {
                          const auto ratio = [&](Places places) {
                              return errors_of(runs, "motor", 16, places).ours /
                                     errors_of(runs, "motor", 64, places).comparison;
                          };
                          const double c = ratio(Places::kCentre);
                          const double s = ratio(Places::kSpread);
                          constexpr double kPrinted = 10.35 / 8.65;
                          return Finding{{},
                                         {c, s},
                                         {{our_scene("motor", Places::kCentre), {}, c <= kPrinted},
                                          {our_scene("motor", Places::kSpread), {}, s <= kPrinted}},
                                         "measured: samples at the centre, then spread"};
                      }});
    claims.push_back(
        {"lk-savings", kPaper, "section 5", "16 samples for 64 save memory and bandwidth: how many times",
         Printed::statement("significant memory, computation and bandwidth savings"), rule::statement(),
         Basis::kDefinition,
         "declared bits and bytes of the comparison with 64 samples over the method with 16", true,
         [](ClaimRuns& runs) {
             const DeclaredCost ours = declared_cost("laine_karras:samples=16");
             const DeclaredCost theirs = declared_cost("stochastic:samples=64,depth_test=first");
             const double memory = static_cast<double>(theirs.storage_bits) / ours.storage_bits;
             const double bytes = theirs.bytes() / ours.bytes();
             const ClaimTrace motor{"motor", "500x500", "80x80"};
             const auto pins = [&](const char* technique) {
                 const RunRecord& run = runs.run({motor, technique, "cached"});
                 return number_of(run.total.pin_read) + number_of(run.total.pin_write);
             };
             const double measured =
                 pins("stochastic:samples=64,depth_test=first") / pins("laine_karras:samples=16");
             return Finding{
                 {memory, bytes},
                 {measured},
                 {{"", {}, memory > 2 && bytes > 2}},
                 "worst case: memory, then bytes a fragment; measured: bytes on the pins, scene motor. "
                 "\"Significant\" taken as twice and more"};
         }});
}

void add_never_worse(std::vector<Claim>& claims) {
    claims.push_back(
        {"lk-never-worse", kPaper, "Figure 8",
         "With extremely many layers it never performs worse, smoke, alpha .05",
         Printed::meaning("never performs worse than the comparison", 1, 0), rule::at_most(), Basis::kAssets,
         "RMSE over the comparison's with 16 samples", true, [](ClaimRuns& runs) {
             const ClaimTrace plume{"plume", "500x500", "80x80"};
             const double ratio =
                 number_of(runs.run({plume, "laine_karras:samples=16"}).rmse8) /
                 number_of(runs.run({plume, "stochastic:samples=16,depth_test=first"}).rmse8);
             return Finding{{},
                            {ratio},
                            {{"our scene plume", {ratio}}},
                            fmt::format("{:+.1f} % of error; that nearly all of the gain is lost comes out",
                                        100 * (ratio - 1))};
         }});
    claims.push_back(
        {"lk-never-worse-large", kPaper, "Figure 8",
         "With extremely many layers it never performs worse: 64 whole layers of alpha .05, any order",
         Printed::meaning("never performs worse than the comparison", 1, 0), rule::at_most(),
         Basis::kDefinition,
         "RMSE over the comparison's with 16 samples, within 4 standard errors; the greatest of three orders",
         true, [](ClaimRuns& runs) {
             double greatest = 0;
             double noise = 0;
             std::string each;
             for (const auto& [order, name] :
                  {std::pair{"", "random"}, std::pair{"near_to_far", "near to far"},
                   std::pair{"far_to_near", "far to near"}}) {
                 ClaimTrace layers{"layers", "128x128", "48x48"};
                 layers.layers = 64;
                 layers.alpha = 0.05;
                 layers.order = order;
                 const RunRecord& ours = runs.run({layers, "laine_karras:samples=16,format=float32"});
                 const RunRecord& theirs =
                     runs.run({layers, "stochastic:samples=16,depth_test=first,format=float32"});
                 const double ratio = number_of(ours.rmse8) / number_of(theirs.rmse8);
                 // Of a mean of n squares of about Gaussian errors: each RMSE scatters by 1 / sqrt(2 n).
                 const double pixels = number_of(ours.width) * number_of(ours.height);
                 noise = std::max(noise, 4 * ratio / std::sqrt(pixels));
                 greatest = std::isnan(ratio) ? ratio : std::max(greatest, ratio);
                 each += fmt::format("{}{} {:.3f}", each.empty() ? "" : ", ", name, ratio);
             }
             return Finding{{},
                            {greatest},
                            {{"", {greatest}, false, noise}},
                            fmt::format("{}, each within {:.3f}. With few layers, which the caption does not "
                                        "speak of, it may be worse: of n free samples the comparison takes "
                                        "floor or ceil(alpha n), and a prefix of an aligned span is not that "
                                        "even",
                                        each, noise)};
         }});
}

}  // namespace

void add_laine_karras_table_claims(std::vector<Claim>& claims) {
    add_cells(claims);
    add_slopes(claims);
    add_statements(claims);
    add_never_worse(claims);
}

}  // namespace ropsim
