// Tangent planes of receivers in a light's view, against other points of the same plane carried there.
#include "analysis/shadow_receiver_plane.h"

#include <array>
#include <cmath>
#include <limits>

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

constexpr glm::dvec3 kNormal{0.3, 0.9, -0.2};  // of a plane through the world's origin

TraceHeader view_from(const glm::vec3& eye, bool parallel) {
    TraceHeader header;
    header.width = 64;
    header.height = 48;
    header.camera.emplace();
    header.camera->view = glm::lookAt(eye, glm::vec3(0), glm::vec3(0, 0, -1));
    header.camera->projection = parallel ? glm::ortho(-2.0f, 2.0f, -1.5f, 1.5f, 1.0f, 9.0f)
                                         : glm::perspective(0.8f, 4.0f / 3, 1.0f, 9.0f);
    return header;
}

ViewPoint seen(const TraceHeader& view, const glm::dvec3& world) {
    const glm::dvec4 at = LightSpace::to_pixels(view) * glm::dvec4(world, 1);
    return {at.x / at.w, at.y / at.w, at.z / at.w};
}

glm::dvec3 on_plane(double x, double z) {
    return {x, -(kNormal.x * x + kNormal.z * z) / kNormal.y, z};
}

void expect_runs_on(const ReceiverPlane& plane, const TraceHeader& light, const ViewPoint& at,
                    double within) {
    for (const auto& [x, z] : {std::pair(0.5, 0.1), {-0.3, 0.4}, {0.2, -0.6}}) {
        const ViewPoint there = seen(light, on_plane(x, z));
        EXPECT_NEAR(at.z + plane.dx * (there.x - at.x) + plane.dy * (there.y - at.y), there.z, within);
        EXPECT_GT(std::abs(there.z - at.z), 100 * within) << "a plane that faces the light shows nothing";
    }
}

TEST(ReceiverPlane, RunsOnAsTheSurfaceDoes) {
    TraceHeader camera = view_from({1, 5, 1}, false);
    for (const bool parallel : {true, false}) {
        const TraceHeader light = view_from({-3, 4, 0.5f}, parallel);
        const ViewPoint at = seen(light, on_plane(0.05, 0.02));
        Material material;
        const glm::dvec3 normal = glm::dmat3(camera.camera->view) * glm::normalize(kNormal);
        for (int c = 0; c < 3; ++c) material.normal[c] = static_cast<float>(normal[c]);
        expect_runs_on(ReceiverPlanes(camera, light).of_material(material, at), light, at, 1e-5);

        // Depths of the plane in every pixel.
        camera.opaque.emplace();
        camera.opaque->depth.clear();
        for (int y = 0; y < camera.height; ++y)
            for (int x = 0; x < camera.width; ++x) {
                const glm::dvec3 near = LightSpace::world(camera, {x + 0.5, y + 0.5, 0});
                const glm::dvec3 far = LightSpace::world(camera, {x + 0.5, y + 0.5, 1});
                const double along = -glm::dot(near, kNormal) / glm::dot(far - near, kNormal);
                camera.opaque->depth.push_back(
                    static_cast<float>(seen(camera, near + along * (far - near)).z));
            }
        constexpr std::size_t kSample = 24 * 64 + 30;
        const ViewPoint point{30.5, 24.5, static_cast<double>(camera.opaque->depth[kSample])};
        const ViewPoint there = LightSpace(camera, light)(point);
        const auto plane = [&] { return ReceiverPlanes(camera, light).of_opaque(kSample, point, there); };
        expect_runs_on(plane(), light, there, 5e-5);
        // A silhouette to the left and nothing below leave the two other neighbours.
        camera.opaque->depth[kSample - 1] = 0.1f;
        camera.opaque->depth[kSample + 64] = std::numeric_limits<float>::infinity();
        expect_runs_on(plane(), light, there, 5e-5);
        camera.opaque->depth[kSample - 64] = std::numeric_limits<float>::infinity();
        EXPECT_EQ(plane().dx, 0.0) << "nothing is known along one axis";
        EXPECT_EQ(plane().dy, 0.0);
    }
}

TEST(ReceiverPlane, IsNeverSteeperThanItsLimit) {
    const TraceHeader light = view_from({0, 5, 0}, true);  // straight from above
    const ReceiverPlanes planes(light, light);
    Material material;
    material.normal[0] = 1;
    material.normal[2] = 0;  // edge on
    const ReceiverPlane plane = planes.of_material(material, {32, 24, 0.5});
    // A texel is 1/16 across and the range of depth 8.
    const double steepest = std::sqrt(1 - ReceiverPlanes::kLeastCosine * ReceiverPlanes::kLeastCosine) /
                            ReceiverPlanes::kLeastCosine / 16 / 8;
    EXPECT_NEAR(std::abs(plane.dx), steepest, 1e-6);
    EXPECT_NEAR(plane.dy, 0.0, 1e-9);
    material.normal[0] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(planes.of_material(material, {32, 24, 0.5}).dx, 0.0);
}

}  // namespace
}  // namespace ropsim
