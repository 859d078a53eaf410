#include "rop/double_reading/boxed_double.h"

#include "base/error.h"

#include <bit>
#include <cmath>
#include <limits>
#include <vector>

namespace ropsim {
namespace {

constexpr std::uint32_t kFirst = 0xFF800001u;  // behind minus infinity
constexpr std::size_t kMost = 0xFFFFFFFFu - kFirst + std::size_t{1};

std::vector<double>& table() {
    static thread_local std::vector<double> values;
    return values;
}

}  // namespace

std::uint32_t boxed_double(double value) {
    if (std::isnan(value)) return std::bit_cast<std::uint32_t>(std::numeric_limits<float>::quiet_NaN());
    const auto narrow = static_cast<float>(value);
    if (static_cast<double>(narrow) == value) return std::bit_cast<std::uint32_t>(narrow);
    CHECK(table().size() < kMost, "{} doubles in a pixel's state", table().size());
    table().push_back(value);
    return kFirst + static_cast<std::uint32_t>(table().size() - 1);
}

double unboxed_double(std::uint32_t word) {
    if (!is_boxed(word)) return static_cast<double>(std::bit_cast<float>(word));
    const std::size_t entry = word - kFirst;
    CHECK(entry < table().size(), "word {:#x} stands for no double", word);
    return table()[entry];
}

bool is_boxed(std::uint32_t word) {
    return word >= kFirst;
}
std::size_t boxed_doubles() {
    return table().size();
}
void forget_boxed_doubles() {
    table().clear();
}

}  // namespace ropsim
