// Hashed alpha testing: where its cubes lie, where the noise stays, the image's expectation, bytes and cost.
#include "rop/threshold_hash.h"
#include "tests/rop/random_fragments.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

Camera camera_at(glm::vec3 eye) {
    Camera camera;
    camera.view = glm::lookAt(eye, eye + glm::vec3(0, 0, -1), glm::vec3(0, 1, 0));
    camera.projection = glm::perspective(1.0f, 1.0f, 0.5f, 50.0f);
    camera.near_plane = 0.5f;
    camera.far_plane = 50;
    return camera;
}
TraceHeader header_with_camera(int side, glm::vec3 eye = {0.3f, 0.2f, 5.0f}) {
    TraceHeader header = test::header_of(side, side);
    header.camera = camera_at(eye);
    return header;
}

// The pixel centre's position by its ray: an eye that looks along -z, with a distance from the window depth.
TEST(PixelCubes, PositionIsOnThePixelsRay) {
    const int side = 200;
    const glm::vec3 eye(0.3f, 0.2f, 5.0f);
    const PixelCubes cubes(side, side, camera_at(eye));
    ASSERT_TRUE(cubes.valid());
    const double slope = std::tan(0.5);  // half the field of view of one radian
    for (const double distance : {0.6, 3.0, 20.0}) {
        const double z = (1 / 0.5 - 1 / distance) / (1 / 0.5 - 1 / 50.0);
        for (const auto& [x, y] : {std::pair(0, 0), std::pair(137, 11), std::pair(199, 100)}) {
            const CubePlace place = cubes.at(x, y, static_cast<float>(z));
            const double across = ((x + 0.5) / side * 2 - 1) * slope * distance;
            const double down = ((y + 0.5) / side * 2 - 1) * slope * distance;
            const double tolerance = 1e-4 * distance * distance;  // of a depth rounded to float
            EXPECT_NEAR(place.position[0], eye.x + across, tolerance);
            EXPECT_NEAR(place.position[1], eye.y - down, tolerance);
            EXPECT_NEAR(place.position[2], eye.z - distance, tolerance);
            // Pixels to a unit of length.
            EXPECT_NEAR(place.scale * 2 * slope * distance / side, 1, 1e-3);
        }
    }
    Camera flat;
    flat.projection = glm::mat4(0.0f);
    EXPECT_FALSE(PixelCubes(side, side, flat).valid());
}

// Alpha of each fragment passes with probability alpha: over many pixels the mean image is exact compositing
// of one layer, and of layers whose thresholds are independent.
TEST(HashedAlpha, ExpectationIsAlpha) {
    constexpr int kSide = 160;
    constexpr double kPixels = kSide * kSide;
    for (const char* hash : {"position", "pixel", "primitive"}) {
        for (const float alpha : {0.05f, 0.3f, 0.9f}) {
            std::vector<Fragment> layer;
            for (int i = 0; i < kSide * kSide; ++i) {
                const auto primitive = static_cast<std::uint32_t>(i % 97);
                layer.push_back(test::fragment_at(i % kSide, i / kSide, 0.9f, alpha, {1, 0, 0}, primitive));
                layer.push_back(
                    test::fragment_at(i % kSide, i / kSide, 0.5f, alpha, {0, 1, 0}, primitive + 100));
            }
            TestFrame frame(std::string("hashed_alpha:format=float32,hash=") + hash,
                            header_with_camera(kSide), 3);
            frame.draw(layer);
            const std::vector<float> image = frame.image();
            std::array<double, 3> mean{};
            for (std::size_t i = 0; i < image.size(); ++i) mean[i % 3] += image[i] / kPixels;
            const double t = 1.0 - static_cast<double>(alpha);
            const auto rgb = test::background_of(frame.header(), 0, 0);
            // Each pixel is one of three colours. Cubes are half a pixel to two wide, so that up to four
            // pixels share one: the error is at most twice that of independent pixels.
            const double tolerance = 5 * 2 * 0.5 / kSide;
            EXPECT_NEAR(mean[0], t * alpha + t * t * rgb[0], tolerance) << hash << " " << alpha;
            EXPECT_NEAR(mean[1], alpha + t * t * rgb[1], tolerance) << hash << " " << alpha;
        }
    }
}

TEST(HashedAlpha, OneAlwaysPassesAndZeroNever) {
    constexpr int kSide = 64;
    for (const char* hash : {"position", "pixel", "primitive"}) {
        for (const float alpha : {0.0f, 1.0f}) {
            TestFrame frame(std::string("hashed_alpha:hash=") + hash, header_with_camera(kSide));
            std::vector<Fragment> fragments;
            for (std::uint32_t i = 0; i < kSide * kSide; ++i)
                fragments.push_back(test::fragment_at(
                    static_cast<int>(i % kSide), static_cast<int>(i / kSide), 0.25f, alpha, {1, 1, 1}, i));
            frame.draw(fragments);
            EXPECT_EQ(frame.log().path_count(alpha == 1 ? 1 : 0), fragments.size()) << hash;
        }
    }
}

// The test is alpha >= threshold, so that an alpha of 1 passes the largest threshold, which is 1; the
// smallest is above 0.
TEST(HashedAlpha, AlphaPassesAtItsThreshold) {
    EXPECT_EQ(hashed_unit<PlainDatapath>(0xFFFFFFFFu), 1.0f);
    EXPECT_EQ(hashed_unit<PlainDatapath>(0), 0x1p-24f);
    const float z = 0.375f;
    const auto seed = static_cast<std::uint32_t>(mix64(9));
    for (std::uint32_t x = 0; x < 8; ++x) {
        const float threshold = hashed_unit<PlainDatapath>(
            hash_words<PlainDatapath>({x | 5u << 16, std::bit_cast<std::uint32_t>(z), 0}, seed));
        TestFrame frame("hashed_alpha:hash=pixel", test::header_of(8, 8), 9);
        const int column = static_cast<int>(x);
        frame.draw_one(test::fragment_at(column, 5, z, std::nextafter(threshold, 0.0f), {1, 1, 1}));
        EXPECT_EQ(frame.log().path_count(1), 0u);
        frame.draw_one(test::fragment_at(column, 5, z, threshold, {1, 1, 1}));
        EXPECT_EQ(frame.log().path_count(1), 1u);
    }
}

// The noise is the surface's: a plane across the view keeps its thresholds when the camera moves by whole
// pixels along it, by position; by pixel it does not.
TEST(HashedAlpha, NoiseStaysOnTheSurface) {
    constexpr int kSide = 64;
    const float alpha = 0.5f;
    const float distance = 4;
    const float z = (1 / 0.5f - 1 / distance) / (1 / 0.5f - 1 / 50.0f);
    std::vector<Fragment> plane;
    for (int i = 0; i < kSide * kSide; ++i)
        plane.push_back(test::fragment_at(i % kSide, i / kSide, z, alpha, {1, 1, 1}));
    const float pixel = 2 * std::tan(0.5f) * distance / kSide;
    for (const bool by_position : {true, false}) {
        const std::string technique = by_position ? "hashed_alpha" : "hashed_alpha:hash=pixel";
        // Off the faces of the cubes, where rounding would decide.
        const glm::vec3 eye(0.31f * pixel, 0.17f * pixel, 5.01f);
        TestFrame here(technique, header_with_camera(kSide, eye));
        TestFrame moved(technique, header_with_camera(kSide, eye + glm::vec3(8 * pixel, 0, 0)));
        here.draw(plane);
        moved.draw(plane);
        const auto a = here.image();
        const auto b = moved.image();
        int same = 0;
        int compared = 0;
        for (int y = 0; y < kSide; ++y) {
            for (int x = 8; x < kSide; ++x) {
                ++compared;
                const auto at = static_cast<std::size_t>(3 * (y * kSide + x));
                same += a[at] == b[at - 24] ? 1 : 0;
            }
        }
        // Two independent masks of one half agree in one half of the pixels.
        if (by_position) {
            EXPECT_GT(same, compared * 99 / 100);
        } else {
            EXPECT_NEAR(same, compared / 2.0, 6 * std::sqrt(compared / 4.0));
        }
    }
}

TEST(HashedAlpha, PositionNeedsACamera) {
    try {
        TestFrame::make("hashed_alpha:hash=position", test::header_of(4, 4));
        FAIL() << "accepted";
    } catch (const UserError& error) {
        EXPECT_NE(std::string(error.what()).find("no camera"), std::string::npos);
    }
    EXPECT_NO_THROW(TestFrame::make("hashed_alpha", test::header_of(4, 4)));
    TraceHeader flat = test::header_of(4, 4);
    flat.camera = Camera{};
    flat.camera->projection = glm::mat4(0.0f);
    EXPECT_THROW(TestFrame::make("hashed_alpha", flat), UserError);
}

// Z32F and RGBA8: 4 bytes read and 8 written by what passes, none by what does not. The hash is in the cost
// of both.
TEST(HashedAlpha, BytesAndCost) {
    TestFrame frame("hashed_alpha", header_with_camera(8));
    EXPECT_EQ(frame.declaration().storage_bits_per_pixel(), 64);
    const CostTable table = frame.operation().cost(test::plain_shape());
    const auto rejected = test::bytes_of(frame.declaration(), table[0].worst.data());
    const auto passed = test::bytes_of(frame.declaration(), table[1].worst.data());
    EXPECT_EQ(rejected.read + rejected.write, 0u);
    EXPECT_EQ(passed.read, 4u);
    EXPECT_EQ(passed.write, 8u);
    // Two hashes of three words: three multipliers to put them together, two to mix, one for the cube's size.
    const auto units = table[0].work.units;
    EXPECT_EQ(units[static_cast<std::size_t>(Unit::kIntegerMultiplier)], 2u * 6);
    EXPECT_EQ(units[static_cast<std::size_t>(Unit::kDivider)], 2u);
}

// Charged and plain agree where there is a camera, which the conformance tests' scenes do not have.
TEST(HashedAlpha, ChargedEqualsPlainWithACamera) {
    Random random(43);
    TraceHeader header = header_with_camera(6);
    const auto fragments = test::random_fragments(header, {.count = 3000}, random);
    TestFrame plain("hashed_alpha", header, 3);
    TestFrame charged("hashed_alpha", header, 3);
    const CostTable table = charged.operation().cost(test::prime_shape());
    plain.draw(fragments);
    for (std::size_t i = 0; i < fragments.size(); ++i) {
        const auto outcome = charged.operation().charged_fragment(test::prime_shape(), 0, 0, fragments[i], {},
                                                                  charged.store());
        ASSERT_EQ(outcome.path, static_cast<int>(plain.log().record_path(i)));
        ASSERT_EQ(outcome.work, table[static_cast<std::size_t>(outcome.path)].work);
    }
    EXPECT_EQ(plain.image(), charged.image());
}

}  // namespace
}  // namespace ropsim
