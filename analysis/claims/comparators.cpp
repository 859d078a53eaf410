// What the techniques that the five papers compare themselves with store and move, as their papers and
// public code have them: bits a pixel, passes, and bytes of a fragment at worst.
#include "analysis/claims/declared_cost.h"
#include "analysis/claims/list.h"

#include <fmt/format.h>

namespace ropsim {
namespace {

// The sizes that follow from the formats which the paper or its public code names, by hand: bits a pixel,
// passes over the fragments, and bytes read and written by a fragment in all of them. A pass over the
// geometry reads and writes what it adds to, and reads what the pass before it left for it.
struct Comparator {
    const char* id;
    const char* paper;
    const char* what;
    const char* formats;
    const char* technique;
    double bits, passes, read, write;
};

constexpr const char* kPaper = "Comparators";

constexpr Comparator kComparators[] = {
    {"blend", "Porter and Duff 1984", "sorted alpha blending", "RGBA16F", "alpha_blend", 64, 1, 8, 8},
    {"hashed", "Wyman and McGuire 2017", "hashed alpha testing", "depth 32, RGBA8", "hashed_alpha", 64, 1, 4,
     8},
    {"st8", "Enderton et al. 2011", "basic stochastic transparency, 8 samples", "depth 32 and RGBA8 a sample",
     "stochastic:samples=8", 512, 1, 32, 64},
    {"st8-depth", "Enderton et al. 2011", "depth-based and corrected stochastic transparency, 8 samples",
     "depth 32 a sample, RGBA16F, R16F", "stochastic:samples=8,method=depth_based", 336, 3, 74, 42},
    {"lk8", "Laine and Karras 2011", "stratified stochastic transparency, 8 samples",
     "depth 32 and RGBA8 a sample, a mask bit a sample, a counter of 32", "laine_karras:samples=8", 552, 1,
     37, 69},
    {"at8", "Salvi et al. 2011", "adaptive transparency, 8 nodes", "8 bytes a node, RGBA16F",
     "adaptive:nodes=8", 576, 2, 136, 72},
    {"slab8", "Wyman 2016", "SLAB, 8 layers", "8 bytes a layer", "slab:layers=8", 512, 1, 64, 64},
    {"mlab4", "Salvi and Vaidyanathan 2014", "multi-layer alpha blending, 4 layers",
     "depth 32, RGB8, transmittance 8 a layer", "mlab:layers=4", 256, 1, 32, 32},
    {"mlab8", "Salvi and Vaidyanathan 2014", "multi-layer alpha blending, 8 layers",
     "depth 32, RGB8, transmittance 8 a layer", "mlab:layers=8", 512, 1, 64, 64},
    {"aoit4", "Intel 2014", "one-pass AOIT, 4 nodes",
     "depth 32, RGB8, transmittance 8 a node, a control word of 32", "aoit:nodes=4", 288, 1, 36, 36},
    {"k-buffer4", "Bavoil et al. 2007", "k-buffer, 4 layers", "depth 32 and RGBA8 a layer, a count of 32",
     "k_buffer:layers=4", 288, 1, 36, 36},
    {"hybrid4", "Maule et al. 2013", "hybrid transparency, 4 layers",
     "depth 32 and RGBA8 a layer, a tail of 64", "hybrid:layers=4", 320, 1, 40, 40},
    {"wboit", "McGuire and Bavoil 2013", "weighted blended OIT", "RGBA16F, R8", "weighted_blended", 72, 1, 9,
     9},
    {"mboit4", "Münstermann et al. 2018", "moment-based OIT, 4 power moments", "5 values of float32, RGBA16F",
     "moment_based:moments=4", 224, 2, 48, 28},
    {"mboit6-16", "Münstermann et al. 2018", "moment-based OIT, 6 power moments of UNORM16",
     "6 values and their sum of UNORM16, RGBA16F", "moment_based:moments=6,moment_format=unorm16", 176, 2, 36,
     22},
    {"mboit-trig3", "Münstermann et al. 2018", "moment-based OIT, 3 trigonometric moments",
     "7 values of float32, RGBA16F", "moment_based:moments=6,basis=trigonometric", 288, 2, 64, 36},
    {"mboit8", "Münstermann et al. 2018", "moment-based OIT, 8 power moments", "9 values of float32, RGBA16F",
     "moment_based:moments=8", 352, 2, 80, 44},
    {"opacity-map", "Kim and Neumann 2001", "opacity shadow maps, 16 planes",
     "16 values and two bounds of float32, RGBA16F", "opacity_map", 640, 3, 160, 80},
    {"fourier7", "Jansen and Bavoil 2010", "Fourier opacity maps, 7 coefficients", "two RGBA16F, RGBA16F",
     "fourier_map:bounds=frame", 192, 2, 40, 24},
    {"wavelet3", "Aizenshtein et al. 2022", "wavelet transparency, rank 3",
     "16 coefficients of float16, bounds, RGBA16F", "wavelet:rank=3", 384, 3, 96, 48},
};

void add_comparator(std::vector<Claim>& claims, const Comparator& row) {
    claims.push_back(
        {fmt::format("cmp-bits-{}", row.id), kPaper, row.paper, fmt::format("Bits a pixel of {}", row.what),
         Printed::formula(row.formats, {row.bits}), rule::exact(), Basis::kDefinition,
         "storage that the technique declares", false, [&row](ClaimRuns&) {
             const double bits = declared_cost(row.technique).storage_bits;
             return Finding{
                 {bits}, {}, {{"", {bits}}}, fmt::format("{:g} bits of {}", row.bits, row.formats)};
         }});
    claims.push_back(
        {fmt::format("cmp-bytes-{}", row.id), kPaper, row.paper,
         fmt::format("Passes over the fragments, and bytes that a fragment reads and writes in them, of {}",
                     row.what),
         Printed::formula(fmt::format("{:g} pass{}, {:g} + {:g} bytes", row.passes,
                                      row.passes == 1 ? "" : "es", row.read, row.write),
                          {row.passes, row.read, row.write}),
         rule::exact(), Basis::kDefinition, "worst case that follows from the declaration", false,
         [&row](ClaimRuns&) {
             const DeclaredCost cost = declared_cost(row.technique);
             const std::vector<double> values{static_cast<double>(cost.geometry_passes),
                                              static_cast<double>(cost.worst_case.read),
                                              static_cast<double>(cost.worst_case.write)};
             return Finding{values, {}, {{"", values}}, "formats as above, every byte of the state moved"};
         }});
}

void add_lists_and_peeling(std::vector<Claim>& claims) {
    claims.push_back({"cmp-node-lists", kPaper, "Yang et al. 2010",
                      "Bits of a node of per-pixel linked lists",
                      Printed::formula("colour, depth and next, 32 each", {96}), rule::exact(),
                      Basis::kDefinition, "the node that the technique declares", false, [](ClaimRuns&) {
                          double bits = 0;
                          for (const Surface& surface : declared_cost("a_buffer").declaration.surfaces)
                              if (surface.layout == Layout::kPool) bits = 8.0 * surface.element_bytes();
                          return Finding{{bits}, {}, {{"", {bits}}}, "and a head of 32 bits a pixel"};
                      }});
    claims.push_back(
        {"cmp-passes-dual", kPaper, "Bavoil and Myers 2008",
         "Passes of dual depth peeling for 4, 8 and 16 layers", Printed::formula("L / 2 + 1", {3, 5, 9}),
         rule::exact(), Basis::kDefinition, "passes that the technique declares", false, [](ClaimRuns&) {
             std::vector<double> passes;
             for (const int layers : {4, 8, 16})
                 passes.push_back(
                     declared_cost(fmt::format("dual_depth_peeling:layers={}", layers)).geometry_passes);
             return Finding{passes, {}, {{"", passes}}, "two layers a pass, and one to begin"};
         }});
}

}  // namespace

void add_comparator_claims(std::vector<Claim>& claims) {
    for (const Comparator& row : kComparators) add_comparator(claims, row);
    add_lists_and_peeling(claims);
}

}  // namespace ropsim
