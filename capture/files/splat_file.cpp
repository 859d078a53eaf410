// Reads 3D Gaussian splats from binary PLY.
#include "capture/files/splat_file.h"

#include "base/error.h"
#include "capture/files/ply_header.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string_view>

namespace ropsim {
namespace {

static_assert(std::endian::native == std::endian::little, "values are read as they lie in the file");

// Reads one splat after the other's properties.
class SplatReader {
 public:
    SplatReader(const PlyHeader& header, std::span<const std::uint8_t> vertices, const std::string& name)
        : header_(header), vertices_(vertices), name_(name) {
        for (int i = 0; i < 3; ++i) {
            position_[i] = find(std::string(1, static_cast<char>('x' + i)));
            color_[i] = find(fmt::format("f_dc_{}", i));
            scale_[i] = find(fmt::format("scale_{}", i));
        }
        for (int i = 0; i < 4; ++i) rotation_[i] = find(fmt::format("rot_{}", i));
        opacity_ = find("opacity");
        std::size_t rest = 0;
        for (const PlyProperty& property : header.properties) rest += property.name.starts_with("f_rest_");
        for (std::size_t i = 0; i < rest; ++i) rest_.push_back(find(fmt::format("f_rest_{}", i)));
        while (3 * ((degree_ + 1) * (degree_ + 1) - 1) < static_cast<int>(rest) && degree_ < 3) ++degree_;
        if (3 * ((degree_ + 1) * (degree_ + 1) - 1) != static_cast<int>(rest)) {
            throw UserError(name, fmt::format("{} properties f_rest_*; spherical harmonics of degree 0 to 3 "
                                              "have 0, 9, 24 or 45",
                                              rest));
        }
    }

    SplatFile read() const {
        SplatFile splats;
        const auto count = static_cast<std::size_t>(header_.count);
        splats.degree = degree_;
        splats.positions.resize(count);
        splats.scales.resize(count);
        splats.rotations.resize(count);
        splats.opacities.resize(count);
        splats.harmonics.resize(count * splats.harmonics_a_splat());
        for (std::size_t i = 0; i < count; ++i) read_splat(i, splats);
        return splats;
    }

 private:
    const PlyProperty* find(const std::string& wanted) const {
        for (const PlyProperty& property : header_.properties) {
            if (property.name != wanted) continue;
            if (property.scalar == PlyScalar::kOther) {
                throw UserError(name_, fmt::format("property {} is neither float nor double", wanted));
            }
            return &property;
        }
        throw UserError(name_, fmt::format("a vertex has no property {}; give a .ply as 3D Gaussian "
                                           "splatting writes it",
                                           wanted));
    }

    [[noreturn]] void refuse(std::size_t splat, const std::string& what, float value) const {
        throw UserError(name_, fmt::format("splat {} (byte {}): {} is {}; repair or remove the splat", splat,
                                           header_.bytes + splat * header_.stride, what, value));
    }

    float value(std::size_t splat, const PlyProperty* property) const {
        const std::uint8_t* at = vertices_.data() + splat * header_.stride + property->offset;
        float result = 0;
        if (property->scalar == PlyScalar::kFloat) {
            std::memcpy(&result, at, sizeof result);
        } else {
            double wide = 0;
            std::memcpy(&wide, at, sizeof wide);
            constexpr double kLargest = std::numeric_limits<float>::max();
            result = std::fabs(wide) <= kLargest ? static_cast<float>(wide)
                                                 : std::numeric_limits<float>::infinity();
        }
        if (!std::isfinite(result)) refuse(splat, property->name, result);
        return result;
    }

    void read_splat(std::size_t i, SplatFile& splats) const {
        for (int k = 0; k < 3; ++k) {
            splats.positions[i][k] = value(i, position_[k]);
            splats.scales[i][k] = std::exp(value(i, scale_[k]));
            if (!std::isfinite(splats.scales[i][k])) {
                refuse(i, fmt::format("the exponential of {}", scale_[k]->name), splats.scales[i][k]);
            }
        }
        splats.opacities[i] = 1.0f / (1.0f + std::exp(-value(i, opacity_)));
        const glm::quat rotation(value(i, rotation_[0]), value(i, rotation_[1]), value(i, rotation_[2]),
                                 value(i, rotation_[3]));
        // In double precision, where the square of no float underflows or overflows.
        const glm::dquat wide(rotation);
        const double length = glm::length(wide);
        if (!(length > 0)) refuse(i, "the length of rot_0..3", 0);
        splats.rotations[i] = glm::quat(wide / length);
        const std::size_t terms = splats.harmonics_a_splat();
        glm::vec3* harmonics = &splats.harmonics[i * terms];
        for (std::size_t k = 0; k < 3; ++k) {
            const auto channel = static_cast<int>(k);
            harmonics[0][channel] = value(i, color_[k]);
            for (std::size_t term = 1; term < terms; ++term)
                harmonics[term][channel] = value(i, rest_[k * (terms - 1) + term - 1]);
        }
    }

    const PlyHeader& header_;
    std::span<const std::uint8_t> vertices_;
    const std::string& name_;
    const PlyProperty* position_[3];
    const PlyProperty* color_[3];
    const PlyProperty* scale_[3];
    const PlyProperty* rotation_[4];
    const PlyProperty* opacity_;
    std::vector<const PlyProperty*> rest_;
    int degree_ = 0;
};

std::string_view header_text(std::span<const std::uint8_t> bytes) {
    const std::size_t length = std::min(bytes.size(), kMaxPlyHeaderBytes);
    return {reinterpret_cast<const char*>(bytes.data()), length};
}

}  // namespace

SplatFile parse_splats(std::span<const std::uint8_t> bytes, const std::string& name) {
    const PlyHeader header = parse_ply_header(header_text(bytes), name);
    if (header.count == 0) throw UserError(name, "holds no splats");
    const std::span<const std::uint8_t> vertices = bytes.subspan(header.bytes);
    const SplatReader reader(header, vertices, name);
    const std::uint64_t whole = vertices.size() / header.stride;
    if (whole < header.count) {
        throw UserError(name, fmt::format("the header announces {} splats of {} bytes, the file ends after "
                                          "{}; it is cut short",
                                          header.count, header.stride, whole));
    }
    if (!header.more_after && vertices.size() != header.count * header.stride) {
        throw UserError(name, fmt::format("{} bytes follow the last of {} splats; the header's count does "
                                          "not fit the file",
                                          vertices.size() - header.count * header.stride, header.count));
    }
    return reader.read();
}

SplatFile load_splats(const std::string& path) {
    std::ifstream stream(path, std::ios::binary | std::ios::ate);
    const bool readable = stream && std::filesystem::is_regular_file(path);
    const std::streamoff length = readable ? static_cast<std::streamoff>(stream.tellg()) : -1;
    if (length < 0) throw UserError(path, "cannot be opened; check the name and the permissions");
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(length));
    stream.seekg(0);
    stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(length));
    if (!stream) throw UserError(path, "cannot be read to its end; check the disk");
    return parse_splats(bytes, path);
}

bool is_splat_ply(const std::string& path) {
    std::ifstream stream(path, std::ios::binary);
    std::string head(kMaxPlyHeaderBytes, '\0');
    stream.read(head.data(), static_cast<std::streamsize>(head.size()));
    head.resize(static_cast<std::size_t>(stream.gcount()));
    if (!head.starts_with("ply")) return false;
    head.resize(std::min(head.find("end_header"), head.size()));
    return head.find(" f_dc_0") != std::string::npos && head.find(" scale_0") != std::string::npos;
}

}  // namespace ropsim
