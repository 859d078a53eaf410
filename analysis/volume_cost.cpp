#include "analysis/volume_cost.h"

#include "capture/shader_cost/shader_compiler.h"
#include "capture/shader_cost/spirv_cost.h"

#include <fmt/format.h>

namespace ropsim {
namespace {

// The march as an application writes it. Depth and shadow map are single channels of 4 bytes.
constexpr const char* kMarch = R"(
layout(binding = 0) uniform sampler2D u_depth;   // of the opaque layer
layout(binding = 1) uniform sampler2D u_shadow;  // the light's
uniform vec4 u_ends;        // of the march: near and far in metres; 1 over the number of steps
uniform mat4 u_to_world;    // window coordinates to the world
uniform mat4 u_to_light;    // world to the light's texels and depth
uniform vec4 u_depth_law;   // window depth is x + y / (distance from the eye's plane)
uniform vec4 u_eye;         // place in the world
uniform vec4 u_view;        // the eye's axis
uniform vec4 u_medium;      // extinction, per metre, over ln 2; anisotropy; falloff; base height
uniform vec4 u_albedo;
uniform vec4 u_ambient;     // over the albedo
uniform vec4 u_light;       // colour, over the albedo
uniform vec4 u_light_place; // direction or place

float phase(float cosine) {
    float g = u_medium.y;
    float d = 1.0 + g * g - 2.0 * g * cosine;
    float r = inversesqrt(d);
    return (1.0 - g * g) * 0.0795774715 * r * r * r;
}

float random(uvec2 pixel) {  // a hash of the pixel
    uint h = pixel.x * 0x9E3779B9u ^ pixel.y * 0x85EBCA6Bu;
    h ^= h >> 16; h *= 0x7FEB352Du; h ^= h >> 15; h *= 0x846CA68Bu; h ^= h >> 16;
    return float(h >> 8) * (1.0 / 16777216.0);
}

struct Ray { vec3 direction; float planar; float first; float step; float optical; float phase; };

Ray make_ray() {
    Ray ray;
    float depth = texelFetch(u_depth, ivec2(gl_FragCoord.xy), 0).r;
    vec4 end = u_to_world * vec4(gl_FragCoord.xy, depth, 1.0);
    vec3 along = end.xyz / end.w - u_eye.xyz;
    float units = inversesqrt(dot(along, along));
    ray.direction = along * units;
    ray.planar = dot(ray.direction, u_view.xyz);
    float far = min(1.0 / units, u_ends.y);
    ray.step = max(far - u_ends.x, 0.0) * u_ends.z;
    ray.first = u_ends.x;
#ifdef JITTER
    ray.first += ray.step * random(uvec2(gl_FragCoord.xy));
#else
    ray.first += 0.5 * ray.step;
#endif
    ray.optical = u_medium.x * ray.step;
#if defined(LIGHT) && !defined(POINT_LIGHT)
    ray.phase = phase(-dot(ray.direction, u_light_place.xyz));
#endif
    return ray;
}

struct Step { vec4 color; float depth; };

Step march_step(Ray ray, float number) {
    Step result;
    float distance = ray.first + number * ray.step;
    vec3 position = u_eye.xyz + ray.direction * distance;
    float optical = ray.optical;
#ifdef FALLOFF
    optical *= exp2(-max(position.y - u_medium.w, 0.0) * u_medium.z);
#endif
    float alpha = 1.0 - exp2(-optical);
    vec3 source = u_ambient.rgb;
#ifdef LIGHT
    float lit = ray.phase;
#ifdef POINT_LIGHT
    vec3 away = position - u_light_place.xyz;
    float nearness = inversesqrt(max(dot(away, away), u_light_place.w));
    lit = phase(-dot(ray.direction, away) * nearness) * nearness * nearness;
#endif
#ifdef SHADOW
    vec4 at = u_to_light * vec4(position, 1.0);
#ifdef POINT_LIGHT
    at.xyz /= at.w;
#endif
    float visible = 0.0;
    for (int y = 0; y < SHADOW; ++y)
        for (int x = 0; x < SHADOW; ++x)
            visible += at.z <= texelFetch(u_shadow, ivec2(at.xy) + ivec2(x, y), 0).r ? 1.0 : 0.0;
    lit *= visible * (1.0 / float(SHADOW * SHADOW));
#endif
    source += u_light.rgb * lit;
#endif
    result.color = vec4(source * alpha, alpha);
    result.depth = u_depth_law.x + u_depth_law.y / (distance * ray.planar);
    return result;
}
)";

std::string main_of(int steps, bool full) {
    std::string outputs, body;
    for (int i = 0; i < steps; ++i) {
        outputs += fmt::format("layout(location = {}) out {} o_{};\n", i, full ? "vec4" : "float", i);
        if (full) outputs += fmt::format("layout(location = {}) out float o_depth_{};\n", steps + i, i);
        body += fmt::format("    Step step_{0} = march_step(ray, {0}.0);\n    o_{0} = step_{0}.color{1};\n",
                            i, full ? "" : ".a");
        if (full) body += fmt::format("    o_depth_{0} = step_{0}.depth;\n", i);
    }
    return outputs + "void main() {\n    Ray ray = make_ray();\n" + body + "}\n";
}

ShaderCost cost_of(const VolumeShader& shader, int steps, bool full) {
    std::string text = "#version 450 core\n";
    if (shader.falloff) text += "#define FALLOFF\n";
    if (shader.light) text += "#define LIGHT\n";
    if (shader.light && shader.point_light) text += "#define POINT_LIGHT\n";
    if (shader.light && shader.shadow_texels > 0)
        text += fmt::format("#define SHADOW {}\n", shader.shadow_texels);
    if (shader.jitter) text += "#define JITTER\n";
    const SpirvModule module(compile_fragment_shader("volume", text + kMarch + main_of(steps, full)));
    return count_spirv_cost(module, {4, 4}).cost;
}

// A shader of one step and one of two tell a step from what happens once.
ShaderCost share(const ShaderCost& one, const ShaderCost& two, int steps) {
    const auto of = [&](std::uint32_t first, std::uint32_t both) {
        const std::uint32_t step = both - first;
        const std::uint32_t once = first - step;
        const auto count = static_cast<std::uint32_t>(steps);
        return step + (once + count / 2) / count;
    };
    return {of(one.alu_instructions, two.alu_instructions), of(one.texture_fetches, two.texture_fetches),
            of(one.texture_bytes, two.texture_bytes)};
}

}  // namespace

VolumeCost measure_volume_cost(const VolumeShader& shader) {
    VolumeCost cost;
    cost.full = share(cost_of(shader, 1, true), cost_of(shader, 2, true), shader.steps);
    cost.alpha = share(cost_of(shader, 1, false), cost_of(shader, 2, false), shader.steps);
    cost.source = fmt::format(
        "SPIR-V of the march's GLSL after optimisation ({}): a step's scalar operations, and 1/{} of a "
        "pixel's",
        shader_compiler_version(), shader.steps);
    return cost;
}

}  // namespace ropsim
