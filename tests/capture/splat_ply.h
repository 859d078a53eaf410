// Writes binary PLY for tests, property by property.
#pragma once

#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

namespace ropsim::testing {

// A column of the vertices; `type` is float, double, int or uchar.
struct PlyProperty {
    std::string type;
    std::string name;
    std::vector<double> values;
};

inline std::vector<std::uint8_t> splat_ply(const std::vector<PlyProperty>& properties) {
    const std::size_t count = properties.at(0).values.size();
    std::string header = "ply\nformat binary_little_endian 1.0\ncomment a test's\nelement vertex " +
                         std::to_string(count) + "\n";
    for (const PlyProperty& p : properties) header += "property " + p.type + " " + p.name + "\n";
    header += "end_header\n";
    std::vector<std::uint8_t> bytes(header.begin(), header.end());
    const auto put = [&](auto value) {
        std::uint8_t raw[sizeof value];
        std::memcpy(raw, &value, sizeof value);
        bytes.insert(bytes.end(), raw, raw + sizeof value);
    };
    for (std::size_t i = 0; i < count; ++i)
        for (const PlyProperty& p : properties) {
            if (p.type == "float") put(static_cast<float>(p.values[i]));
            if (p.type == "double") put(p.values[i]);
            if (p.type == "int") put(static_cast<std::int32_t>(p.values[i]));
            if (p.type == "uchar") put(static_cast<std::uint8_t>(p.values[i]));
        }
    return bytes;
}

inline void write_bytes(const std::string& path, const std::vector<std::uint8_t>& bytes) {
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace ropsim::testing
