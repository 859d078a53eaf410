// Puts the draw's GLSL between the common declarations and a main for each variant, compiles and counts.
#include "capture/shader_cost/shader_cost.h"

#include "capture/shader_cost/shader_compiler.h"
#include "capture/shader_cost/spirv_cost.h"
#include "capture/shader_sources.h"

#include <map>
#include <mutex>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace ropsim {
namespace {

using Key = std::tuple<std::string, std::vector<std::uint32_t>, bool>;

SpirvCost cost_of(const SceneDraw& draw, std::string_view variant,
                  const std::vector<std::uint32_t>& texel_bytes) {
    const std::string glsl = fmt::format("#version 450 core\n{}{}\n{}", shader_source("surface"),
                                         draw.shading, shader_source(variant));
    const SpirvModule module(compile_fragment_shader(draw.state.name, glsl));
    return count_spirv_cost(module, texel_bytes);
}

}  // namespace

ShaderCosts measure_shader_cost(const SceneDraw& draw, bool materials) {
    static std::mutex mutex;
    static std::map<Key, ShaderCosts> known;
    // R8 or RGBA8.
    std::vector<std::uint32_t> texel_bytes;
    for (const SceneTexture& texture : draw.textures)
        texel_bytes.push_back(static_cast<std::uint32_t>(texture.channels));
    const std::scoped_lock lock(mutex);
    const auto [entry, is_new] = known.try_emplace(Key(draw.shading, texel_bytes, materials));
    if (is_new) {
        const SpirvCost full = cost_of(draw, materials ? "cost_material" : "cost_full", texel_bytes);
        const SpirvCost alpha = cost_of(draw, "cost_alpha", texel_bytes);
        std::string source = fmt::format(
            "SPIR-V of the draw's GLSL after optimisation ({}): scalar operations, both sides of branches",
            shader_compiler_version());
        if (full.assumed_loops > 0)
            source += fmt::format(", loops without a constant trip count {} times", kAssumedTrips);
        entry->second = {full.cost, alpha.cost, std::move(source)};
    }
    return entry->second;
}

}  // namespace ropsim
