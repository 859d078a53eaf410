// Claims of Enderton et al. 2011 about passes, memory and the arithmetic of Table 1.
#include "analysis/claims/declared_cost.h"
#include "analysis/claims/list.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr const char* kPaper = "Enderton et al. 2011";
constexpr const char* kDeclared = "passes and surfaces that the technique declares";

using Values = std::vector<double>;

Values depth_based_passes(const std::vector<int>& samples) {
    Values passes;
    for (const int s : samples)
        passes.push_back(
            declared_cost(fmt::format("stochastic:method=depth_based,samples={},hardware_samples=8", s))
                .geometry_passes);
    return passes;
}

void add_passes(std::vector<Claim>& claims) {
    const auto add = [&](const char* id, const char* place, const char* claim, const Printed& printed,
                         const char* why, auto passes) {
        claims.push_back({id, kPaper, place, claim, printed, rule::exact(), Basis::kDefinition, kDeclared,
                          false, [why, passes](ClaimRuns&) {
                              const Values count = passes();
                              return Finding{count, {}, {{"", count}}, why};
                          }});
    };
    add("st-single-pass", "abstract", "The basic method takes a single render pass",
        Printed::formula("a single render pass", {1}), "as declared; one pass over the fragments",
        [] { return Values{static_cast<double>(declared_cost("stochastic:samples=8").geometry_passes)}; });
    add("st-passes", "sections 3.5, 7",
        "Depth-based: passes over the transparent geometry for 8 and 16 samples", Printed::numbers_of("3, 5"),
        "total alpha once; depth and accumulation for each 8 samples", [] {
            return depth_based_passes({8, 16});
        });
    add("st-passes-formula", "section 3.5", "Passes for 8, 16, 32 and 64 samples",
        Printed::formula("1 + 2(S/8)", {3, 5, 9, 17}), "as declared", [] {
            return depth_based_passes({8, 16, 32, 64});
        });
    add("st-peeling-passes", "section 5",
        "Depth peeling renders the scene once for each of D layers (D = 10)",
        Printed::formula("O(D) times", {10}), "as declared by depth_peeling:layers=10",
        [] { return Values{static_cast<double>(declared_cost("depth_peeling:layers=10").geometry_passes)}; });
}

void add_memory(std::vector<Claim>& claims) {
    claims.push_back(
        {"st-memory-basic", kPaper, "section 1", "The basic method needs no memory beyond the MSAA z-buffer",
         Printed::formula("no additional memory", {0}), rule::exact(), Basis::kDefinition, kDeclared, false,
         [](ClaimRuns&) {
             constexpr double kDepthBits = 8 * 32;
             constexpr double kColorBits = 8 * 32;
             const double bits = declared_cost("stochastic:samples=8", 8).storage_bits;
             return Finding{{bits - kDepthBits},
                            {},
                            {{"", {bits - kDepthBits}},
                             {"the z-buffer as the multisampled frame buffer, colours included",
                              {bits - kDepthBits - kColorBits}}},
                            fmt::format("{:.0f} bits a pixel with 8 samples: depth and RGBA8 colour", bits)};
         }});
    claims.push_back(
        {"st-memory-depth-based", kPaper, "section 7",
         "Depth-based: memory beyond the scene's own z-buffer, in MSAA z-buffers",
         Printed::meaning("a couple of", 2, 0.5), rule::digits(), Basis::kDefinition, kDeclared, false,
         [](ClaimRuns&) {
             // In z-buffers of 8 samples of 32 bits, the opaque layer's own taken off.
             const auto extra = [](const std::string& options) {
                 const double bits =
                     declared_cost("stochastic:samples=8,method=depth_based" + options, 8).storage_bits;
                 return bits / (8 * 32) - 1;
             };
             const double sampled = extra(",total_alpha=sample,accumulator=sample");
             const double pixel = extra(",total_alpha=pixel,accumulator=pixel");
             return Finding{
                 {sampled},
                 {},
                 {{"total alpha of R16F and sums of RGBA16F in every sample, as section 3.5 has them",
                   {sampled}}},
                 fmt::format("{:.2f}, where 1.5 to 2.5 is taken as a couple: the edge decides. The formats "
                             "are not printed; with both targets a pixel instead of a sample, as in section "
                             "3.4, it is {:.2f}",
                             sampled, pixel)};
         }});
}

// Milliseconds of Table 1: base, then what the total adds up.
struct Timed {
    const char* scene;
    double base, total, relative, frames;
    std::vector<double> parts;
    const char* cells_id;
    const char* cells;  // the parts over the base, as printed
};
const std::vector<Timed>& table1() {
    static const std::vector<Timed> scenes{{"Motor",
                                            3.6,
                                            13.6,
                                            3.74,
                                            73,
                                            {2.6, 3.3, 2.7, 3.4, 1.6},
                                            "st-table1-cells-motor",
                                            "0.71, 0.91, 0.75, 0.93, 0.44"},
                                           {"Dog",
                                            14.7,
                                            38.4,
                                            2.61,
                                            26,
                                            {8.9, 1.2, 8.6, 8.7, 9.5, 1.5},
                                            "st-table1-cells-dog",
                                            "0.61, 0.08, 0.58, 0.59, 0.64, 0.1"},
                                           {"WindyHill",
                                            9.5,
                                            38.4,
                                            4.05,
                                            26,
                                            {13.1, 2.8, 6.9, 7.0, 6.9, 1.7},
                                            "st-table1-cells-windy_hill",
                                            "1.39, 0.30, 0.73, 0.74, 0.73, 0.18"}};
    return scenes;
}

// How far a quotient of times with one decimal may lie from that of the times before they were rounded.
double rounding_of(double time, double base) {
    return (time + 0.05) / (base - 0.05) - time / base;
}

void add_table1(std::vector<Claim>& claims) {
    const auto add = [&](const char* id, const char* claim, const char* printed, const Rule& rule,
                         auto find) {
        claims.push_back({id, kPaper, "Table 1", claim, Printed::numbers_of(printed), rule,
                          Basis::kDefinition, "arithmetic on the printed times", false,
                          [find](ClaimRuns&) { return find(); }});
    };
    add("st-table1-totals", "The totals of Motor, Dog, WindyHill in ms are the sums of their rows",
        "13.6, 38.4, 38.4", rule::digits(), [] {
            Values sums;
            for (const Timed& scene : table1()) {
                double sum = 0;
                for (const double part : scene.parts) sum += part;
                sums.push_back(sum);
            }
            return Finding{{}, sums, {{"", sums}}, "without the base, which is not a pass of the method"};
        });
    add("st-table1-relative", "The totals over the base", "3.74, 2.61, 4.05", rule::digits(), [] {
        Values ratios;
        Values noise;
        for (const Timed& scene : table1()) {
            ratios.push_back(scene.total / scene.base);
            noise.push_back(rounding_of(scene.total, scene.base));
        }
        return Finding{
            {},
            ratios,
            {{"", ratios}, {"times that were divided before they were rounded", ratios, false, 0, noise}},
            fmt::format("the printed times give {:.2f}, {:.2f}, {:.2f}", ratios[0], ratios[1], ratios[2])};
    });
    add("st-table1-fps", "Frames a second", "73, 26, 26", rule::digits(), [] {
        Values frames;
        Values noise;
        for (const Timed& scene : table1()) {
            frames.push_back(1000 / scene.total);
            noise.push_back(1000 / (scene.total - 0.05) - 1000 / scene.total);
        }
        return Finding{
            {},
            frames,
            {{"", frames}, {"times that were divided before they were rounded", frames, false, 0, noise}},
            "1000 over the total"};
    });
    for (const Timed& scene : table1())
        add(scene.cells_id, "Each row over the base: shadow (if any), opaque, the three passes, other",
            scene.cells, rule::digits(), [&scene] {
                Values ratios;
                Values noise;
                for (const double part : scene.parts) {
                    ratios.push_back(part / scene.base);
                    noise.push_back(rounding_of(part, scene.base));
                }
                return Finding{
                    {},
                    ratios,
                    {{"", ratios},
                     {"times that were divided before they were rounded", ratios, false, 0, noise}},
                    fmt::format("the printed milliseconds of {} over its base of {}", scene.scene,
                                scene.base)};
            });
    claims.push_back(
        {"st-three-to-four", kPaper, "section 5", "The run time is between three and four times the baseline",
         Printed::statement("between three and four times"), rule::statement(), Basis::kDefinition,
         "the printed ratios", false, [](ClaimRuns&) {
             Values ratios;
             bool strictly = true;
             bool rounded = true;
             for (const Timed& scene : table1()) {
                 ratios.push_back(scene.relative);
                 strictly = strictly && scene.relative >= 3 && scene.relative <= 4;
                 rounded = rounded && std::round(scene.relative) >= 3 && std::round(scene.relative) <= 4;
             }
             return Finding{{},
                            ratios,
                            {{"", {}, strictly}, {"ratios rounded to whole numbers", {}, rounded}},
                            "Table 1 itself has 2.61 (Dog) and 4.05 (WindyHill)"};
         }});
}

// 5, 10 and 20 layers in every pixel.
void add_linear(std::vector<Claim>& claims) {
    claims.push_back(
        {"st-linear", kPaper, "section 7", "Its work is linear in the number of fragments",
         Printed::formula("linear with the number of fragments", {2}), rule::exact(), Basis::kDefinition,
         "bytes that 10 more layers add to 10, over those that 5 more add to 5", true, [](ClaimRuns& runs) {
             const auto bytes = [&](int layers, Measured RecordedTraffic::*read,
                                    Measured RecordedTraffic::*write) {
                 ClaimTrace trace{"layers", "64x64", "32x32"};
                 trace.layers = layers;
                 trace.alpha = 0.3;
                 const RecordedTraffic& total =
                     runs.run({trace, "stochastic:samples=8,method=depth_based", "cached"}).total;
                 return number_of(total.*read) + number_of(total.*write);
             };
             const auto growth = [&](auto read, auto write) {
                 return (bytes(20, read, write) - bytes(10, read, write)) /
                        (bytes(10, read, write) - bytes(5, read, write));
             };
             const double worst =
                 growth(&RecordedTraffic::worst_case_read, &RecordedTraffic::worst_case_write);
             const double touched = growth(&RecordedTraffic::read, &RecordedTraffic::write);
             return Finding{
                 {worst},
                 {touched},
                 {{"", {touched}}, {"no sample being full yet, which spares fragments bytes", {worst}}},
                 fmt::format("{:.3f} of the bytes touched: behind full samples a fragment leaves "
                             "early; {:.3f} where none does, at worst",
                             touched, worst)};
         }});
}

}  // namespace

void add_stochastic_cost_claims(std::vector<Claim>& claims) {
    add_passes(claims);
    add_memory(claims);
    add_table1(claims);
    add_linear(claims);
}

}  // namespace ropsim
