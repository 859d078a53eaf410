// The k-buffer and the k+-buffer keep the same fragments, one sorted and one not.
#include "tests/rop/random_fragments.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

struct Scene {
    TraceHeader header;
    std::vector<Fragment> fragments;
};

Scene scene_of(std::uint64_t seed, bool distinct_depths, std::size_t count = 1000,
               int most_in_a_pixel = 1 << 30) {
    Random random(seed);
    Scene scene{test::opaque_header(9, 6, 1, random), {}};
    scene.fragments = test::random_fragments(
        scene.header,
        {.count = count, .distinct_depths = distinct_depths, .most_in_a_pixel = most_in_a_pixel}, random);
    return scene;
}

std::vector<float> image_of(const std::string& technique, const Scene& scene) {
    TestFrame frame(technique, scene.header);
    frame.draw(scene.fragments);
    return frame.image();
}

// Exact compositing of each pixel's nearest `layers` fragments.
double error_of_nearest(const std::string& technique, const Scene& scene, int layers) {
    TestFrame frame(technique, scene.header);
    frame.draw(scene.fragments);
    std::vector<Fragment> nearest;
    for (int pixel = 0; pixel < scene.header.width * scene.header.height; ++pixel) {
        auto own =
            test::nearest_first(scene.fragments, pixel % scene.header.width, pixel / scene.header.width);
        own.resize(std::min(own.size(), static_cast<std::size_t>(layers)));
        nearest.insert(nearest.end(), own.begin(), own.end());
    }
    return test::worst_error(frame, nearest);
}

TEST(KBufferFamily, KeepsTheNearestFragments) {
    for (const int layers : {2, 3, 8}) {
        const std::string k = "layers=" + std::to_string(layers) + ",format=float32";
        EXPECT_LT(error_of_nearest("k_buffer:" + k, scene_of(1, false), layers), 1e-5);
        EXPECT_LT(error_of_nearest("k_plus_buffer:" + k, scene_of(2, true), layers), 1e-5);
    }
}

// The k-buffer end of stochastic layered alpha blending is the k-buffer, bit for bit, in both formats; so is
// the k+-buffer where no depths are equal.
TEST(KBufferFamily, OneImage) {
    for (const char* format : {"format=paper", "format=float32"}) {
        for (const bool distinct : {true, false}) {
            const Scene scene = scene_of(3, distinct);
            const auto sorted = image_of(std::string("k_buffer:layers=5,") + format, scene);
            EXPECT_EQ(sorted, image_of(std::string("slab:bits=inf,layers=5,") + format, scene));
            if (distinct) {
                EXPECT_EQ(sorted, image_of(std::string("k_plus_buffer:layers=5,") + format, scene));
            }
        }
    }
}

TEST(KBufferFamily, ExactWithRoomInAnyOrder) {
    for (const char* technique : {"k_buffer", "k_plus_buffer"}) {
        Scene scene = scene_of(4, true, 600, 16);
        const auto expect_exact = [&] {
            TestFrame frame(std::string(technique) + ":layers=16,format=float32", scene.header);
            frame.draw(scene.fragments);
            EXPECT_LT(test::worst_error(frame, scene.fragments), 1e-5) << technique;
        };
        expect_exact();
        std::ranges::sort(scene.fragments, {}, &Fragment::z);
        expect_exact();
        std::ranges::reverse(scene.fragments);
        expect_exact();
    }
}

// Until something has been replaced the k+-buffer too takes the earlier of equal depths as nearer.
TEST(KBufferFamily, EqualDepths) {
    for (const char* technique : {"k_buffer:layers=4,format=float32", "k_plus_buffer:layers=4,format=float32",
                                  "k_plus_buffer:layers=3,format=float32"}) {
        TestFrame frame(technique, test::header_of(1, 1));
        for (std::uint32_t i = 0; i < 3; ++i)
            frame.draw_one(
                test::fragment_at(0, 0, 0.5f, i == 2 ? 1.0f : 0.5f,
                                  {i == 0 ? 1.0f : 0.0f, i == 1 ? 1.0f : 0.0f, i == 2 ? 1.0f : 0.0f}, i));
        EXPECT_EQ(frame.color(), (std::array<float, 3>{0.5f, 0.25f, 0.25f})) << technique;
        // Not nearer than the furthest of a full array.
        if (frame.declaration().surfaces[0].elements == 3) {
            frame.draw_one(test::fragment_at(0, 0, 0.5f, 1.0f, {9, 9, 9}, 3));
            EXPECT_EQ(frame.color(), (std::array<float, 3>{0.5f, 0.25f, 0.25f})) << technique;
        }
    }
}

// With fixed-point depths the far plane is a layer like any other: it is kept one step in front of the clear
// value.
TEST(KBufferFamily, FragmentsOnTheFarPlane) {
    for (const char* technique : {"k_buffer", "k_plus_buffer", "hybrid", "slab"}) {
        for (const char* depth : {"unorm8", "unorm16", "unorm24", "snorm8", "float16", "float32"}) {
            TestFrame frame(fmt::format("{}:layers=2,format=float32,depth_format={}", technique, depth),
                            test::header_of(1, 1, 1, {0, 0, 0}));
            frame.draw_one(test::fragment_at(0, 0, 1.0f, 0.5f, {1, 0, 0}, 0));
            frame.draw_one(test::fragment_at(0, 0, 0.5f, 0.5f, {0, 1, 0}, 1));
            EXPECT_EQ(frame.color(), (std::array<float, 3>{0.25f, 0.5f, 0})) << technique << " " << depth;
        }
    }
}

// Colours beyond the range of binary16 stop at its end: nothing becomes infinite, or no number at all behind
// an opaque layer.
TEST(KBufferFamily, ColoursBeyondTheirFormat) {
    for (const char* technique :
         {"k_buffer:layers=3,color_format=float16", "k_plus_buffer:layers=3,color_format=float16",
          "hybrid:layers=1,color_format=float16,tail_format=float16", "hybrid:layers=1",
          "hybrid:layers=1,tail_format=packed_wrapping", "slab:layers=3,color_format=float16",
          "slab:layers=3,composite=normalised", "slab:layers=3,coverage=discrete,composite=normalised"}) {
        TestFrame frame(technique + std::string(",image_format=float32"), test::header_of(1, 1));
        Fragment glow = test::fragment_at(0, 0, 0.6f, 0, {0, 0, 0}, 3);
        glow.r = 1e30f;
        frame.draw({{test::fragment_at(0, 0, 0.5f, 0.5f, {1e30f, 1, 1}, 0),
                     test::fragment_at(0, 0, 0.4f, 1e-5f, {1e10f, 1e10f, 1}, 1), glow,
                     test::fragment_at(0, 0, 0.3f, 1.0f, {0.5f, 0.5f, 0.5f}, 2)}});
        for (const float v : frame.color()) {
            EXPECT_TRUE(std::isfinite(v)) << technique;
            EXPECT_GE(v, 0.0f) << technique;
        }
    }
}

// vis(z) as composited: the transmittance of the stored layers strictly in front.
TEST(KBufferFamily, Visibility) {
    const std::vector<Fragment> layers = {test::fragment_at(0, 0, 0.5f, 0.5f, {1, 1, 1}, 0),
                                          test::fragment_at(0, 0, 0.25f, 0.25f, {1, 1, 1}, 1),
                                          test::fragment_at(0, 0, 0.75f, 0.75f, {1, 1, 1}, 2),
                                          test::fragment_at(0, 0, 0.9f, 1.0f, {1, 1, 1}, 3)};
    constexpr std::array<float, 6> kDepths = {0.1f, 0.25f, 0.3f, 0.6f, 0.8f, 1.0f};
    for (const char* technique : {"k_buffer:layers=3", "k_plus_buffer:layers=3", "slab:layers=3,bits=inf",
                                  "slab:layers=3,bits=inf,composite=normalised"}) {
        TestFrame frame(technique + std::string(",format=float32"), test::header_of(1, 1));
        frame.draw(layers);
        ASSERT_TRUE(frame.operation().has_visibility()) << technique;
        std::array<float, kDepths.size()> values{};
        frame.operation().visibility(frame.store(), 0, 0, kDepths, values);
        EXPECT_EQ(values, (std::array<float, 6>{1, 1, 0.75f, 0.375f, 0.09375f, 0.09375f})) << technique;
    }
    // With masks, in shares of their bits: alpha 1/2 and 3/4 of 4 bits have exactly 2 and 3.
    TestFrame frame("slab:layers=3,bits=4,coverage=discrete", test::header_of(1, 1));
    frame.draw(std::span(layers).first(1));
    std::array<float, kDepths.size()> values{};
    frame.operation().visibility(frame.store(), 0, 0, kDepths, values);
    EXPECT_EQ(values, (std::array<float, 6>{1, 1, 1, 0.5f, 0.5f, 0.5f}));
}

}  // namespace
}  // namespace ropsim
