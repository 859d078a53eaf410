// Sources: AMD, "RDNA Instruction Set Architecture" (2020), chapter 12: reciprocal, square roots, base-2
// exponential and logarithm, sine and cosine (of turns, hence a multiplication before) are one VALU
// instruction each; v_med3 clamps; sign and absolute value are source modifiers. NVIDIA's "CUDA C++
// Programming Guide", arithmetic instructions, has the same set on its special function units. Everything
// longer is those instructions put together as Mesa's NIR lowers it (src/compiler/nir,
// src/compiler/spirv/vtn_glsl450.c); inverse trigonometry, hyperbolic functions, integer division and matrix
// inverses are estimates.
#include "capture/shader_cost/spirv_cost_table.h"

#include "base/error.h"

#include <algorithm>
#include <iterator>

#include <glslang/SPIRV/spirv.hpp>
// After spirv.hpp, whose names it uses.
#include <glslang/SPIRV/GLSL.std.450.h>

namespace ropsim {
namespace {

struct ExtendedCost {
    std::uint32_t number;       // of GLSL.std.450
    std::uint32_t a_component;  // for each component of the result that is used
    std::uint32_t an_operand_component = 0;
    std::uint32_t once = 0;
    bool componentwise = true;
};

constexpr ExtendedCost kExtended[] = {
    {GLSLstd450Round, 1},
    {GLSLstd450RoundEven, 1},
    {GLSLstd450Trunc, 1},
    {GLSLstd450FAbs, 0},   // source modifier
    {GLSLstd450SAbs, 2},   // negate, maximum
    {GLSLstd450FSign, 2},  // two clamps after a scaling
    {GLSLstd450SSign, 2},
    {GLSLstd450Floor, 1},
    {GLSLstd450Ceil, 1},
    {GLSLstd450Fract, 1},
    {GLSLstd450Radians, 1},
    {GLSLstd450Degrees, 1},
    {GLSLstd450Sin, 2},  // to turns, sine
    {GLSLstd450Cos, 2},
    {GLSLstd450Tan, 5},    // to turns, sine, cosine, reciprocal, product
    {GLSLstd450Asin, 15},  // polynomial and square root
    {GLSLstd450Acos, 15},
    {GLSLstd450Atan, 20},  // range reduction and polynomial
    {GLSLstd450Sinh, 5},   // scaling, two exponentials, difference, half
    {GLSLstd450Cosh, 5},
    {GLSLstd450Tanh, 7},
    {GLSLstd450Asinh, 6},
    {GLSLstd450Acosh, 5},
    {GLSLstd450Atanh, 6},
    {GLSLstd450Atan2, 25},
    {GLSLstd450Pow, 3},  // logarithm, product, exponential
    {GLSLstd450Exp, 2},  // scaling, base-2 exponential
    {GLSLstd450Log, 2},
    {GLSLstd450Exp2, 1},
    {GLSLstd450Log2, 1},
    {GLSLstd450Sqrt, 1},
    {GLSLstd450InverseSqrt, 1},
    {GLSLstd450Determinant, 0, 2, 0, false},
    {GLSLstd450MatrixInverse, 6, 0, 0, false},
    {GLSLstd450Modf, 2},
    {GLSLstd450ModfStruct, 0, 2, 0, false},
    {GLSLstd450FMin, 1},
    {GLSLstd450UMin, 1},
    {GLSLstd450SMin, 1},
    {GLSLstd450FMax, 1},
    {GLSLstd450UMax, 1},
    {GLSLstd450SMax, 1},
    {GLSLstd450FClamp, 1},
    {GLSLstd450UClamp, 1},
    {GLSLstd450SClamp, 1},
    {GLSLstd450FMix, 2},        // difference, multiply-add
    {GLSLstd450Step, 2},        // comparison, selection
    {GLSLstd450SmoothStep, 7},  // two differences, reciprocal, product (clamped), two products, multiply-add
    {GLSLstd450Fma, 1},
    {GLSLstd450Frexp, 2},
    {GLSLstd450FrexpStruct, 0, 2, 0, false},
    {GLSLstd450Ldexp, 1},
    {GLSLstd450PackSnorm4x8, 0, 3, 0, false},  // scaling, conversion, insertion
    {GLSLstd450PackUnorm4x8, 0, 3, 0, false},
    {GLSLstd450PackSnorm2x16, 0, 3, 0, false},
    {GLSLstd450PackUnorm2x16, 0, 3, 0, false},
    {GLSLstd450PackHalf2x16, 0, 0, 1, false},
    {GLSLstd450PackDouble2x32, 0, 0, 0, false},
    {GLSLstd450UnpackSnorm4x8, 2, 0, 0, false},  // conversion of a byte, scaling
    {GLSLstd450UnpackUnorm4x8, 2, 0, 0, false},
    {GLSLstd450UnpackSnorm2x16, 2, 0, 0, false},
    {GLSLstd450UnpackUnorm2x16, 2, 0, 0, false},
    {GLSLstd450UnpackHalf2x16, 1, 0, 0, false},
    {GLSLstd450UnpackDouble2x32, 0, 0, 0, false},
    {GLSLstd450Length, 0, 1, 1, false},       // dot product, square root
    {GLSLstd450Distance, 0, 2, 1, false},     // differences besides
    {GLSLstd450Cross, 2, 0, 0, false},        // product, multiply-add
    {GLSLstd450Normalize, 1, 1, 1, false},    // dot product, inverse square root, products
    {GLSLstd450FaceForward, 1, 1, 1, false},  // dot product, comparison, selections
    {GLSLstd450Reflect, 1, 1, 1, false},      // dot product, doubled, multiply-adds
    {GLSLstd450Refract, 3, 1, 6,
     false},  // dot product, k, square root, comparison, two products and selection
    {GLSLstd450FindILsb, 1},
    {GLSLstd450FindSMsb, 2},
    {GLSLstd450FindUMsb, 1},
    {GLSLstd450InterpolateAtCentroid, 2, 0, 0, false},
    {GLSLstd450InterpolateAtSample, 2, 0, 0, false},
    {GLSLstd450InterpolateAtOffset, 2, 0, 0, false},
    {GLSLstd450NMin, 1},
    {GLSLstd450NMax, 1},
    {GLSLstd450NClamp, 1},
};

const ExtendedCost& extended_cost(const SpirvInstruction& instruction) {
    const std::uint32_t number = instruction.operands[1];
    const auto* found = std::find_if(std::begin(kExtended), std::end(kExtended),
                                     [&](const ExtendedCost& cost) { return cost.number == number; });
    CHECK(found != std::end(kExtended), "GLSL.std.450 instruction {} has no cost", number);
    return *found;
}

// Of a reciprocal's quotient and of what a division by a constant becomes; otherwise an emulation.
std::uint32_t integer_division(const SpirvModule& module, const SpirvInstruction& instruction) {
    constexpr std::uint32_t kByConstant = 4;
    constexpr std::uint32_t kEmulated = 20;
    const SpirvInstruction* divisor = module.definition(instruction.operands[1]);
    const bool constant = divisor != nullptr &&
                          (divisor->opcode == spv::OpConstant || divisor->opcode == spv::OpConstantComposite);
    return constant ? kByConstant : kEmulated;
}

bool moves_or_reads(std::uint16_t opcode) {
    switch (opcode) {
        case spv::OpUndef:
        case spv::OpFunction:
        case spv::OpFunctionParameter:
        case spv::OpFunctionCall:
        case spv::OpLabel:
        case spv::OpVariable:
        case spv::OpLoad:
        case spv::OpAccessChain:
        case spv::OpInBoundsAccessChain:
        case spv::OpArrayLength:
        case spv::OpCopyObject:
        case spv::OpBitcast:
        case spv::OpVectorShuffle:
        case spv::OpCompositeConstruct:
        case spv::OpCompositeExtract:
        case spv::OpCompositeInsert:
        case spv::OpTranspose:
        case spv::OpFNegate:  // source modifier
        case spv::OpSampledImage:
        case spv::OpImage:
            return true;
        default:
            // From sampling to gathering and reading, sparse or not: the texture unit's work.
            return (opcode >= spv::OpImageSampleImplicitLod && opcode <= spv::OpImageWrite) ||
                   (opcode >= spv::OpImageSparseSampleImplicitLod && opcode <= spv::OpImageSparseDrefGather);
    }
}

}  // namespace

bool componentwise(const SpirvModule& module, const SpirvInstruction& instruction) {
    switch (instruction.opcode) {
        case spv::OpExtInst:
            return extended_cost(instruction).componentwise;
        case spv::OpMatrixTimesScalar:
        case spv::OpPhi:
        case spv::OpCopyObject:
        case spv::OpFNegate:
        case spv::OpBitcast:
            return true;
        case spv::OpDot:
        case spv::OpVectorTimesMatrix:
        case spv::OpMatrixTimesVector:
        case spv::OpMatrixTimesMatrix:
        case spv::OpOuterProduct:
        case spv::OpAny:
        case spv::OpAll:
        case spv::OpVectorExtractDynamic:
        case spv::OpVectorInsertDynamic:
        case spv::OpImageQuerySizeLod:
        case spv::OpImageQuerySize:
        case spv::OpImageQueryLod:
        case spv::OpImageQueryLevels:
            return false;
        default:
            return module.components(instruction.type) > 0 && !moves_or_reads(instruction.opcode);
    }
}

std::uint32_t alu_cost(const SpirvModule& module, const SpirvInstruction& instruction, std::uint32_t used) {
    const auto components = [&](std::size_t operand) {
        return module.components_of(instruction.operands[operand]);
    };
    if (moves_or_reads(instruction.opcode) || module.components(instruction.type) == 0) {
        // Structures of two results, as modf's, are instructions all the same.
        if (instruction.opcode != spv::OpExtInst) return 0;
    }
    switch (instruction.opcode) {
        case spv::OpExtInst: {
            const ExtendedCost& cost = extended_cost(instruction);
            return cost.a_component * used + cost.an_operand_component * components(2) + cost.once;
        }
        case spv::OpDot:
            return components(0);
        case spv::OpMatrixTimesVector:  // a dot product with each row
            return used * components(1);
        case spv::OpVectorTimesMatrix:
            return used * components(0);
        case spv::OpMatrixTimesMatrix: {
            const SpirvInstruction* right =
                module.definition(module.definition(instruction.operands[1])->type);
            return components(0) * right->operands[1];
        }
        case spv::OpAny:
        case spv::OpAll:
            return components(0) - 1;
        case spv::OpFDiv:  // reciprocal, product
            return 2 * used;
        case spv::OpFRem:
        case spv::OpFMod:  // reciprocal, product, floor, multiply-add
            return 4 * used;
        case spv::OpUDiv:
        case spv::OpSDiv:
        case spv::OpUMod:
        case spv::OpSMod:
        case spv::OpSRem:
            return integer_division(module, instruction) * used;
        case spv::OpPhi:  // where branches meet a selection for each more than one; at the head of a loop a
                          // register
            if (module.blocks()[instruction.block].loop_merge != 0) return 0;
            return static_cast<std::uint32_t>(instruction.operands.size() / 2 - 1) * used;
        case spv::OpFwidth:
        case spv::OpFwidthFine:
        case spv::OpFwidthCoarse:
            return 3 * used;
        default:
            return used;
    }
}

}  // namespace ropsim
