// Backwards from what has effects, until nothing changes.
#include "capture/shader_cost/spirv_liveness.h"

#include "capture/shader_cost/spirv_cost_table.h"

#include <glslang/SPIRV/spirv.hpp>

namespace ropsim {
namespace {

class Liveness {
 public:
    explicit Liveness(const SpirvModule& module) : module_(module) {}

    std::unordered_map<std::uint32_t, std::uint32_t> run() {
        for (const SpirvInstruction& instruction : module_.instructions()) {
            if (instruction.block == SpirvInstruction::kNoBlock) continue;
            if (instruction.result == 0 || instruction.opcode == spv::OpFunctionCall)
                need_operands(instruction);
        }
        while (!pending_.empty()) {
            const std::uint32_t id = pending_.back();
            pending_.pop_back();
            const SpirvInstruction* made = module_.definition(id);
            if (made != nullptr) propagate(*made, live_[id]);
        }
        return std::move(live_);
    }

 private:
    std::uint32_t all_of(std::uint32_t id) const {
        const std::uint32_t components = module_.components_of(id);
        return components == 0 ? 1u : (1u << components) - 1;
    }

    void need(std::uint32_t id, std::uint32_t mask) {
        std::uint32_t& known = live_[id];
        if ((known | mask) == known) return;
        known |= mask;
        pending_.push_back(id);
    }

    void need_operands(const SpirvInstruction& instruction) {
        for (std::size_t i = 0; i < instruction.operands.size(); ++i)
            if (instruction.is_id[i]) need(instruction.operands[i], all_of(instruction.operands[i]));
    }

    void need_parts(const SpirvInstruction& instruction, std::uint32_t mask) {
        for (std::uint32_t part : instruction.operands) {
            const std::uint32_t components = module_.components_of(part);
            if ((mask & all_of(part)) != 0) need(part, mask & all_of(part));
            mask >>= components;
        }
    }

    void need_shuffled(const SpirvInstruction& instruction, std::uint32_t mask) {
        const std::uint32_t first = module_.components_of(instruction.operands[0]);
        for (std::size_t i = 2; i < instruction.operands.size(); ++i) {
            const std::uint32_t from = instruction.operands[i];
            if ((mask >> (i - 2) & 1) == 0 || from == ~0u) continue;
            if (from < first) {
                need(instruction.operands[0], 1u << from);
            } else {
                need(instruction.operands[1], 1u << (from - first));
            }
        }
    }

    // Whether `id` is a vector of which one literal picks a component.
    bool picks_component(const SpirvInstruction& instruction, std::size_t composite) const {
        const SpirvInstruction* made = module_.definition(instruction.operands[composite]);
        const SpirvInstruction* type = made == nullptr ? nullptr : module_.definition(made->type);
        return type != nullptr && type->opcode == spv::OpTypeVector &&
               instruction.operands.size() == composite + 2;
    }

    void propagate(const SpirvInstruction& instruction, std::uint32_t mask) {
        const std::vector<std::uint32_t>& operands = instruction.operands;
        const std::uint32_t components = module_.components(instruction.type);
        if (instruction.opcode == spv::OpCompositeExtract && picks_component(instruction, 0)) {
            need(operands[0], 1u << operands[1]);
        } else if (instruction.opcode == spv::OpCompositeInsert && picks_component(instruction, 1)) {
            if ((mask >> operands[2] & 1) != 0) need(operands[0], all_of(operands[0]));
            if ((mask & ~(1u << operands[2])) != 0) need(operands[1], mask & ~(1u << operands[2]));
        } else if (instruction.opcode == spv::OpCompositeConstruct && components > 0) {
            need_parts(instruction, mask);
        } else if (instruction.opcode == spv::OpVectorShuffle) {
            need_shuffled(instruction, mask);
        } else if (componentwise(module_, instruction)) {
            for (std::size_t i = 0; i < operands.size(); ++i) {
                if (!instruction.is_id[i]) continue;
                const bool same = components > 1 && module_.components_of(operands[i]) == components;
                need(operands[i], same ? mask : all_of(operands[i]));
            }
        } else {
            need_operands(instruction);
        }
    }

    const SpirvModule& module_;
    std::unordered_map<std::uint32_t, std::uint32_t> live_;
    std::vector<std::uint32_t> pending_;
};

}  // namespace

std::unordered_map<std::uint32_t, std::uint32_t> live_components(const SpirvModule& module) {
    return Liveness(module).run();
}

}  // namespace ropsim
