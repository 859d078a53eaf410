// Every codec gives back the bytes of any block: of every element size, at every place in a tile.
#include "base/random.h"
#include "memory/block_codec.h"
#include "tests/memory/block_samples.h"

#include <array>
#include <cstring>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using block_samples::Content;

// Compresses and decompresses; checks sizes, what must stay untouched, and the bytes.
std::uint32_t round_trip(const BlockCodec& codec, const std::uint8_t* block, std::uint32_t tile_offset) {
    const std::uint32_t size = codec.format().block_bytes;
    std::array<std::uint8_t, 256 + 8> packed;
    packed.fill(0xC5);
    const std::uint32_t bytes = codec.compress(block, tile_offset, packed.data());
    if (bytes == size) {
        for (const std::uint8_t b : packed) EXPECT_EQ(b, 0xC5) << "written though it does not fit";
        return bytes;
    }
    EXPECT_EQ(std::count(codec.levels().begin(), codec.levels().end(), bytes), 1) << bytes;
    for (std::size_t b = bytes; b < packed.size(); ++b) EXPECT_EQ(packed[b], 0xC5) << "past the level";
    std::array<std::uint8_t, 256 + 8> back;
    back.fill(0x5A);
    codec.decompress(packed.data(), bytes, tile_offset, back.data());
    EXPECT_EQ(std::memcmp(back.data(), block, size), 0)
        << "kind " << static_cast<int>(codec.kind()) << " element " << codec.format().element_bytes << " x "
        << codec.format().elements << " offset " << tile_offset << " level " << bytes;
    for (std::size_t b = size; b < back.size(); ++b) EXPECT_EQ(back[b], 0x5A) << "past the block";
    return bytes;
}

struct Tally {
    std::uint64_t blocks = 0;
    std::uint64_t compressed = 0;
};

// All contents at all block offsets of a tile, as often as asked.
void check_format(const BlockFormat& format, int rounds, std::uint64_t seed, Tally& tally) {
    const std::uint32_t payload = 64 * std::max(format.elements, 1u) * format.element_bytes;
    const std::uint32_t tile = (payload + format.block_bytes - 1) / format.block_bytes * format.block_bytes;
    for (const CodecKind kind : block_samples::kKinds) {
        const BlockCodec codec(kind, format, block_samples::levels(format.block_bytes));
        for (int round = 0; round < rounds; ++round)
            for (int content = 0; content < block_samples::kContents; ++content) {
                const std::vector<std::uint8_t> bytes = block_samples::tile(
                    format, static_cast<Content>(content), mix64(seed + static_cast<std::uint64_t>(round)));
                for (std::uint32_t offset = 0; offset < tile; offset += format.block_bytes) {
                    ++tally.blocks;
                    tally.compressed +=
                        round_trip(codec, bytes.data() + offset, offset) != format.block_bytes;
                    if (testing::Test::HasFailure()) return;
                }
            }
    }
}

TEST(BlockCodecRoundTrip, EveryElementSizeAtEveryOffset) {
    Tally tally;
    for (std::uint32_t element_bytes = 1; element_bytes <= 64; ++element_bytes)
        for (const std::uint32_t block_bytes : {64u, 128u, 256u}) {
            check_format(block_samples::random_format(element_bytes, block_bytes, element_bytes), 1,
                         element_bytes, tally);
            if (HasFailure()) return;
        }
    EXPECT_GT(tally.compressed, tally.blocks / 8) << tally.blocks;
    EXPECT_LT(tally.compressed, tally.blocks) << tally.blocks;
    EXPECT_GT(tally.blocks, 500'000u);
}

TEST(BlockCodecRoundTrip, SurfacesOfTechniques) {
    Tally tally;
    for (const BlockFormat& format : block_samples::surfaces()) {
        check_format(format, 16, 99, tally);
        if (HasFailure()) return;
    }
    EXPECT_GT(tally.compressed, tally.blocks / 4) << tally.blocks;
    EXPECT_GT(tally.blocks, 150'000u);
}

// What hardly fits, or no longer does.
TEST(BlockCodecRoundTrip, FewBitsFlipped) {
    block_samples::Source source(11);
    std::array<std::uint64_t, 2> outcomes{};
    for (const BlockFormat& format : block_samples::surfaces())
        for (const CodecKind kind : block_samples::kKinds) {
            const BlockCodec codec(kind, format, block_samples::levels(format.block_bytes));
            for (int content = 1; content < block_samples::kContents; ++content) {
                std::vector<std::uint8_t> bytes =
                    block_samples::tile(format, static_cast<Content>(content), source.next());
                const std::uint32_t payload = 64 * std::max(format.elements, 1u) * format.element_bytes;
                for (std::uint32_t flips = payload / 64; flips-- > 0;)
                    bytes[source.below(payload)] ^= static_cast<std::uint8_t>(1u << source.below(8));
                for (std::uint32_t offset = 0; offset < bytes.size(); offset += format.block_bytes)
                    ++outcomes[round_trip(codec, bytes.data() + offset, offset) == format.block_bytes];
                if (HasFailure()) return;
            }
        }
    EXPECT_GT(outcomes[0], 500u);
    EXPECT_GT(outcomes[1], 500u);
}

TEST(BlockCodecRoundTrip, BlocksThatBeginAnywhere) {
    for (std::uint32_t element_bytes = 1; element_bytes <= 64; element_bytes += 3) {
        const BlockFormat format = block_samples::random_format(element_bytes, 128, 700 + element_bytes);
        std::vector<std::uint8_t> bytes = block_samples::tile(format, Content::kRamp, 5);
        bytes.resize(bytes.size() + 256);  // padding
        for (const CodecKind kind : block_samples::kKinds) {
            const BlockCodec codec(kind, format, {16, 32, 64, 120});
            for (std::uint32_t offset = 0; offset < 3 * element_bytes + 70; ++offset)
                round_trip(codec, bytes.data() + offset, offset);
        }
        if (HasFailure()) return;
    }
}

}  // namespace
}  // namespace ropsim
