// Weighted blended OIT: every published weight in closed form, and what binary16 sums and eight-bit revealage
// do to it.
#include "tests/rop/layer_lists.h"
#include "tests/rop/worst_case_bytes.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

constexpr double kNear = 0.5;
constexpr double kFar = 400;

TraceHeader with_camera(TraceHeader header, bool perspective, float metres_per_unit = 1) {
    Camera camera;
    camera.projection =
        perspective ? glm::perspective(0.7, 1.0, kNear, kFar) : glm::ortho(-1.0, 1.0, -1.0, 1.0, kNear, kFar);
    camera.near_plane = kNear;
    camera.far_plane = kFar;
    camera.metres_per_unit = metres_per_unit;
    header.camera = camera;
    return header;
}

// The papers' |z| of a window depth, by the textbook formula.
double distance(double d, bool perspective) {
    return perspective ? kNear * kFar / (kFar - d * (kFar - kNear)) : kNear + d * (kFar - kNear);
}

// As printed, of alpha, window depth and distance.
double weight(const std::string& name, double a, double d, double z) {
    const auto clamped = [](double low, double w, double high) { return std::max(low, std::min(high, w)); };
    if (name == "eq7") return a * clamped(1e-2, 10 / (1e-5 + std::pow(z / 5, 2) + std::pow(z / 200, 6)), 3e3);
    if (name == "eq8")
        return a * clamped(1e-2, 10 / (1e-5 + std::pow(z / 10, 3) + std::pow(z / 200, 6)), 3e3);
    if (name == "eq9") return a * clamped(1e-2, 0.03 / (1e-5 + std::pow(z / 200, 4)), 3e3);
    if (name == "eq10") return a * std::max(1e-2, 3e3 * std::pow(1 - d, 3));
    if (name == "blog2015") return clamped(1e-2, 1e3 * std::pow((8 * a + 0.01) * (1 - 0.95 * d), 3), 3e2);
    if (name == "learnopengl")
        return clamped(1e-2, std::pow(std::min(1.0, a * 10) + 0.01, 3) * 1e8 * std::pow(1 - d * 0.9, 3), 3e3);
    return 1;
}

// The image by the paper's sums, in double precision.
void expect_closed_form(const std::string& name, const TraceHeader& header, bool perspective, double unit,
                        std::span<const Fragment> fragments) {
    TestFrame frame("weighted_blended:format=float32,weight=" + name, header);
    frame.draw(fragments);
    const std::vector<float> image = frame.image();
    for (int pixel = 0; pixel < header.width * header.height; ++pixel) {
        const int x = pixel % header.width;
        const int y = pixel / header.width;
        std::array<double, 3> sum{};
        double weights = 0;
        double revealage = 1;
        for (const Fragment& f : fragments) {
            if (f.x != x || f.y != y) continue;
            const double w = weight(name, f.a, f.z, unit * distance(f.z, perspective));
            sum = {sum[0] + f.r * w, sum[1] + f.g * w, sum[2] + f.b * w};
            weights += f.a * w;
            revealage *= 1.0 - static_cast<double>(f.a);
        }
        const auto background = test::background_of(header, x, y);
        for (std::size_t c = 0; c < 3; ++c) {
            const double mean = weights > 0 ? sum[c] / weights : 0;
            ASSERT_NEAR(image[static_cast<std::size_t>(3 * pixel) + c],
                        (1 - revealage) * mean + revealage * background[c], 2e-5)
                << name;
        }
    }
}

std::vector<Fragment> deep_fragments(const TraceHeader& header, Random& random) {
    test::FragmentOptions options;
    options.count = 2500;
    auto fragments = test::random_fragments(header, options, random);
    // In every second pixel they stand so far back that weights meet their floors, in every third so near
    // that they meet their caps.
    for (Fragment& f : fragments) {
        if ((f.x + f.y) % 2 == 0) f.z = 1 - 0.03f * (1 - f.z);
        if ((f.x + f.y) % 3 == 0) f.z *= 0.02f;
    }
    return fragments;
}

TEST(WeightedBlended, EveryWeightEqualsItsClosedForm) {
    Random random(231);
    const TraceHeader plain = test::opaque_header(10, 7, 1, random);
    const auto fragments = deep_fragments(plain, random);
    for (const char* name : {"eq10", "blog2015", "learnopengl", "none"})
        expect_closed_form(name, plain, true, 1, fragments);
    for (const char* name : {"eq7", "eq8", "eq9"})
        for (const bool perspective : {true, false})
            for (const float unit : {1.0f, 0.01f})
                expect_closed_form(name, with_camera(plain, perspective, unit), perspective, unit, fragments);
}

// The weights by distance have no line among the conformance cases, whose traces have no camera.
TEST(WeightedBlended, ChargedWeightsByDistanceEqualPlainOnes) {
    Random random(232);
    const TraceHeader plain = test::opaque_header(5, 4, 1, random);
    const auto fragments = deep_fragments(plain, random);
    const DatapathShape shape = test::prime_shape();
    for (const char* name : {"eq7", "eq8", "eq9"})
        for (const bool perspective : {true, false}) {
            const TraceHeader header = with_camera(plain, perspective);
            TestFrame a(std::string("weighted_blended:weight=") + name, header);
            TestFrame b(std::string("weighted_blended:weight=") + name, header);
            const CostTable table = b.operation().cost(shape);
            a.draw(fragments);
            for (const Fragment& f : fragments)
                ASSERT_EQ(b.operation().charged_fragment(shape, 0, 0, f, {}, b.store()).work, table[0].work);
            for (int pixel = 0; pixel < 20; ++pixel)
                ASSERT_TRUE(std::ranges::equal(a.words(pixel % 5, pixel / 5), b.words(pixel % 5, pixel / 5)))
                    << name;
        }
}

std::string refusal(const std::string& technique, const TraceHeader& header) {
    try {
        TestFrame::make(technique, header);
    } catch (const UserError& error) {
        return error.what();
    }
    return "";
}

TEST(WeightedBlended, WeightsByDistanceNeedACamera) {
    const TraceHeader header = test::header_of(1, 1);
    for (const char* name : {"eq7", "eq8", "eq9"}) {
        const std::string text = std::string("weighted_blended:weight=") + name;
        EXPECT_THAT(refusal(text, header), testing::HasSubstr("the trace has no camera"));
        EXPECT_EQ(refusal(text, with_camera(header, true)), "");
        TraceHeader oblique = with_camera(header, true);
        oblique.camera->projection[0][2] = 0.1f;
        EXPECT_THAT(refusal(text, oblique), testing::HasSubstr("cannot be told from depth"));
    }
    EXPECT_EQ(refusal("weighted_blended", header), "");
}

TEST(WeightedBlended, ClaimedStorageAndTraffic) {
    EXPECT_EQ(test::storage_bits("weighted_blended"), 72);
    const auto bytes = test::worst_case_bytes("weighted_blended");
    EXPECT_EQ(bytes.read, 9u);
    EXPECT_EQ(bytes.write, 9u);
}

// The tutorial's weight has no depth in it: (10 a + .01)^3 1e8 (1 - .9 z)^3 is at its cap of 3000 at the far
// plane already for alpha above (0.03^(1/3) - .01) / 10 = 0.0301. Same image as without any weight.
TEST(WeightedBlended, TheTutorialsWeightIsConstant) {
    Random random(233);
    const auto fragments = test::random_layers(6, 10, random, [&] { return random.real(0.031, 0.9); });
    for (const Fragment& f : fragments) EXPECT_EQ(weight("learnopengl", f.a, f.z, 0), 3e3);
    TestFrame tutorial("weighted_blended:weight=learnopengl,format=float32", test::header_of(6, 6));
    TestFrame none("weighted_blended:weight=none,format=float32", test::header_of(6, 6));
    tutorial.draw(fragments);
    none.draw(fragments);
    const auto a = tutorial.image();
    const auto b = none.image();
    for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 1e-5);
}

std::array<float, 3> many(const std::string& parameters, int layers, float z, float a,
                          std::array<float, 3> color) {
    TestFrame frame("weighted_blended:revealage_format=float32" + parameters, test::header_of(1, 1));
    for (int i = 0; i < layers; ++i) frame.draw_one(test::fragment_at(0, 0, z, a, color));
    return frame.color();
}

// binary16 ends at 65504. 64 layers ten times as bright as white, alpha 1/2, near the eye: each adds
// 10 / 4 * 3000 to the colour's sum and 3000 / 4 to the weights'. The colour's is infinite after 9 layers;
// without a remedy the image is. The authors' resolve makes it white; sums that saturate leave 65504 over
// 48000, too dark but bright, and dark channels as they are.
TEST(WeightedBlended, OverflowOfColourIsWhiteOrSaturates) {
    const std::array<float, 3> bright = {10, 10, 1};
    EXPECT_NEAR(many(",format=float32", 64, 0, 0.5f, bright)[0], 10, 1e-4);
    EXPECT_NEAR(many("", 8, 0, 0.5f, bright)[0], 10, 0.05);
    EXPECT_EQ(many("", 64, 0, 0.5f, bright), (std::array<float, 3>{1, 1, 1}));
    const auto saturated = many(",overflow=saturate", 64, 0, 0.5f, bright);
    EXPECT_NEAR(saturated[0], 65504.0 / 48000, 0.02);
    EXPECT_NEAR(saturated[2], 1, 5e-3);
}

// The tutorial's weight overflows with 22 opaque layers of no more than white; the sum of weights first where
// colours are darker: replaced by the largest colour sum, the brightest channel shows as 1.
TEST(WeightedBlended, OverflowOfTheWeightsKeepsTheHue) {
    const std::array<float, 3> dark = {0.5f, 0.25f, 0};
    const auto expect_near = [](const std::array<float, 3>& got, std::array<double, 3> expected) {
        for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(got[c], expected[c], 0.01 * expected[c]);
    };
    expect_near(many(",weight=learnopengl", 21, 0.5f, 1, dark), {0.5, 0.25, 0});
    expect_near(many(",weight=learnopengl", 22, 0.5f, 1, dark), {1, 0.5, 0});
    expect_near(many(",weight=learnopengl,overflow=saturate", 22, 0.5f, 1, dark), {0.5, 0.25, 0});
    expect_near(many(",weight=blog2015", 200, 0.5f, 1, dark), {0.5, 0.25, 0});
}

// Whatever overflows, and whatever its sign, the image is finite.
TEST(WeightedBlended, NoInputMakesTheImageInfinite) {
    const float huge = std::numeric_limits<float>::max() / 4;
    for (const char* overflow : {"white", "saturate"})
        for (const char* name : {"eq10", "blog2015", "learnopengl", "none"})
            for (const char* format : {"paper", "float32"}) {
                const std::string text = std::string("weighted_blended:overflow=") + overflow +
                                         ",weight=" + name + ",format=" + format + ",image_format=float32";
                TestFrame frame(text, test::header_of(1, 1));
                for (const float color : {huge, -huge, 65504.0f, -65504.0f, 1e-38f, huge})
                    for (const float a : {0.0f, 1e-38f, 1e-4f, 0.5f, 1.0f}) {
                        Fragment f = test::fragment_at(0, 0, 0.25f, a, {color, color, 0});
                        f.b = std::min(color, 1e30f);  // light that nothing covers
                        frame.draw_one(f);
                        for (const float c : frame.color()) ASSERT_TRUE(std::isfinite(c)) << text;
                    }
            }
}

// Eight bits of revealage stall where a step is less than half: T - a T rounds back to T below 1 / (2 a)
// steps, so that thin layers stop hiding the background, or never begin to. Sixteen bits go on.
TEST(WeightedBlended, RevealageStallsInEightBits) {
    const auto revealage = [](const std::string& format, float a) {
        TestFrame frame("weighted_blended:image_format=float32,revealage_format=" + format,
                        test::header_of(1, 1, 1, {1, 1, 1}));
        for (int i = 0; i < 3000; ++i) frame.draw_one(test::fragment_at(0, 0, 0.5f, a, {0, 0, 0}));
        return frame.color()[0];
    };
    EXPECT_NEAR(revealage("unorm8", 0.01f), 50 / 255.0, 1e-6);
    EXPECT_NEAR(revealage("unorm8", 0.005f), 100 / 255.0, 1e-6);
    EXPECT_EQ(revealage("unorm8", 0.00196f), 1.0f);
    EXPECT_EQ(revealage("unorm8", 0.0019f), 1.0f);
    EXPECT_LT(revealage("unorm8", 0.00197f), 1.0f);
    EXPECT_LT(revealage("unorm16", 0.01f), 0.001);
    EXPECT_LT(revealage("float16", 0.01f), 1e-5);
}

}  // namespace
}  // namespace ropsim
