// Formats and contents of blocks that tests and the benchmark of codecs share.
#pragma once

#include "base/random.h"
#include "memory/block_codec.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

namespace ropsim::block_samples {

inline constexpr std::array kKinds{CodecKind::kDepthPlanes,   CodecKind::kDepthDelta, CodecKind::kDepthBest,
                                   CodecKind::kColorDelta,    CodecKind::kNodeDelta,  CodecKind::kNodesUsed,
                                   CodecKind::kNodesUsedDelta};

inline std::vector<std::uint32_t> levels(std::uint32_t block_bytes) {
    std::vector<std::uint32_t> result;
    for (const std::uint32_t level : {16u, 32u, 64u, 128u, 192u})
        if (level < block_bytes) result.push_back(level);
    return result;
}

// A sequence of random numbers.
class Source {
 public:
    explicit Source(std::uint64_t seed) : state_(seed) {}
    std::uint64_t next() { return mix64(state_++ * 0x9E3779B97F4A7C15u + 1); }
    std::uint32_t below(std::uint32_t end) { return static_cast<std::uint32_t>((next() >> 11) % end); }

 private:
    std::uint64_t state_;
};

inline BlockFormat format(SurfaceClass surface_class, std::uint32_t element_bytes, std::uint32_t elements,
                          bool planar, std::vector<BlockField> fields, std::uint32_t block_bytes = 256) {
    BlockFormat f;
    f.surface_class = surface_class;
    f.block_bytes = block_bytes;
    f.element_bytes = element_bytes;
    f.elements = elements;
    f.planar = planar;
    f.fields = std::move(fields);
    f.clear_element.assign(element_bytes, 0);
    return f;
}

// Fields of random widths, kinds and gaps.
inline BlockFormat random_format(std::uint32_t element_bytes, std::uint32_t block_bytes, std::uint64_t seed) {
    Source source(seed);
    std::vector<BlockField> fields;
    const std::uint32_t bits = element_bytes * 8;
    for (std::uint32_t bit = source.below(4) == 0 ? source.below(9) : 0; bit < bits;) {
        BlockField field{static_cast<std::uint16_t>(bit), 0, 1, FieldKind::kInteger};
        constexpr std::array<std::uint8_t, 8> kWidths{8, 16, 32, 24, 11, 5, 64, 16};
        constexpr std::array<FieldKind, 8> kFieldKinds{
            FieldKind::kUnorm,   FieldKind::kFloat16, FieldKind::kFloat32, FieldKind::kUnorm,
            FieldKind::kInteger, FieldKind::kSnorm,   FieldKind::kInteger, FieldKind::kPacked};
        const std::uint32_t pick = source.below(8);
        field.bits = kWidths[pick];
        field.kind = kFieldKinds[pick];
        if (bit + field.bits > bits) {
            field.bits = static_cast<std::uint8_t>(std::min(bits - bit, 8u));
            field.kind = FieldKind::kInteger;
        }
        const std::uint32_t room = (bits - bit) / field.bits;
        field.channels = static_cast<std::uint8_t>(1 + source.below(std::min(room, 4u)));
        bit += field.bits * field.channels + (source.below(5) == 0 ? source.below(20) : 0);
        fields.push_back(field);
    }
    BlockFormat f = format(SurfaceClass::kNodes, element_bytes, 1 + source.below(5), source.below(3) == 0,
                           std::move(fields), block_bytes);
    for (std::uint8_t& byte : f.clear_element) byte = static_cast<std::uint8_t>(source.below(3) * 100);
    return f;
}

// As techniques declare them.
inline std::vector<BlockFormat> surfaces() {
    using enum FieldKind;
    using enum SurfaceClass;
    std::vector<BlockFormat> all{
        format(kDepth, 4, 1, true, {{0, 32, 1, kFloat32}}),
        format(kDepth, 3, 1, true, {{0, 24, 1, kUnorm}}),
        format(kDepth, 2, 1, true, {{0, 16, 1, kUnorm}}),
        format(kDepth, 4, 1, true, {{0, 24, 1, kUnorm}, {24, 8, 1, kInteger}}),
        format(kDepth, 4, 4, true, {{0, 32, 1, kFloat32}}),
        format(kColor, 4, 1, false, {{0, 8, 4, kUnorm}}),
        format(kColor, 8, 1, false, {{0, 16, 4, kFloat16}}),
        format(kColor, 16, 1, false, {{0, 32, 4, kFloat32}}),
        format(kColor, 4, 1, false, {{0, 11, 2, kInteger}, {22, 10, 1, kInteger}}),
        format(kColor, 4, 1, false, {{0, 32, 1, kPacked}}),
        format(kColor, 6, 4, true, {{0, 16, 3, kFloat16}}),
        format(kColor, 8, 4, false, {{0, 16, 4, kUnorm}}),
        format(kColor, 1, 1, false, {{0, 8, 1, kPacked}}),
        format(kNodes, 8, 8, false, {{0, 32, 1, kFloat32}, {32, 8, 4, kUnorm}}),
        format(kNodes, 8, 8, true, {{0, 32, 1, kFloat32}, {32, 32, 1, kFloat32}}),
        format(kNodes, 12, 4, false, {{0, 32, 1, kFloat32}, {32, 16, 4, kFloat16}}),
        format(kNodes, 20, 8, false, {{0, 32, 5, kFloat32}}),
        format(kNodes, 12, 0, false, {{0, 32, 1, kFloat32}, {32, 32, 1, kInteger}, {64, 8, 4, kUnorm}}),
    };
    return all;
}

enum class Content : int {
    kRandom,
    kZero,
    kClear,
    kOneValue,
    kRamp,
    kPlane,
    kTwoPlanes,
    kOutlier,
    kSpecial,
    kNoise,
    kSortedNodes,
    kAlternating
};
inline constexpr int kContents = static_cast<int>(Content::kAlternating) + 1;

inline void put_bits(std::vector<std::uint8_t>& bytes, std::size_t bit, std::uint32_t count,
                     std::uint64_t value) {
    for (std::uint32_t i = 0; i < count; ++i, ++bit) {
        const auto mask = static_cast<std::uint8_t>(1u << (bit % 8));
        if ((value >> i & 1) != 0)
            bytes[bit / 8] |= mask;
        else
            bytes[bit / 8] &= static_cast<std::uint8_t>(~mask);
    }
}

// Quad order.
inline std::uint32_t pixel_x(std::uint32_t pixel) {
    return (pixel >> 2 & 3) * 2 + (pixel & 1);
}
inline std::uint32_t pixel_y(std::uint32_t pixel) {
    return (pixel >> 4) * 2 + (pixel >> 1 & 1);
}

// Floats that are awkward: signed zeros, denormals, infinities, NaNs with payloads.
inline std::uint64_t special(std::uint32_t bits, Source& source) {
    const std::uint64_t exponent = bits == 16 ? 0x7C00u : 0x7F800000u;
    const std::uint64_t sign = source.below(2) * (std::uint64_t{1} << (bits - 1));
    switch (source.below(5)) {
        case 0:
            return sign;
        case 1:
            return sign | source.below(200);
        case 2:
            return sign | exponent;
        case 3:
            return sign | exponent | (1 + source.below(900));
        default:
            return sign | exponent >> 1;
    }
}

// Value of a channel at a pixel's element.
inline std::uint64_t value_of(Content content, std::uint32_t bits, std::uint32_t pixel, std::uint32_t element,
                              std::uint32_t channel, std::uint64_t tile_seed, Source& source) {
    const std::uint32_t x = pixel_x(pixel);
    const std::uint32_t y = pixel_y(pixel);
    const std::uint64_t base = mix64(tile_seed + channel) >> 4;
    const std::uint64_t slope = 1 + base % 5;
    switch (content) {
        case Content::kOneValue:
            return base;
        case Content::kRamp:
            return base + slope * (std::uint64_t{pixel} * 8 + element);
        case Content::kPlane:
            return (base >> 3) + slope * 3 * x + slope * 7 * y;
        case Content::kTwoPlanes:
            return 2 * x + y > 9 ? (base >> 3) + slope * 3 * x + y : (base >> 5) + 2 * y;
        case Content::kOutlier:
            return pixel == tile_seed % 64 ? ~base : base;
        case Content::kSpecial:
            return bits == 16 || bits == 32 ? special(bits, source) : source.next();
        case Content::kNoise:
            return base + source.below(6);
        case Content::kSortedNodes:
            return base / 2 + (channel == 0 ? std::uint64_t{element} * 40 : 0) + source.below(9);
        default:
            return ((pixel + element) % 2 != 0 ? 0 : ~std::uint64_t{0});
    }
}

// The tile's bytes and its padding to whole blocks.
inline std::vector<std::uint8_t> tile(const BlockFormat& f, Content content, std::uint64_t seed) {
    Source source(seed);
    const std::uint32_t elements = std::max(f.elements, 1u);
    const std::uint32_t payload = 64 * elements * f.element_bytes;
    const std::size_t blocks = (payload + f.block_bytes - 1) / f.block_bytes;
    std::vector<std::uint8_t> bytes(blocks * f.block_bytes, 0);
    if (content == Content::kRandom) {
        for (std::uint32_t b = 0; b < payload; ++b) bytes[b] = static_cast<std::uint8_t>(source.next() >> 24);
        return bytes;
    }
    if (content == Content::kZero) return bytes;
    for (std::uint32_t at = 0; at < 64 * elements; ++at) {
        std::memcpy(bytes.data() + std::size_t{at} * f.element_bytes, f.clear_element.data(),
                    f.element_bytes);
        const std::uint32_t pixel = f.planar ? at % 64 : at / elements;
        const std::uint32_t element = f.planar ? at / 64 : at % elements;
        if (content == Content::kClear) continue;
        if (content == Content::kSortedNodes && element >= mix64(seed + pixel) % (elements + 1)) continue;
        std::uint32_t channel = 0;
        for (const BlockField& field : f.fields)
            for (std::uint32_t c = 0; c < field.channels; ++c, ++channel)
                put_bits(bytes,
                         std::size_t{at} * f.element_bytes * 8 + field.bit + std::size_t{c} * field.bits,
                         field.bits, value_of(content, field.bits, pixel, element, channel, seed, source));
    }
    return bytes;
}

}  // namespace ropsim::block_samples
