// .hair files made field by field, for tests.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

namespace ropsim::testing {

using Bytes = std::vector<std::uint8_t>;
inline constexpr std::uint32_t kAll = 31;  // flags of all arrays

// What goes into a file: two strands of 2 and 3 points unless changed.
struct HairSpec {
    std::uint32_t strands = 2;
    std::uint32_t flags = kAll;
    std::uint32_t default_segments = 0;
    std::vector<std::uint16_t> segments = {1, 2};
    std::vector<float> points = {0, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0, 1, 1, 0.5f, 2};
    std::vector<float> thickness = {0.1f, 0.2f, 0.3f, 0.4f, 0.5f};
    std::vector<float> transparency = {0, 0.25f, 0.5f, 0.75f, 1};
    std::vector<float> colors = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0.5f, 0.5f, 0.5f, 0.25f, 0.5f, 0.75f};
};

template <typename T>
void put(Bytes& bytes, const T& value) {
    const auto* from = reinterpret_cast<const std::uint8_t*>(&value);
    bytes.insert(bytes.end(), from, from + sizeof(T));
}

inline Bytes bytes_of(const HairSpec& spec) {
    Bytes bytes = {'H', 'A', 'I', 'R'};
    put(bytes, spec.strands);
    put(bytes, static_cast<std::uint32_t>(spec.points.size() / 3));
    put(bytes, spec.flags);
    put(bytes, spec.default_segments);
    for (float value : {0.07f, 0.4f, 0.9f, 0.6f, 0.3f}) put(bytes, value);
    const char info[88] = "two strands";
    bytes.insert(bytes.end(), std::begin(info), std::end(info));
    if (spec.flags & 1)
        for (std::uint16_t value : spec.segments) put(bytes, value);
    if (spec.flags & 2)
        for (float value : spec.points) put(bytes, value);
    if (spec.flags & 4)
        for (float value : spec.thickness) put(bytes, value);
    if (spec.flags & 8)
        for (float value : spec.transparency) put(bytes, value);
    if (spec.flags & 16)
        for (float value : spec.colors) put(bytes, value);
    return bytes;
}

// Strands of 1 to 9 segments on a cylinder, thin, with everything the format has.
inline HairSpec cylinder(std::uint32_t strands) {
    HairSpec spec;
    spec.strands = strands;
    spec.segments.clear();
    spec.points.clear();
    spec.thickness.clear();
    spec.transparency.clear();
    spec.colors.clear();
    for (std::uint32_t i = 0; i < strands; ++i) {
        spec.segments.push_back(static_cast<std::uint16_t>(1 + i % 9));
        const float angle = 0.7f * static_cast<float>(i);
        for (std::uint32_t k = 0; k <= 1 + i % 9; ++k) {
            const float z = 3.0f * static_cast<float>(k) / static_cast<float>(1 + i % 9);
            spec.points.insert(spec.points.end(), {std::cos(angle), std::sin(angle), z});
            spec.thickness.push_back(0.02f);
            spec.transparency.push_back(0.5f);
            spec.colors.insert(spec.colors.end(), {0.5f, 0.25f, 0.125f});
        }
    }
    return spec;
}

}  // namespace ropsim::testing
