// The double-precision reading of rop/: its sources, the same files, compiled with double for float in a
// namespace of their own. Included before everything else (the compiler's -include) by the library
// ropsim_rop_double and nothing else, so that the ordinary reading does not know of it.
//
// What stays of single precision comes in before the exchange: fragments, traces, images, stored formats.
// Rounding to a stored format is no part of this reading: techniques are built with format=float32, which
// here keeps values as they are.
#pragma once

#include "base/error.h"
#include "base/huge_pages.h"
#include "base/parallel.h"
#include "base/parameters.h"
#include "base/random.h"
#include "rop/double_reading/boxed_double.h"
#include "rop/format.h"
#include "rop/single_pixel.h"
#include "rop/stored_word.h"
#include "traces/depth_key.h"
#include "traces/depth_test.h"
#include "traces/image.h"
#include "traces/least_alpha.h"
#include "traces/sample_positions.h"
#include "traces/trace.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/glm.hpp>

namespace ropsim_double {

// Names that this reading does not have are the project's.
using namespace ropsim;

// In place of those of rop/stored_word.h and rop/format.h: nothing is rounded.
inline std::uint32_t stored_word(double value) {
    return boxed_double(value);
}
inline double word_value(std::uint32_t word) {
    return unboxed_double(word);
}
inline double stored_value(Format format, double value) {
    CHECK(format == Format::kFloat32, "a stored format in the double-precision reading");
    return value;
}
inline std::array<double, 3> stored_rgb(Format format, const std::array<double, 3>& rgb) {
    CHECK(format == Format::kFloat32, "a stored format in the double-precision reading");
    return rgb;
}

inline double stored_value_down(Format format, double value) {
    return stored_value(format, value);
}
inline double stored_value_dithered(Format format, double value, double) {
    return stored_value(format, value);
}
inline double next_stored_below(Format format, double) {
    CHECK(false, "{} has no neighbours in the double-precision reading", format_info(format).name);
}

// Vectors are of the surface shader, the light and the opaque layer: no arithmetic of the operation's.
inline glm::vec2 operator*(const glm::vec2& v, double factor) {
    return v * static_cast<float>(factor);
}
inline glm::vec3 operator*(const glm::vec3& v, double factor) {
    return v * static_cast<float>(factor);
}
inline glm::vec3 operator*(double factor, const glm::vec3& v) {
    return v * static_cast<float>(factor);
}
inline glm::vec3 operator/(const glm::vec3& v, double divisor) {
    return v / static_cast<float>(divisor);
}

}  // namespace ropsim_double

// Vector code is of floats and has its scalar twin.
#undef __SSE2__
#if defined(__clang__)
#pragma clang diagnostic ignored "-Wkeyword-macro"
#endif
// NOLINTBEGIN: the exchange itself. Every header of the standard library that rop/ uses stands above.
#define float double
#define ropsim ropsim_double
// NOLINTEND
