// What techniques do with light is what their formulas say, and how bright a pixel may be follows from it.
#include "analysis/stress/light_bound.h"
#include "analysis/stress/stress_inputs.h"
#include "analysis/stress/stress_variants.h"
#include "rop/single_pixel.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

LightLaw law(const std::string& technique) {
    return stress_techniques({technique}, false).front().variants.front().light;
}

// By the formulas: what divides a sum of all light by a sum of weights in which light without alpha has no
// part scales that light up, unless its weight is the least there is.
TEST(LightLaws, AreThoseOfTheFormulas) {
    for (const char* weight : {"eq7", "eq8", "eq9", "eq10", "blog2015", "none"}) {
        EXPECT_EQ(law(std::string("weighted_blended:weight=") + weight), LightLaw::kMean) << weight;
        EXPECT_EQ(law(std::string("phenomenological:form=alpha,weight=") + weight), LightLaw::kMean)
            << weight;
    }
    for (const char* weight : {"eq5", "listing", "g3d"})
        EXPECT_EQ(law(std::string("phenomenological:form=alpha,weight=") + weight), LightLaw::kMean)
            << weight;
    EXPECT_EQ(law("weighted_blended:weight=learnopengl,format=float32"), LightLaw::kScaled);
    EXPECT_EQ(law("phenomenological:form=alpha,weight=learnopengl,format=float32"), LightLaw::kScaled);
    // Sums in binary16 end, and what they end at is white.
    EXPECT_EQ(law("weighted_blended:weight=learnopengl"), LightLaw::kAdded);
    EXPECT_EQ(law("phenomenological:form=alpha,weight=learnopengl"), LightLaw::kAdded);
    for (const char* name : {"stochastic", "laine_karras"}) {
        const std::string text = name + std::string(":samples=8");
        EXPECT_EQ(law(text), LightLaw::kMean);
        EXPECT_EQ(law(text + ",correction=coverage"), LightLaw::kMean);
        EXPECT_EQ(law(text + ",method=depth_based"), LightLaw::kScaled);
        EXPECT_EQ(law(text + ",method=depth_based,correction=none"), LightLaw::kConserved);
        EXPECT_EQ(law(text + ",method=depth_based,correction=coverage"), LightLaw::kAdded);
    }
    EXPECT_EQ(law("slab:layers=8,bits=16"), LightLaw::kLayers);
    EXPECT_EQ(law("slab:layers=8,bits=16,composite=accumulated"), LightLaw::kConserved);
    EXPECT_EQ(law("slab:layers=8,bits=16,composite=normalised"), LightLaw::kScaled);
    EXPECT_EQ(law("adaptive:nodes=8"), LightLaw::kConserved);
    for (const char* memory : {"fixed", "shader", "variable"})
        EXPECT_EQ(law(std::string("adaptive:nodes=8,composite=normalised,memory=") + memory),
                  LightLaw::kScaled);
}

// And what they do: a dim light without alpha in front of thin, dark layers far behind comes out as it is, or
// brighter by far.
TEST(LightLaws, ScaledLightGrowsBrighter) {
    StressInput input = layer_input("even", 2, 1);
    input.pixels[0].background = glm::vec3(0.0f);
    input.pixels[0].fragments[0] = {0.0f, 0.01f, 0.01f, 0.01f, 0.0f, 0, 0, 0, 1, 0};
    input.pixels[0].fragments[1] = {1.0f, 0, 0, 0, 1e-4f, 0, 0, 1, 1, 0};
    for (const char* technique : {"weighted_blended:weight=", "phenomenological:form=alpha,weight="}) {
        for (const char* weight : {"eq7", "eq8", "eq9", "eq10", "blog2015", "none", "learnopengl"}) {
            const std::string text = technique + std::string(weight) + ",format=float32";
            const double color = make_single_pixel(text, input.header, 0)->run(input.pixels[0])[0];
            if (law(text) == LightLaw::kScaled) {
                EXPECT_GT(color, 1) << text;
            } else {
                EXPECT_LE(color, 0.01 * 1.001) << text;
            }
        }
    }
    // One sample, which the nearer of two layers takes: the other's alpha is in the total and not in the sum.
    input.pixels[0].fragments[1] = {0.5f, 0, 0, 0, 0.5f, 0, 0, 1, 1, 0};
    input.pixels[0].fragments.push_back({1.0f, 0, 0, 0, 0.5f, 0, 0, 2, 1, 0});
    double most = 0;
    for (std::uint64_t seed = 0; seed < 64; ++seed)
        most = std::max(most, make_single_pixel("stochastic:samples=1,method=depth_based,format=float32",
                                                input.header, seed)
                                  ->run(input.pixels[0])[0]);
    EXPECT_NEAR(most, 0.01 * 0.75 / 0.5, 1e-6);
}

// What comes out of layers and means is no brighter than the brightest of them however many there are; and
// what is let through beyond that, in coarse formats, is bounded.
TEST(LightBound, DoesNotGrowWithLayers) {
    const auto allowed = [](const std::string& technique, const std::string& formats, std::size_t layers) {
        const StressTechnique t = stress_techniques({technique}, true).front();
        const auto found = std::ranges::find(t.variants, formats, &StressVariant::formats);
        EXPECT_NE(found, t.variants.end()) << formats;
        return most_light(*found, light_of(layer_input("even", layers, 1).pixels[0]));
    };
    for (const char* technique : {"alpha_blend", "weighted_blended", "mlab:layers=2"}) {
        // One step of float32 a layer.
        EXPECT_LT(allowed(technique, "float32", 1000), 1.01) << technique;
        EXPECT_LT(allowed(technique, "float32", 100'000), 1.02) << technique;
    }
    EXPECT_LE(allowed("alpha_blend", "color r11g11b10", 100'000), 3.01);
    EXPECT_LE(allowed("weighted_blended", "paper", 100'000), 3.01) << "whatever is revealed";
    EXPECT_LE(allowed("mlab:layers=2", "paper", 100'000), 3.01);
    // 8-bit transmittances stall, and colours in floating point go on adding up.
    EXPECT_GT(allowed("mlab:layers=2", "transmittance unorm8", 100'000), 100);
    // None hides another.
    EXPECT_GT(allowed("adaptive:nodes=8", "float32", 1000), 4);
}

}  // namespace
}  // namespace ropsim
