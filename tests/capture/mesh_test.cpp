// Mesh loading and the simple shapes.
#include "capture/geometry/mesh.h"

#include "base/error.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

std::string write_temporary(const std::string& name, const std::string& content) {
    const std::string path = ::testing::TempDir() + "/" + name;
    std::ofstream(path) << content;
    return path;
}

// The message of the UserError that loading throws, "" if none.
std::string fault(const std::string& path) {
    try {
        load_mesh(path);
    } catch (const UserError& error) {
        EXPECT_EQ(error.where(), path);
        return error.what();
    }
    return "";
}

// Sum over triangles of the signed volume they span with the origin: the enclosed volume if they face
// outwards.
double enclosed_volume(const TriangleMesh& mesh) {
    double volume = 0;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const glm::dvec3 a = mesh.positions[mesh.indices[i]];
        const glm::dvec3 b = mesh.positions[mesh.indices[i + 1]];
        const glm::dvec3 c = mesh.positions[mesh.indices[i + 2]];
        volume += glm::dot(a, glm::cross(b, c)) / 6;
    }
    return volume;
}

TEST(MeshTest, ObjIsTriangulatedCentredScaledAndGivenNormals) {
    // A rectangle 4 x 2 at z = 5, as one face of four corners.
    const std::string path =
        write_temporary("rectangle.obj", "v 10 0 5\nv 14 0 5\nv 14 2 5\nv 10 2 5\nf 1 2 3 4\n");
    const TriangleMesh mesh = load_mesh(path);
    EXPECT_EQ(mesh.triangles(), 2u);
    ASSERT_EQ(mesh.positions.size(), mesh.normals.size());
    glm::vec3 low(1e9f);
    glm::vec3 high(-1e9f);
    for (const glm::vec3& p : mesh.positions) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    EXPECT_EQ(low, glm::vec3(-0.5f, -0.25f, 0));
    EXPECT_EQ(high, glm::vec3(0.5f, 0.25f, 0));
    for (const glm::vec3& n : mesh.normals) EXPECT_NEAR(glm::length(n - glm::vec3(0, 0, 1)), 0.0f, 1e-6f);
}

TEST(MeshTest, FaultsAreOneLineThatSaysHowToMend) {
    EXPECT_THAT(fault("/nowhere/none.obj"), ::testing::HasSubstr("no such mesh file"));
    const std::string points = write_temporary("points.obj", "v 0 0 0\nv 1 0 0\n");
    EXPECT_NE(fault(points), "");
    const std::string lines = write_temporary("lines.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n");
    EXPECT_NE(fault(lines), "");
    const std::string noise = write_temporary("noise.ply", "this is no mesh");
    EXPECT_THAT(fault(noise), ::testing::HasSubstr("not a mesh"));
    const std::string point = write_temporary("point.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n");
    EXPECT_THAT(fault(point), ::testing::HasSubstr("one point"));
    for (const std::string& path : {points, lines, noise, point}) {
        EXPECT_EQ(fault(path).find('\n'), std::string::npos) << path;
    }
}

TEST(MeshTest, ModelsOfGlmark2LoadIntoTheUnitBox) {
    for (const char* name : {"horse.3ds", "bunny.obj"}) {
        const std::string path = std::string("/usr/share/glmark2/models/") + name;
        if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not installed (glmark2-data)";
        const TriangleMesh mesh = load_mesh(path);
        EXPECT_GT(mesh.triangles(), 5000u) << name;
        for (const glm::vec3& p : mesh.positions) {
            for (int axis = 0; axis < 3; ++axis) EXPECT_LE(std::abs(p[axis]), 0.5f + 1e-6f);
        }
        for (const glm::vec3& n : mesh.normals) EXPECT_NEAR(glm::length(n), 1.0f, 1e-4f);
    }
}

TEST(MeshTest, ShapesAreClosedAndFaceOutwards) {
    EXPECT_NEAR(enclosed_volume(box_mesh()), 8.0, 1e-6);
    const double sphere = enclosed_volume(sphere_mesh(64));
    EXPECT_NEAR(sphere, 4.18879, 0.01);
    EXPECT_LT(sphere, 4.18879);
}

}  // namespace
}  // namespace ropsim
