// Occupancy maps as transparency, against a reimplementation in double precision, and where their assumption
// of one alpha holds and fails.
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

struct Map {
    int bits = 128;
    bool by_slab = false;
    enum Alpha { kMean, kGeometric, kConstant } alpha = kMean;
    bool frame = false;
};

double visibility(const Map& map, const Layers& layers, double z) {
    const auto slab_of = [&](double depth) {
        const double share = map.frame ? depth : test::share_of(layers, depth);
        return std::min(static_cast<int>(share * map.bits), map.bits - 1);
    };
    const int words = map.by_slab ? map.bits / 32 : 1;
    const int word_bits = map.bits / words;
    double in_front = 0;
    for (int w = 0; w < words; ++w) {
        std::vector<bool> set(static_cast<std::size_t>(map.bits));
        int count = 0;
        for (const MapLayer& l : layers) {
            const int slab = slab_of(l.z);
            if (slab / word_bits != w) continue;
            set[static_cast<std::size_t>(slab)] = true;
            ++count;
        }
        const auto before = std::count(set.begin(), set.begin() + slab_of(z), true);
        const auto all = std::count(set.begin(), set.end(), true);
        if (all > 0) in_front += static_cast<double>(before) / static_cast<double>(all) * count;
    }
    double sum = 0;
    double absorbed = 0;
    for (const MapLayer& l : layers) {
        sum += l.a;
        absorbed += absorbance(l.a);
    }
    const auto n = static_cast<double>(layers.size());
    const double one = map.alpha == Map::kMean        ? absorbance(sum / n)
                       : map.alpha == Map::kGeometric ? absorbed / n
                                                      : absorbance(0.3f);
    return std::exp(-in_front * one);
}

struct MapCase {
    const char* parameters;
    Map map;
    bool normalised = true;
};
constexpr std::array kCases = {
    MapCase{"", {}},
    MapCase{"bits=32,composite=plain", {32}, false},
    MapCase{"bits=96,counts=slab,alpha=geometric", {96, true, Map::kGeometric}},
    MapCase{"counts=slab", {128, true}},
    MapCase{"bits=64,alpha=constant,bounds=frame", {64, false, Map::kConstant, true}},
};

TEST(OccupancyMap, EqualsItsDefinition) {
    for (const int samples : {1, 4})
        for (const MapCase& setup : kCases) {
            const auto scene = test::map_scene(41, samples);
            const auto expected = test::composited_by(
                scene.header, scene.fragments, scene.slopes,
                [&](const Layers& layers, double z) { return visibility(setup.map, layers, z); },
                setup.normalised);
            const auto image =
                test::drawn_image("occupancy_map:format=float32," + std::string(setup.parameters), scene);
            EXPECT_LT(test::worst_difference(image, expected), 5e-6) << setup.parameters << " " << samples;
            if (samples > 1) continue;
            TestFrame frame("occupancy_map:format=float32," + std::string(setup.parameters), scene.header);
            frame.draw(scene.fragments);
            const auto layers = test::layers_of(scene.header, scene.fragments, {}, 0, 0, 0);
            std::vector<float> depths;
            for (int i = 0; i <= 100; ++i) depths.push_back(static_cast<float>(i) / 100);
            const auto values = test::visibility_at(frame, depths);
            for (std::size_t i = 0; i < depths.size(); ++i)
                ASSERT_NEAR(values[i], visibility(setup.map, layers, depths[i]), 1e-5) << depths[i];
        }
}

// Hair, as the technique has it: fragments of one alpha, no two in a slab. Their image is exact, in any
// order, whatever the alpha is taken from.
TEST(OccupancyMap, ExactForOneAlphaAndASlabEach) {
    Random random(42);
    for (const char* parameters :
         {"alpha=mean", "alpha=geometric", "alpha=constant,constant_alpha=0.25", "counts=slab",
          "composite=plain", "alpha=constant,constant_alpha=0.25,bounds=frame"}) {
        std::vector<Fragment> fragments;
        for (int slab = 0; slab < 128; slab += 3) {
            const float color = random.real(0, 1);
            fragments.push_back(test::fragment_at(0, 0, (static_cast<float>(slab) + 0.5f) / 128, 0.25f,
                                                  {color, 1 - color, 0.5f}));
        }
        // Over the pixel's bounds slabs end elsewhere; these are as many and as far apart.
        random.shuffle(fragments);
        TestFrame frame("occupancy_map:format=float32," + std::string(parameters), test::header_of(1, 1));
        frame.draw(fragments);
        EXPECT_LT(test::worst_error(frame, fragments), 1e-5) << parameters;
    }
}

// Where alphas differ it cannot know which fragment is in front: behind a pane of 0.1 and in front of a wall
// of 0.9, in either order, the second is seen through the mean, 0.5. Closed forms of the weights.
TEST(OccupancyMap, MixedAlphasAreWrong) {
    const auto red_of = [](float first, float second) {
        TestFrame frame("occupancy_map:format=float32,composite=plain", test::header_of(1, 1, 1, {0, 0, 0}));
        frame.draw(std::array{test::fragment_at(0, 0, 0.25f, first, {0, 1, 0}),
                              test::fragment_at(0, 0, 0.75f, second, {1, 0, 0})});
        return frame.color()[0];
    };
    EXPECT_NEAR(red_of(0.9f, 0.1f), 0.1 * 0.5, 1e-6) << "0.01 is exact";
    EXPECT_NEAR(red_of(0.1f, 0.9f), 0.9 * 0.5, 1e-6) << "0.81 is exact";
    EXPECT_NEAR(red_of(1.0f, 0.5f), 0.5 * 0.25, 1e-6) << "hidden";
}

// Several fragments in a slab: the bits in front are scaled by fragments over bits. Two slabs of 1 and 3
// fragments count as 2 and 2; a slab map does not change that within a word, but does across words.
TEST(OccupancyMap, CountsOfSharedSlabs) {
    const std::vector<std::array<float, 2>> layers = {{0.0f, 0.5f}, {1.0f, 0.5f}, {1.0f, 0.5f}, {1.0f, 0.5f}};
    const std::vector<float> furthest = {1.0f};
    for (const auto& [parameters, in_front] : {std::pair("counts=pixel", 2.0), std::pair("counts=slab", 1.0),
                                               std::pair("counts=slab,bits=32", 2.0)}) {
        TestFrame frame("occupancy_map:format=float32," + std::string(parameters), test::header_of(1, 1));
        frame.draw(test::white_fragments(layers));
        EXPECT_NEAR(test::visibility_at(frame, furthest)[0], std::pow(0.5, in_front), 1e-6) << parameters;
    }
}

// Scaled to the total alpha, the background shows by the exact total transmittance and equal colours come out
// exact whatever visibility says; geometric alphas have the product of all fragments right by themselves.
TEST(OccupancyMap, TotalAlphaIsExact) {
    Random random(43);
    std::vector<Fragment> fragments;
    double t = 1;
    for (int i = 0; i < 20; ++i) {
        fragments.push_back(test::fragment_at(0, 0, random.real(0, 1), random.real(0, 0.3), {1, 0, 1}));
        t *= 1.0 - fragments.back().a;
    }
    for (const char* parameters : {"", "bits=32,alpha=constant,constant_alpha=0.9"}) {
        TestFrame frame("occupancy_map:format=float32," + std::string(parameters),
                        test::header_of(1, 1, 1, {0, 1, 0}));
        frame.draw(fragments);
        EXPECT_NEAR(frame.color()[0], 1 - t, 1e-5) << parameters;
        EXPECT_NEAR(frame.color()[1], t, 1e-5) << parameters;
    }
}

// 128 bits, a count, a sum and two bounds; a slab map has a count a word. Every pass but the first reads all
// that it needs to know where it is: 8 + (8 + 16 + 2 + 4) + (8 + 22 + 8 + 2) bytes, of which only one word is
// written, though any.
TEST(OccupancyMap, Bytes) {
    EXPECT_EQ(test::storage_bits("occupancy_map:composite=plain"), 64 + 128 + 16 + 32 + 64);
    EXPECT_EQ(test::storage_bits("occupancy_map"), 64 + 128 + 16 + 32 + 64 + 16);
    EXPECT_EQ(test::storage_bits("occupancy_map:counts=slab,alpha=constant"), 64 + 128 + 64 + 64 + 16);
    const auto worst = test::worst_case_bytes("occupancy_map");
    EXPECT_EQ(worst.read, 8u + 30 + 40);
    EXPECT_EQ(worst.write, 8u + 16 + 2 + 4 + 10);
    TestFrame frame("occupancy_map", test::header_of(1, 1));
    for (int i = 0; i < 5; ++i)
        frame.draw_pass(0, std::array{test::fragment_at(0, 0, 0.5f, 0.5f, {1, 1, 1})});
    for (int i = 0; i < 5; ++i)
        frame.draw_pass(1, std::array{test::fragment_at(0, 0, 0.5f, 0.5f, {1, 1, 1})});
    EXPECT_EQ(frame.log().write_elements(1), 1u) << "a bit that is set is not written again";
    EXPECT_EQ(frame.log().write_elements(2), 5u);
}

// Bits, counts and bounds are the same in any order. The sum of n alphas moves by at most 2 (n - 1) u of
// itself, so the mean m does; visibility e^(-k A), A = -ln(1 - m), moves by k e^(-k A) m / (1 - m) of that,
// at most m / ((1 - m) e A).
TEST(OccupancyMap, AnyOrderUpToRounding) {
    const std::string technique = "occupancy_map:format=float32,composite=plain";
    auto scene = test::map_scene(44);
    const auto first = test::drawn_image(technique, scene);
    struct Pixel {
        int count = 0;
        double color = 0, alpha = 0;
    };
    std::map<int, Pixel> pixels;
    for (const Fragment& f : scene.fragments) {
        Pixel& p = pixels[f.y * scene.header.width + f.x];
        ++p.count;
        p.color += std::max({f.r, f.g, f.b});
        p.alpha += f.a;
    }
    Random random(45);
    for (int round = 0; round < 5; ++round) {
        random.shuffle(scene.fragments);
        const auto image = test::drawn_image(technique, scene);
        for (std::size_t i = 0; i < image.size(); ++i) {
            const Pixel& p = pixels[static_cast<int>(i / 3)];
            const double mean = p.alpha / p.count;
            const double steepness = mean / ((1 - mean) * std::exp(1) * absorbance(mean));
            const double bound =
                0x1p-24 * ((2 * p.count * steepness + 8) * p.color + 2 * p.count * p.color + 4 * p.count);
            ASSERT_NEAR(image[i], first[i], bound);
        }
    }
}

TEST(OccupancyMap, CountsStopAtTheirLargest) {
    TestFrame frame("occupancy_map", test::header_of(1, 1), 0, 1 << 20, false);
    const std::vector<Fragment> many(70000, test::fragment_at(0, 0, 0.5f, 0.001f, {1, 1, 1}));
    frame.draw(many);
    EXPECT_EQ(test::stored_bits(frame, "counts", 0), 0xFFFFu);
    EXPECT_TRUE(std::isfinite(frame.color()[0]));
}

TEST(OccupancyMap, RefusesPartsOfWords) {
    EXPECT_THROW(TestFrame::make("occupancy_map:bits=100", test::header_of(1, 1)), UserError);
    EXPECT_THROW(TestFrame::make("occupancy_map:constant_alpha=0.5", test::header_of(1, 1)), UserError);
}

}  // namespace
}  // namespace ropsim
