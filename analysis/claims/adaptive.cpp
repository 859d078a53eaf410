// Claims of Salvi et al. 2011, "Adaptive Transparency": passes, and what is stored, from declarations alone.
#include "analysis/claims/adaptive.h"

#include "analysis/claims/declared_cost.h"
#include "analysis/claims/list.h"

#include <fmt/format.h>

namespace ropsim {

ListBytes stored_list_bytes(int spatial_samples, const std::string& technique) {
    const DeclaredCost cost = declared_cost(technique, spatial_samples);
    ListBytes bytes{0, cost.storage_bits / 8.0};
    for (const Surface& surface : cost.declaration.surfaces)
        if (surface.layout == Layout::kPool) bytes.node = surface.element_bytes();
    return bytes;
}

// Bounds and 16 planes, or 15 coefficients, of float32, in every spatial sample.
double stored_map_bytes(const std::string& technique, int spatial_samples, bool with_color) {
    const DeclaredCost cost = declared_cost(technique, spatial_samples);
    const int color = with_color ? 0 : cost.surface_bits("accumulated_color");
    return (cost.storage_bits - color) / 8.0;
}

// Depths of S samples, and M times total alpha with the sums. The technique keeps the latter once or in every
// stored sample: what one costs follows from both.
double stored_stochastic_bytes(int samples, int spatial_samples) {
    const std::string base = fmt::format("stochastic:method=depth_based,samples={}", samples);
    const double once = declared_cost(base).storage_bits;
    const double each = declared_cost(base + ",total_alpha=sample,accumulator=sample").storage_bits;
    const double one_color = (each - once) / (samples - 1);
    return (once + (spatial_samples - 1) * one_color) / 8;
}

namespace {

using Values = std::vector<double>;

void add_row(std::vector<Claim>& claims, const char* id, const char* place, const char* claim,
             Printed printed, const Rule& rule, const char* why, Values (*value)()) {
    claims.push_back({id, kAdaptivePaper, place, claim, std::move(printed), rule, Basis::kDefinition,
                      "as the technique declares", false, [value, why](ClaimRuns&) {
                          const Values values = value();
                          return Finding{values, {}, {{"", values}}, why};
                      }});
}

double passes(const char* technique) {
    return declared_cost(technique).geometry_passes;
}

void add_passes(std::vector<Claim>& claims) {
    add_row(claims, "at-passes-fixed", "section 4", "Passes over the transparent geometry",
            Printed::meaning("two-pass", 2, 0), rule::exact(),
            "visibility, then colour; total transmittance is the last node's",
            [] { return Values{passes("adaptive:nodes=8")}; });
    add_row(claims, "at-passes-no-extra", "section 4",
            "Passes that others need for total transmittance, and AT does not",
            Printed::meaning("an extra pass", 1, 0), rule::exact(),
            "three of stochastic transparency, corrected by the depth-based method, against two", [] {
                return Values{passes("stochastic:method=depth_based,samples=8") - passes("adaptive:nodes=8")};
            });
    add_row(claims, "at-passes-maps", "section 4", "Passes of OSMTF and FOMTF, bounds of depth included",
            Printed::formula("visibility, colour, and a pass for the bounds", {3, 3}), rule::exact(),
            "bounds, map, colour", [] {
                return Values{passes("opacity_map"), passes("fourier_map")};
            });
    add_row(claims, "at-passes-st", "section 4",
            "Passes of stochastic transparency: the four of the algorithm and one for total transmittance",
            Printed::meaning("four and an additional one", 5, 0), rule::exact(),
            "three over the transparent geometry, the opaque one, and resolve",
            [] { return Values{passes("stochastic:method=depth_based,samples=8") + 2}; });
    add_row(claims, "at-passes-lists", "section 4.1", "Passes of the prototype over the transparent geometry",
            Printed::meaning("capture ... in per-pixel linked lists", 1, 0), rule::exact(),
            "the other passes are of resolve, which walks the lists",
            [] { return Values{passes("adaptive:memory=variable")}; });
    add_row(claims, "at-passes-peeling", "section 2",
            "Complete passes of depth peeling for k = 4 and 8 layers", Printed::formula("k", {4, 8}),
            rule::exact(), "one a layer", [] {
                return Values{passes("depth_peeling:layers=4"), passes("depth_peeling:layers=8")};
            });
}

void add_storage(std::vector<Claim>& claims) {
    add_row(claims, "at-mask-free", "sections 4.2, 5.2",
            "Coverage masks do not affect the size of a list node: bytes with 1 and 4 samples",
            Printed::formula("does not affect the per-pixel list node size", {12, 12}), rule::exact(),
            "the mask is in the depth's lowest bits", [] {
                return Values{stored_list_bytes(1).node, stored_list_bytes(4).node};
            });
    add_row(claims, "at-lists-alike", "Table 1",
            "All variable-memory methods and both references allocate alike: bytes of a node, and of a pixel",
            Printed::formula("the same amount of graphics memory", {12, 12, 12, 12, 4, 4, 4, 4}),
            rule::exact(), "AT, opacity maps, Fourier maps, A-buffer", [] {
                Values nodes;
                Values heads;
                for (const char* technique : {"adaptive:memory=variable", "opacity_map:memory=variable",
                                              "fourier_map:memory=variable", "a_buffer"}) {
                    const ListBytes bytes = stored_list_bytes(1, technique);
                    nodes.push_back(bytes.node);
                    heads.push_back(bytes.head);
                }
                nodes.insert(nodes.end(), heads.begin(), heads.end());
                return nodes;
            });
    add_row(
        claims, "at-registers", "section 5.3",
        "Bits of the frame buffer that more nodes add: 4 to 64, in lists",
        Printed::meaning("does not require changing GPU buffer allocations", 0, 0), rule::exact(),
        "the curve is in registers: 32 bits a pixel and 12 bytes a fragment with any number of nodes", [] {
            const auto bits = [](int nodes) {
                return declared_cost(fmt::format("adaptive:memory=variable,nodes={}", nodes)).storage_bits;
            };
            return Values{static_cast<double>(bits(64) - bits(4))};
        });
    add_row(
        claims, "at-maps-4x", "section 4.2", "Memory of the maps with 4 spatial samples over that with one",
        Printed::formula("at sample frequency", {4, 4}), rule::exact(), "all of a map is kept a sample", [] {
            const auto ratio = [](const char* map) {
                return stored_map_bytes(map, 4, false) / stored_map_bytes(map, 1, false);
            };
            return Values{ratio("opacity_map"), ratio("fourier_map")};
        });
    add_row(claims, "at-st-4x", "section 5.2",
            "Memory of per-pixel visibility over visibility a sample, ST, 16 samples, 4 spatial ones",
            Printed::meaning("uses less memory: below 1", 1, 0), rule::at_most(),
            "the bytes behind Table 1's 91.4 MB against four times those behind 65.0",
            [] { return Values{stored_stochastic_bytes(16, 4) / (4 * stored_stochastic_bytes(16, 1))}; });
    add_row(claims, "at-bounded", "abstract, section 3",
            "Bounded memory: surfaces that grow with the fragments", Printed::meaning("bounded memory", 0, 0),
            rule::exact(), "nodes of fixed number a pixel; the prototype has one, the pool of its lists", [] {
                double pools = 0;
                for (const Surface& surface : declared_cost("adaptive:nodes=8").declaration.surfaces)
                    pools += surface.layout == Layout::kPool ? 1 : 0;
                return Values{pools};
            });
    add_row(claims, "at-node", "section 3.3", "Bits of a node: depth and transmittance",
            Printed::formula("(z, product of 1 - alpha)", {64}), rule::exact(),
            "formats are not printed; two of float32", [] {
                return Values{(declared_cost("adaptive:nodes=16").storage_bits -
                               declared_cost("adaptive:nodes=8").storage_bits) /
                              8.0};
            });
}

}  // namespace

void add_adaptive_claims(std::vector<Claim>& claims) {
    add_adaptive_table_claims(claims);
    add_passes(claims);
    add_storage(claims);
    add_adaptive_curve_claims(claims);
    add_adaptive_quality_claims(claims);
    add_adaptive_prototype_claims(claims);
    add_adaptive_bandwidth_claims(claims);
}

}  // namespace ropsim
