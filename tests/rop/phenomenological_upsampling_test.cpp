// Draws of phenomenological transparency that are not simply drawn: at a lower resolution, as an aggregate of
// layers, in registers. McGuire and Mara 2017, sections 5.0.1, 7.2 and 7.3.
#include "tests/rop/phenomenological_scene.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::fill;
using test::kTargetWords;
using test::Random;
using test::Targets;
using test::TestFrame;
using test::word;

constexpr std::size_t kLowDepth = 2 * kTargetWords;

// A frame whose draw 0 is of low resolution, over an opaque layer of those depths.
struct LowFrame {
    int scale;
    TestFrame frame;

    LowFrame(const std::string& keys, int by, TraceHeader header)
        : scale(by),
          frame("phenomenological:format=float32,low_draws=fog,low_resolution=" + std::to_string(by) + keys,
                named(std::move(header))) {
        EXPECT_EQ(frame.declaration().passes.size(), 3u);
        EXPECT_EQ(frame.declaration().pixel_words, static_cast<int>(kLowDepth) + 1);
    }
    static TraceHeader named(TraceHeader header) {
        header.draws.resize(1);
        header.draws[0].name = "fog";
        return header;
    }
    int width() const { return low_resolution(frame.header().width, scale); }
    int height() const { return low_resolution(frame.header().height, scale); }
    void set_low(int x, int y, const Targets& t) { fill(frame, x, y, t, kTargetWords); }
    void upsample() { frame.image_pass(2); }
    float low(int x, int y, std::size_t i) { return word(frame, x, y, kTargetWords + i); }
};

TraceHeader with_depths(int width, int height, Random& random) {
    TraceHeader header = test::random_picture(width, height, random);
    for (float& d : header.opaque->depth)
        d = random.integer(0, 4) == 0 ? std::numeric_limits<float>::infinity()
                                      : test::depth_at(*header.camera, random.real(1, 1.3));
    return header;
}
Targets any_targets(Random& random) {
    Targets t;
    for (std::size_t c = 0; c < 3; ++c) {
        t.color[c] = random.real(0, 4);
        t.beta[c] = random.real(0, 1);
    }
    t.net = random.real(0, 4);
    t.diffusion = random.real(0.01, 1);
    t.x = random.real(-1, 1);
    t.y = random.real(-1, 1);
    return t;
}

class PhenomenologicalUpsampling : public testing::TestWithParam<std::tuple<int, std::string>> {
 protected:
    static int scale() { return std::get<0>(GetParam()); }
    static std::string keys() { return ",upsample=" + std::get<1>(GetParam()); }
    static bool bilinear() { return std::get<1>(GetParam()) == "bilinear"; }
};
INSTANTIATE_TEST_SUITE_P(Kernels, PhenomenologicalUpsampling,
                         testing::Combine(testing::Values(2, 4),
                                          testing::Values(std::string("tent7"), std::string("bilinear"))),
                         [](const auto& test) {
                             return std::get<1>(test.param) + "_" + std::to_string(std::get<0>(test.param));
                         });

// The low surface keeps the opaque depth at its own pixel's sample of the image.
TEST_P(PhenomenologicalUpsampling, KeepsTheDepthAtItsSamples) {
    Random random(20);
    LowFrame low(keys(), scale(), with_depths(13, 11, random));
    for (int y = 0; y < low.height(); ++y)
        for (int x = 0; x < low.width(); ++x)
            EXPECT_EQ(
                word(low.frame, x, y, kLowDepth),
                test::opaque_depth(low.frame.header(), x * scale() + scale() / 2, y * scale() + scale() / 2));
}

TEST_P(PhenomenologicalUpsampling, LeavesConstantContentsAsTheyAre) {
    Random random(21);
    LowFrame low(keys(), scale(), with_depths(19, 14, random));
    const Targets t = any_targets(random);
    for (int y = 0; y < low.height(); ++y)
        for (int x = 0; x < low.width(); ++x) low.set_low(x, y, t);
    low.upsample();
    for (int y = 0; y < 14; ++y)
        for (int x = 0; x < 19; ++x)
            for (std::size_t i = 0; i < kTargetWords; ++i)
                ASSERT_NEAR(word(low.frame, x, y, i), low.low(0, 0, i), 5e-6) << x << "," << y << " " << i;
}

// A tent over low pixels times .01 / (.01 + metres between), the border repeated.
TEST_P(PhenomenologicalUpsampling, IsJointBilateral) {
    Random random(22);
    const auto deep = with_depths(21, 18, random);
    LowFrame low(keys(), scale(), deep);
    for (int y = 0; y < low.height(); ++y)
        for (int x = 0; x < low.width(); ++x) low.set_low(x, y, any_targets(random));
    low.upsample();
    const glm::dmat4 p(deep.camera->projection);
    const auto metres = [&](float depth) {
        return p[3][2] / (-(2 * std::min(double{depth}, 1.0) - 1) - p[2][2]) * -1;
    };
    const double half_width = bilinear() ? 1 : 4;  // of the tent, in low pixels
    const int reach = bilinear() ? 1 : 3;
    const int centre = scale() / 2;
    for (int y = 0; y < 18; ++y) {
        for (int x = 0; x < 21; ++x) {
            const double u = (x - centre) / double(scale()), v = (y - centre) / double(scale());
            const double own = metres(test::opaque_depth(deep, x, y));
            const int nearest_u = static_cast<int>(std::floor(u + 0.5));
            const int nearest_v = static_cast<int>(std::floor(v + 0.5));
            std::array<double, kTargetWords> sum{};
            double weights = 0;
            for (int j = nearest_v - reach; j <= nearest_v + reach; ++j) {
                for (int i = nearest_u - reach; i <= nearest_u + reach; ++i) {
                    const double tent = std::max(0.0, 1 - std::abs(i - u) / half_width) *
                                        std::max(0.0, 1 - std::abs(j - v) / half_width);
                    const int s = std::clamp(i, 0, low.width() - 1), t = std::clamp(j, 0, low.height() - 1);
                    const double there = metres(
                        test::opaque_depth(deep, s * scale() + scale() / 2, t * scale() + scale() / 2));
                    const double w = tent * 0.01 / (0.01 + std::abs(there - own));
                    for (std::size_t k = 0; k < kTargetWords; ++k) sum[k] += w * low.low(s, t, k);
                    weights += w;
                }
            }
            for (std::size_t k = 0; k < kTargetWords; ++k)
                ASSERT_NEAR(word(low.frame, x, y, k), sum[k] / weights, 1e-4) << x << "," << y << " " << k;
        }
    }
}

// A near half of the picture with one fog, a far one with another: what leaks is .01 metres of the distance
// between, times what the kernel weighs on the other side.
TEST_P(PhenomenologicalUpsampling, DepthEdgesStayClean) {
    TraceHeader header = test::pictured(32, 16, 0, [](int, int) { return std::array<float, 3>{}; });
    const float near = test::depth_at(*header.camera, 2), far = test::depth_at(*header.camera, 12);
    for (int i = 0; i < 32 * 16; ++i)
        header.opaque->depth[static_cast<std::size_t>(i)] = i % 32 < 16 ? near : far;
    LowFrame low(keys(), scale(), header);
    for (int y = 0; y < low.height(); ++y) {
        for (int x = 0; x < low.width(); ++x) {
            Targets t;
            t.net = x * scale() < 16 ? 1.0f : 0.0f;
            low.set_low(x, y, t);
        }
    }
    low.upsample();
    double most = 0;
    for (int x = 0; x < 32; ++x) {
        const double leaked = x < 16 ? 1 - word(low.frame, x, 8, 3) : word(low.frame, x, 8, 3);
        // The other side weighs at most seven times as much (the bilinear one, 3 : 1 of a quarter, 7 : 1).
        EXPECT_LT(leaked, 7 * 0.01 / 10) << x;
        EXPECT_GE(leaked, 0) << x;
        most = std::max(most, leaked);
    }
    EXPECT_GT(most, 0) << "no kernel reaches over the edge";
}

// With a far plane at infinity, as the paper's weight supposes, what is behind everything is nowhere.
TEST_P(PhenomenologicalUpsampling, AnInfiniteFarPlaneIsOneMoreDepth) {
    Random random(23);
    TraceHeader header = test::random_picture(16, 16, random);
    header.camera->projection = glm::infinitePerspective(glm::radians(60.0f), 1.0f, 0.125f);
    for (std::size_t i = 0; i < 256; ++i)  // a pole between the samples, the sky around it
        header.opaque->depth[i] = i % 16 == 5 ? 0.9f : std::numeric_limits<float>::infinity();
    LowFrame low(keys(), scale(), header);
    Targets t;
    t.net = 2;
    for (int y = 0; y < low.height(); ++y)
        for (int x = 0; x < low.width(); ++x) low.set_low(x, y, t);
    low.upsample();
    for (int x = 0; x < 16; ++x) EXPECT_NEAR(word(low.frame, x, 8, 3), 2, 1e-5) << x;
}

// One or two pixels have no sample at a quarter of the resolution: nothing of such draws is seen.
TEST(PhenomenologicalLowResolution, OfAnImageWithoutASampleShowsTheBackground) {
    for (const int size : {1, 2}) {
        LowFrame low("", 4, test::with_materials(test::header_of(size, size)));
        low.upsample();
        const auto image = low.frame.image();
        for (std::size_t i = 0; i < image.size(); i += 3) {
            EXPECT_FLOAT_EQ(image[i], 0.25f);
            EXPECT_FLOAT_EQ(image[i + 1], 0.5f);
        }
    }
}

// A k-buffer's composite, laid over the background as one surface: without self-modulation what the k-buffer
// itself shows.
TEST(PhenomenologicalAggregate, IsTheKBuffersComposite) {
    Random random(24);
    TraceHeader header = test::with_materials(test::header_of(8, 8));
    header.draws.resize(1);
    header.draws[0].name = "hair";
    test::FragmentOptions options;
    options.count = 2000;  // some 30 layers a pixel
    options.distinct_depths = true;
    options.extremes = false;
    auto fragments = test::random_fragments(header, options, random);
    for (Fragment& f : fragments) f.draw = 0;
    for (const char* layers : {"1", "4", "16"}) {
        TestFrame buffer(std::string("k_buffer:format=float32,layers=") + layers, header);
        TestFrame hair(std::string("phenomenological:format=float32,self_modulation=off,aggregate_draws=hair,"
                                   "aggregate_layers=") +
                           layers,
                       header);
        buffer.draw(fragments);
        hair.draw_pass(0, fragments);
        hair.image_pass(1);
        const auto exact = buffer.image(), image = hair.image();
        for (std::size_t i = 0; i < image.size(); ++i) ASSERT_NEAR(image[i], exact[i], 1e-5) << layers;
        // Its weight is of the nearest layer's depth and of what all cover.
        const auto own = test::nearest_first(fragments, 3, 3);
        const float alpha = 1 - word(hair, 3, 3, 4);
        const double w = test::shader_of("", screen_of(header, 0)).weight(own.front().z, alpha);
        EXPECT_NEAR(word(hair, 3, 3, 3), w * alpha, 1e-5 * w);
    }
}

// A pane that covers its pixel and lets three quarters through is a layer of alpha 1/4.
TEST(PhenomenologicalAggregate, KnowsTheLeastAlpha) {
    const TraceHeader header = test::with_materials(test::header_of(1, 1));
    const auto image = [&](float alpha, float transmission) {
        TestFrame frame("phenomenological:format=float32,aggregate_draws=all", header);
        Fragment pane = test::fragment_at(0, 0, 0.5f, 1, {0.25f, 0.5f, 0.125f});
        pane.a = alpha;
        const std::vector<Material> materials{test::material_of({transmission, transmission, transmission})};
        frame.draw({&pane, 1}, {}, materials);
        return frame.color();
    };
    EXPECT_EQ(image(1, 0.75f), image(0.25f, 0));
    EXPECT_NE(image(1, 0.75f), image(1, 0));
}

TEST(PhenomenologicalDraws, ThatCannotBeBothAreRefused) {
    TraceHeader header = test::header_of(4, 4);
    header.draws.resize(1);
    header.draws[0].name = "hair";
    EXPECT_THROW(TestFrame::make("phenomenological:aggregate_draws=hair,register_draws=hair", header),
                 UserError);
    EXPECT_THROW(TestFrame::make("phenomenological:delta_format=unorm16", header), UserError);
    EXPECT_NO_THROW(TestFrame::make("phenomenological:delta_format=unorm16,offsets=split", header));
}

// Fragments of a run are exported once: the sums and the product of those blended one by one, at the bytes of
// one.
TEST(PhenomenologicalRegisters, HoldWhatIsBlendedSinglyForTheBytesOfOne) {
    Random random(25);
    TraceHeader header = test::random_picture(1, 1, random);
    header.draws.resize(1);
    header.draws[0].name = "fog";
    std::vector<Fragment> fragments;
    std::vector<Material> materials;
    for (std::uint32_t i = 0; i < 40; ++i) {
        fragments.push_back(test::fragment_at(0, 0, random.real(0.1, 0.7), random.real(0, 0.2),
                                              {random.real(0, 1), random.real(0, 1), 1}, i));
        materials.push_back(test::material_of({random.real(0, 1), random.real(0, 1), 0.5f},
                                              random.real(0.9, 1), random.real(1, 1.1)));
    }
    TestFrame singly("phenomenological:format=float32", header);
    TestFrame joined("phenomenological:format=float32,register_draws=fog", header);
    singly.draw_pass(0, fragments, 0, {}, materials);
    const std::uint32_t last = 39;
    joined.operation().run(0, 0, {fragments, {}, materials}, {&last, 1}, joined.store(), joined.log());
    for (std::size_t i = 0; i < kTargetWords; ++i) {
        const double one = word(singly, 0, 0, i);
        EXPECT_NEAR(word(joined, 0, 0, i), one, 2e-6 * std::abs(one) + 1e-9) << i;
    }
    for (std::size_t s = 0; s < 3; ++s) {
        EXPECT_EQ(joined.log().read_elements(s), 1u);
        EXPECT_EQ(joined.log().write_elements(s), 1u);
        EXPECT_EQ(singly.log().write_elements(s), 40u);
    }
    // A small D is raised once, not forty times: what is stored of it does not over-diffuse.
    TestFrame raised("phenomenological:register_draws=fog", header);
    TestFrame raised_often("phenomenological", header);
    for (Material& m : materials) m = test::material_of({0.9f, 0.9f, 0.9f}, 0.999f);
    raised.operation().run(0, 0, {fragments, {}, materials}, {&last, 1}, raised.store(), raised.log());
    raised_often.draw_pass(0, fragments, 0, {}, materials);
    EXPECT_NEAR(word(raised, 0, 0, 7), 1.0 / 255, 1e-7);
    EXPECT_NEAR(word(raised_often, 0, 0, 7), 40.0 / 255, 1e-6);
}

}  // namespace
}  // namespace ropsim
