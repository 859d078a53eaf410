// Claims of McGuire and Mara 2017, "Phenomenological Transparency": bits a pixel, and the quotients of them.
#include "analysis/claims/phenomenological.h"

#include "analysis/claims/declared_cost.h"
#include "analysis/claims/list.h"

#include <algorithm>

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr const char* kAlpha = "phenomenological:form=alpha";

double bits(const std::string& technique) {
    return declared_cost(technique).storage_bits;
}

struct TrafficScene {
    const char* scene;
    bool materials;  // of coloured transmission, refraction or diffusion
};
constexpr TrafficScene kScenes[] = {{"glass", true}, {"fog", true}, {"engine", false}, {"hair", false}};

// Bytes on the pins of the whole frame, caches and compression on.
double pins(ClaimRuns& runs, const char* scene, const std::string& technique) {
    ClaimRun run{{scene, "640x360", "160x90"}, technique};
    run.fidelity = "cached";
    const RunRecord& record = runs.run(run);
    return number_of(record.total.pin_read) + number_of(record.total.pin_write);
}
// By scene: what `other` moves over what `technique` does.
std::vector<double> pin_ratios(ClaimRuns& runs, const std::string& other, const std::string& technique,
                               bool alpha_alone) {
    std::vector<double> ratios;
    for (const TrafficScene& row : kScenes)
        if (!alpha_alone || !row.materials)
            ratios.push_back(pins(runs, row.scene, other) / pins(runs, row.scene, technique));
    return ratios;
}
std::string by_scene(const std::vector<double>& ratios) {
    std::string text;
    const std::size_t first = std::size(kScenes) - ratios.size();
    for (std::size_t i = 0; i < ratios.size(); ++i)
        text += fmt::format("{}{} {:.2f}", i == 0 ? "" : ", ", kScenes[first + i].scene, ratios[i]);
    return text;
}

void add_bits(std::vector<Claim>& claims) {
    const auto add = [&](const char* id, const char* place, const char* claim, Printed printed,
                         const char* why, const std::vector<std::pair<const char*, std::string>>& readings) {
        claims.push_back({id, kPhenomenologicalPaper, place, claim, std::move(printed), rule::exact(),
                          Basis::kDefinition, "storage that the technique declares", false,
                          [readings, why](ClaimRuns&) {
                              Finding finding{{bits(readings.back().second)}, {}, {}, why};
                              for (const auto& [name, technique] : readings)
                                  finding.readings.push_back({name, {bits(technique)}});
                              return finding;
                          }});
    };
    add("mm-112", "section 8.1", "Bits a pixel of the full algorithm", Printed::numbers_of("112"),
        "64 + 32 + 16", {{"", "phenomenological"}});
    add("mm-128", "appendix", "Bits a pixel without separate alpha blending: 112 and another 16",
        Printed::formula("another 16 bits", {128}),
        "RT2's third channel is aligned to four: 128, what two layers of MLAB have",
        {{"", "phenomenological:separate_alpha=off"}});
    add("mm-256", "section 8.1", "Bits a pixel of multi-layer alpha blending, k = 4",
        Printed::numbers_of("256"), "4 layers of depth, RGB8 and transmittance", {{"", "mlab:layers=4"}});
}

// Which 24 of the 112 bits go the paper does not print.
void add_alpha_bits(std::vector<Claim>& claims) {
    claims.push_back(
        {"mm-88", kPhenomenologicalPaper, "section 8.1", "Bits a pixel for scenes of alpha alone",
         Printed::numbers_of("88"), rule::exact(), Basis::kDefinition, "storage that the technique declares",
         false, [](ClaimRuns&) {
             const DeclaredCost full = declared_cost("phenomenological");
             const double beta = full.surface_bits("beta");
             // D is one of RT1's four channels.
             const double needed = full.storage_bits - full.surface_bits("delta") - beta / 4;
             return Finding{
                 {needed, bits(kAlpha)},
                 {},
                 {{"neither RT2 nor D, as alpha alone needs: RGBA16F and RGB8", {needed}},
                  {"one channel of beta, no diffusion, RT2 kept", {bits(kAlpha)}}},
                 fmt::format("which 24 bits go is not printed. Three channels of 8 bits are aligned to four, "
                             "as the appendix says of 24-bit textures: {}; with one channel of beta, "
                             "weighted blending, {:.0f} would do",
                             full.storage_bits - full.surface_bits("delta"), bits("weighted_blended"))};
         }});
}

// 128 to 320: the paper names no k.
void add_k_buffers(std::vector<Claim>& claims) {
    claims.push_back(
        {"mm-128-320", kPhenomenologicalPaper, "section 8.1", "Bits a pixel of k+-buffers",
         Printed::numbers_of("128, 320"), rule::exact(), Basis::kDefinition,
         "declared storage of 2 to 5 layers", false, [](ClaimRuns&) {
             const auto range = [](const char* technique) {
                 return std::vector{bits(fmt::format("{}:layers=2", technique)),
                                    bits(fmt::format("{}:layers=5", technique))};
             };
             const double layer = (bits("k_plus_buffer:layers=5") - bits("k_plus_buffer:layers=2")) / 3;
             return Finding{
                 range("k_plus_buffer"),
                 {},
                 {{"", range("k_plus_buffer")},
                  {"64 bits a layer, 2 to 5 layers, no count", {2 * layer, 5 * layer}}},
                 fmt::format("ours counts its layers in bits more: {:.0f} and {:.0f}; 64 k + 64 of "
                             "1 to 4 layers would be the printed range too",
                             range("k_plus_buffer")[0], range("k_plus_buffer")[1])};
         }});
}

void add_targets(std::vector<Claim>& claims) {
    struct Target {
        const char* id;
        const char* surface;
        const char* printed;
    };
    for (const Target& target : {Target{"mm-table2-rt0", "accumulated", "64"},
                                 {"mm-table2-rt1", "beta", "32"},
                                 {"mm-table2-rt2", "delta", "16"}})
        claims.push_back(
            {target.id, kPhenomenologicalPaper, "Table 2", fmt::format("Bits a pixel of {}", target.id + 10),
             Printed::numbers_of(target.printed), rule::exact(), Basis::kDefinition,
             "the surface that the technique declares", false, [surface = target.surface](ClaimRuns&) {
                 const double size = declared_cost("phenomenological").surface_bits(surface);
                 return Finding{{size}, {}, {{"", {size}}}, fmt::format("surface {}", surface)};
             }});
}

void add_quotients(std::vector<Claim>& claims) {
    claims.push_back(
        {"mm-3.6x", kPhenomenologicalPaper, "section 8.1",
         "Higher throughput for alpha alone by up to 3.6x, as a quotient of storage",
         Printed::numbers_of("3.6x"), rule::digits(), Basis::kDefinition,
         "storage of a k+-buffer over the form for alpha; measured: bytes on the pins over its", true,
         [](ClaimRuns& runs) {
             const std::vector<double> ratios = pin_ratios(runs, "k_plus_buffer:layers=5", kAlpha, true);
             const double ours = bits("k_plus_buffer:layers=5") / bits(kAlpha);
             const double printed = (bits("k_plus_buffer:layers=5") - 32) / bits(kAlpha);
             return Finding{
                 {printed},
                 ratios,
                 {{"", {ours}}, {"the 320 bits of its own sentence", {printed}}},
                 fmt::format("320 / 88; of our k+-buffer of 5 layers {:.2f}; bytes on the pins: {}", ours,
                             by_scene(ratios))};
         }});
    claims.push_back(
        {"mm-2-3x", kPhenomenologicalPaper, "section 8.1",
         "The full model achieves a 2-3x increase against methods of alpha alone",
         Printed::numbers_of("2, 3"), rule::about(), Basis::kDefinition,
         "storage over 112 bits; measured: bytes on the pins of MLAB, k = 4, over the full model's", true,
         [](ClaimRuns& runs) {
             const double full = bits("phenomenological");
             const std::vector<double> ratios = pin_ratios(runs, "mlab:layers=4", "phenomenological", false);
             return Finding{
                 {256 / full, 320 / full},
                 ratios,
                 {{"", {128 / full, 320 / full}},
                  {"the larger storages of its sentence, 256 and 320 bits",
                   {bits("mlab:layers=4") / full, 320 / full}}},
                 fmt::format("against the 128 bits of the same sentence {:.2f}; bytes on the pins: {}",
                             128 / full, by_scene(ratios))};
         }});
    claims.push_back(
        {"mm-2x-abstract", kPhenomenologicalPaper, "abstract",
         "Transparency at a 2x reduction in memory traffic against k-buffers of alpha alone",
         Printed::numbers_of("2x"), rule::about(), Basis::kDefinition,
         "worst-case bytes a fragment of MLAB, k = 4, over the full model's; measured: bytes on the pins",
         true, [](ClaimRuns& runs) {
             const auto bytes = [](const char* technique) { return declared_cost(technique).bytes(); };
             const double worst = bytes("mlab:layers=4") / bytes("phenomenological");
             const std::vector<double> ratios = pin_ratios(runs, "mlab:layers=4", "phenomenological", false);
             return Finding{
                 {worst},
                 ratios,
                 {{"worst-case bytes against MLAB of 4 layers", {worst}}},
                 fmt::format("{:.2f} at worst; on the pins, of the frame: {}; of the written bytes of a "
                             "k+-buffer alone {:.2f} at worst",
                             worst, by_scene(ratios),
                             static_cast<double>(declared_cost("k_plus_buffer:layers=4").worst_case.write) /
                                 static_cast<double>(declared_cost("phenomenological").worst_case.write))};
         }});
}

void add_strictly(std::vector<Claim>& claims) {
    const auto least = [](const std::vector<double>& values) {
        return *std::min_element(values.begin(), values.end());
    };
    claims.push_back({"mm-strictly-storage", kPhenomenologicalPaper, "section 8.1",
                      "Strictly higher throughput for the stage: storage of others over its own, the least",
                      Printed::meaning("strictly higher: above 1", 1, 0), rule::at_least(),
                      Basis::kDefinition,
                      "declared storage of MLAB and k+-buffers of 2 to 5 layers, and the sentence's 128 bits",
                      false, [least](ClaimRuns&) {
                          std::vector<double> ratios{128 / bits("phenomenological")};
                          for (int layers = 2; layers <= 5; ++layers)
                              for (const char* technique : {"mlab", "k_plus_buffer"})
                                  ratios.push_back(bits(fmt::format("{}:layers={}", technique, layers)) /
                                                   bits("phenomenological"));
                          return Finding{{least(ratios)},
                                         {},
                                         {{"", {least(ratios)}}},
                                         "of storage; without separate alpha blending it is 1"};
                      }});
    claims.push_back(
        {"mm-strictly-pins", kPhenomenologicalPaper, "section 8.1",
         "Strictly higher throughput for the stage: bytes on the pins of others over its own, the least",
         Printed::meaning("strictly higher: above 1", 1, 0), rule::at_least(), Basis::kAssets,
         "MLAB, k = 4, and k+-buffers of 2 and 5 layers on four scenes, frames of 640x360", true,
         [least](ClaimRuns& runs) {
             std::vector<double> all;
             ClaimTable table{{"over the full model", "glass", "fog", "engine", "hair"}, {}};
             for (const char* other : {"mlab:layers=4", "k_plus_buffer:layers=2", "k_plus_buffer:layers=5"}) {
                 const auto ratios = pin_ratios(runs, other, "phenomenological", false);
                 std::vector<std::string> row{other};
                 for (const double ratio : ratios) row.push_back(fmt::format("{:.2f}", ratio));
                 table.rows.push_back(row);
                 all.insert(all.end(), ratios.begin(), ratios.end());
             }
             std::vector<Reading> readings{{"our four scenes", {least(all)}}};
             return Finding{{},
                            {least(all)},
                            readings,
                            "throughput follows storage only where every fragment reads and writes all of "
                            "it: of a k+-buffer those that come too late write nothing, and three targets "
                            "are three sectors",
                            table};
         }});
}

void add_declared(std::vector<Claim>& claims) {
    claims.push_back({"mm-one-pass", kPhenomenologicalPaper, "section 4.2",
                      "Sums and products are computed in a single pass over the transparent surfaces",
                      Printed::meaning("a single pass", 1, 0), rule::exact(), Basis::kDefinition,
                      "passes that the technique declares", false, [](ClaimRuns&) {
                          const double passes = declared_cost("phenomenological").geometry_passes;
                          return Finding{{passes}, {}, {{"", {passes}}}, "and a resolve"};
                      }});
    claims.push_back(
        {"mm-any-order", kPhenomenologicalPaper, "sections 3, 8.1",
         "Fixed-function blending alone: no order of operations on a pixel is kept",
         Printed::statement("avoids the pixel-synchronization overhead"), rule::statement(),
         Basis::kDefinition, "1 where any order is declared: its own technique, MLAB", false, [](ClaimRuns&) {
             const auto any = [](const char* technique) {
                 return declared_cost(technique).declaration.ordering == Ordering::kAny ? 1.0 : 0.0;
             };
             const std::vector<double> orders{any("phenomenological"), any("mlab:layers=4")};
             return Finding{{},
                            orders,
                            {{"", {}, orders[0] == 1 && orders[1] == 0}},
                            "MLAB, which it compares with, asks for raster order; rounding, self-modulation "
                            "and displacements past 63 pixels still see the order"};
         }});
    claims.push_back(
        {"mm-one-fetch", kPhenomenologicalPaper, "section 7.3", "... and one texture fetch",
         Printed::meaning("one texture fetch", 1, 0), rule::exact(), Basis::kDefinition,
         "fetches that the technique charges the shader", false, [](ClaimRuns&) {
             const double fetches =
                 declared_cost("phenomenological", 1, true).declaration.added_shading.opaque_depth_fetches;
             return Finding{{fetches}, {}, {{"", {fetches}}}, "the opaque depth, of surfaces that scatter"};
         }});
}

}  // namespace

void add_phenomenological_claims(std::vector<Claim>& claims) {
    add_bits(claims);
    add_alpha_bits(claims);
    add_k_buffers(claims);
    add_targets(claims);
    add_quotients(claims);
    add_strictly(claims);
    add_declared(claims);
    add_phenomenological_listing_claims(claims);
    add_phenomenological_operation_claims(claims);
    add_phenomenological_traffic_claims(claims);
    add_phenomenological_time_claims(claims);
}

}  // namespace ropsim
