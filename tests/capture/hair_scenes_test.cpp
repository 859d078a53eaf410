// The scenes of hair and fur: the papers' counts, hair where it belongs, grass before and behind the scarf.
#include "capture/opaque_pass.h"
#include "capture/scene_fit.h"
#include "capture/scene_list.h"
#include "capture/scenes/dog_body.h"
#include "capture/scenes/hair_head.h"
#include "capture/scenes/hair_strands.h"
#include "tests/capture/test_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gmock/gmock.h>

namespace ropsim {
namespace {

std::unique_ptr<SceneSource> source_of(const std::string& name, double aspect) {
    for (const SceneInfo& info : scene_list())
        if (info.name == name) return info.make(aspect, 1);
    ADD_FAILURE() << name << " is not a scene";
    return nullptr;
}

const SceneInfo& info_of(const std::string& name) {
    const auto& list = scene_list();
    return *std::find_if(list.begin(), list.end(), [&](const SceneInfo& info) { return info.name == name; });
}

const std::vector<float>& buffer_of(const SceneDraw& draw, std::uint32_t binding) {
    return std::find_if(draw.buffers.begin(), draw.buffers.end(),
                        [&](const SceneBuffer& buffer) { return buffer.binding == binding; })
        ->values;
}

// Strands have one vec4 of looks each.
std::size_t strands_in(const SceneDraw& draw) {
    return buffer_of(draw, 2).size() / 4;
}

class HairScenesTest : public testing::OpenGlTest {};

// Salvi et al. 2011, table 1: 15.0 million fragments, 663 in the deepest pixel.
TEST_F(HairScenesTest, PublishedHairHasTheFragmentsAndTheDepthOfTheTable) {
    const GlContext context;
    const Scene scene = source_of("hair", 1280.0 / 720)->build({});
    const LayerCounts counts = count_layers(scene, 1280, 720);
    EXPECT_NEAR(static_cast<double>(counts.fragments), 15.0e6, 0.01 * 15.0e6);
    EXPECT_NEAR(static_cast<double>(counts.deepest), 663, 0.03 * 663);
    const std::vector<float>& looks = buffer_of(scene.transparent[0], 2);
    for (std::size_t i = 3; i < looks.size(); i += 4) {
        EXPECT_GE(looks[i], 0.1f);
        EXPECT_LE(looks[i], 0.4f);
    }
}

// Enderton et al. 2011, figure 7: a dog with 300K hairs.
TEST(HairScenesCountTest, PublishedDogHasThreeHundredThousandHairs) {
    const Scene scene = source_of("dog", 1.0)->build({});
    std::size_t hairs = 0;
    for (const SceneDraw& draw : scene.transparent) {
        hairs += strands_in(draw);
        const std::size_t segments = buffer_of(draw, 1).size() / 4 - strands_in(draw);
        EXPECT_EQ(draw.primitives, 2 * segments) << draw.state.name;
    }
    EXPECT_EQ(hairs, 300000u);
    EXPECT_EQ(info_of("dog").published.primitives, 300000u);
    EXPECT_THAT(scene.description, ::testing::HasSubstr("300000 hairs"));
}

// The same, figure 1: 15,000 hairs, 6,000 cards, transparent cloth.
TEST(HairScenesCountTest, PublishedWindyHillHasItsHairsCardsAndCloth) {
    const Scene scene = source_of("windy_hill", 1.0)->build({});
    std::size_t hairs = 0;
    std::size_t cards = 0;
    std::size_t cloths = 0;
    for (const SceneDraw& draw : scene.transparent) {
        if (draw.state.name == "hair") hairs += strands_in(draw);
        if (draw.state.name == "grass" || draw.state.name == "leaves") {
            EXPECT_EQ(draw.primitives % 6, 0u);
            cards += draw.primitives / 6;
        }
        cloths += draw.state.name == "scarf";
    }
    EXPECT_EQ(hairs, 15000u);
    EXPECT_EQ(cards, 6000u);
    EXPECT_GE(cloths, 1u);
    EXPECT_GE(scene.opaque.size(), 3u);
    EXPECT_EQ(info_of("windy_hill").published.primitives, 15000u);
}

TEST_F(HairScenesTest, GrassIsBehindAndInFrontOfTheScarf) {
    const GlContext context;
    const Scene scene = source_of("windy_hill", 1.0)->build({});
    constexpr int kSide = 200;
    const std::vector<Fragment> all = testing::capture_all(scene, kSide, kSide);
    constexpr float kNone = std::numeric_limits<float>::infinity();
    std::vector<float> nearest(kSide * kSide, kNone);
    std::vector<float> farthest(kSide * kSide, -kNone);
    const auto is = [&](const Fragment& f, const char* name) {
        return scene.transparent[f.draw].state.name == name;
    };
    for (const Fragment& f : all) {
        EXPECT_GT(f.a, 0);
        if (!is(f, "scarf")) continue;
        float& near = nearest[static_cast<std::size_t>(f.y * kSide + f.x)];
        float& far = farthest[static_cast<std::size_t>(f.y * kSide + f.x)];
        near = std::min(near, f.z);
        far = std::max(far, f.z);
    }
    int before = 0;
    int behind = 0;
    for (const Fragment& f : all) {
        if (!is(f, "grass")) continue;
        before += f.z < nearest[static_cast<std::size_t>(f.y * kSide + f.x)] &&
                  nearest[static_cast<std::size_t>(f.y * kSide + f.x)] < kNone;
        behind += f.z > farthest[static_cast<std::size_t>(f.y * kSide + f.x)] &&
                  farthest[static_cast<std::size_t>(f.y * kSide + f.x)] > -kNone;
    }
    EXPECT_GT(before, 300);
    EXPECT_GT(behind, 300);
}

TEST_F(HairScenesTest, FurAndHillFollowTheRequestedFragments) {
    const GlContext context;
    for (const auto& [name, wanted] :
         {std::pair("dog", 40000u), std::pair("windy_hill", 20000u), std::pair("windy_hill", 700000u)}) {
        const std::unique_ptr<SceneSource> source = source_of(name, 1.0);
        const SceneScale scale = fit_scene(*source, 160, 160, 1, wanted);
        const LayerCounts counts = count_layers(source->build(scale), 160, 160);
        EXPECT_NEAR(static_cast<double>(counts.fragments) / wanted, 1, 0.03) << name;
        EXPECT_THROW(source->build({1e4, 1}), UserError) << name;
    }
}

// Root on the skin, tip outside of it, for nearly every hair; no hair is longer than a hand.
TEST(DogTest, FurGrowsOutOfTheSkin) {
    const Scene scene = source_of("dog", 1.0)->build({.count = 0.02});
    const BlobBody body = dog_body();
    std::size_t hairs = 0;
    std::size_t outward = 0;
    for (const SceneDraw& draw : scene.transparent) {
        const std::vector<float>& points = buffer_of(draw, 1);
        const std::size_t stride = points.size() / strands_in(draw);
        for (std::size_t at = 0; at < points.size(); at += stride) {
            const glm::vec3 root(points[at], points[at + 1], points[at + 2]);
            const std::size_t end = at + stride - 4;
            const glm::vec3 tip(points[end], points[end + 1], points[end + 2]);
            EXPECT_LT(std::fabs(body.distance(root)), 0.04f);
            EXPECT_LT(glm::distance(root, tip), 2.0f);
            outward += body.distance(tip) > -0.02f;
            ++hairs;
        }
    }
    EXPECT_GT(static_cast<double>(outward), 0.97 * static_cast<double>(hairs));
}

TEST(HairStrandsTest, LieOutsideTheBustAndDoNotDependOnTheirNumber) {
    const HairStrands few = grow_hair(500, 7);
    const HairStrands many = grow_hair(3000, 7);
    EXPECT_TRUE(std::equal(few.points.begin(), few.points.end(), many.points.begin()));
    EXPECT_TRUE(std::equal(few.locks.begin(), few.locks.end(), many.locks.begin()));
    EXPECT_NE(grow_hair(1, 8).points[31], few.points[31]);
    const BlobBody bust = bust_obstacle();
    std::size_t inside = 0;
    for (const glm::vec3& p : few.points) inside += bust.distance(p) < -0.06f;
    EXPECT_LT(inside, few.points.size() / 50);
}

TEST(HairStrandsTest, WindCarriesHairAlong) {
    HairStyle style;
    style.sweep = 0;
    style.weight = 1;
    style.wind = {5, 0, 0};
    const HairStrands calm = grow_hair(400, 3);
    const HairStrands windy = grow_hair(400, 3, style);
    const auto mean_tip = [](const HairStrands& hair) {
        glm::vec3 sum(0);
        for (std::size_t i = kStrandPoints - 1; i < hair.points.size(); i += kStrandPoints)
            sum += hair.points[i];
        return sum / 400.0f;
    };
    EXPECT_GT(mean_tip(windy).x, mean_tip(calm).x + 1.5f);
    EXPECT_GT(mean_tip(windy).y, mean_tip(calm).y + 1.0f);
}

}  // namespace
}  // namespace ropsim
