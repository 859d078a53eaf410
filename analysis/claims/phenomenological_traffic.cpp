// Claims of McGuire and Mara 2017 about bytes: shadow maps, subsampling, diffusion.
#include "analysis/claims/phenomenological.h"
#include "rop/shadow/filter_cost.h"
#include "traces/trace_statistics.h"

#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace ropsim {
namespace {

// Section 7.3: maps of 4096 x 4096 texels, filtered down to 1024 x 1024; the camera has 1920 x 1080 pixels.
constexpr MapShape kMap{4096, 4096, 1, 3, 4};
constexpr double kScreenPixels = 1920.0 * 1080;
constexpr double kFetches = 176;

VarianceOptions variance(ConversionPasses passes) {
    VarianceOptions options;
    options.passes = passes;
    return options;
}
double saving(ConversionPasses passes, double lookups_a_pixel) {
    return filter_saving(kMap, variance(passes), lookups_a_pixel * kScreenPixels, kFetches, true, true)
        .ratio();
}

void add_fetches(std::vector<Claim>& claims) {
    claims.push_back(
        {"mm-176", kPhenomenologicalPaper, "section 8.1",
         "Texture fetches of the 15x15 tent filter on a stochastic shadow map", Printed::numbers_of("176"),
         rule::within(0.01), Basis::kDefinition, "texels of the kernel; around is taken as within 1 %", false,
         [](ClaimRuns&) {
             const double disc = std::numbers::pi * 7.5 * 7.5;
             return Finding{
                 {},
                 {static_cast<double>(disc_texels(15))},
                 {{"", {15.0 * 15}},
                  {"the disc of diameter 15 in the tent, by area", {disc}},
                  {"the texels of that disc", {static_cast<double>(disc_texels(15))}}},
                 fmt::format("the tent has {}; the disc's area is {:.1f}, and {} texel centres are in it",
                             15 * 15, disc, disc_texels(15))};
         }});
    claims.push_back({"mm-single-fetch", kPhenomenologicalPaper, "sections 4.3.3, 8.1",
                      "Fetches of a look-up in the variance shadow map, a wavelength",
                      Printed::meaning("a single fetch", 1, 0), rule::exact(), Basis::kDefinition,
                      "the look-up's own count", false, [](ClaimRuns&) {
                          const double fetches = variance_lookup_cost(VarianceOptions{}).fetches;
                          return Finding{{fetches}, {}, {{"", {fetches}}}, "bilinear: of four texels"};
                      }});
    claims.push_back({"mm-vsm-bits", kPhenomenologicalPaper, "section 4.3.3",
                      "Bits a texel and wavelength of the variance shadow map", Printed::numbers_of("64"),
                      rule::exact(), Basis::kDefinition, "bytes that the conversion's last pass writes",
                      false, [](ClaimRuns&) {
                          const ConversionPass last = conversion_passes(kMap, VarianceOptions{}).back();
                          const double bits = 8 * static_cast<double>(last.write_bytes) /
                                              static_cast<double>(last.output_texels);
                          return Finding{{bits}, {}, {{"", {bits}}}, "two moments of float32"};
                      }});
    claims.push_back(
        {"mm-vsm-size", kPhenomenologicalPaper, "sections 4.3.3, 7.3",
         "Texels of the filtered map, an axis, from 4096", Printed::numbers_of("1024"), rule::exact(),
         Basis::kDefinition, "texels that the conversion's last pass makes", false, [](ClaimRuns&) {
             const ConversionPass last = conversion_passes(kMap, VarianceOptions{}).back();
             const double side =
                 std::sqrt(static_cast<double>(last.output_texels) / static_cast<double>(kMap.wavelengths));
             return Finding{{side}, {}, {{"", {side}}}, "a factor of four in each dimension"};
         }});
    claims.push_back(
        {"mm-tent-passes", kPhenomenologicalPaper, "section 4.3.3", "Taps of the 15x15 tent in two 1D passes",
         Printed::formula("two 1D passes", {30}), rule::exact(), Basis::kDefinition,
         "fetches a texel of the passes across and down, at the map's size", false, [](ClaimRuns&) {
             double taps = 0;
             for (const ConversionPass& pass :
                  conversion_passes(kMap, variance(ConversionPasses::kSeparate))) {
                 const double fetches =
                     static_cast<double>(pass.fetches) / static_cast<double>(pass.output_texels);
                 if (fetches > 1) taps += fetches;
             }
             return Finding{{taps}, {}, {{"", {taps}}}, "225 in one pass"};
         }});
}

// Look-ups a pixel of our scenes: every fragment and every opaque pixel asks.
double lookups_a_pixel(const std::string& file) {
    TraceReader reader(file);
    const TraceStatistics statistics = measure_trace(reader);
    const TraceHeader& header = reader.header();
    double opaque = 0;
    if (header.opaque)
        for (const float depth : header.opaque->depth) opaque += std::isfinite(depth) && depth < 1 ? 1 : 0;
    const double visible = static_cast<double>(statistics.fragments - statistics.hidden_by_opaque);
    return (visible + opaque) / (static_cast<double>(header.width) * header.height);
}

void add_shadow_savings(std::vector<Claim>& claims) {
    struct Row {
        const char* id;
        const char* place;
        const char* printed;
    };
    for (const Row& row : {Row{"mm-15x", "section 8.1", "15x"}, {"mm-10x", "abstract", "10x"}}) {
        claims.push_back(
            {row.id, kPhenomenologicalPaper, row.place,
             "Net reduction of bandwidth of coloured shadows by variance shadow maps",
             Printed::numbers_of(row.printed), rule::within(0.1), Basis::kAssets,
             "176 fetches of 4 bytes against conversion of three maps and one fetch of 8 bytes; every "
             "fragment "
             "and opaque pixel of our scenes looks up, also where the opaque map shadows; about is within 10 "
             "%",
             true, [printed = Printed::numbers_of(row.printed).numbers[0].value](ClaimRuns& runs) {
                 Finding finding;
                 ClaimTable table{{"scene", "look-ups a pixel", "separate", "reduced", "fused"}, {}};
                 for (const char* scene : {"glass", "bottles", "smoke"}) {
                     const std::string file = runs.trace({scene, "1280x720", "320x180"});
                     if (!runs.executed()) continue;
                     const double lookups = lookups_a_pixel(file);
                     const double fused = saving(ConversionPasses::kFused, lookups);
                     finding.measured.push_back(fused);
                     finding.readings.push_back(
                         {fmt::format("our scene {} and a first filter pass that squares depths itself",
                                      scene),
                          {fused}});
                     table.rows.push_back(
                         {scene, fmt::format("{:.2f}", lookups),
                          fmt::format("{:.1f}", saving(ConversionPasses::kSeparate, lookups)),
                          fmt::format("{:.1f}", saving(ConversionPasses::kReduced, lookups)),
                          fmt::format("{:.1f}", fused)});
                 }
                 finding.why = fmt::format(
                     "it is what the number of look-ups makes it: {:.2f} a pixel with fused passes, {:.2f} "
                     "with the sentence's separate ones; the paper prints 10x and 15x of one method",
                     lookups_for_saving(kMap, variance(ConversionPasses::kFused), printed, kFetches, true,
                                        true) /
                         kScreenPixels,
                     lookups_for_saving(kMap, variance(ConversionPasses::kSeparate), printed, kFetches, true,
                                        true) /
                         kScreenPixels);
                 finding.details = table;
                 return finding;
             }});
    }
}

double path_count(const RunRecord& run, const std::string& begin) {
    double count = 0;
    for (const RecordedPath& path : run.paths)
        if (path.path.starts_with(begin)) count += number_of(path.count);
    return count;
}

void add_subsampling(std::vector<Claim>& claims) {
    claims.push_back(
        {"mm-16x", kPhenomenologicalPaper, "section 7.3, figure 23",
         "4x4 subsampling gives nearly a 16x reduction of the stage's bandwidth", Printed::numbers_of("16x"),
         rule::within(0.05), Basis::kAssets,
         "bytes that the frame touches, and blends, of our scene fog, all draws at a quarter of the "
         "resolution, "
         "upsampling included; nearly is taken as within 5 %",
         true, [](ClaimRuns& runs) {
             const RunRecord& full = runs.run({{"fog"}, "phenomenological"});
             const RunRecord& low = runs.run({{"fog"}, "phenomenological:low_resolution=4,low_draws=all"});
             const double blends = path_count(full, "blend") / path_count(low, "blend");
             const auto bytes = [](const RunRecord& run) {
                 return 1e-6 * (number_of(run.total.read) + number_of(run.total.write));
             };
             return Finding{{},
                            {bytes(full) / bytes(low), blends},
                            {{"our scene fog", {bytes(full) / bytes(low)}},
                             {"our scene fog, the number of blends alone", {blends}}},
                            fmt::format("of bytes, then of blends: the frame touches {:.0f} MB at full and "
                                        "{:.0f} at a quarter, since upsampling's taps take over",
                                        bytes(full), bytes(low))};
         }});
}

void add_hair(std::vector<Claim>& claims) {
    claims.push_back({"mm-hair", kPhenomenologicalPaper, "section 7.3, figure 22",
                      "On hair the result is not substantially better than unsorted blending: RMSE over its",
                      Printed::meaning("not substantially better: taken as at least .9", 0.9, 0),
                      rule::at_least(), Basis::kAssets, "RMSE against exact compositing of two runs", true,
                      [](ClaimRuns& runs) {
                          const double ours = number_of(runs.run({{"hair"}, "phenomenological"}).rmse8);
                          const double blended = number_of(runs.run({{"hair"}, "alpha_blend"}).rmse8);
                          return Finding{{},
                                         {ours / blended},
                                         {{"our scene hair", {ours / blended}}},
                                         fmt::format("{:.2f} over {:.2f}, in 1/255", ours, blended)};
                      }});
}

void add_diffusion(std::vector<Claim>& claims) {
    claims.push_back(
        {"mm-diffusion-taps", kPhenomenologicalPaper, "section 7.3",
         "Diffusion's time is linear in the kernel's elements, in D^2: exponent",
         Printed::meaning("proportional to D^2", 2, 0.05), rule::digits(), Basis::kDefinition,
         "texels in discs of radius 8.5 and 31.5", false, [](ClaimRuns&) {
             const double exponent =
                 std::log(static_cast<double>(disc_texels(63)) / static_cast<double>(disc_texels(17))) /
                 std::log(63.0 / 17);
             return Finding{{}, {exponent}, {{"", {exponent}}}, "until Listing 3 ends it at 16 pixels"};
         }});
    claims.push_back(
        {"mm-over-diffusion", kPhenomenologicalPaper, "appendix",
         "Raising D^2 to a code creates slight over-diffusion: bytes that wider kernels read, over "
         "those with D^2 in float16, fog",
         Printed::meaning("slight: taken as at most 10 % more", 1.1, 0), rule::at_most(), Basis::kAssets,
         "bytes read of two runs, which grow with the kernels; D itself is not measured", true,
         [](ClaimRuns& runs) {
             const auto read = [&](const char* technique) {
                 return number_of(runs.run({{"fog"}, technique}).total.read);
             };
             const double raised = read("phenomenological") / read("phenomenological:beta_format=float16");
             return Finding{{},
                            {raised},
                            {{"our scene fog", {raised}}},
                            fmt::format("layers that scatter by less are raised to {:.1f} pixels each; wider "
                                        "kernels read more than the wider target",
                                        std::sqrt(63.0 * 63 / 255))};
         }});
    claims.push_back(
        {"mm-registers", kPhenomenologicalPaper, "section 7.2",
         "A march accumulated in registers requires the blending bandwidth of a single surface: bytes of 16 "
         "layers over those of one",
         Printed::meaning("a single surface", 1, 0.005), rule::digits(), Basis::kDefinition,
         "bytes touched in the targets, 16 layers a pixel one after the other, joined, over one layer", true,
         [](ClaimRuns& runs) {
             const auto bytes = [&](int layers) {
                 ClaimTrace trace{"layers", "64x64", "32x32"};
                 trace.layers = layers;
                 trace.alpha = 0.15;
                 const RunRecord& run =
                     runs.run({trace, "phenomenological:form=alpha,refraction=off,register_draws=all"});
                 double sum = 0;
                 for (const RecordedTraffic& surface : run.surfaces)
                     for (const char* target : {"accumulated", "beta", "delta"})
                         if (surface.surface == target)
                             sum += number_of(surface.read) + number_of(surface.write);
                 return sum;
             };
             const double ratio = bytes(16) / bytes(1);
             return Finding{{}, {ratio}, {{"", {ratio}}}, "the same blends whatever the number of steps"};
         }});
}

}  // namespace

void add_phenomenological_traffic_claims(std::vector<Claim>& claims) {
    add_fetches(claims);
    add_shadow_savings(claims);
    add_subsampling(claims);
    add_diffusion(claims);
    add_hair(claims);
}

}  // namespace ropsim
