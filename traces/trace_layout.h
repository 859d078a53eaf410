// The layout of a trace file: fixed records, limits, and the cursor that reads them (docs/trace-format.md).
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace ropsim {

// Records are copied to and from the file as they lie in memory.
static_assert(std::endian::native == std::endian::little, "trace files are little-endian");

inline constexpr std::string_view kTraceMagic{"\x89ROPT\r\n\x1A", 8};
inline constexpr std::string_view kTraceEndMagic{"ROPTEND\n", 8};
inline constexpr std::uint32_t kTraceVersion = 2;

inline constexpr std::uint32_t kMaxChunkFragments = 1u << 18;
inline constexpr int kMaxRegionSide = 256;  // x and y within a region are one byte each
inline constexpr int kMaxImageSide = 16384;
inline constexpr std::uint64_t kMinBlockBytes = 16;  // bounds the index by the size of the file

// Something in the file contradicts the format; the reader adds the file's name and the place.
class FormatFault : public std::runtime_error {
 public:
    using std::runtime_error::runtime_error;
};

// A stretch of the file, with XXH64 (seed 0) of its bytes.
struct SectionRecord {
    std::uint64_t offset;
    std::uint64_t stored_bytes;
    std::uint64_t checksum;
};

struct PrologueRecord {
    char magic[8];
    std::uint32_t version;
    std::uint32_t reserved;  // 0
    SectionRecord header;
    SectionRecord opaque;    // stored_bytes 0: absent
    std::uint64_t checksum;  // XXH64 of the bytes before
};
static_assert(sizeof(PrologueRecord) == 72);

// The last bytes of the file.
struct TrailerRecord {
    SectionRecord index;
    std::uint64_t index_raw_bytes;
    std::uint64_t file_bytes;
    std::uint64_t checksum;  // XXH64 of the bytes before
    char magic[8];
};
static_assert(sizeof(TrailerRecord) == 56);

// The index: this record, its chunks, its blocks in file order, then a 64-bit fragment count for each tile.
struct IndexRecord {
    std::uint64_t fragments;
    std::uint64_t chunks;
    std::uint64_t blocks;
    std::uint64_t hash;           // of header, opaque layer and fragments
    std::uint64_t slope_hash;     // of the depth slopes, 0 where there are none
    std::uint64_t material_hash;  // of the materials, 0 where there are none
};
struct ChunkRecord {
    std::uint32_t fragments;
    std::uint32_t blocks;
};
struct BlockRecord {
    std::uint32_t region;  // row-major over the image's regions
    std::uint32_t fragments;
    std::uint64_t stored_bytes;
    std::uint64_t checksum;
};
static_assert(sizeof(IndexRecord) == 48 && sizeof(ChunkRecord) == 8 && sizeof(BlockRecord) == 24);

// Reads forward through bytes that may lie; runs past the end as a FormatFault.
class ByteCursor {
 public:
    ByteCursor(const std::uint8_t* data, std::size_t size) : at_(data), end_(data + size) {}
    std::size_t left() const { return static_cast<std::size_t>(end_ - at_); }
    const std::uint8_t* take(std::uint64_t bytes) {
        if (bytes > left()) throw FormatFault("ends early");
        const std::uint8_t* start = at_;
        at_ += bytes;
        return start;
    }
    std::uint8_t byte() { return *take(1); }
    // Unsigned LEB128 of at most 35 bits.
    std::uint64_t varint() {
        std::uint64_t value = 0;
        for (int shift = 0; shift < 35; shift += 7) {
            const std::uint8_t piece = byte();
            value |= static_cast<std::uint64_t>(piece & 0x7Fu) << shift;
            if (piece < 0x80) return value;
        }
        throw FormatFault("a size is longer than five bytes");
    }
    template <typename T>
    T record() {
        T value;
        std::memcpy(&value, take(sizeof(T)), sizeof(T));
        return value;
    }

 private:
    const std::uint8_t* at_;
    const std::uint8_t* end_;
};

using Bytes = std::vector<std::uint8_t>;

inline void put_bytes(Bytes& out, const void* data, std::size_t size) {
    const auto* bytes = static_cast<const std::uint8_t*>(data);
    out.insert(out.end(), bytes, bytes + size);
}

inline void put_varint(Bytes& out, std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) out.push_back(static_cast<std::uint8_t>(value | 0x80u));
    out.push_back(static_cast<std::uint8_t>(value));
}

}  // namespace ropsim
