// Claims of Salvi et al. 2011 about the curve itself: total transmittance, what compression loses, order.
#include "analysis/claims/adaptive.h"
#include "analysis/claims/curves.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <optional>

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr float kAlpha = 0.15f;

// Random layers of alpha .15: the same for every claim.
const std::vector<PixelFragments>& layers_of(int layers, bool quick) {
    static std::mutex mutex;
    static std::map<std::pair<int, bool>, std::vector<PixelFragments>> known;
    const std::scoped_lock lock(mutex);
    auto& pixels = known[{layers, quick}];
    if (pixels.empty()) pixels = random_layers(quick ? 64 : 576, layers, kAlpha, 1);
    return pixels;
}

std::string nodes_of(int nodes, const std::string& keys = "") {
    return fmt::format("adaptive:nodes={},format=float32{}{}", nodes, keys.empty() ? "" : ",", keys);
}

CurveStudy study(int layers, bool quick, const std::string& technique, int orders = 1) {
    return study_curves(layers_of(layers, quick), {technique, orders, 1});
}

void add_total(std::vector<Claim>& claims) {
    claims.push_back(
        {"at-total", kAdaptivePaper, "sections 3.2, 4",
         "Visibility at infinity is always correct, even if the furthest node is removed: largest error",
         Printed::meaning("always correct", 0, 1e-5), rule::digits(), Basis::kDefinition,
         "random layers of alpha .15 through 2 to 24 nodes, float32, against the product in double", false,
         [](ClaimRuns& runs) {
             double worst = 0;
             for (const int nodes : {2, 4, 8, 24})
                 for (const int layers : {8, 32, 100})
                     worst = std::max(worst, study(layers, runs.quick(), nodes_of(nodes)).total_off);
             const double over = study(32, runs.quick(), nodes_of(4, "removal=overestimate")).total_off;
             return Finding{{},
                            {worst},
                            {{"", {worst}}},
                            fmt::format("roundings of float32 alone; by overestimation up to {:.2f} with 4 "
                                        "nodes and 32 layers",
                                        over)};
         }});
    claims.push_back({"at-exact-to-n", kAdaptivePaper, "section 3.2",
                      "Up to N fragments nothing is removed: RMS error of the curve of 8 layers in 8 nodes",
                      Printed::meaning("more than N fragments ... we compress", 0, 1e-6), rule::digits(),
                      Basis::kDefinition, "random layers through 8 nodes, float32", false,
                      [](ClaimRuns& runs) {
                          const double error = study(8, runs.quick(), nodes_of(8)).curve_rms;
                          return Finding{{}, {error}, {{"", {error}}}, "roundings of float32"};
                      }});
}

// "No ... corrections to the compositing equation" would need the weights to sum to total alpha.
void add_darkness(std::vector<Claim>& claims) {
    claims.push_back(
        {"at-no-correction", kAdaptivePaper, "section 4",
         "No correction to the compositing equation is required: sum of alpha vis(z) over total alpha",
         Printed::meaning("no ... corrections", 1, 0.005), rule::digits(), Basis::kDefinition,
         "equation 2's weights over 32 random layers of alpha .15, 8 nodes", false, [](ClaimRuns& runs) {
             const CurveStudy plain = study(32, runs.quick(), nodes_of(8));
             ClaimTable table{{"nodes", "32 layers", "100 layers"}, {}};
             for (const int nodes : {4, 8, 16, 24}) {
                 std::vector<std::string> row{std::to_string(nodes)};
                 for (const int layers : {32, 100})
                     row.push_back(fmt::format(
                         "{:.3f}", study(layers, runs.quick(), nodes_of(nodes)).weights_over_alpha));
                 table.rows.push_back(row);
             }
             return Finding{{},
                            {plain.weights_over_alpha},
                            {{"", {plain.weights_over_alpha}}},
                            fmt::format("total transmittance needs none, colour does: underestimation takes "
                                        "from fragments what it gives to none, {:.1f} of 255 here",
                                        plain.mean8),
                            table};
         }});
}

// Judged at one step of 8 bits, which is the row's own reading of "negligible".
void add_order(std::vector<Claim>& claims) {
    claims.push_back(
        {"at-order", kAdaptivePaper, "sections 5.1, 6",
         "Order sensitivity with more than 8 nodes, 1/255 between images of six orders",
         Printed::meaning("negligible with more than ~8 nodes: taken as at most 1 of 255", 1, 0),
         rule::at_most(), Basis::kDefinition, "32 random layers of alpha .15, six orders, mean of pixels",
         false, [](ClaimRuns& runs) {
             ClaimTable table{{"nodes", "32 layers", "100 layers"}, {}};
             Finding finding;
             std::optional<int> enough;
             for (const int nodes : {8, 9, 12, 16, 24, 32}) {
                 std::vector<std::string> row{std::to_string(nodes)};
                 double worst = 0;
                 for (const int layers : {32, 100}) {
                     const double spread = study(layers, runs.quick(), nodes_of(nodes), 6).spread8;
                     row.push_back(fmt::format("{:.2f}", spread));
                     worst = std::max(worst, spread);
                     if (layers != 32) continue;
                     finding.measured.push_back(spread);
                     if (nodes == 9) finding.readings.push_back({"", {spread}});
                     if (spread <= 1 && !enough) enough = nodes;
                 }
                 table.rows.push_back(row);
             }
             if (enough) finding.readings.push_back({fmt::format("{} nodes", *enough), {0}});
             finding.why = "measured: 8, 9, 12, 16, 24 and 32 nodes; of 100 layers in the table below";
             finding.details = table;
             return finding;
         }});
}

void add_compression(std::vector<Claim>& claims) {
    claims.push_back(
        {"at-bias", kAdaptivePaper, "section 3.4", "Nodes kept in the nearer half of the fragments, share",
         Printed::meaning("naturally biased towards ... closer to the viewer: above one half", 0.5, 0),
         rule::at_least(), Basis::kDefinition,
         "steps of the curve that are left of 32 random layers of alpha .15 in 8 nodes", false,
         [](ClaimRuns& runs) {
             const double share = study(32, runs.quick(), nodes_of(8)).near_half;
             return Finding{{}, {share}, {{"", {share}}}, "at uniform window depths"};
         }});
    claims.push_back(
        {"at-node-by-node", kAdaptivePaper, "section 3.2",
         "Choosing the removal node by node further minimises the error of visibility: RMS over that of "
         "underestimation",
         Printed::meaning("further minimizes: below 1", 1, 0), rule::at_most(), Basis::kDefinition,
         "the curve at the fragments of 32 random layers of alpha .15, 8 nodes", false, [](ClaimRuns& runs) {
             const auto rms = [&](const char* removal) {
                 return study(32, runs.quick(), nodes_of(8, fmt::format("removal={}", removal))).curve_rms;
             };
             const double under = rms("underestimate");
             const double each = rms("node_by_node");
             return Finding{{},
                            {each / under},
                            {{"", {each / under}}},
                            fmt::format("RMS of the curve .{:03.0f} by underestimation, .{:03.0f} by "
                                        "overestimation, .{:03.0f} node by node",
                                        1e3 * under, 1e3 * rms("overestimate"), 1e3 * each)};
         }});
}

// Error of each representation where fragments ask for it, at pixels of our scenes.
void add_curves_of_scenes(std::vector<Claim>& claims) {
    for (const char* scene : {"smoke", "hair", "forest"}) {
        claims.push_back(
            {fmt::format("at-fig8-{}", scene), kAdaptivePaper, "section 5.1, figure 8",
             fmt::format("Of all approximate techniques AT's curves are closest to the truth, {}", scene),
             Printed::statement("much closer to the ground truth result than any other"), rule::statement(),
             Basis::kAssets,
             "RMS error at the fragments of sampled pixels with 16 fragments or more; 8 nodes against 16 "
             "samples, 16 planes, 7 and 15 coefficients",
             true, [scene](ClaimRuns& runs) {
                 const std::string file = runs.trace({scene});
                 if (!runs.executed()) return Finding{};
                 const auto pixels = sampled_pixels(file, runs.quick() ? 16 : 64, 16);
                 Finding finding;
                 ClaimTable table{{"technique", "RMS error of visibility"}, {}};
                 for (const char* technique :
                      {"adaptive:nodes=8", "stochastic:samples=16,method=depth_based", "opacity_map",
                       "fourier_map", "fourier_map:coefficients=15,coefficients_format=float32"}) {
                     finding.measured.push_back(study_curves(pixels, {technique, 1, 1}).curve_rms);
                     table.rows.push_back({technique, fmt::format("{:.4f}", finding.measured.back())});
                 }
                 const double others =
                     *std::min_element(finding.measured.begin() + 1, finding.measured.end());
                 finding.readings.push_back(
                     {fmt::format("our scene {}", scene), {}, finding.measured[0] < others});
                 const int most = std::string(scene) == "smoke" ? 24 : 16;
                 const double more = study_curves(pixels, {nodes_of(most), 1, 1}).curve_rms;
                 finding.readings.push_back(
                     {fmt::format("{} nodes and our scene {}", most, scene), {}, more < others});
                 finding.why = fmt::format("8 nodes {:.4f}, {} nodes {:.4f}, the best of the others {:.4f}",
                                           finding.measured[0], most, more, others);
                 finding.details = table;
                 return finding;
             }});
    }
}

}  // namespace

void add_adaptive_curve_claims(std::vector<Claim>& claims) {
    add_total(claims);
    add_darkness(claims);
    add_order(claims);
    add_compression(claims);
    add_curves_of_scenes(claims);
}

}  // namespace ropsim
