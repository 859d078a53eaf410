// Bodies of blobs against closed forms: distances, areas, volumes, and meshes without holes.
#include "capture/geometry/implicit_mesh.h"

#include <cmath>
#include <map>
#include <numbers>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

struct Measures {
    double area = 0;
    double volume = 0;  // signed: positive when triangles are counterclockwise from outside
    bool closed = true;
};

Measures measure(const TriangleMesh& mesh) {
    Measures result;
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const std::uint32_t* corner = &mesh.indices[i];
        const glm::dvec3 a = mesh.positions[corner[0]];
        const glm::dvec3 b = mesh.positions[corner[1]];
        const glm::dvec3 c = mesh.positions[corner[2]];
        result.area += 0.5 * glm::length(glm::cross(b - a, c - a));
        result.volume += glm::dot(a, glm::cross(b, c)) / 6;
        for (int k = 0; k < 3; ++k) ++edges[{corner[k], corner[(k + 1) % 3]}];
    }
    for (const auto& [edge, count] : edges) {
        const auto back = edges.find({edge.second, edge.first});
        result.closed = result.closed && back != edges.end() && back->second == count;
    }
    return result;
}

TEST(ImplicitMeshTest, BallHasItsAreaVolumeAndNormals) {
    const BlobBody body({ellipsoid({0.3f, -0.2f, 0.1f}, glm::vec3(0.8f), 0.1f)});
    const TriangleMesh mesh = body.mesh(glm::vec3(-1.2f), glm::vec3(1.4f), 0.05f);
    const Measures measures = measure(mesh);
    EXPECT_TRUE(measures.closed);
    EXPECT_NEAR(measures.area, 4 * std::numbers::pi * 0.64, 0.02 * 4 * std::numbers::pi * 0.64);
    EXPECT_NEAR(measures.volume, 4.0 / 3 * std::numbers::pi * 0.512, 0.03);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const glm::vec3 out = mesh.positions[i] - glm::vec3(0.3f, -0.2f, 0.1f);
        EXPECT_NEAR(glm::length(out), 0.8f, 0.01f);
        EXPECT_GT(glm::dot(glm::normalize(out), mesh.normals[i]), 0.999f);
    }
}

TEST(ImplicitMeshTest, EllipsoidHasItsVolume) {
    const BlobBody body({ellipsoid(glm::vec3(0), {1.0f, 0.5f, 0.7f}, 0.1f)});
    const Measures measures = measure(body.mesh(glm::vec3(-1.2f), glm::vec3(1.2f), 0.04f));
    EXPECT_TRUE(measures.closed);
    const double exact = 4.0 / 3 * std::numbers::pi * 0.35;
    EXPECT_NEAR(measures.volume, exact, 0.02 * exact);
}

TEST(ImplicitMeshTest, DistancesOfBallsAndCapsulesAreExact) {
    const BlobBody capsule({limb({0, 0, 0}, {2, 0, 0}, 0.5f, 0.5f, 0.1f)});
    EXPECT_FLOAT_EQ(capsule.distance({1, 2, 0}), 1.5f);
    EXPECT_FLOAT_EQ(capsule.distance({4, 0, 0}), 1.5f);
    EXPECT_FLOAT_EQ(capsule.distance({1, 0.25f, 0}), -0.25f);
    // Halfway between two equal balls the smooth minimum lies a quarter of the blend lower.
    const BlobBody two(
        {limb({-1, 0, 0}, {-1, 0, 0}, 0.5f, 0.5f, 0.4f), limb({1, 0, 0}, {1, 0, 0}, 0.5f, 0.5f, 0.4f)});
    EXPECT_NEAR(two.distance({0, 0, 0}), 0.5f - 0.25f * 0.4f, 1e-6f);
    EXPECT_NEAR(two.distance({1, 0, 1}), 0.5f, 1e-6f) << "out of the blend's reach";
}

TEST(ImplicitMeshTest, CarvedBlobsAreTakenAway) {
    Blob hole = limb({0, 0, 0}, {0, 0, 0}, 0.5f, 0.5f, 0.001f);
    hole.carved = true;
    const BlobBody shell({limb({0, 0, 0}, {0, 0, 0}, 1.0f, 1.0f, 0.001f), hole});
    EXPECT_NEAR(shell.distance({0, 0, 0}), 0.5f, 1e-3f);
    EXPECT_NEAR(shell.distance({0.75f, 0, 0}), -0.25f, 1e-3f);
    const double exact = 4.0 / 3 * std::numbers::pi * (1 - 0.125);
    const Measures measures = measure(shell.mesh(glm::vec3(-1.2f), glm::vec3(1.2f), 0.05f));
    EXPECT_TRUE(measures.closed);
    EXPECT_NEAR(measures.volume, exact, 0.02 * exact);
}

}  // namespace
}  // namespace ropsim
