// The technique `colored_shadow_map`: each wavelength's depths against their probabilities, and the bytes
// that its draws let through.
#include "rop/shadow/shadow_map.h"
#include "tests/rop/random_fragments.h"

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::fragment_at;
using test::TestFrame;

constexpr int kSide = 96;
constexpr double kTexels = kSide * kSide;
constexpr std::array<const char*, 3> kSurfaces = {"depth_red", "depth_green", "depth_blue"};

TraceHeader light_view() {
    TraceHeader header = test::header_of(kSide, kSide);
    header.materials = true;
    return header;
}

// `layers` in every texel, one primitive each, of draw 0.
struct Layer {
    float z;
    float alpha;
    std::array<float, 3> transmission;
};
void draw(TestFrame& frame, const std::vector<Layer>& layers, bool materials = true) {
    std::vector<Fragment> fragments;
    std::vector<Material> described;
    for (std::size_t l = 0; l < layers.size(); ++l)
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x) {
                fragments.push_back(fragment_at(x, y, layers[l].z, layers[l].alpha, {1, 1, 1},
                                                static_cast<std::uint32_t>(l)));
                Material m;
                for (std::size_t c = 0; c < 3; ++c) m.transmission[c] = layers[l].transmission[c];
                described.push_back(m);
            }
    frame.draw(fragments, {}, materials ? described : std::vector<Material>{});
}

StoredShadowMap depths(TestFrame& frame, const std::string& surface) {
    return stored_depths_of(frame.declaration(), frame.stores(), frame.header(), surface);
}

double share(const StoredShadowMap& map, float depth) {
    double count = 0;
    for (const float z : map.depths) count += z == depth ? 1 : 0;
    return count / static_cast<double>(map.depths.size());
}

double five_deviations(double p, double draws) {
    return 5 * std::sqrt(p * (1 - p) / draws);
}

TEST(ColoredShadowMap, EachWavelengthKeepsTheNearestDepthItDrew) {
    // Far layer first: order must not matter.
    const std::vector<Layer> layers = {{0.5f, 0.5f, {0.0f, 0.25f, 1.0f}}, {0.25f, 0.8f, {0.75f, 0.5f, 0.0f}}};
    for (const std::string draws : {"separate", "shared"}) {
        TestFrame frame("colored_shadow_map:samples=4,empty=far,draws=" + draws, light_view(), 7);
        draw(frame, layers);
        for (std::size_t c = 0; c < 3; ++c) {
            const double near = static_cast<double>(layers[1].alpha * (1 - layers[1].transmission[c]));
            const double far =
                (1 - near) * static_cast<double>(layers[0].alpha * (1 - layers[0].transmission[c]));
            const StoredShadowMap map = depths(frame, kSurfaces[c]);
            ASSERT_EQ(map.samples, 4);
            EXPECT_NEAR(share(map, 0.25f), near, five_deviations(near, 4 * kTexels) + 1e-7) << c << draws;
            EXPECT_NEAR(share(map, 0.5f), far, five_deviations(far, 4 * kTexels) + 1e-7) << c << draws;
            EXPECT_NEAR(share(map, 1.0f), 1 - near - far,
                        five_deviations(1 - near - far, 4 * kTexels) + 1e-7);
        }
    }
}

// An unfiltered texel's visibility behind one layer is rho's coin: variance rho (1 - rho) / S.
TEST(ColoredShadowMap, ATexelHasTheVarianceOfItsCoins) {
    for (const int samples : {1, 4, 16}) {
        TestFrame frame("colored_shadow_map:samples=" + std::to_string(samples), light_view(), 3);
        draw(frame, {{0.5f, 0.8f, {0.75f, 0.5f, 0.25f}}});
        for (std::size_t c = 0; c < 3; ++c) {
            const double rho = 0.8 * (0.25 + 0.25 * static_cast<double>(c));
            const StoredShadowMap map = depths(frame, kSurfaces[c]);
            double squares = 0;
            for (int y = 0; y < kSide; ++y)
                for (int x = 0; x < kSide; ++x) {
                    const double error = stochastic_visibility(map, x, y, 0.75) - (1 - rho);
                    squares += error * error / kTexels;
                }
            const double variance = rho * (1 - rho) / samples;
            // Fourth moment of a mean of S coins about its expectation.
            const double s = samples;
            const double fourth = rho * (1 - rho) * (1 + 3 * (s - 2) * rho * (1 - rho)) / (s * s * s);
            EXPECT_NEAR(squares, variance, 5 * std::sqrt((fourth - variance * variance) / kTexels));
        }
    }
}

// Grey glass: separate draws colour its noise, shared ones do not.
TEST(ColoredShadowMap, SharedDrawsMakeGreyNoise) {
    for (const bool shared : {false, true}) {
        TestFrame frame(std::string("colored_shadow_map:draws=") + (shared ? "shared" : "separate"),
                        light_view(), 3);
        draw(frame, {{0.5f, 0.6f, {0.5f, 0.5f, 0.0f}}});
        const StoredShadowMap red = depths(frame, "depth_red");
        const StoredShadowMap green = depths(frame, "depth_green");
        const StoredShadowMap blue = depths(frame, "depth_blue");
        double red_green = 0;
        double red_blue = 0;
        for (std::size_t i = 0; i < red.depths.size(); ++i) {
            red_green += red.depths[i] == 0.5f && green.depths[i] == 0.5f ? 1 / kTexels : 0;
            red_blue += red.depths[i] == 0.5f && blue.depths[i] == 0.5f ? 1 / kTexels : 0;
        }
        const double expected_green = shared ? 0.3 : 0.3 * 0.3;
        const double expected_blue = shared ? 0.3 : 0.3 * 0.6;
        EXPECT_NEAR(red_green, expected_green, five_deviations(expected_green, kTexels));
        EXPECT_NEAR(red_blue, expected_blue, five_deviations(expected_blue, kTexels));
    }
}

TEST(ColoredShadowMap, OneWavelengthTakesTheMeanAndAlphaAloneWithoutMaterials) {
    for (const bool materials : {true, false}) {
        TraceHeader header = light_view();
        header.materials = materials;
        TestFrame frame("colored_shadow_map:wavelengths=1", header, 3);
        EXPECT_EQ(frame.declaration().storage_bits_per_pixel(), 32);
        draw(frame, {{0.5f, 0.6f, {0.75f, 0.5f, 0.25f}}}, materials);
        const double rho = materials ? 0.3 : 0.6;
        EXPECT_NEAR(share(depths(frame, "depth"), 0.5f), rho, five_deviations(rho, kTexels));
    }
}

TEST(ColoredShadowMap, CausticsThinTheShadowOfGlassThatFacesTheLight) {
    TestFrame frame("colored_shadow_map:wavelengths=1", light_view(), 3);
    std::vector<Fragment> fragments;
    std::vector<Material> described;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            fragments.push_back(fragment_at(x, y, 0.5f, 0.5f, {1, 1, 1}));
            Material m;
            m.eta = 1.5f;
            if (x >= kSide / 2) m.normal[0] = 1, m.normal[2] = 0;
            described.push_back(m);
        }
    frame.draw(fragments, {}, described);
    const StoredShadowMap map = depths(frame, "depth");
    std::array<double, 2> shadowed{};  // facing the light, and along its rays
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
            shadowed[x < kSide / 2 ? 0 : 1] += map.depths[map.texel(x, y)] == 0.5f ? 2 / kTexels : 0;
    const double strength = std::pow(0.25, 0.2);
    for (const auto& [got, rho] :
         {std::pair(shadowed[0], 0.5 * (1 - strength)), std::pair(shadowed[1], 0.5 * (1 + strength))})
        EXPECT_NEAR(got, rho, five_deviations(rho, kTexels / 2));
}

TEST(ColoredShadowMap, WhatKeptNothingHoldsTheFarPlaneOrTheOpaqueLayer) {
    TraceHeader header = light_view();
    header.opaque.emplace();
    header.opaque->rgb.assign(std::size_t{3} * kSide * kSide, 1.0f);
    header.opaque->depth.assign(std::size_t{kSide} * kSide, 0.75f);
    for (const bool opaque : {false, true}) {
        TestFrame frame(std::string("colored_shadow_map:empty=") + (opaque ? "opaque" : "far"), header, 1);
        draw(frame, {{0.5f, 0.25f, {0, 0, 0}}});
        EXPECT_NEAR(share(depths(frame, "depth_green"), opaque ? 0.75f : 1.0f), 0.75,
                    five_deviations(0.25, kTexels));
    }
}

TEST(ColoredShadowMap, OnlyDrawsThatAreWonTouchMemory) {
    TestFrame frame("colored_shadow_map:samples=2", light_view(), 1);
    // Red passes, green is caught, blue is caught half of the time; then a layer behind that is always
    // caught.
    draw(frame, {{0.5f, 1.0f, {1.0f, 0.0f, 0.5f}}, {0.75f, 1.0f, {1.0f, 0.0f, 1.0f}}});
    const double draws = 2 * kTexels;
    EXPECT_EQ(frame.log().read_elements(0), 0u);
    EXPECT_EQ(frame.log().write_elements(0), 0u);
    EXPECT_EQ(static_cast<double>(frame.log().read_elements(1)), 2 * draws);
    EXPECT_EQ(static_cast<double>(frame.log().write_elements(1)), draws) << "the far layer is not nearer";
    const auto blue = static_cast<double>(frame.log().read_elements(2));
    EXPECT_NEAR(blue / draws, 0.5, five_deviations(0.5, draws));
    EXPECT_EQ(static_cast<double>(frame.log().write_elements(2)), blue);
}

TEST(ColoredShadowMap, SeedsOfObjectsIgnoreThePrimitive) {
    const auto red_of = [](const std::string& seed_from, std::uint32_t primitive) {
        TestFrame frame("colored_shadow_map:seed_from=" + seed_from, light_view(), 5);
        std::vector<Fragment> fragments;
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x)
                fragments.push_back(fragment_at(x, y, 0.5f, 0.5f, {1, 1, 1}, primitive));
        frame.draw(fragments);
        return depths(frame, "depth_red").depths;
    };
    EXPECT_EQ(red_of("object", 1), red_of("object", 2));
    EXPECT_NE(red_of("primitive", 1), red_of("primitive", 2));
}

}  // namespace
}  // namespace ropsim
