#include "rop/nodes/weighted_tail.h"

#include <string>

namespace ropsim {

WeightedTail::WeightedTail(Declaration& declaration, Parameters& parameters,
                           const TechniqueFormats& formats) {
    const std::string format = parameters.get_choice("tail_format", formats.float32() ? "float32" : "packed",
                                                     {"packed", "packed_wrapping", "float16", "float32"});
    packed_ = format.starts_with("packed");
    wraps_ = format == "packed_wrapping";
    const FieldSpec sums = packed_
                               ? FieldSpec::integer(32, 0, ValueRange::kSum)
                               : FieldSpec::real(format == "float16" ? Format::kFloat16 : Format::kFloat32, 4,
                                                 0.0f, ValueRange::kSum);
    // Packed, the sum of alpha stands beside the count.
    const FieldSpec rest = FieldSpec::integer(32, 0, packed_ ? ValueRange::kSum : ValueRange::kUnit);
    const auto fields = declaration.surface("tail", 1, Layout::kInterleaved, Initial::kClear, {sums, rest});
    first_ = fields[0];
    second_ = fields[1];
}

}  // namespace ropsim
