// What outdoor scenes are made of: pipes, painted leaves, shadows, cards, trees, vehicles.
#include "capture/geometry/pipe_mesh.h"
#include "capture/geometry/tree_growth.h"
#include "capture/geometry/vehicle_mesh.h"
#include "capture/scenery/card_draw.h"
#include "capture/scenery/leaf_texture.h"
#include "capture/scenery/scene_parts.h"
#include "capture/scenery/scenery_mesh.h"
#include "capture/scenery/sun_shadow.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include <glm/gtc/constants.hpp>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

float area(const TriangleMesh& mesh) {
    float sum = 0;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const glm::vec3 a = mesh.positions[mesh.indices[i]];
        const glm::vec3 b = mesh.positions[mesh.indices[i + 1]];
        const glm::vec3 c = mesh.positions[mesh.indices[i + 2]];
        sum += 0.5f * glm::length(glm::cross(b - a, c - a));
    }
    return sum;
}

float distance_to_line(glm::vec3 p, glm::vec3 from, glm::vec3 to) {
    const glm::vec3 along = glm::normalize(to - from);
    const glm::vec3 off = p - from;
    return glm::length(off - glm::dot(off, along) * along);
}

TEST(PipeMeshTest, StraightPipeIsAPrismOfTheRightArea) {
    const std::vector<glm::vec3> path = {{1, 2, 3}, {2, 2.5f, 5}, {3, 3, 7}};
    const std::vector<float> radii(3, 0.4f);
    for (bool faceted : {false, true}) {
        const TriangleMesh mesh = pipe_mesh(path, radii, {.sides = 9, .capped = true, .faceted = faceted});
        EXPECT_EQ(mesh.triangles(), 2u * 9 * 2 + 2 * 7);
        const float length = glm::length(path[2] - path[0]);
        const float side = 2 * 0.4f * std::sin(glm::pi<float>() / 9);
        const float cap = 0.5f * 9 * 0.16f * std::sin(glm::two_pi<float>() / 9);
        EXPECT_NEAR(area(mesh), 9 * side * length + 2 * cap, 1e-3f);
        for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
            EXPECT_NEAR(distance_to_line(mesh.positions[i], path[0], path[2]), 0.4f, 1e-4f);
            EXPECT_NEAR(glm::length(mesh.normals[i]), 1.0f, 1e-4f);
        }
    }
}

TEST(PipeMeshTest, BentPipeKeepsItsWidthInBothArms) {
    const std::vector<glm::vec3> path = {{0, 0, 0}, {0, 3, 0}, {3, 3, 0}};
    const TriangleMesh mesh = pipe_mesh(path, std::vector<float>(3, 0.25f), {.sides = 16});
    // The mitre's ring belongs to both arms: its corners are as far from either axis.
    for (std::size_t i = 17; i < 34; ++i) {
        EXPECT_NEAR(distance_to_line(mesh.positions[i], path[0], path[1]), 0.25f, 1e-3f);
        EXPECT_NEAR(distance_to_line(mesh.positions[i], path[1], path[2]), 0.25f, 1e-3f);
    }
}

TEST(PipeMeshTest, TrianglesFaceOutwards) {
    const std::vector<glm::vec3> path = {{0, 0, 0}, {0, 0, 1}, {1, 0, 2}};
    const TriangleMesh mesh = pipe_mesh(path, std::vector<float>(3, 0.2f), {.sides = 8, .capped = true});
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const glm::vec3 a = mesh.positions[mesh.indices[i]];
        const glm::vec3 normal =
            glm::cross(mesh.positions[mesh.indices[i + 1]] - a, mesh.positions[mesh.indices[i + 2]] - a);
        EXPECT_GT(glm::dot(normal, mesh.normals[mesh.indices[i]]), 0) << "triangle " << i / 3;
    }
}

TEST(LeafTextureTest, BladeCoversTheAreaOfItsOutline) {
    const float belly = 0.4f;
    for (float bend : {0.0f, 0.5f, -0.5f}) {
        LeafPainting painting(256, glm::vec3(0.1f));
        painting.paint({{0.5f, 0.1f}, {0.1f, 0.7f}, 0.2f, belly, bend, 0.2f, {0.2f, 0.4f, 0.1f}});
        const SceneTexture texture = painting.texture();
        double covered = 0;
        for (std::size_t i = 3; i < texture.values.size(); i += 4) covered += texture.values[i];
        // The same outline, integrated along the blade.
        double expected = 0;
        for (int i = 0; i < 10000; ++i) {
            const double t = (i + 0.5) / 10000;
            const double quarter = glm::half_pi<double>();
            expected += t < belly ? std::pow(std::sin(quarter * t / belly), 0.7)
                                  : std::pow(std::cos(quarter * (t - belly) / (1 - belly)), 0.85);
        }
        expected *= 0.2 * std::sqrt(0.5) / 10000;
        EXPECT_NEAR(covered / (256 * 256) / expected, 1.0, 0.02) << bend;
    }
}

TEST(LeafTextureTest, PlantsGrowFromTheLowerEdgeAndEndBeforeTheOthers) {
    for (const SceneTexture& texture :
         {twig_texture(3, glm::vec3(0.1f)), spray_texture(3, glm::vec3(0.1f)),
          fern_texture(3, glm::vec3(0.1f)), grass_texture(3, glm::vec3(0.1f))}) {
        const auto alpha = [&](int x, int y) {
            return texture.values[static_cast<std::size_t>(4 * (y * texture.width + x) + 3)];
        };
        float foot = 0;
        for (int x = 0; x < texture.width; ++x) {
            foot = std::max(foot, alpha(x, texture.height - 10));
            EXPECT_EQ(alpha(x, 0), 0.0f);
        }
        EXPECT_GT(foot, 0.5f);
        for (int y = 0; y < texture.height; ++y) {
            EXPECT_EQ(alpha(0, y), 0.0f);
            EXPECT_EQ(alpha(texture.width - 1, y), 0.0f);
        }
    }
}

TEST(SunShadowTest, BoxesAndBallsShadeWhatTheyHideFromTheSun) {
    const glm::vec3 sun = light_direction();
    SunShadow shadow;
    EXPECT_EQ(shadow.light({0, 0, 0}), 1.0f);
    shadow.add_box(10.0f * sun, glm::vec3(1.5f), 0.7f, 0.6f);
    EXPECT_NEAR(shadow.light({0, 0, 0}), 0.4f, 1e-5f);
    EXPECT_EQ(shadow.light(20.0f * sun), 1.0f) << "the box is behind";
    EXPECT_EQ(shadow.light({6, 0, -6}), 1.0f);
    shadow.add_ball(5.0f * sun, glm::vec3(1, 2, 1), 0.5f);
    EXPECT_NEAR(shadow.light({0, 0, 0}), 0.2f, 1e-5f);
    // At the edge of a shadow part of the sun is seen.
    SunShadow half;
    const glm::vec3 across = glm::normalize(glm::cross(sun, glm::vec3(0, 1, 0)));
    half.add_ball(50.0f * sun + 5.0f * across, glm::vec3(5), 1);
    const float light = half.light({0, 0, 0});
    EXPECT_GT(light, 0.1f);
    EXPECT_LT(light, 0.9f);
}

TEST(CardDrawTest, ShufflingIsAPermutationThatTheSeedDecides) {
    std::vector<Card> cards(1000);
    for (std::size_t i = 0; i < cards.size(); ++i) cards[i].centre.x = static_cast<float>(i);
    std::vector<Card> first = cards;
    std::vector<Card> second = cards;
    shuffle_cards(first, 1);
    shuffle_cards(second, 2);
    std::set<float> seen;
    int stayed = 0;
    int same = 0;
    for (std::size_t i = 0; i < cards.size(); ++i) {
        seen.insert(first[i].centre.x);
        stayed += first[i].centre.x == static_cast<float>(i);
        same += first[i].centre.x == second[i].centre.x;
    }
    EXPECT_EQ(seen.size(), cards.size());
    EXPECT_LT(stayed, 10);
    EXPECT_LT(same, 10);
}

TEST(TreeGrowthTest, MoreTwigsLeaveTheFirstAsTheyAre) {
    TreeForm form;
    form.cards = 50;
    SceneryMesh wood;
    std::vector<Card> few;
    grow_tree(form, {1, 0, 2}, 7, wood, few);
    form.cards = 90;
    std::vector<Card> many;
    grow_tree(form, {1, 0, 2}, 7, wood, many);
    ASSERT_EQ(few.size(), 50u);
    ASSERT_EQ(many.size(), 90u);
    for (std::size_t i = 0; i < few.size(); ++i) {
        EXPECT_EQ(few[i].centre, many[i].centre);
        EXPECT_NEAR(glm::dot(few[i].right, few[i].up), 0.0f, 1e-3f);
        EXPECT_GT(few[i].centre.y, 0.5f * form.crown_from * form.height);
        EXPECT_LT(few[i].centre.y, 1.3f * form.height);
    }
}

TEST(SceneryMeshTest, QuadsAreCutIntoPiecesThatFaceTheirNormal) {
    SceneryMesh mesh;
    mesh.add_quad({0, 0, 0}, {4, 0, 0}, {4, 2, 0}, {0, 2, 0}, glm::vec4(1.0f), Finish::kPlain, 4, 3);
    EXPECT_EQ(mesh.triangles(), 24u);
    float sum = 0;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const glm::vec3 a = mesh.vertices[mesh.indices[i]].position;
        const glm::vec3 cross = glm::cross(mesh.vertices[mesh.indices[i + 1]].position - a,
                                           mesh.vertices[mesh.indices[i + 2]].position - a);
        EXPECT_GT(cross.z, 0);
        sum += 0.5f * cross.z;
    }
    EXPECT_NEAR(sum, 8.0f, 1e-4f);
    EXPECT_EQ(mesh.vertices[0].normal, glm::vec3(0, 0, 1));
}

TEST(VehicleMeshTest, StandsOnTheGroundWithItsWindowsInside) {
    for (const Vehicle& vehicle : {make_car(glm::vec3(0.5f)), make_van(glm::vec3(0.5f))}) {
        glm::vec3 low(1e9f);
        glm::vec3 high(-1e9f);
        for (const SceneryVertex& v : vehicle.body.vertices) {
            low = glm::min(low, v.position);
            high = glm::max(high, v.position);
            EXPECT_NEAR(glm::length(v.normal), 1.0f, 1e-3f);
        }
        EXPECT_NEAR(low.y, 0.0f, 0.03f);
        EXPECT_GT(high.x - low.x, 2 * (high.z - low.z));
        EXPECT_GE(vehicle.glass.triangles(), 16u);
        for (const SceneryVertex& v : vehicle.glass.vertices) {
            EXPECT_GT(v.position.y, 0.8f);
            EXPECT_TRUE(glm::all(glm::lessThanEqual(v.position, high)));
            EXPECT_TRUE(glm::all(glm::greaterThanEqual(v.position, low)));
            EXPECT_LT(v.color.a, 1.0f);
        }
    }
}

}  // namespace
}  // namespace ropsim
