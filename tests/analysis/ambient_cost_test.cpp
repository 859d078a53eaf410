// The operations of Listing 2 as constants, against the counter that measures captured shaders.
#include "analysis/ambient_cost.h"

#include "capture/shader_cost/shader_cost.h"

#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

ShaderCost measured(const std::string& body) {
    const std::string shading = R"(
layout(binding = 0) uniform sampler2D u_depth;
layout(binding = 1) uniform sampler2D u_ambient;
uniform vec3 u_clip;
uniform ivec2 u_last;
in float v_alpha;
in float v_z;
vec2 tap(vec2 offset) {
    ivec2 at = clamp(ivec2(gl_FragCoord.xy + offset), ivec2(0), u_last);
    float z = u_clip.x / (u_clip.y * texelFetch(u_depth, at, 0).r + u_clip.z);
    float weight = 0.01 / (0.01 + abs(v_z - z));
    return vec2(texelFetch(u_ambient, at, 0).r * weight, weight);
}
vec4 shade() {
    vec2 slope = vec2(dFdx(v_alpha), dFdy(v_alpha));
    float steepness = length(slope);
    vec2 sum = vec2(0.0);
)" + body + "return vec4(0.0, 0.0, 0.0, clamp(sum.x / max(0.01, sum.y), 0.0, 1.0)); }\n";
    SceneDraw draw;
    draw.state.name = "listing";
    draw.shading = shading;
    for (int i = 0; i < 2; ++i) {
        SceneTexture texture;
        texture.width = texture.height = 1;
        texture.channels = 1;
        texture.values.assign(1, 1.0f);
        draw.textures.push_back(texture);
    }
    return measure_shader_cost(draw, false).alpha;
}

std::string line(int taps) {
    return fmt::format(
        "vec2 up = slope / steepness;\n"
        "for (int t = 0; t < {}; ++t) sum += tap(up * float(3 * t));\n",
        taps);
}
// The row's shift is a constant of the unrolled loop, which the optimiser does not see in |dy| & 1.
std::string box(int radius) {
    return fmt::format(
        "for (int dy = -{0}; dy <= {0}; ++dy)\n"
        "    for (int dx = -{0}; dx <= {0}; ++dx)\n"
        "        sum += tap(2.0 * vec2(float(dx) + (dy % 2 != 0 ? 0.5 : -0.5), float(dy)));\n",
        radius);
}

TEST(AmbientCostTest, OperationsOfTheListing) {
    constexpr std::uint32_t kComparison = 1;
    constexpr std::uint32_t kGradient = 2 + 3 + kComparison;  // with its length
    for (const int taps : {2, 12}) {
        InferenceSettings settings;
        settings.line_taps = taps;
        const ShaderCost cost = measured(line(taps));
        EXPECT_EQ(line_cost(settings, 1).alu_instructions, cost.alu_instructions + kComparison) << taps;
        EXPECT_EQ(line_cost(settings, 1).texture_fetches, cost.texture_fetches) << taps;
    }
    for (const int radius : {1, 3}) {
        InferenceSettings settings;
        settings.box_radius = radius;
        const ShaderCost cost = measured(box(radius));
        EXPECT_EQ(box_cost(settings, 1).alu_instructions, cost.alu_instructions + kGradient) << radius;
        EXPECT_EQ(box_cost(settings, 1).texture_fetches, cost.texture_fetches) << radius;
    }
    const ShaderCost both = measured("if (steepness < 1e-4) {" + box(3) + "} else {" + line(12) + "}\n");
    EXPECT_EQ(divergent_cost({}, 1).alu_instructions, both.alu_instructions);
    EXPECT_EQ(divergent_cost({}, 1).texture_fetches, both.texture_fetches);
}

TEST(AmbientCostTest, PublishedListing) {
    const ShaderCost line = line_cost({}, 1);
    EXPECT_EQ(line.texture_fetches, 24u);
    EXPECT_EQ(line.texture_bytes, 12u * 5u);
    EXPECT_EQ(line.alu_instructions, 202u);
    const ShaderCost box = box_cost({}, 1);
    EXPECT_EQ(box.texture_fetches, 98u);
    EXPECT_EQ(box.texture_bytes, 49u * 5u);
    EXPECT_EQ(box.alu_instructions, 792u);
    EXPECT_EQ(box_cost({}, 4).texture_bytes, 49u * 8u);
}

}  // namespace
}  // namespace ropsim
