// A block of a trace file: the fragments of one chunk that lie in one screen region, as columns.
#include "traces/block_codec.h"

#include "traces/half_float.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include <fmt/format.h>

namespace ropsim {

namespace {

constexpr std::array<const char*, kColumnCount> kNames{
    "rank",    "x",       "y",  "z",  "r",  "g",           "b",   "a",  "primitive", "coverage", "draw",
    "slope_x", "slope_y", "tr", "tg", "tb", "collimation", "eta", "nx", "ny",        "nz"};

const char* name_of(int column) {
    return kNames[static_cast<std::size_t>(column)];
}

const char* column_type(int column, ColorStorage color_storage) {
    const char* const color = color_storage == ColorStorage::kFloat16 ? "f16" : "f32";
    switch (column) {
        case kX:
        case kY:
            return "u8";
        case kCoverage:
        case kDrawIndex:
            return "u16";
        case kRank:
        case kPrimitive:
            return "u32";
        case kRed:
        case kGreen:
        case kBlue:
            return color;
        default:
            return column >= kFirstMaterialChannel ? color : "f32";
    }
}

bool announced(int column, const TraceHeader& header) {
    if (column < kFirstChannel) return true;
    return column < kFirstMaterialChannel ? header.depth_slopes : header.materials;
}

bool is_wanted(int column, unsigned wanted) {
    if (column < kFirstChannel) return true;
    return (wanted & (column < kFirstMaterialChannel ? kSlopeChannels : kMaterialChannels)) != 0;
}

// Whether every value lies in [low, high]; a NaN lies nowhere. Written to vectorise: no early exit.
bool all_within(const std::vector<float>& values, std::size_t count, float low, float high) {
    unsigned outside = 0;
    for (std::size_t i = 0; i < count; ++i)
        outside |= static_cast<unsigned>(!(values[i] >= low)) | static_cast<unsigned>(!(values[i] <= high));
    return outside == 0;
}

template <typename T>
bool all_below(const std::vector<T>& values, std::size_t count, std::uint32_t end) {
    T largest = 0;
    for (std::size_t i = 0; i < count; ++i) largest = std::max(largest, values[i]);
    return largest < end;
}

}  // namespace

std::vector<ColumnDescription> written_columns(const TraceHeader& header) {
    std::vector<ColumnDescription> result;
    for (int column = 0; column < kColumnCount; ++column)
        if (announced(column, header))
            result.push_back({name_of(column), column_type(column, header.color_storage), true});
    return result;
}

std::vector<int> map_columns(const std::vector<ColumnDescription>& columns, const TraceHeader& header) {
    std::vector<int> result;
    for (const ColumnDescription& column : columns) {
        const auto found = std::find(kNames.begin(), kNames.end(), column.name);
        const int id = found == kNames.end() ? -1 : static_cast<int>(found - kNames.begin());
        if (id < 0 && column.required)
            throw FormatFault(fmt::format(
                "holds a column '{}' that this version does not know; use a newer one", column.name));
        if (id >= 0 && !announced(id, header))
            throw FormatFault(fmt::format("column '{}' is there, but not announced", column.name));
        if (id >= 0 && column.type != column_type(id, header.color_storage))
            throw FormatFault(fmt::format("column '{}' has type '{}'; '{}' is expected", column.name,
                                          column.type, column_type(id, header.color_storage)));
        if (id >= 0 && std::find(result.begin(), result.end(), id) != result.end())
            throw FormatFault(fmt::format("column '{}' is there twice", column.name));
        result.push_back(id);
    }
    for (int id = 0; id < kColumnCount; ++id)
        if (announced(id, header) && std::find(result.begin(), result.end(), id) == result.end())
            throw FormatFault(fmt::format("column '{}' is missing", name_of(id)));
    return result;
}

RegionBounds region_bounds(const TraceHeader& header, int region_side, std::uint32_t region) {
    const int across = (header.width + region_side - 1) / region_side;
    const int left = static_cast<int>(region) % across * region_side;
    const int top = static_cast<int>(region) / across * region_side;
    return {left, top, std::min(left + region_side, header.width),
            std::min(top + region_side, header.height)};
}

template <typename T, typename Get>
void BlockEncoder::put(std::vector<T>& scratch, std::size_t count, Bytes& out, Get&& get) {
    scratch.resize(count);
    for (std::size_t i = 0; i < count; ++i) scratch[i] = get(i);
    column_.clear();
    encoder_.encode(scratch.data(), count, column_);
    put_varint(out, column_.size());
    put_bytes(out, column_.data(), column_.size());
}

template <typename Get>
void BlockEncoder::put_real(bool half, std::size_t count, Bytes& out, Get&& get) {
    if (half)
        put(words_, count, out, [&](std::size_t i) { return half_from_float(get(i)); });
    else
        put(dwords_, count, out, [&](std::size_t i) { return std::bit_cast<std::uint32_t>(get(i)); });
}

void BlockEncoder::encode(const FragmentChunk& chunk, const std::uint32_t* ranks, std::size_t count,
                          const RegionBounds& bounds, ColorStorage color_storage, Bytes& out) {
    const auto at = [&](std::size_t i) -> const Fragment& { return chunk.fragments[ranks[i]]; };
    const bool half = color_storage == ColorStorage::kFloat16;
    put(dwords_, count, out, [&](std::size_t i) { return ranks[i]; });
    put(bytes_, count, out, [&](std::size_t i) { return static_cast<std::uint8_t>(at(i).x - bounds.left); });
    put(bytes_, count, out, [&](std::size_t i) { return static_cast<std::uint8_t>(at(i).y - bounds.top); });
    put_real(false, count, out, [&](std::size_t i) { return at(i).z; });
    for (const auto channel : {&Fragment::r, &Fragment::g, &Fragment::b})
        put_real(half, count, out, [&](std::size_t i) { return at(i).*channel; });
    put_real(false, count, out, [&](std::size_t i) { return at(i).a; });
    put(dwords_, count, out, [&](std::size_t i) { return at(i).primitive; });
    put(words_, count, out, [&](std::size_t i) { return at(i).coverage; });
    put(words_, count, out, [&](std::size_t i) { return at(i).draw; });
    if (!chunk.slopes.empty())
        for (const auto channel : {&DepthSlope::dx, &DepthSlope::dy})
            put_real(false, count, out, [&](std::size_t i) { return chunk.slopes[ranks[i]].*channel; });
    if (chunk.materials.empty()) return;
    const auto surface = [&](std::size_t i) -> const Material& { return chunk.materials[ranks[i]]; };
    for (int c = 0; c < 3; ++c)
        put_real(half, count, out, [&](std::size_t i) { return surface(i).transmission[c]; });
    put_real(half, count, out, [&](std::size_t i) { return surface(i).collimation; });
    put_real(half, count, out, [&](std::size_t i) { return surface(i).eta; });
    for (int c = 0; c < 3; ++c)
        put_real(half, count, out, [&](std::size_t i) { return surface(i).normal[c]; });
}

BlockDecoder::BlockDecoder(const TraceHeader& header, std::vector<int> columns)
    : color_storage_(header.color_storage),
      non_finite_(header.non_finite),
      draws_(static_cast<std::uint32_t>(header.draws.size())),
      coverage_end_(1u << header.samples),
      columns_(std::move(columns)) {}

const BlockColumns& BlockDecoder::decode(const std::uint8_t* data, std::size_t size, std::size_t count,
                                         std::uint32_t chunk_fragments, const RegionBounds& bounds,
                                         unsigned wanted) {
    ByteCursor in(data, size);
    for (const int column : columns_) {
        const std::uint64_t bytes = in.varint();
        const ByteCursor body(in.take(bytes), bytes);
        if (column < 0 || !is_wanted(column, wanted)) continue;
        try {
            decode_column(column, body, count);
        } catch (const FormatFault& fault) {
            throw FormatFault(fmt::format("column '{}' {}", name_of(column), fault.what()));
        }
    }
    if (in.left() != 0) throw FormatFault("is longer than its columns");
    validate(count, chunk_fragments, bounds);
    if (!non_finite_) validate_values(count, wanted);
    return block_;
}

void BlockDecoder::decode_column(int column, ByteCursor in, std::size_t count) {
    const auto decode = [&](auto& out) {
        out.resize(count);
        decoder_.decode(in, count, out.data());
    };
    switch (column) {
        case kRank:
            return decode(block_.rank);
        case kX:
            return decode(block_.x);
        case kY:
            return decode(block_.y);
        case kZ:
            return decode_float(in, count, block_.z);
        case kRed:
            return decode_color(in, count, block_.red);
        case kGreen:
            return decode_color(in, count, block_.green);
        case kBlue:
            return decode_color(in, count, block_.blue);
        case kAlpha:
            return decode_float(in, count, block_.alpha);
        case kPrimitive:
            return decode(block_.primitive);
        case kCoverage:
            return decode(block_.coverage);
        case kDrawIndex:
            return decode(block_.draw);
        default:
            break;
    }
    std::vector<float>& channel = block_.channels[static_cast<std::size_t>(column - kFirstChannel)];
    if (column >= kFirstMaterialChannel)
        decode_color(in, count, channel);
    else
        decode_float(in, count, channel);
}

void BlockDecoder::decode_float(ByteCursor in, std::size_t count, std::vector<float>& out) {
    dwords_.resize(count);
    out.resize(count);
    decoder_.decode(in, count, dwords_.data());
    std::memcpy(out.data(), dwords_.data(), count * sizeof(float));
}

void BlockDecoder::decode_color(ByteCursor in, std::size_t count, std::vector<float>& out) {
    if (color_storage_ == ColorStorage::kFloat32) return decode_float(in, count, out);
    words_.resize(count);
    out.resize(count);
    decoder_.decode(in, count, words_.data());
    for (std::size_t i = 0; i < count; ++i) out[i] = float_from_half(words_[i]);
}

void BlockDecoder::validate(std::size_t count, std::uint32_t chunk_fragments,
                            const RegionBounds& bounds) const {
    unsigned falling = 0;
    for (std::size_t i = 1; i < count; ++i)
        falling |= static_cast<unsigned>(block_.rank[i] <= block_.rank[i - 1]);
    if (falling != 0 || block_.rank[count - 1] >= chunk_fragments)
        throw FormatFault("holds ranks out of order");
    if (!all_below(block_.x, count, static_cast<std::uint32_t>(bounds.right - bounds.left)) ||
        !all_below(block_.y, count, static_cast<std::uint32_t>(bounds.bottom - bounds.top)))
        throw FormatFault("holds pixels outside its region");
    if (!all_below(block_.coverage, count, coverage_end_))
        throw FormatFault("holds a coverage of too many samples");
    if (!all_below(block_.draw, count, draws_)) throw FormatFault("names a draw that does not exist");
}

void BlockDecoder::validate_values(std::size_t count, unsigned wanted) const {
    if (!all_within(block_.z, count, 0, 1)) throw FormatFault("holds a depth outside [0, 1]");
    if (!all_within(block_.alpha, count, 0, 1)) throw FormatFault("holds an alpha outside [0, 1]");
    const float largest =
        color_storage_ == ColorStorage::kFloat16 ? kLargestHalf : std::numeric_limits<float>::max();
    for (const auto* color : {&block_.red, &block_.green, &block_.blue})
        if (!all_within(*color, count, -largest, largest))
            throw FormatFault("holds a colour that is not finite");
    for (const int column : columns_) {
        if (column < kFirstChannel || !is_wanted(column, wanted)) continue;
        const bool share = column >= kTransmissionR && column <= kCollimation;
        const float limit = column < kFirstMaterialChannel ? std::numeric_limits<float>::max() : largest;
        if (!all_within(block_.channels[static_cast<std::size_t>(column - kFirstChannel)], count,
                        share ? 0.0f : -limit, share ? 1.0f : limit))
            throw FormatFault(fmt::format("holds a value of '{}' out of range", name_of(column)));
    }
}

}  // namespace ropsim
