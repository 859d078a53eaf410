// Which way captured triangles face: OpenGL's rule, at any number of samples, and on a closed surface.
#include "tests/capture/test_scene.h"

#include <array>
#include <map>
#include <utility>

namespace ropsim::testing {
namespace {

constexpr int kSide = 64;

using FacingCapture = OpenGlTest;

// A convex octahedron around the middle of the window whose triangles run counterclockwise seen from outside.
// Window coordinates (right, down, away) are right-handed, so that the normal by the right-hand rule points
// outwards.
std::vector<WindowTriangle> octahedron() {
    const glm::vec3 middle(32, 32, 0.5f);
    std::vector<WindowTriangle> triangles;
    for (const float x : {-25.3f, 25.3f})
        for (const float y : {-27.1f, 27.1f})
            for (const float z : {-0.3f, 0.3f}) {
                WindowTriangle t{
                    {middle + glm::vec3(x, 0, 0), middle + glm::vec3(0, y, 0), middle + glm::vec3(0, 0, z)}};
                const glm::vec3 normal = glm::cross(t.corners[1] - t.corners[0], t.corners[2] - t.corners[0]);
                if (glm::dot(normal, t.corners[0] - middle) < 0) std::swap(t.corners[1], t.corners[2]);
                triangles.push_back(t);
            }
    return triangles;
}

TEST_F(FacingCapture, OfAClosedSurfaceTheNearHalfFacesFrontAndTheFarHalfBack) {
    const GlContext context;
    const std::vector<WindowTriangle> triangles = octahedron();
    Scene scene;
    scene.transparent.push_back(window_draw(triangles, kSide, kSide, {1, 1, 1, 0.5f}));
    for (const int samples : {1, 4}) {
        const FragmentChunk chunk = capture_chunk(scene, kSide, kSide, samples);
        std::array<int, 2> fragments{};
        std::map<std::pair<int, int>, std::array<int, 2>> pixels;
        for (const Fragment& f : chunk.fragments) {
            ASSERT_LT(primitive_number(f), triangles.size());
            const auto& corners = triangles[primitive_number(f)].corners;
            const bool away = corners[0].z + corners[1].z + corners[2].z > 1.5f;
            EXPECT_EQ(faces_back(f), away) << f.x << ',' << f.y << " triangle " << primitive_number(f);
            ++fragments[faces_back(f) ? 1 : 0];
            ++pixels[{f.x, f.y}][faces_back(f) ? 1 : 0];
        }
        // The silhouette, a rhombus of half diagonals 25.3 and 27.1, is covered once by each half.
        EXPECT_NEAR(fragments[0], 2 * 25.3 * 27.1, samples == 1 ? 30 : 250);
        EXPECT_EQ(fragments[0], fragments[1]);
        for (const auto& [pixel, count] : pixels)
            EXPECT_EQ(count[0], count[1]) << pixel.first << ',' << pixel.second;
    }
}

TEST_F(FacingCapture, DoesNotChangeTheOrderInWhichTrianglesArrive) {
    const GlContext context;
    Scene scene;
    scene.transparent.push_back(window_draw(octahedron(), kSide, kSide, {1, 1, 1, 0.5f}));
    const std::vector<Fragment> fragments = capture_all(scene, kSide, kSide);
    for (std::size_t i = 1; i < fragments.size(); ++i)
        EXPECT_LE(primitive_number(fragments[i - 1]), primitive_number(fragments[i])) << i;
}

}  // namespace
}  // namespace ropsim::testing
