// The medium's functions against integrals and the C library, and the rays of a view against its matrices.
#include "analysis/volume_medium.h"

#include "analysis/volume_ray.h"

#include <cmath>
#include <numbers>

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

// Simpson's rule over the cosine; the sphere's area element is 2 pi times the cosine's.
template <typename Function>
double over_the_sphere(const Function& function) {
    constexpr int kIntervals = 200000;
    double sum = 0;
    for (int i = 0; i <= kIntervals; ++i) {
        const double cosine = -1 + 2.0 * i / kIntervals;
        const int weight = i == 0 || i == kIntervals ? 1 : i % 2 == 1 ? 4 : 2;
        sum += weight * function(cosine);
    }
    return 2 * std::numbers::pi * sum * (2.0 / kIntervals) / 3;
}

TEST(HenyeyGreenstein, IntegratesToOneAndHasItsMeanCosine) {
    for (const double g : {-0.95, -0.5, 0.0, 0.1, 0.76, 0.95}) {
        EXPECT_NEAR(over_the_sphere([&](double cosine) { return henyey_greenstein(cosine, g); }), 1, 1e-9)
            << g;
        EXPECT_NEAR(over_the_sphere([&](double cosine) { return cosine * henyey_greenstein(cosine, g); }), g,
                    1e-9)
            << g;
    }
}

TEST(HenyeyGreenstein, IsolatedValues) {
    EXPECT_DOUBLE_EQ(henyey_greenstein(0.3, 0), 1 / (4 * std::numbers::pi));
    // (1 - g^2) / (1 -+ g)^3 forwards and backwards.
    EXPECT_NEAR(henyey_greenstein(1, 0.5), 6 / (4 * std::numbers::pi), 1e-14);
    EXPECT_NEAR(henyey_greenstein(-1, 0.5), (0.75 / 3.375) / (4 * std::numbers::pi), 1e-14);
    // Where g is next to 1 and rounding takes the cosine past it.
    const double g = std::nextafter(1.0, 0.0);
    EXPECT_TRUE(std::isfinite(henyey_greenstein(1 + 1e-15, g)));
    EXPECT_GT(henyey_greenstein(1 + 1e-15, g), 1e29);
}

TEST(VolumeMedium, AbsorbedShareKeepsItsBitsWhereItIsSmall) {
    for (double depth = 1e-12; depth < 1e3; depth *= 1.37) {
        const double exact = -std::expm1(-depth);
        EXPECT_NEAR(absorbed_share(depth), exact, 1e-14 * exact) << depth;
    }
    EXPECT_EQ(absorbed_share(0), 0);
    EXPECT_EQ(absorbed_share(1e300), 1);
}

TEST(VolumeMedium, ExtinctionFallsAboveItsBaseAlone) {
    VolumeMedium medium;
    medium.extinction = 0.5;
    EXPECT_EQ(extinction_at(medium, 100), 0.5);
    medium.height_falloff = 2;
    medium.base_height = 3;
    EXPECT_EQ(extinction_at(medium, -7), 0.5);
    EXPECT_EQ(extinction_at(medium, 3), 0.5);
    EXPECT_NEAR(extinction_at(medium, 5), 0.5 * std::exp(-1), 1e-15);
    EXPECT_EQ(extinction_at(medium, 1e9), 0);
}

TraceHeader view_of(const glm::mat4& projection) {
    TraceHeader header;
    header.width = 20;
    header.height = 12;
    header.camera.emplace();
    header.camera->view = glm::lookAt(glm::vec3(3, 2, 5), glm::vec3(0.3f, 0.2f, 0), glm::vec3(0, 1, 0));
    header.camera->projection = projection;
    header.camera->metres_per_unit = 0.25f;
    return header;
}

// Points along the ray, rasterised by the view's own matrices, fall on the pixel's centre at the ray's depth.
void expect_rays_match(const TraceHeader& header) {
    const PixelRays rays(header);
    ASSERT_TRUE(rays.valid());
    const glm::dmat4 to_clip = glm::dmat4(header.camera->projection) * glm::dmat4(header.camera->view);
    for (int y = 0; y < header.height; y += 3) {
        for (int x = 0; x < header.width; x += 3) {
            const PixelRay ray = rays(x, y);
            for (const double distance : {0.2, 0.9, 4.0}) {
                const glm::dvec4 clip = to_clip * glm::dvec4(ray.at(distance), 1);
                EXPECT_NEAR((clip.x / clip.w + 1) / 2 * header.width, x + 0.5, 1e-5);
                EXPECT_NEAR((1 - clip.y / clip.w) / 2 * header.height, y + 0.5, 1e-5);
                const double depth = (clip.z / clip.w + 1) / 2;
                EXPECT_NEAR(ray.depth(distance), depth, 1e-6);
                EXPECT_NEAR(ray.distance(ray.depth(distance)), distance, 1e-9);
            }
            EXPECT_NEAR(glm::length(ray.direction), 4, 1e-6) << "world units a metre";
            EXPECT_NEAR(glm::length(ray.to_eye), 1, 1e-12);
        }
    }
}

TEST(PixelRay, PerspectiveDistancesAreFromTheEye) {
    const TraceHeader header = view_of(glm::perspective(0.7f, 1.6f, 0.5f, 40.0f));
    expect_rays_match(header);
    const PixelRays rays(header);
    const PixelRay corner = rays(0, 0);
    EXPECT_LT(glm::length(corner.origin - glm::dvec3(3, 2, 5)), 1e-5);
    // The near plane is met farther from the eye in the corner, by 1 / cos.
    const double cosine = corner.to_eye.z;
    EXPECT_LT(cosine, 0.9);
    EXPECT_NEAR(corner.distance(0), 0.25 * 0.5 / cosine, 1e-6);
    EXPECT_NEAR(corner.distance(1), 0.25 * 40 / cosine, 1e-4);
}

TEST(PixelRay, OrthographicDistancesAreFromTheEyesPlane) {
    const TraceHeader header = view_of(glm::ortho(-2.0f, 2.0f, -1.0f, 1.0f, 0.5f, 40.0f));
    expect_rays_match(header);
    const PixelRays rays(header);
    for (const PixelRay& ray : {rays(0, 0), rays(19, 11)}) {
        EXPECT_NEAR(ray.to_eye.z, 1, 1e-12);
        EXPECT_NEAR(ray.distance(0), 0.25 * 0.5, 1e-6);
        EXPECT_NEAR(ray.distance(1), 0.25 * 40, 1e-5);
    }
}

TEST(PixelRay, AFarPlaneAtInfinityIsNeverReached) {
    const PixelRays rays(view_of(glm::infinitePerspective(0.7f, 1.6f, 0.5f)));
    ASSERT_TRUE(rays.valid());
    EXPECT_EQ(rays(3, 3).distance(1), std::numeric_limits<double>::infinity());
    EXPECT_NEAR(rays(3, 3).distance(0), 0.25 * 0.5 / rays(3, 3).to_eye.z, 1e-6);
}

TEST(PixelRay, MatricesThatCannotBeInvertedAreNotValid) {
    EXPECT_FALSE(PixelRays(view_of(glm::mat4(0.0f))).valid());
    TraceHeader flat = view_of(glm::perspective(0.7f, 1.6f, 0.5f, 40.0f));
    flat.camera->view = glm::mat4(0.0f);
    EXPECT_FALSE(PixelRays(flat).valid());
    TraceHeader no_scale = view_of(glm::perspective(0.7f, 1.6f, 0.5f, 40.0f));
    no_scale.camera->metres_per_unit = 0;
    EXPECT_FALSE(PixelRays(no_scale).valid());
}

}  // namespace
}  // namespace ropsim
