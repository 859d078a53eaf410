// A block of a trace file: the fragments of one chunk that lie in one screen region, as columns.
#pragma once

#include "traces/column_codec.h"
#include "traces/fragment.h"
#include "traces/trace.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

// The columns this version knows, in the order that it writes them.
enum ColumnId : int {
    kRank,
    kX,
    kY,
    kZ,
    kRed,
    kGreen,
    kBlue,
    kAlpha,
    kPrimitive,
    kCoverage,
    kDrawIndex,
    // Channels, where the header says so.
    kSlopeX,
    kSlopeY,
    kTransmissionR,
    kTransmissionG,
    kTransmissionB,
    kCollimation,
    kEta,
    kNormalX,
    kNormalY,
    kNormalZ,
    kColumnCount
};
inline constexpr int kFirstChannel = kSlopeX;
inline constexpr int kFirstMaterialChannel = kTransmissionR;
inline constexpr std::size_t kChannelCount = kColumnCount - kFirstChannel;

// A column as the file's header describes it.
struct ColumnDescription {
    std::string name;
    std::string type;  // u8, u16, u32, f16, f32
    bool required = true;
};
std::vector<ColumnDescription> written_columns(const TraceHeader& header);

// Maps the columns of a file, in file order, to ColumnId, -1 for an optional one to skip. Throws FormatFault
// on a required column that is unknown, a known one that is missing, given twice, of the wrong type, or a
// channel that the header does not announce.
std::vector<int> map_columns(const std::vector<ColumnDescription>& columns, const TraceHeader& header);

// The pixels of a region: x in [left, right), y in [top, bottom).
struct RegionBounds {
    int left, top, right, bottom;
};
RegionBounds region_bounds(const TraceHeader& header, int region_side, std::uint32_t region);

// Encodes blocks; one thread at a time.
class BlockEncoder {
 public:
    // Appends to `out` the block of the chunk's fragments ranks[0], ..., ranks[count - 1], with the channels
    // that the chunk has: ranks rise, pixels lie in `bounds`.
    void encode(const FragmentChunk& chunk, const std::uint32_t* ranks, std::size_t count,
                const RegionBounds& bounds, ColorStorage color_storage, Bytes& out);

 private:
    template <typename T, typename Get>
    void put(std::vector<T>& scratch, std::size_t count, Bytes& out, Get&& get);
    template <typename Get>
    void put_real(bool half, std::size_t count, Bytes& out, Get&& get);

    ColumnEncoder encoder_;
    std::vector<std::uint8_t> bytes_;
    std::vector<std::uint16_t> words_;
    std::vector<std::uint32_t> dwords_;
    Bytes column_;
};

// The decoded columns of a block.
struct BlockColumns {
    std::vector<std::uint32_t> rank, primitive;
    std::vector<std::uint8_t> x, y;  // from the region's corner
    std::vector<std::uint16_t> coverage, draw;
    std::vector<float> z, red, green, blue, alpha;
    std::array<std::vector<float>, kChannelCount> channels;  // by ColumnId - kFirstChannel

    DepthSlope slope(std::size_t i) const { return {channels[0][i], channels[1][i]}; }
    Material material(std::size_t i) const {
        const auto value = [&](int column) {
            return channels[static_cast<std::size_t>(column - kFirstChannel)][i];
        };
        return {{value(kTransmissionR), value(kTransmissionG), value(kTransmissionB)},
                value(kCollimation),
                value(kEta),
                {value(kNormalX), value(kNormalY), value(kNormalZ)}};
    }
    Fragment fragment(std::size_t i, const RegionBounds& bounds) const {
        return {z[i],
                red[i],
                green[i],
                blue[i],
                alpha[i],
                static_cast<std::uint16_t>(bounds.left + x[i]),
                static_cast<std::uint16_t>(bounds.top + y[i]),
                primitive[i],
                coverage[i],
                draw[i]};
    }
};

// Decodes and validates blocks; one thread at a time.
class BlockDecoder {
 public:
    BlockDecoder(const TraceHeader& header, std::vector<int> columns);
    // Throws FormatFault when the bytes are no block, or a value is out of range: ranks must rise and stay
    // below `chunk_fragments`, pixels lie in the region, draws exist, coverage fit the samples, and, unless
    // the header says non_finite, z, alpha, transmission and collimation be in [0, 1] and the rest finite.
    // Channels outside `wanted` (ChannelSet) are skipped. The result stays valid until the next call.
    const BlockColumns& decode(const std::uint8_t* data, std::size_t size, std::size_t count,
                               std::uint32_t chunk_fragments, const RegionBounds& bounds, unsigned wanted);

 private:
    void decode_column(int column, ByteCursor in, std::size_t count);
    void decode_color(ByteCursor in, std::size_t count, std::vector<float>& out);
    void decode_float(ByteCursor in, std::size_t count, std::vector<float>& out);
    void validate(std::size_t count, std::uint32_t chunk_fragments, const RegionBounds& bounds) const;
    void validate_values(std::size_t count, unsigned wanted) const;

    ColorStorage color_storage_;
    bool non_finite_;
    std::uint32_t draws_;
    std::uint32_t coverage_end_;
    std::vector<int> columns_;
    ColumnDecoder decoder_;
    BlockColumns block_;
    std::vector<std::uint16_t> words_;
    std::vector<std::uint32_t> dwords_;
};

}  // namespace ropsim
