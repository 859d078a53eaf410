// Sizes of compressed blocks whose contents have a closed form: what fits a level, and what is a bit too
// much.
#include "memory/block_codec.h"
#include "memory/depth_references.h"
#include "tests/memory/block_samples.h"

#include <array>
#include <cstring>
#include <functional>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using block_samples::pixel_x;
using block_samples::pixel_y;

// All levels that a block of 256 bytes can have: what compress() returns tells the size to 8 bytes.
std::vector<std::uint32_t> fine_levels() {
    std::vector<std::uint32_t> levels;
    for (std::uint32_t level = 8; level < 256; level += 8) levels.push_back(level);
    return levels;
}

constexpr std::uint32_t level_of(std::uint32_t bits) {
    return std::min((bits + 63) / 64 * 8, 256u);
}

// Compressed size of a block; checks that it comes back, too.
std::uint32_t size_of(CodecKind kind, const BlockFormat& format, const std::vector<std::uint8_t>& block,
                      std::vector<std::uint32_t> levels = fine_levels()) {
    const BlockCodec codec(kind, format, std::move(levels));
    std::array<std::uint8_t, 256> packed;
    const std::uint32_t bytes = codec.compress(block.data(), 0, packed.data());
    if (bytes == 256) return bytes;
    std::array<std::uint8_t, 256> back;
    codec.decompress(packed.data(), bytes, 0, back.data());
    EXPECT_EQ(std::memcmp(back.data(), block.data(), 256), 0) << bytes;
    return bytes;
}

// A block whose field's channel c of element i is value(i, c).
template <typename Value>
std::vector<std::uint8_t> fill(const BlockFormat& format, Value&& value) {
    std::vector<std::uint8_t> block(256, 0);
    for (std::uint32_t i = 0; i < 256 / format.element_bytes; ++i) {
        std::uint32_t channel = 0;
        for (const BlockField& field : format.fields)
            for (std::uint32_t c = 0; c < field.channels; ++c, ++channel)
                block_samples::put_bits(
                    block,
                    std::size_t{i} * format.element_bytes * 8 + field.bit + std::size_t{c} * field.bits,
                    field.bits, value(i, channel));
    }
    return block;
}

BlockFormat color(std::uint32_t bits, FieldKind kind) {
    return block_samples::format(SurfaceClass::kColor, bits / 2, 1, false,
                                 {{0, static_cast<std::uint8_t>(bits), 4, kind}});
}
const BlockFormat depth_float =
    block_samples::format(SurfaceClass::kDepth, 4, 1, true, {{0, 32, 1, FieldKind::kFloat32}});
const BlockFormat nodes = block_samples::format(
    SurfaceClass::kNodes, 8, 8, false, {{0, 32, 1, FieldKind::kFloat32}, {32, 8, 4, FieldKind::kUnorm}});

// Noise of `width` bits that has its least and its largest value in two quads, one each at their anchors.
std::uint32_t noise(std::uint32_t i, std::uint32_t c, std::uint32_t width) {
    const auto largest = static_cast<std::uint32_t>(low_bits(width));
    if (i == 0 || i == 5) return 0;
    if (i == 1 || i == 4) return largest;
    if (i == 8 + c) return c % 2 == 0 ? largest : 0;
    return static_cast<std::uint32_t>(mix64(i * 7 + c) >> 20) & largest;
}

TEST(BlockCodecSize, ColorOfEveryWidth) {
    for (const std::uint32_t bits : {8u, 16u, 32u}) {
        const BlockFormat format = color(bits, FieldKind::kUnorm);
        const std::uint32_t pixels = 512 / bits;
        const std::uint32_t header = 2 + 4 * (2 + (bits == 8 ? 4 : bits == 16 ? 5 : 6) + bits);
        for (std::uint32_t width = 0; width < bits; ++width) {
            const auto block = fill(format, [&](std::uint32_t i, std::uint32_t c) {
                return (c + 1) * 3 % 2 + noise(i, c, width);
            });
            EXPECT_EQ(size_of(CodecKind::kColorDelta, format, block), level_of(header + 4 * pixels * width))
                << bits << " bits, deltas of " << width;
        }
    }
}

TEST(BlockCodecSize, ColorLevelsTakeOneWidthAndNotTheNext) {
    const BlockFormat format = color(8, FieldKind::kUnorm);
    // 58 bits of header and 256 for each bit of the deltas.
    const std::array<std::uint32_t, 6> expected{32, 64, 128, 128, 256, 256};
    for (std::uint32_t width = 0; width < expected.size(); ++width) {
        const auto block =
            fill(format, [&](std::uint32_t i, std::uint32_t c) { return 40 * c + noise(i, c, width); });
        EXPECT_EQ(size_of(CodecKind::kColorDelta, format, block, {32, 64, 128}), expected[width]) << width;
    }
}

TEST(BlockCodecSize, ChannelsHaveWidthsOfTheirOwn) {
    const BlockFormat format = color(8, FieldKind::kUnorm);
    const auto block = fill(format, [](std::uint32_t i, std::uint32_t c) { return noise(i, c, c * 2); });
    EXPECT_EQ(size_of(CodecKind::kColorDelta, format, block), level_of(58 + 64 * (0 + 2 + 4 + 6)));
}

TEST(BlockCodecSize, ConstantBlocksFitTheSmallestLevel) {
    for (const auto& [bits, kind] : {std::pair{8u, FieldKind::kUnorm}, std::pair{16u, FieldKind::kFloat16},
                                     std::pair{32u, FieldKind::kFloat32}}) {
        const BlockFormat format = color(bits, kind);
        const auto block = fill(format, [](std::uint32_t, std::uint32_t c) { return mix64(c); });
        EXPECT_EQ(size_of(CodecKind::kColorDelta, format, block, {32, 64, 128}), 32u) << bits;
    }
}

TEST(BlockCodecSize, FloatsOrderAcrossZeroAsIntegersDo) {
    // Four denormals of either sign, and both zeros: ten neighbours in order, four bits.
    const BlockFormat format = color(16, FieldKind::kFloat16);
    const auto block = fill(format, [](std::uint32_t i, std::uint32_t c) {
        const std::uint32_t k = noise(i, c, 3);
        return k < 4 ? 0x8000u + 4 - k : k - 4;
    });
    EXPECT_EQ(size_of(CodecKind::kColorDelta, format, block), level_of(2 + 4 * 23 + 128 * 4));
}

TEST(BlockCodecSize, QuadsOfTheirOwnColor) {
    const BlockFormat format = color(8, FieldKind::kUnorm);
    for (std::uint32_t width = 0; width <= 4; ++width) {
        // Red: anchors of eight bits, deltas from 0 to 2^width - 1.
        const auto block = fill(format, [&](std::uint32_t i, std::uint32_t c) -> std::uint32_t {
            if (c != 0) return 9;
            const std::uint32_t anchor = i / 4 == 3 ? 0 : i / 4 == 7 ? 255 : i / 4 * 67 % 256;
            return anchor + (i % 4 == 0   ? 0
                             : i / 4 == 2 ? (i % 4 == 1 ? 0 : low_bits(width))
                                          : mix64(i) & low_bits(width));
        });
        EXPECT_EQ(size_of(CodecKind::kColorDelta, format, block),
                  level_of(2 + 4 * 14 + 12 + 16 * 8 + 48 * width))
            << width;
    }
}

TEST(BlockCodecSize, ChannelsThatFollowTheOneBefore) {
    const BlockFormat format = color(16, FieldKind::kFloat16);
    for (std::uint32_t width = 0; width <= 8; ++width) {
        // Each channel is the one before, 1000 more, and noise; the first is noise of sixteen bits.
        const auto block = fill(format, [&](std::uint32_t i, std::uint32_t c) {
            std::uint32_t value = noise(i, 0, 15);
            for (std::uint32_t k = 1; k <= c; ++k) value += 1000 + noise(i, k, width);
            return value;
        });
        EXPECT_EQ(size_of(CodecKind::kColorDelta, color(16, FieldKind::kInteger), block),
                  level_of(2 + 4 * 23 + 32 * 15 + 3 * 32 * width))
            << width;
    }
}

// Depth bits of a plane with integer slopes and corrections of `width` bits, none at its three references.
std::vector<std::uint8_t> plane(std::uint32_t width) {
    return fill(depth_float, [&](std::uint32_t i, std::uint32_t) {
        const std::uint32_t x = pixel_x(i);
        const std::uint32_t y = pixel_y(i);
        const bool reference = (x == 0 && y == 0) || (x == 7 && y == 0) || (x == 0 && y == 7);
        const std::uint32_t c = i == 9 ? static_cast<std::uint32_t>(low_bits(width)) : noise(i, 3, width);
        return 0x3F400000u + 100003 * x + 70001 * y + (reference ? 0 : c);
    });
}

TEST(BlockCodecSize, PlaneOfDepth) {
    // Mode, width, depth and two slopes of 37 bits; then the corrections.
    for (std::uint32_t width = 0; width <= 20; ++width)
        for (const CodecKind kind : {CodecKind::kDepthPlanes, CodecKind::kDepthBest})
            EXPECT_EQ(size_of(kind, depth_float, plane(width)), level_of(2 + 6 + 32 + 2 * 37 + 64 * width))
                << width;
    // 8:1 with corrections of two bits, 4:1 up to six.
    EXPECT_EQ(size_of(CodecKind::kDepthPlanes, depth_float, plane(2), {32, 64, 128}), 32u);
    EXPECT_EQ(size_of(CodecKind::kDepthPlanes, depth_float, plane(3), {32, 64, 128}), 64u);
    EXPECT_EQ(size_of(CodecKind::kDepthPlanes, depth_float, plane(6), {32, 64, 128}), 64u);
    EXPECT_EQ(size_of(CodecKind::kDepthPlanes, depth_float, plane(7), {32, 64, 128}), 128u);
    EXPECT_EQ(size_of(CodecKind::kDepthPlanes, depth_float, plane(14), {32, 64, 128}), 128u);
    EXPECT_EQ(size_of(CodecKind::kDepthPlanes, depth_float, plane(15), {32, 64, 128}), 256u);
}

TEST(BlockCodecSize, SlopesOfSeventhsErrByLessThanAUnit) {
    // Rounded depths of a plane whose slopes are no multiples of 1/16: corrections of two bits at most.
    const auto block = fill(depth_float, [](std::uint32_t i, std::uint32_t) {
        const double z = 0x3F200000 + 12345.678 * pixel_x(i) - 2345.431 * pixel_y(i);
        return static_cast<std::uint32_t>(z + 0.5);
    });
    EXPECT_EQ(size_of(CodecKind::kDepthPlanes, depth_float, block, {32, 64, 128}), 32u);
}

TEST(BlockCodecSize, TwoPlanesOfDepth) {
    // Every line between a corner and the other three that leaves each a row and a column to see its slopes
    // by.
    const auto inside = [](int x, int y, int edge) {
        switch (edge) {
            case 0:
                return x + y >= 8;
            case 1:
                return x - y >= 2;
            case 2:
                return y - x >= 3;
            case 3:
                return x >= 5;
            default:
                return y >= 4;
        }
    };
    for (int edge = 0; edge < 5; ++edge) {
        const auto block = fill(depth_float, [&](std::uint32_t i, std::uint32_t) {
            const std::uint32_t x = pixel_x(i);
            const std::uint32_t y = pixel_y(i);
            return inside(static_cast<int>(x), static_cast<int>(y), edge)
                       ? 0x3F400000u + 100003 * x + 70001 * y
                       : 0x3E100000u + 5003 * x - 20001 * y;
        });
        // Two planes, where the second begins, and a bit a pixel.
        EXPECT_EQ(size_of(CodecKind::kDepthPlanes, depth_float, block),
                  level_of(2 + 6 + 2 * (32 + 2 * 37) + 6 + 64))
            << edge;
    }
}

TEST(BlockCodecSize, ReferencesHaveAttilasLowBits) {
    // Of 64 depths of 32 bits behind two bits of mode.
    EXPECT_EQ(reference_low_bits(64 * 8 - 2, 64, 32), 5);
    EXPECT_EQ(reference_low_bits(128 * 8 - 2, 64, 32), 13);
    EXPECT_EQ(reference_low_bits(192 * 8 - 2, 64, 32), 21);
    EXPECT_EQ(reference_low_bits(192, 64, 32), 0);
    EXPECT_EQ(reference_low_bits(191, 64, 32), -1);
}

TEST(BlockCodecSize, DepthsNearTwoReferences) {
    // Depths in four spans of 2^low: at the least and the largest depth, one above the one, one below the
    // other.
    const auto block = [](std::uint32_t low, std::uint32_t beyond) {
        return fill(depth_float, [&](std::uint32_t i, std::uint32_t) {
            const std::array<std::uint32_t, 4> span{1000, 1001 + beyond, 90000, 90001};
            return (span[(i * 7 + i / 8) % 4] << low) + static_cast<std::uint32_t>(mix64(i) & low_bits(low));
        });
    };
    const std::vector<std::uint32_t> attila{64, 128, 192};
    EXPECT_EQ(size_of(CodecKind::kDepthDelta, depth_float, block(5, 0), attila), 64u);
    EXPECT_EQ(size_of(CodecKind::kDepthDelta, depth_float, block(13, 0), attila), 128u);
    // A span further: 1000, 1002 and what lies near 90000 are no pairs at five bits, but one at thirteen.
    EXPECT_EQ(size_of(CodecKind::kDepthDelta, depth_float, block(5, 1), attila), 128u);
    EXPECT_EQ(size_of(CodecKind::kDepthDelta, depth_float, block(13, 1), attila), 192u);
    EXPECT_EQ(size_of(CodecKind::kDepthBest, depth_float, block(5, 0), attila), 64u);
}

TEST(BlockCodecSize, UsedNodesAndTheirMask) {
    for (std::uint32_t used = 0; used <= 32; ++used) {
        const auto block = fill(nodes, [&](std::uint32_t i, std::uint32_t c) -> std::uint64_t {
            return i * 13 % 32 < used ? mix64(i * 5 + c) | 1 : 0;
        });
        // Two bits of mode and 32 of the mask are five bytes.
        EXPECT_EQ(size_of(CodecKind::kNodesUsed, nodes, block), level_of(8 * (5 + 8 * used))) << used;
        EXPECT_EQ(size_of(CodecKind::kNodesUsed, nodes, block, {32, 64, 128}), used <= 3    ? 32u
                                                                               : used <= 7  ? 64u
                                                                               : used <= 15 ? 128u
                                                                                            : 256u)
            << used;
    }
}

TEST(BlockCodecSize, DepthsAlongAPixelsNodes) {
    for (std::uint32_t width = 0; width <= 12; ++width) {
        // Four pixels far apart; their eight nodes 5000 apart and up to 2^width - 1 more; one colour.
        const auto block = fill(nodes, [&](std::uint32_t i, std::uint32_t c) {
            if (c != 0) return 7 * c;
            std::uint32_t z = 0x30000000u + i / 8 * 0x1000000u;
            for (std::uint32_t k = 1; k <= i % 8; ++k) z += 5000 + noise(i / 8 * 8 + k, 0, width);
            return z;
        });
        // Mode; depths by chain, anchors of 26 bits; four constant channels. 0x3000000 takes 26 bits.
        const std::uint32_t bits = 2 + (2 + 6 + 32 + 6 + 32 + 4 * 26 + 28 * width) + 4 * (2 + 4 + 8);
        EXPECT_EQ(size_of(CodecKind::kNodeDelta, nodes, block), level_of(bits)) << width;
    }
}

TEST(BlockCodecSize, UsedNodesByDelta) {
    // Two nodes of each pixel are used: sixteen bytes, or three by delta.
    const auto block = fill(nodes, [&](std::uint32_t i, std::uint32_t c) -> std::uint32_t {
        if (i % 8 > 1) return 0;
        return c != 0 ? 7 * c : 0x3F000000u + i / 8 * 100 + i % 8 * 1000;
    });
    EXPECT_EQ(size_of(CodecKind::kNodesUsed, nodes, block), level_of(8 * (5 + 8 * 8)));
    EXPECT_GT(size_of(CodecKind::kNodeDelta, nodes, block), level_of(8 * (5 + 8 * 8)));
    // Mode and mask; a chain: anchors 0..300 in nine bits, deltas of 1000 in none.
    EXPECT_EQ(size_of(CodecKind::kNodesUsedDelta, nodes, block),
              level_of(2 + 32 + (2 + 6 + 32 + 6 + 32 + 4 * 9) + 4 * 14));
    const std::vector<std::uint8_t> clear(256, 0);
    EXPECT_EQ(size_of(CodecKind::kNodesUsedDelta, nodes, clear), 8u);
}

TEST(BlockCodecSize, UnusedNodesAcrossBordersCostTheirBitOfTheMask) {
    // Elements of three bytes: the block at 256 begins within one and ends within another.
    const BlockFormat format =
        block_samples::format(SurfaceClass::kNodes, 3, 8, false, {{0, 24, 1, FieldKind::kUnorm}});
    std::vector<std::uint8_t> block(256, 0x21);
    std::fill_n(block.begin(), 2, 0);
    std::fill_n(block.end() - 2, 2, 0);
    const BlockCodec codec(CodecKind::kNodesUsedDelta, format, fine_levels());
    std::array<std::uint8_t, 256> packed;
    // Mode, 86 elements, one constant column.
    EXPECT_EQ(codec.compress(block.data(), 256, packed.data()), level_of(2 + 86 + 2 + 6 + 24));
    block[0] = 5;  // two bytes of the first
    EXPECT_EQ(codec.compress(block.data(), 256, packed.data()), level_of(2 + 86 + 2 + 6 + 24 + 16));
}

TEST(BlockCodecSize, BytesInThePaddingKeepABlockAsItIs) {
    BlockFormat format =
        block_samples::format(SurfaceClass::kColor, 1, 1, false, {{0, 8, 1, FieldKind::kInteger}});
    std::vector<std::uint8_t> block(256, 0);
    std::fill_n(block.begin(), 64, 33);
    for (const CodecKind kind : {CodecKind::kColorDelta, CodecKind::kNodesUsed, CodecKind::kDepthPlanes}) {
        block[64] = 0;
        EXPECT_LT(size_of(kind, format, block), 256u);
        block[64] = 1;
        EXPECT_EQ(size_of(kind, format, block), 256u);
    }
}

TEST(BlockCodecSize, LatenciesAreAttilasAndAdderTrees) {
    const auto latency = [](CodecKind kind, const BlockFormat& format) {
        const BlockCodec codec(kind, format, {32, 64, 128});
        return std::pair{codec.compress_latency(), codec.decompress_latency()};
    };
    EXPECT_EQ(latency(CodecKind::kNone, depth_float), std::pair(0u, 0u));
    EXPECT_EQ(latency(CodecKind::kDepthDelta, depth_float), std::pair(8u, 8u));
    EXPECT_EQ(latency(CodecKind::kDepthPlanes, depth_float), std::pair(13u, 10u));
    // Four channels: two levels of adders.
    EXPECT_EQ(latency(CodecKind::kColorDelta, color(8, FieldKind::kUnorm)), std::pair(10u, 11u));
    // 32 elements a block, eight a pixel, five channels: five, three and three levels.
    EXPECT_EQ(latency(CodecKind::kNodesUsed, nodes), std::pair(11u, 11u));
    EXPECT_EQ(latency(CodecKind::kNodeDelta, nodes), std::pair(11u, 13u));
    EXPECT_EQ(latency(CodecKind::kNodesUsedDelta, nodes), std::pair(13u, 15u));
    // In planes a group is a quad: two levels for three.
    BlockFormat planar = nodes;
    planar.planar = true;
    EXPECT_EQ(latency(CodecKind::kNodeDelta, planar), std::pair(11u, 12u));
}

}  // namespace
}  // namespace ropsim
