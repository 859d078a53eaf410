// Weights blocks by their loops, then adds up what each live instruction costs.
#include "capture/shader_cost/spirv_cost.h"

#include "base/error.h"
#include "capture/shader_cost/spirv_cost_table.h"
#include "capture/shader_cost/spirv_liveness.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <unordered_map>
#include <unordered_set>

#include <glslang/SPIRV/spirv.hpp>

namespace ropsim {
namespace {

// Labels of the blocks that can be reached from the head of a loop without leaving it.
std::unordered_set<std::uint32_t> loop_body(
    const SpirvBlock& head, const std::unordered_map<std::uint32_t, const SpirvBlock*>& by_label) {
    std::unordered_set<std::uint32_t> reached = {head.label};
    std::vector<std::uint32_t> pending = {head.label};
    while (!pending.empty()) {
        const SpirvBlock& block = *by_label.at(pending.back());
        pending.pop_back();
        for (std::uint32_t next : block.successors)
            if (next != head.loop_merge && reached.insert(next).second) pending.push_back(next);
    }
    return reached;
}

// How often each block runs.
std::vector<std::uint32_t> block_weights(const SpirvModule& module, std::uint32_t& loops) {
    std::unordered_map<std::uint32_t, const SpirvBlock*> by_label;
    for (const SpirvBlock& block : module.blocks()) by_label[block.label] = &block;
    std::vector<std::uint32_t> weights(module.blocks().size(), 1);
    for (const SpirvBlock& head : module.blocks()) {
        if (head.loop_merge == 0) continue;
        ++loops;
        const auto body = loop_body(head, by_label);
        for (std::size_t i = 0; i < weights.size(); ++i)
            if (body.contains(module.blocks()[i].label)) weights[i] *= kAssumedTrips;
    }
    return weights;
}

// Whether `id` is a product that becomes part of a multiply-add.
bool lone_product(const SpirvModule& module, std::uint32_t id,
                  const std::unordered_map<std::uint32_t, std::uint32_t>& uses) {
    const SpirvInstruction* made = module.definition(id);
    return made != nullptr && (made->opcode == spv::OpFMul || made->opcode == spv::OpVectorTimesScalar) &&
           uses.at(id) == 1;
}

bool fused(const SpirvModule& module, const SpirvInstruction& instruction,
           const std::unordered_map<std::uint32_t, std::uint32_t>& uses) {
    return (instruction.opcode == spv::OpFAdd || instruction.opcode == spv::OpFSub) &&
           (lone_product(module, instruction.operands[0], uses) ||
            lone_product(module, instruction.operands[1], uses));
}

// The variable behind a sampled image: loaded directly, or picked from an array of samplers.
std::uint32_t texture_bytes(const SpirvModule& module, std::uint32_t image,
                            const std::vector<std::uint32_t>& bytes_a_texel) {
    const SpirvInstruction* made = module.definition(image);
    while (made != nullptr && (made->opcode == spv::OpImage || made->opcode == spv::OpLoad))
        made = module.definition(made->operands[0]);
    constexpr std::uint32_t kUnknown = ~0u;
    std::uint32_t element = 0;
    if (made != nullptr && made->opcode == spv::OpAccessChain) {
        element = module.constant_bits(made->operands[1], kUnknown);
        made = module.definition(made->operands[0]);
    }
    CHECK(made != nullptr && made->opcode == spv::OpVariable, "a texture that is no variable");
    const std::uint32_t binding = module.decoration(made->result, spv::DecorationBinding, 0);
    // Any texture of the array may be meant: the widest counts.
    if (element == kUnknown) return *std::max_element(bytes_a_texel.begin(), bytes_a_texel.end());
    CHECK(binding + element < bytes_a_texel.size(), "the shader reads texture {}, the draw has {}",
          binding + element, bytes_a_texel.size());
    return bytes_a_texel[binding + element];
}

// Texels that an image instruction reads; 0 where it is none.
std::uint32_t texels(const SpirvModule& module, const SpirvInstruction& instruction) {
    constexpr std::uint32_t kBilinear = 4;
    constexpr std::uint32_t kTrilinear = 8;
    switch (instruction.opcode) {
        case spv::OpImageFetch:
            return 1;
        case spv::OpImageGather:
        case spv::OpImageDrefGather:
            return kBilinear;
        case spv::OpImageSampleImplicitLod:
        case spv::OpImageSampleProjImplicitLod:
            return kTrilinear;
        case spv::OpImageSampleExplicitLod:
        case spv::OpImageSampleProjExplicitLod: {
            // Image, coordinate, mask of operands, level (or gradients). Between two levels both are read.
            if ((instruction.operands[2] & spv::ImageOperandsLodMask) == 0) return kTrilinear;
            constexpr std::uint32_t kNotConstant = 0x7FC00000;  // NaN
            const float level =
                std::bit_cast<float>(module.constant_bits(instruction.operands[3], kNotConstant));
            return level == std::trunc(level) ? kBilinear : kTrilinear;
        }
        default:
            return 0;
    }
}

// SPIRV-Tools leaves one function beside main: what `discard` was wrapped into.
void check_call(const SpirvModule& module, const SpirvInstruction& call) {
    const SpirvInstruction* callee = module.definition(call.operands[0]);
    CHECK(callee != nullptr && callee[1].opcode == spv::OpLabel && callee[2].opcode == spv::OpKill,
          "a function was not inlined");
}

}  // namespace

SpirvCost count_spirv_cost(const SpirvModule& module, const std::vector<std::uint32_t>& bytes_a_texel) {
    SpirvCost result;
    const std::vector<std::uint32_t> weights = block_weights(module, result.assumed_loops);
    const auto live = live_components(module);
    std::unordered_map<std::uint32_t, std::uint32_t> uses;
    for (const SpirvInstruction& instruction : module.instructions()) {
        if (instruction.block == SpirvInstruction::kNoBlock) continue;
        for (std::size_t i = 0; i < instruction.operands.size(); ++i)
            if (instruction.is_id[i]) ++uses[instruction.operands[i]];
    }
    for (const SpirvInstruction& instruction : module.instructions()) {
        if (instruction.block == SpirvInstruction::kNoBlock) continue;
        if (instruction.opcode == spv::OpFunctionCall) check_call(module, instruction);
        const auto mask = live.find(instruction.result);
        if (instruction.result == 0 || mask == live.end()) continue;
        const std::uint32_t weight = weights[instruction.block];
        if (!fused(module, instruction, uses)) {
            const auto used = static_cast<std::uint32_t>(std::popcount(mask->second));
            result.cost.alu_instructions += weight * alu_cost(module, instruction, used);
        }
        if (const std::uint32_t count = texels(module, instruction); count > 0) {
            result.cost.texture_fetches += weight;
            result.cost.texture_bytes +=
                weight * count * texture_bytes(module, instruction.operands[0], bytes_a_texel);
        }
    }
    return result;
}

}  // namespace ropsim
