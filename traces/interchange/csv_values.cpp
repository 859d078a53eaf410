// Numbers of CSV files.
#include "traces/interchange/csv_values.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <limits>

namespace ropsim {

namespace {

// Digits that from_chars finds out of a float's range: small ones are no fault.
std::optional<float> extreme(std::string_view text) {
    double wide = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), wide);
    if (end != text.data() + text.size()) return std::nullopt;
    const bool tiny = error == std::errc::result_out_of_range && text.find("e-") != std::string_view::npos;
    if (tiny) return 0.0f;
    if (error != std::errc{} || std::abs(wide) > static_cast<double>(std::numeric_limits<float>::max()))
        return std::nullopt;
    return static_cast<float>(wide);
}

std::optional<float> nan_by_bits(std::string_view text) {
    constexpr std::string_view kStart = "nan(0x";
    std::uint32_t bits = 0;
    const char* const end = text.data() + text.size();
    const auto [at, error] = std::from_chars(text.data() + kStart.size(), end, bits, 16);
    if (error != std::errc{} || end - at != 1 || *at != ')') return std::nullopt;
    const auto value = std::bit_cast<float>(bits);
    return std::isnan(value) ? std::optional(value) : std::nullopt;
}

}  // namespace

std::optional<std::uint64_t> csv_integer(std::string_view text) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

std::optional<float> csv_real(std::string_view text) {
    if (text.starts_with("nan(0x")) return nan_by_bits(text);
    float value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc::result_out_of_range) return extreme(text);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

}  // namespace ropsim
