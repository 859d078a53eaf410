// Deep OpenEXR files of other programs: depths, arrival orders, and what is refused.
#include "base/atomic_file.h"
#include "base/error.h"
#include "tests/traces/deep_exr_writer.h"
#include "tests/traces/trace_conversion.h"
#include "traces/image.h"
#include "traces/interchange/deep_exr.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <ImfDeepScanLineOutputPart.h>
#include <ImfDeepTiledOutputFile.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

class ForeignDeepExr : public ScratchTest {
 protected:
    std::vector<Fragment> import(const DeepPicture<PlainSample>& picture, DeepOrder order = DeepOrder::kFile,
                                 std::uint64_t seed = 0) {
        picture.write(path("f.exr"));
        notes_ = import_deep_exr(path("f.exr"), path("t"), {order, seed});
        return read_fragments(path("t"));
    }
    std::string fault(const std::string& file) {
        try {
            import_deep_exr(path(file), path("t"));
        } catch (const UserError& error) {
            EXPECT_EQ(error.where(), path(file));
            return error.what();
        }
        return "(accepted)";
    }
    // Of an image whose pixel (12, -7), in the file's coordinates, holds these samples.
    std::string sample_fault(const std::vector<PlainSample>& samples, bool volumes = false) {
        DeepPicture<PlainSample> picture = plain_picture(10, -8, 5, 4);
        if (volumes) picture.channels.push_back({"ZBack", Imf::FLOAT, offsetof(PlainSample, z_back)});
        picture.samples[{11, -8}] = {{1, 0.1f, 0.1f, 0.1f, 0.5f, 1}};
        picture.samples[{12, -7}] = samples;
        picture.write(path("f.exr"));
        return fault("f.exr");
    }
    std::vector<std::string> notes_;
};

TEST_F(ForeignDeepExr, TakesPixelsColoursAndScaledDepths) {
    DeepPicture<PlainSample> picture = plain_picture(-3, 100, 12, 9);
    picture.samples[{-3, 100}] = {{5.0f, 0.5f, 0.25f, 0.125f, 0.75f}, {4.75f, 0, 0, 0, 0}};
    picture.samples[{8, 108}] = {{0.0f, 9, 8, 7, 1}, {1e-30f, 0, 0, 0, 0.5f}, {5.0f, 0, 0, 0, 0.5f}};
    const std::vector<Fragment> f = import(picture);
    ASSERT_EQ(f.size(), 5u);
    // Rounds: both pixels' first samples, then the second, then what is left. 5 / 8 is the first power to
    // fit.
    EXPECT_TRUE(f[0].x == 0 && f[0].y == 0 && f[0].z == 5.0f / 8 && f[0].primitive == 0);
    EXPECT_TRUE(f[0].r == 0.5f && f[0].g == 0.25f && f[0].b == 0.125f && f[0].a == 0.75f);
    EXPECT_TRUE(f[1].x == 11 && f[1].y == 8 && f[1].z == 0.0f && f[1].primitive == 2 && f[1].r == 9.0f);
    EXPECT_TRUE(f[2].z == 4.75f / 8 && f[2].primitive == 1);
    EXPECT_TRUE(f[3].z == 1e-30f / 8 && f[3].primitive == 3);
    EXPECT_TRUE(f[4].z == f[0].z && f[4].primitive == 4 && f[4].coverage == 1 && f[4].draw == 0);
    EXPECT_THAT(notes_, ElementsAre("depth is Z * 2^-3"));
    const TraceReader reader(path("t"));
    EXPECT_EQ(reader.header().width, 12);
    EXPECT_EQ(reader.header().height, 9);
    EXPECT_EQ(reader.header().samples, 1);
    EXPECT_EQ(reader.header().color_storage, ColorStorage::kFloat32);
}

TEST_F(ForeignDeepExr, DepthsKeepOrderAndTiesExactly) {
    const auto depths = [&](const std::vector<float>& distances) {
        DeepPicture<PlainSample> picture = plain_picture(0, 0, 1, 1);
        for (const float z : distances) picture.samples[{0, 0}].push_back({z, 0, 0, 0, 0.5f});
        std::vector<float> result;
        for (const Fragment& f : import(picture)) result.push_back(f.z);
        return result;
    };
    EXPECT_THAT(depths({0.3f, 1.0f, 1e-45f, -0.0f}),
                ElementsAre(0.3f, 1.0f, 1e-45f, 0.0f));  // fit as they are
    EXPECT_THAT(depths({1.0000001f, 0.5f}), ElementsAre(1.0000001f / 2, 0.25f));
    EXPECT_THAT(depths({1024, 1023.99994f}), ElementsAre(1.0f, 1023.99994f / 1024));
    EXPECT_THAT(depths({3e38f, 1}), ElementsAre(3e38f * 0x1p-128f, 0x1p-128f));  // a denormal, exact
    // Infinity is farther than anything that is finite, also where that alone would be 1.
    EXPECT_THAT(depths({kInfinity, 1024, kInfinity}), ElementsAre(1.0f, 0.5f, 1.0f));
    EXPECT_THAT(notes_, ElementsAre("depth is Z * 2^-11, 1 where Z is infinite"));
    EXPECT_THAT(depths({kInfinity, 0}), ElementsAre(1.0f, 0.0f));
    EXPECT_THAT(sample_fault({{3e38f, 0, 0, 0, 1}, {1.1e-38f, 0, 0, 0, 1}}),
                HasSubstr("exceed the range of a float"));
}

TEST_F(ForeignDeepExr, HalfColoursStayHalvesAndGreyIsGrey) {
    struct HalfSample {
        float z, a;
        std::uint16_t y;
    };
    DeepPicture<HalfSample> grey;
    grey.window = {{0, 0}, {1, 0}};
    grey.channels = {{"Z", Imf::FLOAT, offsetof(HalfSample, z)},
                     {"A", Imf::FLOAT, offsetof(HalfSample, a)},
                     {"Y", Imf::HALF, offsetof(HalfSample, y)}};
    grey.samples[{1, 0}] = {{0.5f, 0.5f, 0x3555}};
    grey.write(path("f.exr"));
    import_deep_exr(path("f.exr"), path("t"));
    const std::vector<Fragment> f = read_fragments(path("t"));
    ASSERT_EQ(f.size(), 1u);
    const float third = 0x1.554p-2f;  // 0x3555
    EXPECT_TRUE(f[0].r == third && f[0].g == third && f[0].b == third);
    EXPECT_EQ(TraceReader(path("t")).header().color_storage, ColorStorage::kFloat16);
}

// Depths of one pixel, given and as they arrive; colour tells ties apart.
TEST_F(ForeignDeepExr, OrdersArriveAsNamed) {
    DeepPicture<PlainSample> picture = plain_picture(0, 0, 1, 1);
    for (const float z : {0.5f, 0.25f, 0.5f, 0.75f, 0.25f})
        picture.samples[{0, 0}].push_back({z, 0, 0, 0, 0.5f});
    const auto arrivals = [&](DeepOrder order, std::uint64_t seed = 0) {
        std::vector<std::uint32_t> result;
        for (const Fragment& f : import(picture, order, seed)) result.push_back(f.primitive);
        return result;
    };
    EXPECT_THAT(arrivals(DeepOrder::kFile), ElementsAre(0, 1, 2, 3, 4));
    EXPECT_THAT(arrivals(DeepOrder::kNearToFar), ElementsAre(1, 4, 0, 2, 3));
    EXPECT_THAT(arrivals(DeepOrder::kFarToNear), ElementsAre(3, 0, 2, 1, 4));
    std::map<std::vector<std::uint32_t>, int> shuffles;
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
        const std::vector<std::uint32_t> order = arrivals(DeepOrder::kShuffle, seed);
        ++shuffles[order];
        const auto place = [&](std::uint32_t i) {
            return std::find(order.begin(), order.end(), i) - order.begin();
        };
        EXPECT_LT(place(0), place(2));
        EXPECT_LT(place(1), place(4));
    }
    EXPECT_GT(shuffles.size(), 15u);  // of 30 that keep both ties
}

TEST_F(ForeignDeepExr, ShuffleIsUniform) {
    DeepPicture<PlainSample> picture = plain_picture(0, 0, 100, 60);
    for (int y = 0; y < 60; ++y)
        for (int x = 0; x < 100; ++x)
            for (const float z : {0.1f, 0.2f, 0.3f}) picture.samples[{x, y}].push_back({z, 0, 0, 0, 0.5f});
    std::map<std::pair<int, int>, std::vector<std::uint32_t>> pixels;
    for (const Fragment& f : import(picture, DeepOrder::kShuffle, 3))
        pixels[{f.x, f.y}].push_back(f.primitive % 3);
    std::map<std::vector<std::uint32_t>, int> counts;
    for (const auto& [pixel, order] : pixels) ++counts[order];
    ASSERT_THAT(counts, SizeIs(6));
    for (const auto& [order, count] : counts) EXPECT_NEAR(count, 1000, 6 * std::sqrt(1000 * 5 / 6.0));
}

// Rounds run over tiles, in a tile over quads: 8x8 tiles of a 10x3 image.
TEST_F(ForeignDeepExr, RoundsAreLayersOfQuads) {
    DeepPicture<PlainSample> picture = plain_picture(0, 0, 10, 3);
    for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 10; ++x) picture.samples[{x, y}].assign(x == 9 ? 2 : 1, {0.5f, 0, 0, 0, 1});
    std::vector<std::pair<int, int>> pixels;
    for (const Fragment& f : import(picture)) pixels.push_back({f.x, f.y});
    ASSERT_EQ(pixels.size(), 33u);
    const std::vector<std::pair<int, int>> start{{0, 0}, {1, 0}, {0, 1}, {1, 1},
                                                 {2, 0}, {3, 0}, {2, 1}, {3, 1}};
    EXPECT_TRUE(std::equal(start.begin(), start.end(), pixels.begin()));
    EXPECT_EQ(pixels[16], std::pair(0, 2));
    EXPECT_EQ(pixels[23], std::pair(7, 2));
    EXPECT_EQ(pixels[24], std::pair(8, 0));  // the second tile
    EXPECT_THAT(std::vector(pixels.begin() + 30, pixels.end()),
                ElementsAre(std::pair(9, 0), std::pair(9, 1), std::pair(9, 2)));
}

TEST_F(ForeignDeepExr, VolumesAreSurfacesWhereNothingIsInThem) {
    DeepPicture<PlainSample> picture = plain_picture(0, 0, 2, 1);
    picture.channels.push_back({"ZBack", Imf::FLOAT, offsetof(PlainSample, z_back)});
    picture.samples[{0, 0}] = {{3, 0, 0, 0, 0.5f, 4}, {1, 0, 0, 0, 0.5f, 3}, {0.5f, 0, 0, 0, 0.5f, 0.5f}};
    picture.samples[{1, 0}] = {{2, 0, 0, 0, 0.5f, 0}};  // a ZBack before Z says nothing
    const std::vector<Fragment> f = import(picture);
    EXPECT_EQ(f[0].z, 0.75f);
    ASSERT_THAT(notes_, SizeIs(2));
    EXPECT_THAT(notes_[1], HasSubstr("2 samples are volumes"));
    EXPECT_THAT(sample_fault({{1, 0, 0, 0, 0.5f, 3}, {2, 0, 0, 0, 0.5f, 2}}, true),
                HasSubstr("pixel (12, -7): the volume from 1 to 3 overlaps the sample at 2"));
    EXPECT_THAT(sample_fault({{1, 0, 0, 0, 0.5f, 2}, {1, 0, 0, 0, 0.5f, 1}}, true), HasSubstr("overlaps"));
    EXPECT_THAT(sample_fault({{1, 0, 0, 0, 0.5f, 3}, {kNan, 0, 0, 0, 0.5f, 2}}, true), HasSubstr("Z is nan"));
}

TEST_F(ForeignDeepExr, FaultsNameThePixelOfTheFile) {
    EXPECT_THAT(sample_fault({{-1, 0, 0, 0, 0.5f}}), HasSubstr("pixel (12, -7): Z is -1"));
    EXPECT_THAT(sample_fault({{kNan, 0, 0, 0, 0.5f}}), HasSubstr("pixel (12, -7): Z is nan"));
    EXPECT_THAT(sample_fault({{1, 0, 0, 0, 1.002f}}), HasSubstr("pixel (12, -7): A is 1.002"));
    EXPECT_THAT(sample_fault({{1, 0, 0, 0, -0.01f}}), HasSubstr("A is -0.01"));
    EXPECT_THAT(sample_fault({{1, 0, 0, 0, kNan}}), HasSubstr("A is nan"));
    EXPECT_THAT(sample_fault({{1, 0, kInfinity, 0, 1}}), HasSubstr("its colour is 0, inf, 0"));
    EXPECT_EQ(entries(), 1u);  // no trace, no temporary
    DeepPicture<PlainSample> picture = plain_picture(0, 0, 1, 1);
    picture.samples[{0, 0}] = {{0, 0, 0, 0, 1 + 0x1p-11f}};
    EXPECT_EQ(import(picture)[0].a, 1.0f);
    EXPECT_THAT(notes_, SizeIs(2));
}

TEST_F(ForeignDeepExr, OtherFilesAreRefusedWithWhatTheyHold) {
    EXPECT_THAT(fault("none.exr"), HasSubstr("no such file"));
    write_file(path("text.exr"), "deep thoughts");
    EXPECT_THAT(fault("text.exr"), HasSubstr("is not an OpenEXR file"));
    write_exr(path("flat.exr"), Image(4, 4, {"R", "G", "B"}));
    EXPECT_THAT(fault("flat.exr"), HasSubstr("holds no deep image"));
    for (const char* channel : {"Z", "A", "G"}) {
        DeepPicture<PlainSample> picture = plain_picture(0, 0, 4, 4);
        std::erase_if(picture.channels, [&](const DeepChannel& c) { return c.name == channel; });
        picture.write(path("lacks.exr"));
        EXPECT_THAT(fault("lacks.exr"), HasSubstr("has no channel")) << channel;
    }
    Imf::Header tiled = plain_picture(0, 0, 4, 4).header();
    tiled.setType(Imf::DEEPTILE);
    tiled.setTileDescription(Imf::TileDescription(2, 2));
    { Imf::DeepTiledOutputFile file(path("tiled.exr").c_str(), tiled, 0); }
    EXPECT_THAT(fault("tiled.exr"), HasSubstr("holds deep tiles; convert it"));
    plain_picture(0, 0, 16385, 1).write(path("wide.exr"));
    EXPECT_THAT(fault("wide.exr"), HasSubstr("is 16385x1 pixels"));
}

TEST_F(ForeignDeepExr, TheFirstDeepPartIsTaken) {
    DeepPicture<PlainSample> picture = plain_picture(0, 0, 2, 2);
    for (const Imf::Compression compression :
         {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION}) {
        picture.compression = compression;
        picture.samples[{1, 1}] = {{0.5f, 0, 0, 0, 1}};
        Imf::Header flat(2, 2);
        flat.setName("beauty");
        flat.setType(Imf::SCANLINEIMAGE);
        flat.channels().insert("R", Imf::Channel(Imf::FLOAT));
        Imf::Header first = picture.header();
        first.displayWindow() = flat.displayWindow();
        first.setName("first");
        Imf::Header second = first;
        second.setName("second");
        const Imf::Header headers[] = {flat, first, second};
        {
            Imf::MultiPartOutputFile file(path("f.exr").c_str(), headers, 3, false, 0);
            Imf::OutputPart beauty(file, 0);
            float pixels[4] = {1, 2, 3, 4};
            Imf::FrameBuffer frame;
            frame.insert("R", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(pixels), 4, 8));
            beauty.setFrameBuffer(frame);
            beauty.writePixels(2);
            Imf::DeepScanLineOutputPart one(file, 1);
            picture.write_rows(one);
            picture.samples[{1, 1}].resize(2);
            Imf::DeepScanLineOutputPart two(file, 2);
            picture.write_rows(two);
        }
        EXPECT_THAT(import_deep_exr(path("f.exr"), path("t")), SizeIs(1));
        EXPECT_EQ(TraceReader(path("t")).fragment_count(), 1u);
    }
}

}  // namespace
}  // namespace ropsim
