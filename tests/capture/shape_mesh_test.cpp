// Turned, swept and extruded meshes against the volumes and areas of geometry books, and their normals.
#include "capture/geometry/chess_pieces.h"
#include "capture/geometry/lathe_mesh.h"
#include "capture/geometry/profile.h"
#include "capture/geometry/swept_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

// Sum over triangles of the signed volume they span with the origin: positive if they face outwards.
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

double area(const TriangleMesh& mesh) {
    double sum = 0;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const glm::dvec3 a = mesh.positions[mesh.indices[i]];
        const glm::dvec3 b = mesh.positions[mesh.indices[i + 1]];
        const glm::dvec3 c = mesh.positions[mesh.indices[i + 2]];
        sum += 0.5 * glm::length(glm::cross(b - a, c - a));
    }
    return sum;
}

// Every normal has unit length and points to the side from which its triangle is anticlockwise.
void expect_sound_normals(const TriangleMesh& mesh) {
    ASSERT_EQ(mesh.positions.size(), mesh.normals.size());
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const glm::vec3 a = mesh.positions[mesh.indices[i]];
        const glm::vec3 face =
            glm::cross(mesh.positions[mesh.indices[i + 1]] - a, mesh.positions[mesh.indices[i + 2]] - a);
        for (std::size_t k = 0; k < 3; ++k) {
            const glm::vec3 normal = mesh.normals[mesh.indices[i + k]];
            EXPECT_NEAR(glm::length(normal), 1.0f, 1e-4f);
            EXPECT_GT(glm::dot(normal, face), 0.0f) << "triangle " << i / 3;
        }
    }
}

// Whether every edge (by position) is passed once each way: a surface without holes.
bool closed(const TriangleMesh& mesh) {
    const auto key = [&](std::uint32_t index) {
        const glm::vec3 p = mesh.positions[index];
        return std::array<long, 3>{std::lround(p.x * 1e5), std::lround(p.y * 1e5), std::lround(p.z * 1e5)};
    };
    std::map<std::pair<std::array<long, 3>, std::array<long, 3>>, int> balance;
    for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
        const auto from = key(mesh.indices[i]);
        const auto to = key(mesh.indices[i % 3 == 2 ? i - 2 : i + 1]);
        ++balance[{from, to}];
        --balance[{to, from}];
    }
    return std::all_of(balance.begin(), balance.end(), [](const auto& edge) { return edge.second == 0; });
}

constexpr double kPi = glm::pi<double>();

TEST(LatheMeshTest, ConeAndCylinderHaveTheirVolumesAndAreas) {
    const TriangleMesh cylinder = lathe_mesh({{0, 0}, {2, 0}, {2, 3}, {0, 3}}, 400);
    EXPECT_NEAR(enclosed_volume(cylinder), 12 * kPi, 0.01);
    EXPECT_NEAR(area(cylinder), 2 * 4 * kPi + 12 * kPi, 0.01);
    const TriangleMesh cone = lathe_mesh({{0, 0}, {1, 0}, {0, 2}}, 400);
    EXPECT_NEAR(enclosed_volume(cone), 2 * kPi / 3, 0.001);
    for (const TriangleMesh& mesh : {cylinder, cone}) {
        expect_sound_normals(mesh);
        EXPECT_TRUE(closed(mesh));
    }
    // A pipe: down its inner wall.
    const TriangleMesh pipe = lathe_mesh({{2, 0}, {2, 1}, {1, 1}, {1, 0}, {2, 0}}, 400);
    EXPECT_NEAR(enclosed_volume(pipe), 3 * kPi, 0.001);
}

TEST(LatheMeshTest, SharpBendsStayEdgesAndOthersAreSmooth) {
    std::vector<glm::vec2> half_circle;
    for (int i = 0; i <= 40; ++i) {
        const float angle = glm::pi<float>() * (static_cast<float>(i) / 40 - 0.5f);
        half_circle.emplace_back(std::max(std::cos(angle), 0.0f), std::sin(angle));
    }
    // A unit ball's normals are its positions.
    const TriangleMesh ball = lathe_mesh(half_circle, 32);
    for (std::size_t i = 0; i < ball.positions.size(); ++i) {
        // At the poles the profile ends.
        if (std::abs(ball.positions[i].y) < 0.99f) {
            EXPECT_LT(glm::distance(ball.positions[i], ball.normals[i]), 1e-3f);
        }
    }
    const TriangleMesh can = lathe_mesh({{1, 0}, {1, 1}, {0, 1}}, 32);
    for (const glm::vec3& normal : can.normals) EXPECT_TRUE(normal.y == 0.0f || normal.y == 1.0f) << normal.y;
}

TEST(ProfileTest, CurvesPassThroughTheirPointsAndStraightOnesStayStraight) {
    const std::vector<glm::vec2> points = {{0, 0}, {1, 0.5f}, {0.4f, 2}, {0, 2.5f}};
    const std::vector<glm::vec2> curve = smooth_profile(points, 7);
    ASSERT_EQ(curve.size(), 3u * 7 + 1);
    for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(curve[7 * i], points[i]);
    for (const glm::vec2& p : curve) EXPECT_GE(p.x, 0.0f);
    for (const glm::vec2& p : smooth_profile({{1, 1}, {2, 2}, {4, 4}}, 9)) EXPECT_NEAR(p.x, p.y, 1e-5f);
}

TEST(SweptMeshTest, TubesRingsAndCapsHaveTheirVolumes) {
    const TriangleMesh tube = tube_mesh({{0, 0, 0}, {0, 0, 2}, {0, 0, 5}}, 0.5f, 200);
    EXPECT_NEAR(enclosed_volume(tube), 5 * 0.25 * kPi, 0.001);
    expect_sound_normals(tube);
    EXPECT_TRUE(closed(tube));
    // A torus by Pappus: 2 pi R times the section's area.
    SweptProfile ring;
    for (const glm::vec2& p : circle_outline(3, 300)) ring.path.emplace_back(p.x, p.y, 0);
    ring.outline = {{-0.2f, -0.1f}, {0.2f, -0.1f}, {0.2f, 0.1f}, {-0.2f, 0.1f}};
    ring.closed = true;
    ring.up = {0, 0, 1};
    const TriangleMesh torus = swept_mesh(ring);
    EXPECT_NEAR(enclosed_volume(torus), 2 * kPi * 3 * 0.08, 0.001);
    EXPECT_TRUE(closed(torus));
}

TEST(SweptMeshTest, ScalesTaperAndTiltTheNormals) {
    SweptProfile cone;
    cone.path = {{0, 0, 0}, {0, 0, 1}, {0, 0, 2}};
    cone.scales = {1.0f, 0.75f, 0.5f};
    cone.outline = circle_outline(1, 200);
    cone.capped = false;
    const TriangleMesh mesh = swept_mesh(cone);
    // The wall leans inwards by a quarter a unit of height.
    for (const glm::vec3& normal : mesh.normals) EXPECT_NEAR(normal.z, 0.25f / std::sqrt(1 + 0.0625f), 1e-4f);
}

TEST(SweptMeshTest, ExtrusionFillsOutlinesThatAreNotConvex) {
    // An L of three unit squares, and a gear-like star.
    const TriangleMesh l = extruded_mesh({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}, 0.5f);
    EXPECT_NEAR(enclosed_volume(l), 3, 1e-5);
    expect_sound_normals(l);
    EXPECT_TRUE(closed(l));
    std::vector<glm::vec2> star;
    for (int i = 0; i < 24; ++i) {
        const double angle = kPi * i / 12;
        star.emplace_back((i % 2 == 0 ? 2.0 : 1.0) * std::cos(angle),
                          (i % 2 == 0 ? 2.0 : 1.0) * std::sin(angle));
    }
    // 24 triangles of sides 2 and 1 about the middle, 15 degrees apart.
    EXPECT_NEAR(enclosed_volume(extruded_mesh(star, 1)), 24 * 2 * std::sin(kPi / 12), 1e-4);
}

TEST(SweptMeshTest, AppendingMovesPositionsAndTurnsNormals) {
    TriangleMesh mesh = box_mesh();
    const glm::mat4 model =
        glm::rotate(glm::translate(glm::mat4(1.0f), glm::vec3(5, 0, 0)), 1.0f, glm::vec3(0.6f, 0.8f, 0)) *
        glm::scale(glm::mat4(1.0f), glm::vec3(1, 2, 0.5f));
    append_mesh(mesh, lathe_mesh({{0, -1}, {1, -1}, {1, 1}, {0, 1}}, 100), model);
    EXPECT_NEAR(enclosed_volume(mesh), 8 + 2 * kPi, 0.01);
    expect_sound_normals(mesh);
}

TEST(ChessPiecesTest, StandOnTheBoardWithinTheirSquareInTheUsualOrderOfHeights) {
    float below = 0;
    for (ChessPiece piece : {ChessPiece::kPawn, ChessPiece::kRook, ChessPiece::kKnight, ChessPiece::kBishop,
                             ChessPiece::kQueen, ChessPiece::kKing}) {
        const TriangleMesh mesh = chess_piece_mesh(piece);
        glm::vec3 low(1e9f);
        glm::vec3 high(-1e9f);
        for (const glm::vec3& p : mesh.positions) {
            low = glm::min(low, p);
            high = glm::max(high, p);
        }
        EXPECT_NEAR(low.y, 0.0f, 1e-6f);
        EXPECT_GT(high.y, below);
        below = high.y;
        EXPECT_LT(high.x - low.x, 0.8f * kChessSquare);
        EXPECT_GT(enclosed_volume(mesh), 0.0);
        EXPECT_NEAR(chess_piece_radius(piece, 0.002f), 0.5f * (high.z - low.z), 0.1f * (high.z - low.z));
        EXPECT_EQ(chess_piece_radius(piece, 0.2f), 0.0f);
    }
}

}  // namespace
}  // namespace ropsim
