// The range of an option that takes a floating-point number.
#pragma once

#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace ropsim {

// Both ends included. CLI::Range would let NaN pass.
inline CLI::Validator between(double low, double high) {
    return CLI::Validator(
        [low, high](std::string& text) {
            double value = 0;
            if (CLI::detail::lexical_cast(text, value) && value >= low && value <= high) return std::string();
            return fmt::format("{} is no number from {} to {}", text, low, high);
        },
        fmt::format("in [{} - {}]", low, high));
}

}  // namespace ropsim
