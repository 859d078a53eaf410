// Distances from the eye of window depths, against projections that put points there.
#include "rop/view_distance.h"

#include <cmath>

#include <glm/gtc/matrix_transform.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

std::optional<Camera> camera_of(const glm::mat4& projection, float metres_per_unit = 1) {
    Camera camera;
    camera.projection = projection;
    camera.metres_per_unit = metres_per_unit;
    return camera;
}

// Points in front of the eye, through the projection to window depth and back.
void expect_round_trip(const glm::mat4& projection, float metres_per_unit, double tolerance = 2e-5) {
    const ViewDistance distance(camera_of(projection, metres_per_unit), "here", "it", "do not");
    for (const double z : {0.6, 1.0, 3.0, 17.0, 39.0}) {
        const glm::dvec4 clip = glm::dmat4(projection) * glm::dvec4(0.3, -0.2, -z, 1);
        const double depth = 0.5 + 0.5 * clip.z / clip.w;
        const double metres = z * static_cast<double>(metres_per_unit);
        EXPECT_NEAR(static_cast<double>(distance.of<PlainDatapath>(static_cast<float>(depth))), metres,
                    tolerance * metres * z);
    }
}

TEST(ViewDistanceTest, InvertsWhateverProjects) {
    for (const float unit : {1.0f, 0.01f, 25.4f}) {
        expect_round_trip(glm::perspective(0.7f, 1.5f, 0.5f, 40.0f), unit);
        expect_round_trip(glm::infinitePerspective(0.7f, 1.5f, 0.5f), unit);
        // Off the axis, as of one eye of two.
        expect_round_trip(glm::frustum(-0.2f, 0.3f, -0.2f, 0.25f, 0.5f, 40.0f), unit);
        expect_round_trip(glm::ortho(-3.0f, 2.0f, -1.0f, 1.0f, 0.5f, 40.0f), unit);
        // Depth reversed: the near plane at 1.
        glm::mat4 reversed = glm::perspective(0.7f, 1.5f, 0.5f, 40.0f);
        reversed[2][2] *= -1;
        reversed[3][2] *= -1;
        expect_round_trip(reversed, unit);
    }
}

TEST(ViewDistanceTest, WithoutACameraItIsDepthItself) {
    EXPECT_EQ(ViewDistance().of<PlainDatapath>(0.375f), 0.375f);
}

std::string refusal(const std::optional<Camera>& camera) {
    try {
        const ViewDistance distance(camera, "--technique: fog", "this fog", "use fog=none");
    } catch (const UserError& error) {
        return error.where() + ": " + error.what();
    }
    return "";
}

TEST(ViewDistanceTest, RefusalsNameTheKeyAndTheRemedy) {
    EXPECT_EQ(refusal({}),
              "--technique: fog: this fog goes by the distance from the eye and the trace has no camera; use "
              "fog=none");
    glm::mat4 oblique = glm::perspective(0.7f, 1.5f, 0.5f, 40.0f);
    oblique[1][2] = 0.1f;
    glm::mat4 neither = glm::perspective(0.7f, 1.5f, 0.5f, 40.0f);
    neither[3][3] = 0.5f;
    for (const glm::mat4& projection : {oblique, neither, glm::mat4(0.0f)})
        EXPECT_EQ(refusal(camera_of(projection)),
                  "--technique: fog: the distance from the eye cannot be told from depth with the trace's "
                  "projection; use fog=none");
}

}  // namespace
}  // namespace ropsim
