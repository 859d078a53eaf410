// What the techniques that the papers compare themselves with declare, against sizes derived by hand from the
// formats that their papers and public code name: bits a pixel, passes, bytes of a fragment at worst.
#include "analysis/claims/declared_cost.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

// Bytes that a fragment reads and writes in one pass over the geometry: it reads and writes what it adds to,
// and reads what passes before left for it.
struct PassBytes {
    int read = 0, write = 0;
};
struct Expected {
    const char* technique;
    int bits;
    std::vector<PassBytes> passes;
};

constexpr int kHalfColor = 64;  // RGBA16F
constexpr int kHalfBytes = 8;

const std::vector<Expected>& expectations() {
    static const std::vector<Expected> all{
        // Porter and Duff 1984: RGBA16F.
        {"alpha_blend", kHalfColor, {{kHalfBytes, kHalfBytes}}},
        // Wyman and McGuire 2017: depth 32, RGBA8.
        {"hashed_alpha", 32 + 32, {{4, 4 + 4}}},
        // Enderton et al. 2011: depth 32 and RGBA8 a sample.
        {"stochastic:samples=8", 8 * (32 + 32), {{8 * 4, 8 * (4 + 4)}}},
        // Its depth-based method, corrected: depths, total alpha of R16F, sums of RGBA16F.
        {"stochastic:samples=8,method=depth_based",
         8 * 32 + 16 + kHalfColor,
         {{2, 2}, {8 * 4, 8 * 4}, {8 * 4 + kHalfBytes, kHalfBytes}}},
        // Laine and Karras 2011: a mask bit a sample and a counter of 32 beside them.
        {"laine_karras:samples=8", 8 * (32 + 32) + 8 + 32, {{8 * 4 + 1 + 4, 8 * (4 + 4) + 1 + 4}}},
        // Salvi et al. 2011: depth and transmittance of float32 a node, RGBA16F.
        {"adaptive:nodes=8", 8 * (32 + 32) + kHalfColor, {{8 * 8, 8 * 8}, {8 * 8 + kHalfBytes, kHalfBytes}}},
        // Wyman 2016: 8 bytes a layer.
        {"slab:layers=8", 8 * 64, {{8 * 8, 8 * 8}}},
        // Salvi and Vaidyanathan 2014: depth 32, RGB8, transmittance 8 a layer.
        {"mlab:layers=4", 4 * (32 + 24 + 8), {{4 * 8, 4 * 8}}},
        {"mlab:layers=8", 8 * (32 + 24 + 8), {{8 * 8, 8 * 8}}},
        // Intel 2014, one pass: the same a node, and a control word.
        {"aoit:nodes=4", 4 * (32 + 24 + 8) + 32, {{4 * 8 + 4, 4 * 8 + 4}}},
        // Bavoil et al. 2007: depth 32 and RGBA8 a layer, and their count.
        {"k_buffer:layers=4", 4 * (32 + 32) + 32, {{4 * 8 + 4, 4 * 8 + 4}}},
        // Maule et al. 2013: the same a layer, and a tail of RGBA16F.
        {"hybrid:layers=4", 4 * (32 + 32) + kHalfColor, {{4 * 8 + kHalfBytes, 4 * 8 + kHalfBytes}}},
        // McGuire and Bavoil 2013: RGBA16F, R8.
        {"weighted_blended", kHalfColor + 8, {{kHalfBytes + 1, kHalfBytes + 1}}},
        // Münstermann et al. 2018: moments and their sum, RGBA16F; a trigonometric one has two parts.
        {"moment_based:moments=4",
         (4 + 1) * 32 + kHalfColor,
         {{5 * 4, 5 * 4}, {5 * 4 + kHalfBytes, kHalfBytes}}},
        {"moment_based:moments=6,moment_format=unorm16",
         (6 + 1) * 16 + kHalfColor,
         {{7 * 2, 7 * 2}, {7 * 2 + kHalfBytes, kHalfBytes}}},
        {"moment_based:moments=6,basis=trigonometric",
         (2 * 3 + 1) * 32 + kHalfColor,
         {{7 * 4, 7 * 4}, {7 * 4 + kHalfBytes, kHalfBytes}}},
        {"moment_based:moments=8",
         (8 + 1) * 32 + kHalfColor,
         {{9 * 4, 9 * 4}, {9 * 4 + kHalfBytes, kHalfBytes}}},
        // Kim and Neumann 2001: two bounds, 16 planes of float32 between them, RGBA16F.
        {"opacity_map",
         2 * 32 + 16 * 32 + kHalfColor,
         {{8, 8}, {8 + 16 * 4, 16 * 4}, {8 + 16 * 4 + kHalfBytes, kHalfBytes}}},
        // Jansen and Bavoil 2010: two RGBA16F of coefficients, RGBA16F.
        {"fourier_map:bounds=frame", 2 * 64 + kHalfColor, {{16, 16}, {16 + kHalfBytes, kHalfBytes}}},
        // Aizenshtein et al. 2022: bounds, 16 coefficients of float16, RGBA16F.
        {"wavelet:rank=3",
         2 * 32 + 16 * 16 + kHalfColor,
         {{8, 8}, {8 + 16 * 2, 16 * 2}, {8 + 16 * 2 + kHalfBytes, kHalfBytes}}},
    };
    return all;
}

TEST(DeclaredBits, OfAPixelFollowFromTheFormats) {
    for (const Expected& row : expectations())
        EXPECT_EQ(declared_cost(row.technique).storage_bits, row.bits) << row.technique;
}

TEST(DeclaredBytes, OfAFragmentFollowFromThePasses) {
    for (const Expected& row : expectations()) {
        PassBytes sum;
        for (const PassBytes& pass : row.passes) {
            sum.read += pass.read;
            sum.write += pass.write;
        }
        const DeclaredCost cost = declared_cost(row.technique);
        EXPECT_EQ(cost.geometry_passes, static_cast<int>(row.passes.size())) << row.technique;
        EXPECT_EQ(cost.worst_case.read, static_cast<std::uint64_t>(sum.read)) << row.technique;
        EXPECT_EQ(cost.worst_case.write, static_cast<std::uint64_t>(sum.write)) << row.technique;
    }
}

// Yang et al. 2010: colour, depth and next of 32 bits each, and a head a pixel.
TEST(DeclaredBits, OfANodeOfPerPixelLists) {
    const DeclaredCost cost = declared_cost("a_buffer");
    std::vector<int> nodes;
    for (const Surface& surface : cost.declaration.surfaces)
        if (surface.layout == Layout::kPool) nodes.push_back(8 * surface.element_bytes());
    EXPECT_EQ(nodes, std::vector<int>{3 * 32});
    EXPECT_EQ(cost.storage_bits, 32);
}

// Bavoil and Myers 2008: two layers a pass, and one pass to begin.
TEST(DeclaredPasses, OfDualDepthPeeling) {
    for (const int layers : {4, 8, 16})
        EXPECT_EQ(declared_cost("dual_depth_peeling:layers=" + std::to_string(layers)).geometry_passes,
                  layers / 2 + 1);
}

}  // namespace
}  // namespace ropsim
