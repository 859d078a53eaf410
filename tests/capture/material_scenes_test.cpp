// The scenes that record materials: what their fragments say about transmission, refraction and diffusion,
// and that equation 1 of McGuire and Mara 2017 is what the recorded pair of alpha and transmission means.
#include "capture/capture.h"
#include "capture/gl_context.h"
#include "capture/scenery/transmissive_draw.h"
#include "tests/capture/own_file.h"
#include "tests/capture/test_scene.h"
#include "traces/least_alpha.h"
#include "traces/trace.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <gmock/gmock.h>

namespace ropsim {
namespace {

// Bounds of what the fragments of a draw hold.
struct DrawFacts {
    std::uint64_t fragments = 0;
    float least[8] = {1e9f, 1e9f, 1e9f, 1e9f, 1e9f, 1e9f, 1e9f, 1e9f};  // a, tr, tg, tb, c, eta, |n|, n.eye
    float most[8] = {-1e9f, -1e9f, -1e9f, -1e9f, -1e9f, -1e9f, -1e9f, -1e9f};
    double highest_transmission = 0;  // mean over fragments of the clearest channel
};

struct SceneFacts {
    TraceHeader header;
    std::uint64_t fragments = 0;
    std::uint32_t deepest = 0;
    std::map<std::string, DrawFacts> draws;
};

// Unit vector from a fragment's place towards the eye, camera space.
glm::vec3 to_eye(const TraceHeader& header, const Fragment& f) {
    const glm::vec2 ndc(2 * (static_cast<float>(f.x) + 0.5f) / static_cast<float>(header.width) - 1,
                        1 - 2 * (static_cast<float>(f.y) + 0.5f) / static_cast<float>(header.height));
    const glm::mat4& p = header.camera->projection;
    return glm::normalize(-glm::vec3(ndc.x / p[0][0], ndc.y / p[1][1], -1));
}

void note(SceneFacts& facts, const Fragment& f, const Material& m) {
    DrawFacts& draw = facts.draws[facts.header.draws[f.draw].name];
    const glm::vec3 normal(m.normal[0], m.normal[1], m.normal[2]);
    const float values[8] = {f.a,
                             m.transmission[0],
                             m.transmission[1],
                             m.transmission[2],
                             m.collimation,
                             m.eta,
                             glm::length(normal),
                             glm::dot(normal, to_eye(facts.header, f))};
    for (int i = 0; i < 8; ++i) {
        draw.least[i] = std::min(draw.least[i], values[i]);
        draw.most[i] = std::max(draw.most[i], values[i]);
    }
    draw.highest_transmission += std::max({values[1], values[2], values[3]});
    ++draw.fragments;
}

class MaterialScenesTest : public testing::OpenGlTest {
 protected:
    SceneFacts capture(const std::string& scene, int width, int height) {
        CaptureOptions options;
        options.scene_or_file = scene;
        options.size = {width, height};
        const std::string path = test::own_file(scene + ".trace");
        capture_scene(options, path);
        TraceReader reader(path);
        SceneFacts facts;
        facts.header = reader.header();
        EXPECT_TRUE(facts.header.materials);
        std::vector<std::uint32_t> layers(static_cast<std::size_t>(width * height));
        FragmentChunk chunk;
        while (reader.next(chunk)) {
            for (std::size_t i = 0; i < chunk.size(); ++i) {
                const Fragment& f = chunk.fragments[i];
                note(facts, f, chunk.materials[i]);
                ++layers[static_cast<std::size_t>(f.y * width + f.x)];
            }
            facts.fragments += chunk.size();
        }
        facts.deepest = *std::max_element(layers.begin(), layers.end());
        return facts;
    }
};

void expect_physical(const SceneFacts& facts) {
    for (const auto& [name, draw] : facts.draws) {
        EXPECT_GT(draw.least[0], 0.0f) << name << ": alpha 0 is nothing to draw";
        EXPECT_LE(draw.most[0], 1.0f) << name;
        for (int channel = 1; channel <= 3; ++channel) {
            EXPECT_GE(draw.least[channel], 0.0f) << name;
            EXPECT_LE(draw.most[channel], 1.0f) << name;
        }
        EXPECT_NEAR(draw.least[6], 1.0f, 2e-3f) << name << ": unit normals, to a half's precision";
        EXPECT_NEAR(draw.most[6], 1.0f, 2e-3f) << name;
    }
}

TEST_F(MaterialScenesTest, GlassTransmitsColourAndRefracts) {
    const SceneFacts facts = capture("glass", 320, 180);
    expect_physical(facts);
    for (const char* name : {"pawns", "rooks", "knights", "bishops", "queens", "kings", "bars"}) {
        ASSERT_TRUE(facts.draws.contains(name)) << name;
        const DrawFacts& draw = facts.draws.at(name);
        EXPECT_EQ(draw.least[5], 1.5f);
        EXPECT_EQ(draw.most[5], 1.5f);
        EXPECT_EQ(draw.least[4], 1.0f);
        // Normals face the eye, up to what a triangle's interpolated position and normal may miss.
        EXPECT_GT(draw.least[7], -0.02f) << name;
        EXPECT_GT(draw.highest_transmission / static_cast<double>(draw.fragments), 0.1) << name;
    }
}

TEST_F(MaterialScenesTest, PlasticTransmitsColourWithoutRefraction) {
    const SceneFacts facts = capture("bottles", 320, 180);
    expect_physical(facts);
    const DrawFacts& draw = facts.draws.at("bottles");
    EXPECT_EQ(draw.least[5], 1.0f);
    EXPECT_EQ(draw.most[5], 1.0f);
    EXPECT_GT(draw.most[1], 0.5f);
    EXPECT_GT(draw.highest_transmission / static_cast<double>(draw.fragments), 0.3);
}

TEST_F(MaterialScenesTest, FogDiffusesLeavesCoverAndOnlyLanternsTransmit) {
    const SceneFacts facts = capture("fog", 320, 180);
    expect_physical(facts);
    const DrawFacts& fog = facts.draws.at("fog");
    EXPECT_NEAR(fog.most[4], 0.2f, 1e-3f) << "collimation";
    EXPECT_EQ(fog.most[1], 0.0f);
    EXPECT_EQ(fog.most[5], 1.0f);
    EXPECT_LT(fog.most[0], 0.25f) << "thin";
    const DrawFacts& leaves = facts.draws.at("leaves");
    EXPECT_EQ(leaves.most[1], 0.0f);
    EXPECT_EQ(leaves.least[4], 1.0f);
    EXPECT_GT(leaves.most[0], 0.9f);
    EXPECT_LT(leaves.least[0], 0.2f) << "outlines cover partly";
    const DrawFacts& lanterns = facts.draws.at("lanterns");
    EXPECT_EQ(lanterns.least[5], 1.5f);
    EXPECT_GT(lanterns.most[1], 0.3f);
}

TEST_F(MaterialScenesTest, FogThickensWithDepth) {
    // Twice the distance, more of its banks: half of the fog's fragments lie in the farther half of its
    // length.
    CaptureOptions options;
    options.scene_or_file = "fog";
    options.size = {320, 180};
    const std::string path = test::own_file("fog_depth.trace");
    capture_scene(options, path);
    TraceReader reader(path);
    const Camera& camera = *reader.header().camera;
    std::set<std::uint32_t> near_banks;
    std::set<std::uint32_t> far_banks;
    FragmentChunk chunk;
    while (reader.next(chunk))
        for (const Fragment& f : chunk.fragments) {
            if (reader.header().draws[f.draw].name != "fog") continue;
            const float ndc = 2 * f.z - 1;
            const float away = camera.projection[3][2] / (ndc + camera.projection[2][2]);
            (away < 23 ? near_banks : far_banks).insert(primitive_number(f) / 2);
        }
    EXPECT_GT(static_cast<double>(far_banks.size()), 2.0 * static_cast<double>(near_banks.size()));
}

TEST_F(MaterialScenesTest, TheEngineIsPartialCoverageOnly) {
    const SceneFacts facts = capture("engine", 320, 180);
    expect_physical(facts);
    EXPECT_GE(facts.draws.size(), 15u) << "a draw a group of parts";
    for (const auto& [name, draw] : facts.draws) {
        EXPECT_EQ(draw.most[1], 0.0f) << name;
        EXPECT_EQ(draw.least[4], 1.0f) << name;
        EXPECT_EQ(draw.most[5], 1.0f) << name;
        EXPECT_GT(draw.least[7], -0.02f) << name;
    }
}

// A row of panes, frosted more and more from left to right: what is recorded is what the panes are made of,
// and one of them absorbs nothing, so that only its coverage says that it is there.
TEST_F(MaterialScenesTest, PanesAreFrostedMoreAndMore) {
    const SceneFacts facts = capture("panes", 320, 180);
    expect_physical(facts);
    const DrawFacts& frost = facts.draws.at("frost");
    EXPECT_GT(frost.least[1], 0.9f) << "transmission";
    EXPECT_NEAR(frost.least[4], 0.05f, 1e-4f) << "collimation";
    EXPECT_LT(frost.most[4], 1.0f);
    EXPECT_EQ(frost.most[5], 1.0f) << "index";
    for (const auto& [name, draw] : facts.draws) {
        EXPECT_EQ(draw.least[0], 1.0f) << name << ": coverage";
        EXPECT_GT(draw.highest_transmission / static_cast<double>(draw.fragments), 0.1) << name;
    }
    for (const char* name : {"glass", "edges"}) {
        EXPECT_EQ(facts.draws.at(name).least[4], 1.0f) << name;
        EXPECT_EQ(facts.draws.at(name).most[5], 1.0f) << name << ": flat panes leave directions alone";
    }
    for (const char* name : {"ripples", "bevels"}) {
        EXPECT_EQ(facts.draws.at(name).least[5], 1.5f) << name;
        EXPECT_LT(facts.draws.at(name).least[7], 0.97f) << name << ": turned away from the eye";
    }
    TraceReader reader(test::own_file("panes.trace"));
    FragmentChunk chunk;
    std::map<float, std::pair<double, double>> places;  // sum of x and number, by collimation
    std::uint64_t absorbing_nothing = 0;
    while (reader.next(chunk))
        for (std::size_t i = 0; i < chunk.size(); ++i) {
            const Fragment& f = chunk.fragments[i];
            const Material& m = chunk.materials[i];
            if (facts.header.draws[f.draw].name != "frost") continue;
            // The pane before the row is frosted red glass.
            if (std::abs(m.collimation - 0.6f) > 0.01f) {
                places[m.collimation].first += f.x;
                places[m.collimation].second += 1;
            }
            if (m.transmission[0] == 1 && m.transmission[1] == 1 && m.transmission[2] == 1) {
                EXPECT_EQ(f.r + f.g + f.b, 0.0f) << "reflects nothing either";
                ++absorbing_nothing;
            }
        }
    EXPECT_EQ(places.size(), 5u);
    EXPECT_GT(absorbing_nothing, 2000u);
    double right = 1e9;
    for (const auto& [collimation, sum] : places) {
        const double middle = sum.first / sum.second;
        EXPECT_LT(middle, right - 20) << collimation;
        right = middle;
    }
}

// Metres along the view's axis.
double distance(const Camera& camera, float z) {
    const double ndc = 2 * static_cast<double>(z) - 1;
    return static_cast<double>(camera.projection[3][2]) /
           (ndc + static_cast<double>(camera.projection[2][2]));
}

// The box touches the frost of one pane and the hand that of another, and behind every pane the hall goes on
// for metres.
TEST_F(MaterialScenesTest, ThingsTouchThePanesOrStandFarBehind) {
    const SceneFacts facts = capture("panes", 320, 180);
    TraceReader reader(test::own_file("panes.trace"));
    FragmentChunk chunk;
    struct Gaps {
        double least = 1e9, most = 0;
        std::uint64_t touching = 0;
    };
    std::map<int, Gaps> gaps;  // by collimation in percent
    while (reader.next(chunk))
        for (std::size_t i = 0; i < chunk.size(); ++i) {
            const Fragment& f = chunk.fragments[i];
            if (facts.header.draws[f.draw].name != "frost") continue;
            const float behind = facts.header.opaque->depth[static_cast<std::size_t>(f.y * 320 + f.x)];
            if (!(f.z < behind)) continue;
            const double gap = distance(*facts.header.camera, behind) - distance(*facts.header.camera, f.z);
            Gaps& pane = gaps[static_cast<int>(std::lround(100 * chunk.materials[i].collimation))];
            pane.least = std::min(pane.least, gap);
            pane.most = std::max(pane.most, gap);
            pane.touching += gap < 0.03;
        }
    EXPECT_LT(gaps.at(25).least, 0.004) << "the box";
    EXPECT_GT(gaps.at(25).touching, 200u);
    EXPECT_LT(gaps.at(5).least, 0.02) << "the hand";
    EXPECT_GT(gaps.at(5).touching, 20u);
    for (const int collimation : {90, 75, 50, 25, 5}) EXPECT_GT(gaps.at(collimation).most, 4) << collimation;
}

// The amounts that the scenes are made for, at their own size.
TEST_F(MaterialScenesTest, FullSizeAmounts) {
    const SceneFacts glass = capture("glass", 1280, 720);
    EXPECT_GE(glass.fragments, 1'000'000u);
    EXPECT_GE(glass.deepest, 8u);
    const SceneFacts bottles = capture("bottles", 1280, 720);
    EXPECT_GE(bottles.fragments, 1'000'000u);
    EXPECT_GE(bottles.deepest, 8u);
    const SceneFacts panes = capture("panes", 1280, 720);
    EXPECT_GE(panes.fragments, 1'000'000u);
    EXPECT_GE(panes.deepest, 6u);
}

// A square of glass over the whole image, seen face on, mirroring nothing: its fragments must compose to
// equation 1 with the material as it was specified, although they hold another alpha.
TEST_F(MaterialScenesTest, RecordedPairsMeanEquationOne) {
    constexpr int kSide = 16;
    struct Case {
        glm::vec3 transmission;
        float coverage;
    };
    for (const Case& glass : {Case{{0.9f, 0.3f, 0.1f}, 1.0f}, Case{{0.5f, 0.5f, 0.5f}, 1.0f},
                              Case{{0.2f, 0.8f, 0.6f}, 0.4f}, Case{{1.0f, 1.0f, 1.0f}, 1.0f}}) {
        GlassLook look;
        look.environment = "night_environment";
        look.reflectance = 0;
        look.inner_reflections = 0;
        Scene scene;
        scene.materials = true;
        scene.camera = look_at({0, 0, 4}, {0, 0, 0}, 20, 1, 1, 1, 10);
        TriangleMesh square;
        square.positions = {{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}};
        square.normals.assign(4, glm::vec3(0, 0, 1));
        square.indices = {0, 1, 2, 0, 2, 3};
        scene.transparent.push_back(transmissive_draw(
            "pane", square, {{glm::mat4(1.0f), glm::vec4(glass.transmission, glass.coverage)}}, look));
        const GlContext context;
        const FragmentChunk chunk = testing::capture_chunk(scene, kSide, kSide, 1);
        ASSERT_EQ(chunk.size(), static_cast<std::size_t>(kSide * kSide));
        float least_share = 1;
        for (std::size_t i = 0; i < chunk.size(); ++i) {
            const Fragment& f = chunk.fragments[i];
            EXPECT_EQ(least_alpha(f.a, chunk.materials[i]), f.a) << "is the least already";
            float clearest = 1;
            for (int k = 0; k < 3; ++k) {
                const float passes = 1 - f.a + f.a * chunk.materials[i].transmission[k];
                const float expected = 1 - glass.coverage + glass.coverage * glass.transmission[k];
                // 10 degrees off the axis the way through the glass is 1% longer, and Fresnel's law takes
                // nothing.
                EXPECT_NEAR(passes, expected, 0.02f) << k;
                clearest = std::min(clearest, chunk.materials[i].transmission[k]);
            }
            least_share = std::min(least_share, clearest);
        }
        // The least alpha: one channel is absorbed by all that is covered. Clear glass keeps a trace of
        // alpha.
        if (glass.transmission != glm::vec3(1.0f)) {
            EXPECT_NEAR(least_share, 0.0f, 1e-3f);
        }
        EXPECT_GT(chunk.fragments[0].a, 0.0f);
    }
}

}  // namespace
}  // namespace ropsim
