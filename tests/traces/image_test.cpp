// Images: OpenEXR keeps every bit, PNG holds exact sRGB, faults are the user's.
#include "traces/image.h"

#include "base/atomic_file.h"
#include "base/error.h"
#include "base/random.h"
#include "tests/traces/scratch.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfTiledOutputFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

namespace ropsim {
namespace {

using Images = ScratchTest;

Image noise(int width, int height, std::vector<std::string> channels) {
    Image image(width, height, std::move(channels));
    for (std::size_t i = 0; i < image.values.size(); ++i)
        image.values[i] = random_unit(7, static_cast<std::uint32_t>(i));
    return image;
}

TEST_F(Images, ExrRoundTripsBitwise) {
    Image image = noise(37, 21, {"R", "G", "B", "A", "error.R", "pixels"});
    image.values[0] = std::numeric_limits<float>::infinity();
    image.values[1] = -1e-40f;
    image.values[2] = 3e38f;
    write_exr(path("a.exr"), image);
    const Image read = read_exr(path("a.exr"));
    EXPECT_EQ(read.width, 37);
    EXPECT_EQ(read.height, 21);
    EXPECT_EQ(read.channels, image.channels);
    EXPECT_EQ(read.values, image.values);
    EXPECT_EQ(read.channel("B"), 2);
    EXPECT_EQ(read.channel("Z"), -1);
    EXPECT_EQ(read.pixel(3, 2)[1], image.values[(2 * 37 + 3) * 6 + 1]);
}

TEST_F(Images, ExrBytesAreDeterministic) {
    write_exr(path("a.exr"), noise(64, 64, {"R", "G", "B"}));
    write_exr(path("b.exr"), noise(64, 64, {"R", "G", "B"}));
    EXPECT_EQ(read_file(path("a.exr")), read_file(path("b.exr")));
}

TEST_F(Images, ExrFaultsAreUserErrors) {
    EXPECT_THROW(read_exr(path("missing.exr")), UserError);
    write_file(path("text.exr"), "hello");
    EXPECT_THROW(read_exr(path("text.exr")), UserError);
    write_exr(path("a.exr"), noise(64, 64, {"R", "G", "B"}));
    const std::string content = read_file(path("a.exr"));
    for (std::size_t percent = 0; percent < 100; percent += 5) {
        write_file(path("cut.exr"), content.substr(0, content.size() * percent / 100));
        EXPECT_THROW(read_exr(path("cut.exr")), UserError) << percent << "%";
    }
    EXPECT_THROW(write_exr(path("missing/a.exr"), noise(4, 4, {"R"})), UserError);
}

// OpenEXR unpacks tiles whole: what they claim is held against the file as its rows are.
TEST_F(Images, TilesOfAnExrAreNoLargerThanTheFileAllows) {
    {
        Imf::Header header(40, 30);
        header.channels().insert("R", Imf::Channel(Imf::FLOAT));
        header.setTileDescription(Imf::TileDescription(16, 16, Imf::ONE_LEVEL));
        const std::vector<float> values(std::size_t{40} * 30, 0.25f);
        Imf::FrameBuffer buffer;
        buffer.insert("R", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(const_cast<float*>(values.data())),
                                      sizeof(float), 40 * sizeof(float)));
        Imf::TiledOutputFile file(path("tiled.exr").c_str(), header);
        file.setFrameBuffer(buffer);
        file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
    }
    const Image image = read_exr(path("tiled.exr"));
    EXPECT_EQ(image.width, 40);
    EXPECT_EQ(image.pixel(39, 29)[0], 0.25f);
    std::string bytes = read_file(path("tiled.exr"));
    const std::string name("tiles\0tiledesc\0", 15);
    const std::size_t at = bytes.find(name);
    ASSERT_NE(at, std::string::npos);
    for (const std::uint32_t side : {30000u, 0x7FFFFFFFu}) {
        std::memcpy(&bytes[at + name.size() + 4], &side, sizeof side);
        std::memcpy(&bytes[at + name.size() + 8], &side, sizeof side);
        write_file(path("large.exr"), bytes);
        EXPECT_THROW(read_exr(path("large.exr")), UserError) << side;
    }
}

TEST_F(Images, PngIsExactSrgb) {
    // Linear values on a fine grid: the code of each must be the nearest to the standard's formula.
    Image image(4096, 1, {"A", "B", "G", "R"});
    const auto value = [](int x) { return static_cast<float>(x) / 4095.0f; };
    for (int x = 0; x < 4096; ++x) {
        image.pixel(x, 0)[3] = value(x);
        image.pixel(x, 0)[2] = 2 * value(x) - 0.5f;  // beyond both ends: clamped
        image.pixel(x, 0)[1] = x == 0 ? std::nanf("") : 0.0f;
    }
    write_png(path("a.png"), image);
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    ASSERT_TRUE(png_image_begin_read_from_file(&png, path("a.png").c_str()));
    EXPECT_EQ(png.width, 4096u);
    EXPECT_EQ(png.format & (PNG_FORMAT_FLAG_LINEAR | PNG_FORMAT_FLAG_COLOR | PNG_FORMAT_FLAG_ALPHA),
              PNG_FORMAT_FLAG_COLOR);
    png.format = PNG_FORMAT_RGB;
    std::vector<std::uint8_t> bytes(PNG_IMAGE_SIZE(png));
    ASSERT_TRUE(png_image_finish_read(&png, nullptr, bytes.data(), 0, nullptr));
    const auto encoded = [](double linear) {
        linear = std::min(1.0, std::max(0.0, linear));
        return 255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055);
    };
    for (std::size_t x = 0; x < 4096; ++x) {
        ASSERT_LE(std::abs(bytes[3 * x] - encoded(static_cast<double>(value(static_cast<int>(x))))),
                  0.5 + 1e-4)
            << x;
        ASSERT_LE(
            std::abs(bytes[3 * x + 1] - encoded(static_cast<double>(2 * value(static_cast<int>(x)) - 0.5f))),
            0.5 + 1e-4);
        ASSERT_EQ(bytes[3 * x + 2], 0);
    }
}

TEST_F(Images, PngLeavesNothingOnFailure) {
    EXPECT_THROW(write_png(path("missing/a.png"), noise(4, 4, {"R", "G", "B"})), UserError);
    EXPECT_EQ(entries(), 0u);
}

}  // namespace
}  // namespace ropsim
