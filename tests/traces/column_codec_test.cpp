// Columns and blocks: exact for every kind of data, later columns skipped, forged bytes refused.
#include "traces/column_codec.h"

#include "base/random.h"
#include "traces/block_codec.h"
#include "traces/column_filters.h"
#include "traces/generators.h"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

template <typename T>
void expect_round_trip(const std::vector<T>& elements, const char* name) {
    ColumnEncoder encoder;
    ColumnDecoder decoder;
    Bytes bytes;
    encoder.encode(elements.data(), elements.size(), bytes);
    std::vector<T> read(elements.size());
    decoder.decode(ByteCursor(bytes.data(), bytes.size()), read.size(), read.data());
    EXPECT_EQ(read, elements) << name << ", " << elements.size() << " elements of " << sizeof(T);
}

template <typename T>
void expect_round_trips(std::size_t count) {
    std::vector<T> noise(count), few(count), rising(count), falling(count), quads(count),
        constant(count, T(77));
    for (std::size_t i = 0; i < count; ++i) {
        noise[i] = static_cast<T>(mix64(i));
        few[i] = static_cast<T>(mix64(mix64(i) % 200));
        rising[i] = static_cast<T>(3 * i + (mix64(i) & 1));
        falling[i] = static_cast<T>(~(5 * i));
        quads[i] = static_cast<T>((i / 4) * 2 + (mix64(i % 4) & 0xFFFF));
    }
    expect_round_trip(noise, "noise");
    expect_round_trip(few, "few values");
    expect_round_trip(rising, "rising");
    expect_round_trip(falling, "falling");
    expect_round_trip(quads, "quads");
    expect_round_trip(constant, "constant");
}

TEST(ColumnCodec, RoundTripsEveryKindOfData) {
    for (const std::size_t count : {1u, 2u, 3u, 4u, 5u, 100u, 1024u, 5000u}) {
        expect_round_trips<std::uint8_t>(count);
        expect_round_trips<std::uint16_t>(count);
        expect_round_trips<std::uint32_t>(count);
    }
}

TEST(ColumnCodec, ConstantColumnsCostNothing) {
    ColumnEncoder encoder;
    Bytes bytes;
    const std::vector<std::uint32_t> constant(100000, 0xDEADBEEF);
    encoder.encode(constant.data(), constant.size(), bytes);
    EXPECT_THAT(bytes, ElementsAre(1, 0xEF, 0xBE, 0xAD, 0xDE));
}

TEST(ColumnCodec, NoiseIsHardlyLargerThanItself) {
    ColumnEncoder encoder;
    Bytes bytes;
    std::vector<std::uint32_t> noise(10000);
    for (std::size_t i = 0; i < noise.size(); ++i) noise[i] = static_cast<std::uint32_t>(mix64(i));
    encoder.encode(noise.data(), noise.size(), bytes);
    EXPECT_LE(bytes.size(), 4 * noise.size() + 5);
}

TEST(ColumnFilters, FollowTheirDefinitions) {
    const std::vector<std::uint8_t> in{5, 6, 8, 7, 10, 255};
    std::vector<std::uint8_t> out(6);
    apply_filter(ColumnFilter::kIncrement, in.data(), in.size(), out.data());
    EXPECT_THAT(out, ElementsAre(5, 0, 1, 254, 2, 244));
    apply_filter(ColumnFilter::kDelta1, in.data(), in.size(), out.data());
    EXPECT_THAT(out, ElementsAre(10, 2, 4, 1, 6, 21));  // 245 is -11
    apply_filter(ColumnFilter::kDelta4, in.data(), in.size(), out.data());
    EXPECT_THAT(out, ElementsAre(10, 12, 16, 14, 10, 13));  // 10 - 5, 255 - 6 = -7
}

TEST(ColumnCodec, RefusesForgedColumns) {
    ColumnDecoder decoder;
    std::vector<std::uint16_t> out(8);
    const auto refused = [&](const Bytes& bytes) {
        EXPECT_THROW(decoder.decode(ByteCursor(bytes.data(), bytes.size()), out.size(), out.data()),
                     FormatFault);
    };
    refused({});
    refused({99});                                  // no such filter
    refused({1, 7});                                // half a constant
    refused({1, 7, 7, 7});                          // more than a constant
    refused({0, 9, 0, 0, 0});                       // no such plane method
    refused({0, 1, 1, 2, 3});                       // a raw plane cut short
    refused({0, 2, 4, 1, 2, 3, 4, 0, 0});           // not a zstd frame
    refused({0, 2, 0xFF, 0xFF, 0xFF, 0xFF, 0x7F});  // a plane of 34 GB
    refused({2, 0, 5, 5, 0, 1});                    // palette of one, index 1
    EXPECT_NO_THROW(decoder.decode(ByteCursor(Bytes{2, 0, 5, 5, 0, 0}.data(), 6), out.size(), out.data()));
    EXPECT_EQ(out[7], 0x0505);
}

TEST(BlockCodec, OptionalUnknownColumnsAreSkippedAndRequiredOnesRefused) {
    RandomFragments options;
    options.count = 50;
    const std::vector<Fragment> fragments = random_fragments(options);
    const TraceHeader header = random_header(options);
    std::vector<std::uint32_t> ranks(50);
    for (std::uint32_t i = 0; i < 50; ++i) ranks[i] = i;
    const RegionBounds bounds = region_bounds(header, 128, 0);
    Bytes bytes{3, 200, 201, 202};  // a column of a later version, with a filter nobody knows yet
    BlockEncoder().encode(FragmentChunk{fragments, {}, {}}, ranks.data(), 50, bounds, ColorStorage::kFloat32,
                          bytes);
    std::vector<ColumnDescription> columns = written_columns(header);
    columns.insert(columns.begin(), {"slope", "f32", false});
    BlockDecoder decoder(header, map_columns(columns, header));
    const BlockColumns& block = decoder.decode(bytes.data(), bytes.size(), 50, 50, bounds, kAllChannels);
    for (std::size_t i = 0; i < 50; ++i) {
        EXPECT_EQ(block.fragment(i, bounds).z, fragments[i].z);
        EXPECT_EQ(block.fragment(i, bounds).primitive, i);
    }
    columns[0].required = true;
    EXPECT_THROW(map_columns(columns, header), FormatFault);
    columns.erase(columns.begin(), columns.begin() + 2);
    EXPECT_THROW(map_columns(columns, header), FormatFault);  // rank is missing
}

// The block of the worked example in docs/trace-format.md.
TEST(BlockCodec, BytesAreTheDocumentedOnes) {
    const std::vector<Fragment> fragments{{0.5f, 0.25f, 0.25f, 0.25f, 0.5f, 1, 0, 7, 1, 0},
                                          {0.75f, 0.25f, 0.25f, 0.25f, 0.5f, 1, 0, 8, 1, 0}};
    const std::vector<std::uint32_t> ranks{0, 1};
    Bytes bytes;
    BlockEncoder().encode(FragmentChunk{fragments, {}, {}}, ranks.data(), 2, {0, 0, 4, 2},
                          ColorStorage::kFloat32, bytes);
    const Bytes documented{0x09, 0x03, 0,    0,    0,    0,    0,    0,    0,    0,        // rank
                           0x02, 0x01, 0x01, 0x02, 0x01, 0x00,                             // x, y
                           0x0A, 0x00, 0,    0,    0,    0,    0x01, 0x00, 0x40, 0, 0x3F,  // z
                           0x05, 0x01, 0,    0,    0x80, 0x3E, 0x05, 0x01, 0,    0, 0x80,
                           0x3E, 0x05, 0x01, 0,    0,    0x80, 0x3E,                    // r, g, b
                           0x05, 0x01, 0,    0,    0,    0x3F,                          // a
                           0x0A, 0x00, 0x01, 0x07, 0x08, 0,    0,    0,    0,    0, 0,  // primitive
                           0x03, 0x01, 0x01, 0x00, 0x03, 0x01, 0x00, 0x00};             // coverage, draw
    EXPECT_EQ(bytes, documented);
}

TEST(BlockCodec, RefusesValuesOutOfRange) {
    RandomFragments options;
    options.count = 50;
    TraceHeader header = random_header(options);
    const std::vector<Fragment> good = random_fragments(options);
    const RegionBounds bounds = region_bounds(header, 128, 0);
    const auto fault_of = [&](auto&& change, std::uint32_t chunk_fragments = 50) -> std::string {
        std::vector<Fragment> fragments = good;
        std::vector<std::uint32_t> ranks(50);
        for (std::uint32_t i = 0; i < 50; ++i) ranks[i] = i;
        change(fragments, ranks);
        Bytes bytes;
        BlockEncoder().encode(FragmentChunk{fragments, {}, {}}, ranks.data(), 50, bounds,
                              ColorStorage::kFloat32, bytes);
        BlockDecoder decoder(header, map_columns(written_columns(header), header));
        try {
            decoder.decode(bytes.data(), bytes.size(), 50, chunk_fragments, bounds, kAllChannels);
        } catch (const FormatFault& fault) {
            return fault.what();
        }
        return "";
    };
    using F = std::vector<Fragment>;
    using R = std::vector<std::uint32_t>;
    EXPECT_EQ(fault_of([](F&, R&) {}), "");
    EXPECT_THAT(fault_of([](F&, R& r) { std::swap(r[3], r[4]); }), HasSubstr("ranks"));
    EXPECT_THAT(fault_of([](F&, R& r) { r[3] = r[4]; }), HasSubstr("ranks"));
    EXPECT_THAT(fault_of([](F&, R&) {}, 49), HasSubstr("ranks"));
    EXPECT_THAT(fault_of([](F& f, R&) { f[7].x = 32; }), HasSubstr("region"));
    EXPECT_THAT(fault_of([](F& f, R&) { f[7].y = 32; }), HasSubstr("region"));
    EXPECT_THAT(fault_of([](F& f, R&) { f[7].z = 1.5f; }), HasSubstr("depth"));
    EXPECT_THAT(fault_of([](F& f, R&) { f[7].a = -1; }), HasSubstr("alpha"));
    EXPECT_THAT(fault_of([](F& f, R&) { f[7].g = 1 / 0.0f; }), HasSubstr("colour"));
    EXPECT_THAT(fault_of([](F& f, R&) { f[7].coverage = 2; }), HasSubstr("coverage"));
    EXPECT_THAT(fault_of([](F& f, R&) { f[7].draw = 1; }), HasSubstr("draw"));
}

}  // namespace
}  // namespace ropsim
