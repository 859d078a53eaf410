// The .hair format: a header of 128 bytes, then the arrays that its flags announce, little-endian.
#include "capture/files/hair_file.h"

#include "base/error.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace ropsim {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays are read as they lie in the file");

constexpr std::size_t kHeaderBytes = 128;
constexpr std::size_t kInfoBytes = 88;
constexpr std::size_t kInfoOffset = kHeaderBytes - kInfoBytes;
constexpr std::uint32_t kHasSegments = 1;
constexpr std::uint32_t kHasPoints = 2;
constexpr std::uint32_t kHasThickness = 4;
constexpr std::uint32_t kHasTransparency = 8;
constexpr std::uint32_t kHasColors = 16;
constexpr std::uint32_t kAllFlags = 31;

struct HairHeader {
    std::uint32_t strands;
    std::uint32_t points;
    std::uint32_t flags;
    std::uint32_t segments;  // of every strand, where there is no array
    float thickness;
    float transparency;
    float color[3];
};
static_assert(sizeof(HairHeader) == kInfoOffset - 4);

[[noreturn]] void refuse(const std::string& name, const std::string& what) {
    throw UserError(name, what + "; give an undamaged .hair file");
}

HairHeader read_header(std::span<const std::uint8_t> bytes, const std::string& name) {
    if (bytes.size() < 4 || std::memcmp(bytes.data(), "HAIR", 4) != 0)
        refuse(name, "not a .hair file: it does not begin with HAIR");
    if (bytes.size() < kHeaderBytes)
        refuse(name, fmt::format("header: {} bytes, fewer than the {} of a .hair header", bytes.size(),
                                 kHeaderBytes));
    HairHeader header;
    std::memcpy(&header, bytes.data() + 4, sizeof(header));
    if ((header.flags & ~kAllFlags) != 0)
        refuse(name,
               fmt::format("header: flags {:#x} hold bits that the format does not define", header.flags));
    if ((header.flags & kHasPoints) == 0) refuse(name, "header: the flags announce no points");
    if (header.strands == 0) refuse(name, "header: 0 strands");
    return header;
}

// The arrays' sizes follow from the header: none is allocated before they are known to be there.
void check_length(const HairHeader& header, std::size_t bytes, const std::string& name) {
    std::uint64_t expected = kHeaderBytes;
    if (header.flags & kHasSegments) expected += std::uint64_t{2} * header.strands;
    const std::uint64_t points = header.points;
    expected += 12 * points;
    if (header.flags & kHasThickness) expected += 4 * points;
    if (header.flags & kHasTransparency) expected += 4 * points;
    if (header.flags & kHasColors) expected += 12 * points;
    if (expected != bytes)
        refuse(name, fmt::format("the file has {} bytes, but {} strands with {} points and flags {:#x} "
                                 "take {}",
                                 bytes, header.strands, header.points, header.flags, expected));
    if ((header.flags & kHasSegments) == 0) {
        const std::uint64_t implied = std::uint64_t{header.strands} * (std::uint64_t{header.segments} + 1);
        if (header.segments == 0 || implied != points)
            refuse(name, fmt::format("header: {} strands of {} segments have {} points, not {}",
                                     header.strands, header.segments, implied, header.points));
    }
}

// Takes arrays off the front of the file's bytes.
class ArrayReader {
 public:
    ArrayReader(std::span<const std::uint8_t> bytes, const std::string& name) : bytes_(bytes), name_(name) {}

    template <typename T>
    std::vector<T> take(std::size_t count) {
        std::vector<T> values(count);
        std::memcpy(values.data(), bytes_.data() + at_, count * sizeof(T));
        at_ += count * sizeof(T);
        return values;
    }

    // Floats within [low, high], none of them NaN.
    std::vector<float> take_floats(std::size_t count, float low, float high, const char* what) {
        const std::size_t start = at_;
        std::vector<float> values = take<float>(count);
        for (std::size_t i = 0; i < count; ++i)
            if (!(values[i] >= low && values[i] <= high))
                refuse(name_, fmt::format("byte {}: {} {} is outside {} to {}", start + 4 * i, what,
                                          values[i], low, high));
        return values;
    }

    std::vector<glm::vec3> take_vectors(std::size_t count, float low, float high, const char* what) {
        const std::vector<float> values = take_floats(3 * count, low, high, what);
        std::vector<glm::vec3> vectors(count);
        for (std::size_t i = 0; i < count; ++i)
            vectors[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
        return vectors;
    }

 private:
    std::span<const std::uint8_t> bytes_;
    const std::string& name_;
    std::size_t at_ = kHeaderBytes;
};

// A strand's colour or width from the header, held to the same range as an array's.
float checked(float value, float high, const char* what, const std::string& name) {
    if (!(value >= 0 && value <= high))
        refuse(name, fmt::format("header: default {} {} is outside 0 to {}", what, value, high));
    return value;
}

constexpr float kLargest = 1e9f;  // of a coordinate: sums and squares of such stay finite

// Where each strand begins, from the segments of each; a strand of n segments has n + 1 points.
std::vector<std::size_t> strand_starts(const std::vector<std::uint16_t>& segments, std::size_t points,
                                       const std::string& name) {
    std::vector<std::size_t> starts = {0};
    starts.reserve(segments.size() + 1);
    for (std::uint16_t count : segments) starts.push_back(starts.back() + count + 1u);
    if (starts.back() != points)
        refuse(name, fmt::format("byte {}: the segments of {} strands add up to {} points, the header says "
                                 "{}",
                                 kHeaderBytes, segments.size(), starts.back(), points));
    return starts;
}

// Drops strands of one point, which nothing can be drawn of.
void drop_single_points(HairFile& hair) {
    std::size_t kept_points = 0;
    std::vector<std::size_t> starts = {0};
    for (std::size_t i = 0; i < hair.strands(); ++i) {
        const std::size_t first = hair.first_points[i];
        const std::size_t last = hair.first_points[i + 1];
        if (last - first < 2) continue;
        for (std::size_t p = first; p < last; ++p, ++kept_points) {
            hair.points[kept_points] = hair.points[p];
            hair.thickness[kept_points] = hair.thickness[p];
            hair.transparency[kept_points] = hair.transparency[p];
            hair.colors[kept_points] = hair.colors[p];
        }
        starts.push_back(kept_points);
    }
    hair.points.resize(kept_points);
    hair.thickness.resize(kept_points);
    hair.transparency.resize(kept_points);
    hair.colors.resize(kept_points);
    hair.first_points = std::move(starts);
}

}  // namespace

HairFile parse_hair(std::span<const std::uint8_t> bytes, const std::string& name) {
    const HairHeader header = read_header(bytes, name);
    check_length(header, bytes.size(), name);
    ArrayReader reader(bytes, name);
    const std::size_t points = header.points;
    HairFile hair;
    std::vector<std::uint16_t> segments;
    if (header.flags & kHasSegments) {
        segments = reader.take<std::uint16_t>(header.strands);
        hair.first_points = strand_starts(segments, points, name);
    } else {
        for (std::size_t i = 0; i <= header.strands; ++i)
            hair.first_points.push_back(i * (std::size_t{header.segments} + 1));
    }
    hair.points = reader.take_vectors(points, -kLargest, kLargest, "coordinate");
    hair.thickness = header.flags & kHasThickness
                         ? reader.take_floats(points, 0, kLargest, "thickness")
                         : std::vector<float>(points, checked(header.thickness, kLargest, "thickness", name));
    hair.transparency =
        header.flags & kHasTransparency
            ? reader.take_floats(points, 0, 1, "transparency")
            : std::vector<float>(points, checked(header.transparency, 1, "transparency", name));
    if (header.flags & kHasColors) {
        hair.colors = reader.take_vectors(points, 0, 1, "colour");
    } else {
        glm::vec3 color;
        for (int c = 0; c < 3; ++c) color[c] = checked(header.color[c], 1, "colour", name);
        hair.colors.assign(points, color);
    }
    const char* info = reinterpret_cast<const char*>(bytes.data() + kInfoOffset);
    hair.info.assign(info, std::find(info, info + kInfoBytes, '\0'));
    drop_single_points(hair);
    if (hair.strands() == 0) refuse(name, "no strand has two points; nothing can be drawn");
    return hair;
}

HairFile load_hair(const std::string& path) {
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    std::ifstream stream(path, std::ios::binary);
    if (error || !stream) throw UserError(path, "no such .hair file, or it cannot be read");
    std::vector<std::uint8_t> bytes(size);
    stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
    if (static_cast<std::uintmax_t>(stream.gcount()) != size)
        throw UserError(path, fmt::format("only {} of {} bytes could be read", stream.gcount(), size));
    return parse_hair(bytes, path);
}

}  // namespace ropsim
