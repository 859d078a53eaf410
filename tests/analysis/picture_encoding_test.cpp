// Encoded pictures, decoded again by libwebp.
#include "analysis/report/picture_encoding.h"

#include <algorithm>
#include <cstdlib>
#include <random>

#include <gtest/gtest.h>
#include <webp/decode.h>

namespace ropsim {
namespace {

std::vector<std::uint8_t> bytes_of(const std::string& uri) {
    const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::vector<std::uint8_t> bytes;
    std::uint32_t group = 0;
    int bits = 0;
    for (std::size_t i = uri.find(',') + 1; i < uri.size() && uri[i] != '='; ++i) {
        group = group << 6 | static_cast<std::uint32_t>(digits.find(uri[i]));
        bits += 6;
        if (bits < 8) continue;
        bits -= 8;
        bytes.push_back(static_cast<std::uint8_t>(group >> bits));
    }
    return bytes;
}

Picture decoded(const std::string& uri) {
    EXPECT_TRUE(uri.starts_with("data:image/webp;base64,"));
    const std::vector<std::uint8_t> bytes = bytes_of(uri);
    Picture picture;
    std::uint8_t* rgb = WebPDecodeRGB(bytes.data(), bytes.size(), &picture.width, &picture.height);
    if (rgb == nullptr) return {};
    picture.rgb.assign(rgb, rgb + static_cast<std::ptrdiff_t>(picture.width) * picture.height * 3);
    WebPFree(rgb);
    return picture;
}

// Noise over a gradient: as hard as a stochastic technique's image.
Picture noise(int width, int height, unsigned seed) {
    std::mt19937 random(seed);
    Picture picture{width, height, {}};
    for (int i = 0; i < width * height * 3; ++i)
        picture.rgb.push_back(static_cast<std::uint8_t>((i / 64 + random() % 64) % 256));
    return picture;
}

int largest_difference(const Picture& a, const Picture& b) {
    int largest = 0;
    for (std::size_t i = 0; i < a.rgb.size(); ++i)
        largest = std::max(largest, std::abs(static_cast<int>(a.rgb[i]) - static_cast<int>(b.rgb[i])));
    return largest;
}

TEST(PictureEncoding, ExactIsExactAndNearIsAsNearAsItSays) {
    const Picture picture = noise(67, 41, 1);
    for (const auto& [loss, most] :
         {std::pair{PictureLoss::kNone, 0}, {PictureLoss::kNear, 2}, {PictureLoss::kNearer, 8}}) {
        const Picture back = decoded(picture_uri(picture, loss));
        ASSERT_EQ(back.width, 67);
        ASSERT_EQ(back.height, 41);
        EXPECT_LE(largest_difference(picture, back), most) << loss_text(loss);
    }
}

TEST(PictureEncoding, EveryStepIsSmaller) {
    const Picture picture = noise(160, 90, 2);
    std::size_t before = std::string::npos;
    for (int loss = 0; loss < kPictureLosses; ++loss) {
        const std::size_t size = picture_uri(picture, static_cast<PictureLoss>(loss)).size();
        EXPECT_LT(size, before) << loss;
        before = size;
    }
}

TEST(PictureEncoding, KeepsTheBudgetAndLosesNoMoreThanItMust) {
    std::vector<Picture> pictures{noise(160, 90, 3),
                                  Picture{160, 90, std::vector<std::uint8_t>(std::size_t{160} * 90 * 3, 9)}};
    for (unsigned i = 4; i < 10; ++i) pictures.push_back(noise(160, 90, i));
    std::size_t exact = 0;
    for (const Picture& picture : pictures) exact += picture_uri(picture, PictureLoss::kNone).size();
    for (const EncodedPicture& one : encode_within(pictures, exact, 2))
        EXPECT_EQ(one.loss, PictureLoss::kNone);
    for (const std::size_t budget : {exact - 1, exact / 2, exact / 4}) {
        const auto encoded = encode_within(pictures, budget, 2);
        std::size_t total = 0;
        for (const EncodedPicture& one : encoded) total += one.uri.size();
        EXPECT_LE(total, budget);
        EXPECT_EQ(encoded[1].loss, PictureLoss::kNone) << "a plain picture has nothing to give";
        const auto again = encode_within(pictures, budget, 1);
        for (std::size_t i = 0; i < encoded.size(); ++i) EXPECT_EQ(encoded[i].uri, again[i].uri) << "threads";
    }
    for (const EncodedPicture& one : encode_within(pictures, 1, 2)) EXPECT_EQ(one.loss, PictureLoss::kCoarse);
}

TEST(PictureEncoding, NumbersSurvive) {
    const std::vector<double> values{0, 1, 255, 256, 65536, 16777215, 2e9, -3, 12.4};
    const Picture back = decoded(picture_uri(packed_numbers(3, 3, values), PictureLoss::kNone));
    const std::vector<int> expected{0, 1, 255, 256, 65536, 16777215, 16777215, 0, 12};
    for (std::size_t i = 0; i < values.size(); ++i)
        EXPECT_EQ(back.rgb[3 * i] * 65536 + back.rgb[3 * i + 1] * 256 + back.rgb[3 * i + 2], expected[i]);
}

}  // namespace
}  // namespace ropsim
