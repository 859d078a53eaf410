// Parses through SPIRV-Tools, which knows every instruction's operands.
#include "capture/shader_cost/spirv_module.h"

#include "base/error.h"

#include <glslang/SPIRV/spirv.hpp>
#include <spirv-tools/libspirv.h>

namespace ropsim {

struct SpirvModuleParser {
    static spv_result_t header(void*, spv_endianness_t, std::uint32_t, std::uint32_t, std::uint32_t,
                               std::uint32_t, std::uint32_t) {
        return SPV_SUCCESS;
    }

    static spv_result_t instruction(void* data, const spv_parsed_instruction_t* parsed) {
        auto& module = *static_cast<SpirvModule*>(data);
        SpirvInstruction instruction;
        instruction.opcode = parsed->opcode;
        instruction.type = parsed->type_id;
        instruction.result = parsed->result_id;
        for (std::uint16_t i = 0; i < parsed->num_operands; ++i) {
            const spv_parsed_operand_t& operand = parsed->operands[i];
            if (operand.type == SPV_OPERAND_TYPE_RESULT_ID || operand.type == SPV_OPERAND_TYPE_TYPE_ID)
                continue;
            const bool is_id = operand.type == SPV_OPERAND_TYPE_ID ||
                               operand.type == SPV_OPERAND_TYPE_MEMORY_SEMANTICS_ID ||
                               operand.type == SPV_OPERAND_TYPE_SCOPE_ID;
            for (std::uint16_t word = 0; word < operand.num_words; ++word) {
                instruction.operands.push_back(parsed->words[operand.offset + word]);
                instruction.is_id.push_back(is_id);
            }
        }
        if (instruction.result != 0) {
            module.definitions_.emplace(instruction.result, module.instructions_.size());
        }
        module.instructions_.push_back(std::move(instruction));
        return SPV_SUCCESS;
    }
};

SpirvModule::SpirvModule(const SpirvWords& words) {
    spv_context context = spvContextCreate(SPV_ENV_UNIVERSAL_1_0);
    const spv_result_t result =
        spvBinaryParse(context, this, words.data(), words.size(), SpirvModuleParser::header,
                       SpirvModuleParser::instruction, nullptr);
    spvContextDestroy(context);
    CHECK(result == SPV_SUCCESS, "SPIR-V does not parse: {}", static_cast<int>(result));
    find_blocks();
}

void SpirvModule::find_blocks() {
    bool inside = false;
    for (SpirvInstruction& instruction : instructions_) {
        if (instruction.opcode == spv::OpLabel) {
            blocks_.push_back({instruction.result, {}, 0});
            inside = true;
        }
        instruction.block = inside ? blocks_.size() - 1 : SpirvInstruction::kNoBlock;
        const std::vector<std::uint32_t>& operands = instruction.operands;
        switch (instruction.opcode) {
            case spv::OpLoopMerge:
                blocks_.back().loop_merge = operands[0];
                break;
            case spv::OpBranch:
                blocks_.back().successors = {operands[0]};
                break;
            case spv::OpBranchConditional:
                blocks_.back().successors = {operands[1], operands[2]};
                break;
            case spv::OpSwitch:  // selector, default, then literal and label by turns
                for (std::size_t i = 1; i < operands.size(); ++i)
                    if (instruction.is_id[i]) blocks_.back().successors.push_back(operands[i]);
                break;
            case spv::OpFunctionEnd:
                inside = false;
                break;
            default:
                break;
        }
    }
}

const SpirvInstruction* SpirvModule::definition(std::uint32_t id) const {
    const auto found = definitions_.find(id);
    return found == definitions_.end() ? nullptr : &instructions_[found->second];
}

std::uint32_t SpirvModule::components(std::uint32_t type) const {
    const SpirvInstruction* made = definition(type);
    if (made == nullptr) return 0;
    switch (made->opcode) {
        case spv::OpTypeBool:
        case spv::OpTypeInt:
        case spv::OpTypeFloat:
            return 1;
        case spv::OpTypeVector:
        case spv::OpTypeMatrix:
            return made->operands[1] * components(made->operands[0]);
        default:
            return 0;
    }
}

std::uint32_t SpirvModule::components_of(std::uint32_t id) const {
    const SpirvInstruction* made = definition(id);
    return made == nullptr ? 0 : components(made->type);
}

std::uint32_t SpirvModule::constant_bits(std::uint32_t id, std::uint32_t absent) const {
    const SpirvInstruction* made = definition(id);
    if (made == nullptr || made->opcode != spv::OpConstant) return absent;
    return made->operands[0];
}

std::uint32_t SpirvModule::decoration(std::uint32_t id, std::uint32_t kind, std::uint32_t absent) const {
    for (const SpirvInstruction& instruction : instructions_) {
        if (instruction.opcode == spv::OpDecorate && instruction.operands.size() == 3 &&
            instruction.operands[0] == id && instruction.operands[1] == kind) {
            return instruction.operands[2];
        }
    }
    return absent;
}

}  // namespace ropsim
