// Numbers of CSV files.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace ropsim {

// Decimal digits that fit; nothing else may stand in `text`.
std::optional<std::uint64_t> csv_integer(std::string_view text);

// The nearest float; too small a number is 0, too large a one is none. Also inf and nan, with a sign, and
// nan(0xBITS), a NaN by all its 32 bits.
std::optional<float> csv_real(std::string_view text);

}  // namespace ropsim
