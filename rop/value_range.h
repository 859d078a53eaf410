// What values a field of a surface holds, said where it is declared and known before any scene is: which
// stored formats can hold them, and how far those round.
#pragma once

#include "rop/format.h"

#include <cstdint>

namespace ropsim {

enum class ValueRange : std::uint8_t {
    kUnit,        // [0, 1]: depth, alpha, transmittance and what multiplies it
    kSignedUnit,  // [-1, 1]
    kColor,       // of a layer, or of layers that hide one another: as bright as the brightest of them
    kSum,         // of what is never negative, over layers: grows with their number
    kSignedSum,   // the same of what may be negative
};

// Formats whose largest value is 1.
constexpr bool ends_at_one(Format format) {
    return format == Format::kUnorm8 || format == Format::kUnorm16 || format == Format::kUnorm24 ||
           format == Format::kSnorm8 || format == Format::kLog8;
}
constexpr bool has_sign(Format format) {
    return format == Format::kFloat32 || format == Format::kFloat16 || format == Format::kSnorm8;
}

// Whether values of that range can be stored, rounded but not cut off. `bright`: scenes with colours above 1.
// A sum that outgrows a floating-point format is stopped by the operation, or becomes infinite and white
// where the paper has it so (overflow=white). Integers hold what they count; packed values of so many bits
// each end somewhere, and no sum stops before.
constexpr bool holds(Format format, ValueRange range, bool bright) {
    if (format == Format::kUint32 || format == Format::kBits)
        return range == ValueRange::kUnit || range == ValueRange::kSignedUnit;
    switch (range) {
        case ValueRange::kUnit:
            return true;
        case ValueRange::kSignedUnit:
            return has_sign(format);
        case ValueRange::kColor:
            return !bright || !ends_at_one(format);
        case ValueRange::kSum:
            return !ends_at_one(format);
        case ValueRange::kSignedSum:
            return has_sign(format) && !ends_at_one(format);
    }
    return false;
}

// The most that storing a value of at most 1 rounds it by: half a step next to 1. Of floating-point formats
// the same holds of larger values, relative to them.
constexpr double half_step(Format format) {
    switch (format) {
        case Format::kFloat16:
            return 0x1p-11;
        case Format::kUnorm8:
            return 0.5 / 255;
        case Format::kUnorm16:
            return 0.5 / 65535;
        case Format::kUnorm24:
            return 0.5 / 16777215;
        case Format::kSnorm8:
            return 0.5 / 127;
        case Format::kLog8:
            return 0.011;  // (2^(1/32) - 1) / 2
        case Format::kR11G11B10:
            return 0x1p-6;
        case Format::kRgb9e5:
            return 0x1p-9;
        case Format::kBits:
            return 0.5 / 255;  // of packed sums: rop/nodes/weighted_tail.h
        default:
            return 0x1p-24;
    }
}

}  // namespace ropsim
