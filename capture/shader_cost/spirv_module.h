// A SPIR-V module taken apart: instructions with their operands, types, constants and the blocks of its
// functions.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

namespace ropsim {

using SpirvWords = std::vector<std::uint32_t>;

struct SpirvInstruction {
    std::uint16_t opcode = 0;  // spv::Op
    std::uint32_t type = 0;    // id of the result's type, 0 without
    std::uint32_t result = 0;  // 0 without
    // What follows type and result: ids and literals, one element a word.
    std::vector<std::uint32_t> operands;
    std::vector<bool> is_id;  // of each operand
    std::size_t block = 0;    // index into SpirvModule::blocks; kNoBlock outside functions

    static constexpr std::size_t kNoBlock = ~std::size_t{0};
};

struct SpirvBlock {
    std::uint32_t label = 0;
    std::vector<std::uint32_t> successors;  // labels
    std::uint32_t loop_merge = 0;           // label behind the loop that this block heads, 0: heads none
};

class SpirvModule {
 public:
    // A malformed module is our own mistake (CHECK).
    explicit SpirvModule(const SpirvWords& words);

    const std::vector<SpirvInstruction>& instructions() const { return instructions_; }
    const std::vector<SpirvBlock>& blocks() const { return blocks_; }
    // The instruction that makes `id`; null where there is none.
    const SpirvInstruction* definition(std::uint32_t id) const;
    // Scalars of a value of `type`: 1 for a scalar, columns times rows for a matrix, 0 for everything else.
    std::uint32_t components(std::uint32_t type) const;
    std::uint32_t components_of(std::uint32_t id) const;
    // Of a scalar integer or 32-bit float constant, as bits; `absent` where `id` is none.
    std::uint32_t constant_bits(std::uint32_t id, std::uint32_t absent) const;
    // Value of an OpDecorate with one literal, `absent` without.
    std::uint32_t decoration(std::uint32_t id, std::uint32_t kind, std::uint32_t absent) const;

 private:
    friend struct SpirvModuleParser;
    void find_blocks();

    std::vector<SpirvInstruction> instructions_;
    std::vector<SpirvBlock> blocks_;
    std::unordered_map<std::uint32_t, std::size_t> definitions_;
};

}  // namespace ropsim
