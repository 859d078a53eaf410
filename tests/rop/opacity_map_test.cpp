// Opacity shadow maps and deep opacity maps as transparency, against a reimplementation in double precision,
// closed forms, and table 1 of Salvi et al. 2011.
#include "tests/rop/visibility_maps.h"
#include "tests/rop/worst_case_bytes.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::absorbance;
using test::Layers;
using test::MapLayer;
using test::Random;
using test::TestFrame;

struct Planes {
    int count = 16;
    bool linear = true;
    enum Kind { kPixel, kFrame, kDeep, kGrowing } kind = kPixel;
    double depth_range = 0.05;
};

// In units of planes: whole numbers stand at planes, 0 where a map begins.
double position(const Planes& planes, const Layers& layers, double z) {
    const double count = planes.count;
    if (planes.kind == Planes::kPixel) return test::share_of(layers, z) * count;
    if (planes.kind == Planes::kFrame) return z * count;
    double nearest = 2;
    for (const MapLayer& l : layers) nearest = std::min(nearest, l.z);
    const double share = std::clamp((z - nearest) / planes.depth_range, 0.0, 1.0);
    if (planes.kind == Planes::kDeep) return share * count;
    // Layers of sizes 1, 2, 3 ...: position k where k (k + 1) / 2 of their sum is passed.
    return (std::sqrt(1 + 4 * count * (count + 1) * share) - 1) / 2;
}

// Absorbance strictly in front of plane `k`, which stands at position k.
double in_front_of_plane(const Planes& planes, const Layers& layers, int k) {
    double sum = 0;
    if (k < 1) return 0;
    for (const MapLayer& l : layers) {
        double at = position(planes, layers, l.z);
        // Behind the last plane of a deep map it counts to that.
        if (planes.kind >= Planes::kDeep) at = std::min(at, planes.count - 0.5);
        if (at < k) sum += absorbance(l.a);
    }
    return sum;
}
double visibility(const Planes& planes, const Layers& layers, double z) {
    const double at = position(planes, layers, z);
    const int k = static_cast<int>(at);
    const double front = in_front_of_plane(planes, layers, k);
    if (!planes.linear || k >= planes.count) return std::exp(-front);
    return std::exp(-(front + (at - k) * (in_front_of_plane(planes, layers, k + 1) - front)));
}

struct MapCase {
    const char* parameters;
    Planes planes;
    bool normalised = false;
};
constexpr std::array kCases = {
    MapCase{"", {}},
    MapCase{"lookup=step", {16, false}},
    MapCase{"slices=5,sums=slab", {5, true}},
    MapCase{"slices=7,sums=slab,lookup=step,composite=normalised", {7, false}, true},
    MapCase{"slices=1,composite=normalised", {1, true}, true},
    MapCase{"bounds=frame", {16, true, Planes::kFrame}},
    MapCase{"bounds=frame,lookup=step,slices=9", {9, false, Planes::kFrame}},
    MapCase{"planes=deep,depth_range=0.4", {16, true, Planes::kDeep, 0.4}},
    MapCase{"planes=deep,depth_range=0.4,lookup=step,sums=slab", {16, false, Planes::kDeep, 0.4}},
    MapCase{"planes=deep,depth_range=0.6,spacing=growing,slices=6", {6, true, Planes::kGrowing, 0.6}},
};

TEST(OpacityMap, EqualsItsDefinition) {
    for (const int samples : {1, 4})
        for (const MapCase& setup : kCases)
            for (const char* memory : {"fixed", "variable"}) {
                const std::string parameters = setup.parameters;
                if (memory == std::string("variable") && parameters.find("slab") != std::string::npos)
                    continue;
                auto scene = test::map_scene(21, samples);
                // Lists keep one depth, without its lowest bits.
                if (memory == std::string("variable") && samples > 1) {
                    scene.slopes.clear();
                    for (Fragment& f : scene.fragments)
                        f.z = std::bit_cast<float>(std::bit_cast<std::uint32_t>(f.z) & ~15u);
                }
                const auto expected = test::composited_by(
                    scene.header, scene.fragments, scene.slopes,
                    [&](const Layers& layers, double z) { return visibility(setup.planes, layers, z); },
                    setup.normalised);
                const auto image = test::drawn_image(
                    "opacity_map:format=float32,color_format=float32,memory=" + std::string(memory) + "," +
                        parameters,
                    scene);
                EXPECT_LT(test::worst_difference(image, expected), 5e-6)
                    << parameters << " " << memory << " samples " << samples;
            }
}

TEST(OpacityMap, TellsVisibilityAsItComposites) {
    const auto scene = test::map_scene(22);
    const auto layers = test::layers_of(scene.header, scene.fragments, {}, 0, 0, 0);
    std::vector<float> depths = {0.0f, 1.0f};
    for (const MapLayer& l : layers) depths.push_back(static_cast<float>(l.z));
    for (int i = 1; i < 50; ++i) depths.push_back(static_cast<float>(i) / 50.01f);
    for (const char* memory : {"fixed", "variable"}) {
        for (const MapCase& setup : kCases) {
            if (std::string(setup.parameters).find("slab") != std::string::npos) continue;
            TestFrame frame(
                "opacity_map:format=float32,memory=" + std::string(memory) + "," + setup.parameters,
                scene.header);
            frame.draw(scene.fragments);
            const auto values = test::visibility_at(frame, depths);
            for (std::size_t i = 0; i < depths.size(); ++i)
                ASSERT_NEAR(values[i], visibility(setup.planes, layers, depths[i]), 1e-5)
                    << setup.parameters << " " << memory << " at " << depths[i];
        }
    }
}

// Table 1 of Salvi et al. 2011 at 1280 x 720, MByte of 2^20 bytes: 16 float32 planes and two bounds.
TEST(OpacityMap, BytesOfTable1) {
    const auto map_bytes = [](int samples) {
        const auto operation = TestFrame::make("opacity_map", test::header_of(4, 4, samples));
        int bits = 0;
        for (const Surface& s : operation->declaration().surfaces)
            if (s.name != "accumulated_color") bits += s.bits_per_pixel();
        return bits / 8;
    };
    EXPECT_EQ(map_bytes(1), 72);
    EXPECT_NEAR(map_bytes(1) * 921600.0 / (1 << 20), 63.3, 0.05);
    EXPECT_NEAR(map_bytes(4) * 921600.0 / (1 << 20), 253.1, 0.05);
    EXPECT_EQ(test::storage_bits("opacity_map"), 640);
    // Deep planes need the nearest depth alone, the whole depth range none.
    EXPECT_EQ(test::storage_bits("opacity_map:planes=deep"), 640 - 32);
    EXPECT_EQ(test::storage_bits("opacity_map:bounds=frame"), 640 - 64);
    EXPECT_EQ(test::storage_bits("opacity_map:memory=variable"), 32);
}

// A model in which each pass reads and writes what it changes gives 144 and 80 bytes; but the passes for map
// and colour read the bounds too, twice 8. Fewer slices can be touched: the planes behind, two planes, or a
// slab and those in front of it.
TEST(OpacityMap, WorstCaseBytesOfThreePasses) {
    const auto worst = test::worst_case_bytes("opacity_map");
    EXPECT_EQ(worst.read, 144u + 2 * 8);
    EXPECT_EQ(worst.write, 80u);
    const auto frame = test::worst_case_bytes("opacity_map:bounds=frame");
    EXPECT_EQ(frame.read, 144u - 8);
    EXPECT_EQ(frame.write, 80u - 8);
    EXPECT_EQ(TestFrame::make("opacity_map", test::header_of(1, 1))->declaration().passes.size(), 3u);
    EXPECT_EQ(TestFrame::make("opacity_map:bounds=frame", test::header_of(1, 1))->declaration().passes.size(),
              2u);
}

// Counted by hand: fragments at positions 0, 4.5 and 16 of 16 add to 16, 12 and 0 planes, or to slabs 0 and
// 4. Look-ups read plane 0; planes 3 and 4; plane 15; or slab 0, slabs 0 to 4, slabs 0 to 15. Bounds are
// widened twice, read nine times; the accumulator is read and written thrice.
TEST(OpacityMap, BytesTouched) {
    const std::vector<std::array<float, 2>> layers = {{0.25f, 0.5f}, {0.5f, 0.5f}, {0.3203125f, 0.5f}};
    for (const bool slabs : {false, true}) {
        TestFrame frame(slabs ? "opacity_map:sums=slab" : "opacity_map", test::header_of(1, 1));
        frame.draw(test::white_fragments(layers));
        const OperationLog& log = frame.log();
        EXPECT_EQ(log.read_elements(0), 9u);
        EXPECT_EQ(log.write_elements(0), 2u);
        EXPECT_EQ(log.write_elements(1), slabs ? 2u : 16u + 12);
        EXPECT_EQ(log.read_elements(1), slabs ? 2u + 1 + 5 + 16 : 16u + 12 + 1 + 2 + 1);
        EXPECT_EQ(log.read_elements(2), 3u);
        EXPECT_EQ(log.write_elements(2), 3u);
    }
}

// Section 4.1: a list is walked three times where bounds are the pixel's, twice where they are the frame's,
// which with 4 bytes of head and 16 written is the model of 44 bytes for variable memory.
TEST(OpacityMap, VariableMemoryWalksTheListAgain) {
    for (const int traversals : {2, 3}) {
        TestFrame frame(
            traversals == 3 ? "opacity_map:memory=variable" : "opacity_map:memory=variable,bounds=frame",
            test::header_of(1, 1));
        for (int i = 0; i < 7; ++i)
            frame.draw_one(test::fragment_at(0, 0, 0.1f * static_cast<float>(i), 0.5f, {1, 1, 1}));
        EXPECT_EQ(frame.log().read_elements(0) * 4 + frame.log().write_elements(0) * 4 +
                      frame.log().write_elements(1) * 12,
                  7u * 20);
        frame.image();
        EXPECT_EQ(frame.log().read_elements(1) * 12, 7u * 12 * static_cast<unsigned>(traversals));
    }
}

// Sums of n terms in any two orders differ by at most 2 (n - 1) u times the sum of magnitudes, u = 2^-24, and
// e^-x moves by at most x e^-x <= 1/e of that relative change.
TEST(OpacityMap, AnyOrderUpToRounding) {
    auto scene = test::map_scene(23);
    const auto first = test::drawn_image("opacity_map:format=float32", scene);
    std::map<int, std::pair<int, double>> pixels;  // fragments and their colour, the brightest channel
    for (const Fragment& f : scene.fragments) {
        auto& [count, color] = pixels[f.y * scene.header.width + f.x];
        ++count;
        color += std::max({f.r, f.g, f.b});
    }
    Random random(24);
    for (int round = 0; round < 5; ++round) {
        random.shuffle(scene.fragments);
        const auto image = test::drawn_image("opacity_map:format=float32", scene);
        for (std::size_t i = 0; i < image.size(); ++i) {
            const auto& [count, color] = pixels[static_cast<int>(i / 3)];
            // Map; a rounding or two each of logarithm, look-up, exponential; sum; transmittance.
            const double bound =
                0x1p-24 * (2 * count * color / std::exp(1) + 8 * color + 2 * count * color + 4 * count);
            ASSERT_NEAR(image[i], first[i], bound);
        }
    }
}

// Thin layers whose planes stand between them: the nearest and the furthest of a pixel are exact whatever the
// number of slices, so that two layers are, opaque ones too (but for the floor under transmittance).
TEST(OpacityMap, TwoLayersAreExact) {
    for (const char* parameters : {"slices=1", "slices=16,lookup=step", "slices=3,sums=slab"}) {
        const std::string technique = "opacity_map:format=float32," + std::string(parameters);
        const std::vector<std::array<float, 2>> layers = {{0.75f, 0.5f}, {0.25f, 0.9f}};
        EXPECT_NEAR(test::white_image(technique, layers), 0.9 + 0.1 * 0.5, 1e-6) << parameters;
        const std::vector<std::array<float, 2>> opaque = {{0.25f, 1.0f}, {0.75f, 1.0f}};
        EXPECT_NEAR(test::white_image(technique, opaque), 1 + test::kLeastTransmittance, 1e-6) << parameters;
    }
}

// Banding, as numbers. Within a slab fragments do not dim each other under `step`: n of alpha a make n a.
// Under `linear` the one in the middle of a slab dims itself by the root of its own transmittance. Scaled to
// the total alpha both are exact for equal colours.
TEST(OpacityMap, FragmentsBetweenTwoPlanes) {
    const float a = 0.5f;
    // Planes at 1/4, 1/2 ...: the ends, and three between the first two planes.
    const std::vector<std::array<float, 2>> step = {{0, 0}, {0.05f, a}, {0.125f, a}, {0.2f, a}, {1, 0}};
    const std::string setup = "opacity_map:format=float32,slices=4";
    EXPECT_NEAR(test::white_image(setup + ",lookup=step", step), 3 * a, 1e-6) << "brighter than white";
    const std::vector<std::array<float, 2>> middle = {{0, 0}, {0.125f, a}, {1, 0}};
    EXPECT_NEAR(test::white_image(setup, middle), a * std::sqrt(1 - a), 1e-6) << "dims itself";
    EXPECT_NEAR(test::white_image(setup + ",lookup=step,composite=normalised", step), 0.875, 1e-5);
    EXPECT_NEAR(test::white_image(setup + ",composite=normalised", middle), a, 1e-5);
    // An opaque layer that dims itself is black.
    const std::vector<std::array<float, 2>> opaque = {{0, 0}, {0.125f, 1}, {1, 0}};
    EXPECT_NEAR(test::white_image(setup, opaque), std::sqrt(test::kLeastTransmittance), 1e-5);
    EXPECT_NEAR(test::white_image(setup + ",composite=normalised", opaque), 1, 1e-5);
}

// Bounds without extent: everything stands at the nearest plane, nothing dims anything.
TEST(OpacityMap, CoplanarFragmentsAndASingleOne) {
    for (const char* memory : {"fixed", "variable"}) {
        const std::string technique = "opacity_map:format=float32,memory=" + std::string(memory);
        const std::vector<std::array<float, 2>> pair = {{0.5f, 0.5f}, {0.5f, 0.5f}};
        EXPECT_EQ(test::white_image(technique, pair), 1.0f) << "0.75 is exact";
        EXPECT_EQ(test::white_image(technique, std::span(pair).first(1)), 0.5f);
        // Extents as small as floats have them.
        for (const float tiny : {0x1p-149f, 0x1p-126f}) {
            const std::vector<std::array<float, 2>> close = {{tiny, 0.5f}, {0.0f, 0.5f}};
            EXPECT_NEAR(test::white_image(technique, close), 0.75, 1e-6) << tiny;
        }
        TestFrame empty(technique, test::header_of(1, 1));
        EXPECT_EQ(test::visibility_at(empty, std::array{0.0f, 0.5f, 1.0f}), (std::vector<float>{1, 1, 1}));
    }
}

// Alphas below 2^-12: the product of 1 - alpha in binary16 never leaves 1, while their colour adds up, to
// 0.095 of these; UNORM16 and float32 follow it.
TEST(OpacityMap, ThinLayersDoNotDimTheBackgroundInBinary16) {
    const std::vector<Fragment> thin(1000, test::fragment_at(0, 0, 0.5f, 1e-4f, {0, 0, 0}));
    const double exact = std::pow(1 - 1e-4, 1000);
    const auto background_left = [&](const std::string& parameters) {
        TestFrame frame("opacity_map:" + parameters, test::header_of(1, 1, 1, {1, 1, 1}));
        frame.draw(thin);
        return frame.color()[0];
    };
    EXPECT_EQ(background_left("composite=plain"), 1.0f);
    EXPECT_NEAR(background_left("color_format=float32"), exact, 1e-3);
    // Each step is rounded to a multiple of 1 / 65535: 6 or 7 of them, not 6.55 on the way down.
    EXPECT_NEAR(background_left("composite=normalised"), exact, 1000 * 0.5 / 65535);
}

TEST(OpacityMap, RefusesWhatItCannotDo) {
    for (const char* bad :
         {"opacity_map:spacing=growing", "opacity_map:memory=variable,sums=slab",
          "opacity_map:planes=deep,bounds=frame", "opacity_map:depth_range=0.1", "opacity_map:slices=65"})
        EXPECT_THROW(TestFrame::make(bad, test::header_of(1, 1)), UserError) << bad;
    EXPECT_THROW(TestFrame::make("opacity_map", test::header_of(1, 1, 8)), UserError) << "16 x 8 slices";
    EXPECT_NO_THROW(TestFrame::make("opacity_map:slices=8", test::header_of(1, 1, 8)));
    EXPECT_THROW(TestFrame::make("opacity_map:memory=variable", test::header_of(1, 1, 16)), UserError);
}

}  // namespace
}  // namespace ropsim
