// Holds what an OpenEXR file claims about its sizes against the file, before OpenEXR believes it.
// Layout: "OpenEXR File Layout" of the OpenEXR documentation.
#include "traces/interchange/deep_exr_guard.h"

#include "base/error.h"
#include "traces/trace_layout.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>
#include <utility>

namespace ropsim {

namespace {

constexpr std::uint32_t kExrMagic = 20000630;
constexpr std::uint32_t kMultiPartFlag = 0x1000;
constexpr std::uint8_t kNoCompression = 0;
constexpr std::uint64_t kLargestName = 255;
constexpr std::uint64_t kLargestDeflateRatio = 1032;    // of zlib; run lengths stay below
constexpr std::uint64_t kLargestRowBytes = 0x7FFFFFFF;  // OpenEXR's compressors count in int
// Of a flat image: OpenEXR unpacks this many rows at once at most (DWAB), into a buffer it makes before it
// reads any. No honest image packs better than the ratio; what small files may claim is allowed besides.
constexpr std::int64_t kLargestFlatSide = 65536;
constexpr std::int64_t kMostRowsAtOnce = 256;
constexpr std::uint64_t kLargestFlatRatio = 4096;
constexpr std::uint64_t kSmallFlatBytes = std::uint64_t{64} << 20;

// Types that OpenEXR reads by their own measure, whatever size the attribute gives: where the two differ, it
// would take the middle of a value for the next attribute, and its bytes for a size.
constexpr std::pair<std::string_view, std::uint64_t> kFixedSizes[] = {{"box2f", 16},
                                                                      {"box2i", 16},
                                                                      {"chromaticities", 32},
                                                                      {"compression", 1},
                                                                      {"deepImageState", 1},
                                                                      {"double", 8},
                                                                      {"envmap", 1},
                                                                      {"float", 4},
                                                                      {"int", 4},
                                                                      {"keycode", 28},
                                                                      {"lineOrder", 1},
                                                                      {"m33d", 72},
                                                                      {"m33f", 36},
                                                                      {"m44d", 128},
                                                                      {"m44f", 64},
                                                                      {"rational", 8},
                                                                      {"tiledesc", 9},
                                                                      {"timecode", 8},
                                                                      {"v2d", 16},
                                                                      {"v2f", 8},
                                                                      {"v2i", 8},
                                                                      {"v3d", 24},
                                                                      {"v3f", 12},
                                                                      {"v3i", 12}};

struct Part {
    std::string type;
    std::int32_t window[4] = {0, 0, -1, -1};  // left, top, right, bottom, inclusive
    std::int32_t chunks = -1;
    std::uint8_t compression = kNoCompression;
    std::uint64_t channels = 0;
    std::uint32_t tile_width = 0, tile_height = 0;  // of a tiled image
};

class Walk {
 public:
    explicit Walk(const std::string& path) : path_(path) {
        std::error_code error;
        if (!std::filesystem::is_regular_file(path, error))
            throw UserError(path, "no such file; check the name");
        size_ = std::filesystem::file_size(path);
        in_.open(path, std::ios::binary);
        if (!in_) throw UserError(path, "cannot open; check its permissions");
    }

    std::vector<ExrPartShape> run() {
        if (size_ < 8 || read<std::uint32_t>() != kExrMagic) throw UserError(path_, "is not an OpenEXR file");
        const bool several = (read<std::uint32_t>() & kMultiPartFlag) != 0;
        std::vector<Part> parts;
        do parts.push_back(read_part());
        while (several && peek() != 0);
        if (several) read<std::uint8_t>();
        std::vector<ExrPartShape> shapes;
        for (std::size_t i = 0; i < parts.size(); ++i) {
            const Part& part = parts[i];
            shapes.push_back({part.type, {}});
            if (!part.type.starts_with("deep")) check_flat(part);
            if (part.type == "deepscanline") {
                shapes.back().row_bytes = check_deep(part, several, static_cast<std::int32_t>(i));
            } else if (several) {
                if (part.chunks < 0) fail(at_, "a part has no chunkCount");
                skip(static_cast<std::uint64_t>(part.chunks) * 8);
            } else {
                break;  // the only part is of no interest
            }
        }
        return shapes;
    }

 private:
    [[noreturn]] void fail(std::uint64_t at, const std::string& what) const {
        throw UserError(path_, fmt::format("{} (at byte {}); the file is damaged or cut short", what, at));
    }
    void skip(std::uint64_t bytes) {
        if (bytes > size_ - at_)
            fail(at_, fmt::format("{} bytes are claimed where {} are left", bytes, size_ - at_));
        at_ += bytes;
    }
    void take(void* out, std::uint64_t bytes) {
        const std::uint64_t from = at_;
        skip(bytes);
        in_.seekg(static_cast<std::streamoff>(from));
        in_.read(static_cast<char*>(out), static_cast<std::streamsize>(bytes));
        if (!in_) fail(from, "cannot be read");
    }
    template <typename T>
    T read() {
        T value{};
        take(&value, sizeof(value));
        return value;
    }
    std::uint8_t peek() {
        const auto value = read<std::uint8_t>();
        --at_;
        return value;
    }
    std::string name() {
        std::string text;
        for (char c = read<char>(); c != 0; c = read<char>()) {
            text.push_back(c);
            if (text.size() > kLargestName) fail(at_, "a name is longer than 255 bytes");
        }
        return text;
    }

    // Whether a value that says by itself where it ends, or what to allocate, agrees with where its attribute
    // ends.
    void check_extent(const std::string& type, std::uint64_t end) {
        const std::uint64_t size = end - at_;
        const auto* fixed = std::find_if(std::begin(kFixedSizes), std::end(kFixedSizes),
                                         [&](const auto& known) { return known.first == type; });
        bool good = fixed == std::end(kFixedSizes) || fixed->second == size;
        if (type == "chlist") {
            constexpr std::uint64_t kChannelBytes = 16;  // after its name
            for (channels_ = 0; !name().empty(); ++channels_) skip(kChannelBytes);
            good = at_ == end;
        } else if (type == "stringvector") {
            while (at_ < end) skip(read<std::uint32_t>());
            good = at_ == end;
        } else if (type == "preview") {
            const auto width = size < 8 ? 0 : read<std::uint32_t>();
            const auto height = size < 8 ? 0 : read<std::uint32_t>();
            good = size >= 8 && std::uint64_t{width} * height == (size - 8) / 4 && size % 4 == 0;
        } else if (type == "idmanifest") {
            good = size >= 4 && read<std::uint32_t>() <= (size - 4) * kLargestDeflateRatio;
        }
        if (!good) fail(end, fmt::format("an attribute's size is not that of its value ({} bytes)", size));
    }

    Part read_part() {
        Part part;
        for (std::string attribute = name(); !attribute.empty(); attribute = name()) {
            const std::string type = name();
            const auto size = read<std::int32_t>();
            if (size < 0) fail(at_, "an attribute has a negative size");
            const std::uint64_t start = at_;
            skip(static_cast<std::uint64_t>(size));
            const std::uint64_t end = at_;
            at_ = start;
            check_extent(type, end);
            at_ = start;
            if (attribute == "type" && type == "string" && size <= static_cast<std::int32_t>(kLargestName)) {
                part.type.resize(static_cast<std::size_t>(size));
                take(part.type.data(), part.type.size());
            } else if (attribute == "dataWindow" && size == sizeof(part.window)) {
                take(part.window, sizeof(part.window));
            } else if (attribute == "chunkCount" && size == sizeof(part.chunks)) {
                part.chunks = read<std::int32_t>();
            } else if (attribute == "tiles" && size >= 8) {
                part.tile_width = read<std::uint32_t>();
                part.tile_height = read<std::uint32_t>();
            } else if (attribute == "compression" && size == 1) {
                part.compression = read<std::uint8_t>();
            } else if (type == "chlist") {
                part.channels = channels_;
            }
            at_ = end;
        }
        return part;
    }

    void check_flat(const Part& part) const {
        const std::int64_t width = std::int64_t{part.window[2]} - part.window[0] + 1;
        const std::int64_t height = std::int64_t{part.window[3]} - part.window[1] + 1;
        if (width < 1 || height < 1 || width > kLargestFlatSide || height > kLargestFlatSide)
            throw UserError(path_, fmt::format("is {}x{} pixels; 1 to {} a side can be read", width, height,
                                               kLargestFlatSide));
        // Tiles are unpacked whole, however little of them lies in the image.
        const std::int64_t across = std::max<std::int64_t>(width, part.tile_width);
        const std::int64_t down = std::max<std::int64_t>(std::min(height, kMostRowsAtOnce), part.tile_height);
        if (across > kLargestFlatSide || down > kLargestFlatSide)
            fail(at_, fmt::format("tiles of {}x{} pixels are claimed", part.tile_width, part.tile_height));
        const auto pixels = static_cast<std::uint64_t>(across * down);
        if (pixels * part.channels * sizeof(float) > kSmallFlatBytes + size_ * kLargestFlatRatio)
            fail(at_, fmt::format("{}x{} pixels of {} channels are claimed of {} bytes", width, height,
                                  part.channels, size_));
    }

    std::vector<std::uint64_t> check_deep(const Part& part, bool several, std::int32_t number) {
        const std::int64_t width = std::int64_t{part.window[2]} - part.window[0] + 1;
        const std::int64_t height = std::int64_t{part.window[3]} - part.window[1] + 1;
        if (width < 1 || height < 1 || width > kMaxImageSide || height > kMaxImageSide)
            throw UserError(path_, fmt::format("is {}x{} pixels; 1 to {} a side can be a trace", width,
                                               height, kMaxImageSide));
        if (part.chunks != height)
            fail(at_, fmt::format("{} chunks are claimed for {} rows", part.chunks, height));
        std::vector<std::uint64_t> offsets(static_cast<std::size_t>(height));
        take(offsets.data(), offsets.size() * sizeof(std::uint64_t));
        const std::uint64_t behind_table = at_;
        std::vector<std::uint64_t> row_bytes;
        for (std::int64_t row = 0; row < height; ++row) {
            at_ = offsets[static_cast<std::size_t>(row)];
            if (at_ < behind_table || at_ >= size_) {
                at_ = behind_table;
                fail(at_, fmt::format("row {} has no place in the file", part.window[1] + row));
            }
            row_bytes.push_back(check_chunk(part, several ? number : -1, part.window[1] + row,
                                            static_cast<std::uint64_t>(width)));
        }
        at_ = behind_table;
        return row_bytes;
    }

    std::uint64_t check_chunk(const Part& part, std::int32_t number, std::int64_t y, std::uint64_t width) {
        const std::uint64_t start = at_;
        if (number >= 0 && read<std::int32_t>() != number) fail(start, "a chunk is of another part");
        if (read<std::int32_t>() != y) fail(start, fmt::format("row {} has the chunk of another", y));
        const auto table = read<std::uint64_t>();
        const auto packed = read<std::uint64_t>();
        const auto unpacked = read<std::uint64_t>();
        skip(table);
        skip(packed);
        const auto holds = [&](std::uint64_t stored, std::uint64_t claimed) {
            return part.compression == kNoCompression ? stored == claimed
                                                      : claimed / kLargestDeflateRatio <= stored;
        };
        // A table that does not shrink is stored as it is.
        if (!holds(table, width * sizeof(std::int32_t)) || !holds(packed, unpacked) ||
            unpacked > kLargestRowBytes)
            fail(start, fmt::format("row {} claims {} bytes of samples in {}", y, unpacked, packed));
        return unpacked;
    }

    const std::string path_;
    std::ifstream in_;
    std::uint64_t size_ = 0;
    std::uint64_t at_ = 0;
    std::uint64_t channels_ = 0;  // of the last channel list
};

}  // namespace

std::vector<ExrPartShape> check_exr_claims(const std::string& path) {
    return Walk(path).run();
}

}  // namespace ropsim
