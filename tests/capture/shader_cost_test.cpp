// Shader costs against counts made by hand.
#include "capture/shader_cost/shader_cost.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

ShaderCosts costs(const std::string& shading, bool materials = false, const std::vector<int>& channels = {}) {
    SceneDraw draw;
    draw.state.name = "test";
    draw.shading = shading;
    for (int count : channels) {
        SceneTexture texture;
        texture.width = texture.height = 1;
        texture.channels = count;
        texture.values.assign(static_cast<std::size_t>(count), 1.0f);
        draw.textures.push_back(texture);
    }
    return measure_shader_cost(draw, materials);
}

// What `expression` (a float made of float v, vec3 p, vec3 q, int i) costs by itself.
std::uint32_t cost_of(const std::string& expression) {
    return costs(
               "in float v; in vec3 p; in vec3 q; flat in int i; flat in int j; flat in uint u;\n"
               "vec4 shade() { return vec4(0.0, 0.0, 0.0, " +
               expression + "); }\n")
        .alpha.alu_instructions;
}

TEST(ShaderCostTest, PremultiplyingIsAllThatAConstantColourCosts) {
    const ShaderCosts constant = costs("uniform vec4 u_color; vec4 shade() { return u_color; }");
    EXPECT_EQ(constant.full.alu_instructions, 3u);
    EXPECT_EQ(constant.alpha.alu_instructions, 0u);
    EXPECT_EQ(constant.full.texture_fetches, 0u);
    EXPECT_EQ(constant.full.texture_bytes, 0u);
    EXPECT_THAT(constant.source,
                ::testing::MatchesRegex("SPIR-V of the draw's GLSL after optimisation \\(glslang "
                                        "[0-9.]+, SPIRV-Tools v[0-9.]+\\): scalar operations, "
                                        "both sides of branches"));
}

TEST(ShaderCostTest, OperationsCountTheirComponents) {
    EXPECT_EQ(cost_of("v"), 0u);
    EXPECT_EQ(cost_of("v + p.x"), 1u);
    EXPECT_EQ(cost_of("-v"), 0u) << "a source modifier";
    EXPECT_EQ(cost_of("abs(v)"), 0u);
    EXPECT_EQ(cost_of("v / p.x"), 2u) << "reciprocal and product";
    EXPECT_EQ(cost_of("dot(p, q)"), 3u);
    EXPECT_EQ(cost_of("dot(p + q, q)"), 6u);
    EXPECT_EQ(cost_of("sqrt(v)"), 1u);
    EXPECT_EQ(cost_of("pow(v, p.x)"), 3u);
    EXPECT_EQ(cost_of("exp(v)"), 2u);
    EXPECT_EQ(cost_of("sin(v)"), 2u);
    EXPECT_EQ(cost_of("length(p)"), 4u) << "dot product and square root";
    EXPECT_EQ(cost_of("dot(normalize(p), q)"), 7u + 3u);
    EXPECT_EQ(cost_of("clamp(v, p.x, p.y)"), 1u);
    EXPECT_EQ(cost_of("mix(v, p.x, p.y)"), 2u);
    EXPECT_EQ(cost_of("smoothstep(p.x, p.y, v)"), 7u);
    EXPECT_EQ(cost_of("mod(v, p.x)"), 4u);
    EXPECT_EQ(cost_of("float(i * j)"), 2u) << "product and conversion";
    EXPECT_EQ(cost_of("float(i / j)"), 21u);
    EXPECT_EQ(cost_of("v > p.x ? p.y : p.z"), 2u) << "comparison and selection";
    EXPECT_EQ(cost_of("dot(mat3(p, q, p) * q, p)"), 9u + 3u);
    EXPECT_EQ(cost_of("fwidth(v)"), 3u);
}

TEST(ShaderCostTest, AProductThatOnlyASumUsesIsFused) {
    EXPECT_EQ(cost_of("v * p.x + p.y"), 1u);
    EXPECT_EQ(cost_of("v * p.x - p.y * p.z"), 2u);
    EXPECT_EQ(cost_of("v * p.x + 1.0 / (v * p.x)"), 1u + 2u + 1u) << "the product is used twice";
    EXPECT_EQ(cost_of("dot(p * v + q, q)"), 3u + 3u);
}

TEST(ShaderCostTest, OnlyWantedComponentsCount) {
    const ShaderCosts modulated =
        costs("in vec4 v_a; in vec4 v_b; vec4 shade() { return sqrt(v_a * v_b) + v_b.wzyx; }");
    EXPECT_EQ(modulated.full.alu_instructions, 12u + 3u);
    EXPECT_EQ(modulated.alpha.alu_instructions, 3u);
    const ShaderCosts lit = costs(
        "in vec3 v_n; in vec4 v_c; vec4 shade() {\n"
        "  vec3 n = normalize(v_n); float l = max(dot(n, vec3(0.6, 0.8, 0.1)), 0.0);\n"
        "  return vec4(v_c.rgb * l, v_c.a * v_c.a); }");
    // normalize 7, dot 3, max 1, colour 3, alpha 1, premultiplication 3.
    EXPECT_EQ(lit.full.alu_instructions, 18u);
    EXPECT_EQ(lit.alpha.alu_instructions, 1u);
}

TEST(ShaderCostTest, DiscardAndWhatDecidesItStay) {
    const ShaderCosts cut = costs(
        "in vec2 v_p; in vec4 v_c; vec4 shade() {\n"
        "  if (dot(v_p, v_p) > 1.0) discard;\n  return vec4(v_c.rgb + 1.0, 0.5); }");
    EXPECT_EQ(cut.alpha.alu_instructions, 2u + 1u);
    EXPECT_EQ(cut.full.alu_instructions, 3u + 3u + 3u);
}

TEST(ShaderCostTest, BothSidesOfABranchCount) {
    const ShaderCosts branch = costs(
        "in vec4 v_c; vec4 shade() { float a;\n"
        "  if (v_c.x > v_c.y) a = sin(v_c.z) * v_c.x; else a = sqrt(v_c.w) / v_c.y;\n"
        "  return vec4(0.0, 0.0, 0.0, a); }");
    // comparison 1, sine 2 and product 1, square root 1 and division 2; perhaps a selection instead of the
    // branch.
    EXPECT_GE(branch.alpha.alu_instructions, 7u);
    EXPECT_LE(branch.alpha.alu_instructions, 8u);
}

TEST(ShaderCostTest, LoopsOfConstantLengthAreUnrolledOthersAssumed) {
    const std::string start =
        "in float v; flat in int n; vec4 shade() { float a = v;\n  for (int i = 0; i < ";
    const std::string end = "; ++i) a = sqrt(a);\n  return vec4(0.0, 0.0, 0.0, a); }";
    const ShaderCosts four = costs(start + "4" + end);
    EXPECT_EQ(four.alpha.alu_instructions, 4u);
    EXPECT_EQ(four.source.find("loops"), std::string::npos);
    const ShaderCosts unknown = costs(start + "n" + end);
    EXPECT_EQ(unknown.alpha.alu_instructions, 8u * 3u) << "comparison, square root, increment";
    EXPECT_THAT(unknown.source, ::testing::EndsWith("loops without a constant trip count 8 times"));
    const ShaderCosts nested = costs(
        "in float v; flat in int n; vec4 shade() { float a = v;\n"
        "  for (int i = 0; i < n; ++i) { for (int k = 0; k < n; ++k) a = sqrt(a); }\n"
        "  return vec4(0.0, 0.0, 0.0, a); }");
    EXPECT_EQ(nested.alpha.alu_instructions, 8u * (2u + 8u * 3u));
}

TEST(ShaderCostTest, TexturesCountTexelsTimesTheirBytes) {
    const std::string textures =
        "in vec2 v_t; layout(binding = 0) uniform sampler2D u_a; layout(binding = 1) uniform sampler2D "
        "u_b;\n";
    const ShaderCosts trilinear =
        costs(textures + "vec4 shade() { return vec4(texture(u_b, v_t).rgb, texture(u_a, v_t).r); }", false,
              {1, 4});
    EXPECT_EQ(trilinear.full.texture_fetches, 2u);
    EXPECT_EQ(trilinear.full.texture_bytes, 8u * 4u + 8u * 1u);
    EXPECT_EQ(trilinear.alpha.texture_fetches, 1u);
    EXPECT_EQ(trilinear.alpha.texture_bytes, 8u);
    const ShaderCosts one_level =
        costs(textures + "vec4 shade() { return textureLod(u_b, v_t, 0.0) + texelFetch(u_a, ivec2(3), 0); }",
              false, {1, 4});
    EXPECT_EQ(one_level.full.texture_fetches, 2u);
    EXPECT_EQ(one_level.full.texture_bytes, 4u * 4u + 1u);
    const ShaderCosts between =
        costs(textures + "vec4 shade() { return textureLod(u_b, v_t, v_t.x); }", false, {1, 4});
    EXPECT_EQ(between.full.texture_bytes, 8u * 4u);
    const ShaderCosts looped = costs(
        textures +
            "vec4 shade() { float s = 0.0; for (int i = 0; i < 5; ++i) s += textureLod(u_a, v_t * float(i), "
            "0.0).r; return vec4(s); }",
        false, {1, 4});
    EXPECT_EQ(looped.alpha.texture_fetches, 5u);
    EXPECT_EQ(looped.alpha.texture_bytes, 5u * 4u);
}

TEST(ShaderCostTest, MaterialsCountWhereTheyAreRecorded) {
    const std::string shading =
        "in vec3 v_n; uniform vec4 u_c; vec4 shade() { surface_normal = normalize(v_n);\n"
        "  surface_transmission = u_c.rgb * u_c.r; return u_c; }";
    EXPECT_EQ(costs(shading).full.alu_instructions, 3u);
    EXPECT_EQ(costs(shading, true).full.alu_instructions, 3u + 3u + 7u);
    EXPECT_EQ(costs(shading, true).alpha.alu_instructions, 0u);
}

}  // namespace
}  // namespace ropsim
