// Points from one view's pixels to the world and to another view's pixels.
#include "base/random.h"
#include "rop/shadow/light_space.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

TraceHeader view_of(int width, int height, const glm::mat4& view, const glm::mat4& projection) {
    TraceHeader header;
    header.width = width;
    header.height = height;
    header.camera.emplace();
    header.camera->view = view;
    header.camera->projection = projection;
    return header;
}

TraceHeader perspective_view() {
    return view_of(320, 200, glm::lookAt(glm::vec3(3, 2, 5), glm::vec3(0.3f, 0.2f, 0), glm::vec3(0, 1, 0)),
                   glm::perspective(0.7f, 1.6f, 0.5f, 40.0f));
}

// Looks straight down on x and z from -2 to 2; up in the picture is -z. Depth 0 is at y = 5, 1 at y = -3.
TraceHeader light_from_above() {
    return view_of(64, 64, glm::lookAt(glm::vec3(0, 6, 0), glm::vec3(0), glm::vec3(0, 0, -1)),
                   glm::ortho(-2.0f, 2.0f, -2.0f, 2.0f, 1.0f, 9.0f));
}

// The graphics pipeline spelled out: clip, divide, viewport with y down.
ViewPoint rasterised(const TraceHeader& view, glm::dvec3 world) {
    const glm::dvec4 eye = glm::dmat4(view.camera->view) * glm::dvec4(world, 1);
    const glm::dvec4 clip = glm::dmat4(view.camera->projection) * eye;
    return {(clip.x / clip.w + 1) / 2 * view.width, (1 - clip.y / clip.w) / 2 * view.height,
            (clip.z / clip.w + 1) / 2};
}

TEST(LightSpace, WorldPositionsComeBackFromPixelsAndDepths) {
    const TraceHeader view = perspective_view();
    for (std::uint32_t i = 0; i < 200; ++i) {
        const auto draw = [&](std::uint32_t n) { return 2.0 * static_cast<double>(random_unit(i, n)) - 1.0; };
        const glm::dvec3 world(draw(0), draw(1), draw(2));
        const glm::dvec3 back = LightSpace::world(view, rasterised(view, world));
        EXPECT_LT(glm::length(back - world), 1e-9) << i;
    }
}

TEST(LightSpace, PointsLandWhereTheLightsOwnMatricesPutThem) {
    const TraceHeader view = perspective_view();
    const TraceHeader light = light_from_above();
    const LightSpace to_light(view, light);
    EXPECT_TRUE(to_light.valid());
    for (std::uint32_t i = 0; i < 200; ++i) {
        const auto draw = [&](std::uint32_t n) { return 2.0 * static_cast<double>(random_unit(i, n)) - 1.0; };
        const glm::dvec3 world(draw(0), draw(1), draw(2));
        const ViewPoint expected = rasterised(light, world);
        const ViewPoint point = to_light(rasterised(view, world));
        EXPECT_NEAR(point.x, expected.x, 1e-8);
        EXPECT_NEAR(point.y, expected.y, 1e-8);
        EXPECT_NEAR(point.z, expected.z, 1e-10);
    }
}

TEST(LightSpace, AKnownPointFallsIntoAKnownTexel) {
    const TraceHeader view = perspective_view();
    const LightSpace to_light(view, light_from_above());
    // 16 texels a unit; x = 0.53 is column 32 + 8.48, z = -1.22 is 19.52 rows above the middle.
    const ViewPoint point = to_light(rasterised(view, {0.53, 1.0, -1.22}));
    EXPECT_NEAR(point.x, 40.48, 1e-5);
    EXPECT_NEAR(point.y, 32 - 19.52, 1e-5);
    EXPECT_NEAR(point.z, 0.5, 1e-6);
}

TEST(LightSpace, BehindAPerspectiveLightIsNowhere) {
    const TraceHeader camera = light_from_above();
    const TraceHeader spot =
        view_of(16, 16, glm::lookAt(glm::vec3(0, 1, 0), glm::vec3(0, 0, 0), glm::vec3(0, 0, -1)),
                glm::perspective(1.0f, 1.0f, 0.1f, 10.0f));
    const LightSpace to_light(camera, spot);
    EXPECT_NEAR(to_light(rasterised(camera, {0, 0.5, 0})).x, 8, 1e-6);
    EXPECT_TRUE(std::isnan(to_light(rasterised(camera, {0, 1.5, 0})).z));
}

TEST(LightSpace, MatricesThatCannotBeInvertedAreTold) {
    TraceHeader flat = perspective_view();
    flat.camera->projection = glm::mat4(0.0f);
    EXPECT_FALSE(LightSpace(flat, light_from_above()).valid());
    EXPECT_FALSE(LightSpace(light_from_above(), flat).valid());
}

}  // namespace
}  // namespace ropsim
