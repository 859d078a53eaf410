// Displacement of the background by refraction, McGuire and Mara 2017, equations 8 to 10, against Snell's law
// by angles in double precision.
#include "tests/rop/phenomenological_scene.h"

#include <numbers>
#include <optional>

#include <glm/gtc/constants.hpp>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::perspective_screen;
using test::Random;
using test::shader_of;

// A view in double precision.
struct View {
    glm::dmat4 projection;
    double width, height;

    explicit View(const Screen& screen)
        : projection(screen.camera->projection), width(screen.width), height(screen.height) {}
    glm::dvec2 pixel(const glm::dvec3& at) const {
        const glm::dvec4 clip = projection * glm::dvec4(at, 1);
        return {(clip.x / clip.w + 1) / 2 * width, (1 - clip.y / clip.w) / 2 * height};
    }
    // Of the centre of pixel (x, y), `distance` scene units along the view.
    glm::dvec3 point(int x, int y, double distance) const {
        const glm::dvec4 clip = projection * glm::dvec4(0, 0, -distance, 1);
        const glm::dvec4 ndc((x + 0.5) / width * 2 - 1, 1 - (y + 0.5) / height * 2, clip.z / clip.w, 1);
        const glm::dvec4 at = glm::inverse(projection) * ndc;
        return glm::dvec3(at) / at.w;
    }
    bool parallel() const { return projection[3][3] == 1; }
};

// By angles: the ray leaves in the plane of incidence at asin(sin i / index) from the normal's other side.
// Nothing where it is reflected totally.
std::optional<glm::dvec3> refracted(const glm::dvec3& to_eye, glm::dvec3 normal, double index) {
    if (glm::dot(normal, to_eye) < 0) normal = -normal;
    const double incidence = std::acos(std::min(glm::dot(normal, to_eye), 1.0));
    const double sine = std::sin(incidence) / index;
    if (sine > 1) return {};
    const glm::dvec3 aside = to_eye - glm::dot(normal, to_eye) * normal;
    const glm::dvec3 tangent = glm::length(aside) < 1e-12 ? glm::dvec3(0) : -glm::normalize(aside);
    return -std::cos(std::asin(sine)) * normal + sine * tangent;
}
glm::dvec2 displacement(const View& view, int x, int y, double distance, const glm::dvec3& normal,
                        double index, double depth) {
    const glm::dvec3 at = view.point(x, y, distance);
    const glm::dvec3 to_eye = view.parallel() ? glm::dvec3(0, 0, 1) : glm::normalize(-at);
    const std::optional<glm::dvec3> ray = refracted(to_eye, normal, index);
    if (!ray || -ray->z < 0.01) return {0, 0};
    return view.pixel(at + *ray * (depth / -ray->z)) - glm::dvec2(x + 0.5, y + 0.5);
}

glm::vec3 any_normal(Random& random) {
    // Draws one after the other: compilers differ in the order of a call's arguments.
    const float z = random.real(0.05, 1);
    const float y = random.real(-1, 1);
    const float x = random.real(-1, 1);
    return glm::normalize(glm::vec3(x, y, z));
}

TEST(PhenomenologicalRefraction, IsSnellsLaw) {
    Camera parallel;
    parallel.projection = glm::ortho(-4.0f, 4.0f, -3.0f, 3.0f, 0.1f, 50.0f);
    for (const Screen& screen : {perspective_screen(1280, 720), test::screen_with(800, 600, parallel)}) {
        const View view(screen);
        const SurfaceShader shader = shader_of("", screen);
        Random random(5);
        int bent = 0;
        for (int i = 0; i < 5000; ++i) {
            const int x = random.integer(0, screen.width - 1), y = random.integer(0, screen.height - 1);
            const float z = test::depth_at(*screen.camera, random.real(0.5, 20));
            const glm::vec3 normal = any_normal(random) * (i % 3 == 0 ? -1.0f : 1.0f);  // either side
            const float index = random.real(0.6, 2.5);
            const double distance =
                -(view.parallel() ? (2 * double{z} - 1 - view.projection[3][2]) / view.projection[2][2]
                                  : view.projection[3][2] / (-(2 * double{z} - 1) - view.projection[2][2]));
            const glm::dvec2 exact = displacement(view, x, y, distance, normal, index, 2);
            const glm::vec2 got = shader.displacement(x, y, z, normal, index);
            const double size = glm::length(exact);
            if (size == 0 || size > 2000) continue;  // at the edges of what is transmitted, or out of sight
            ++bent;
            ASSERT_NEAR(got.x, exact.x, 2e-3 + 3e-4 * size) << i << " index " << index << " at " << distance;
            ASSERT_NEAR(got.y, exact.y, 2e-3 + 3e-4 * size) << i << " index " << index << " at " << distance;
        }
        EXPECT_GT(bent, 4000);
    }
}

// Equation 9 must be the identity where nothing changes; as printed it is the mirror's bisector.
TEST(PhenomenologicalRefraction, AnIndexOfOneBendsNothingUnlessAsPrinted) {
    const Screen screen = perspective_screen(1920, 1080);
    const SurfaceShader snell = shader_of("", screen);
    const SurfaceShader printed = shader_of("refraction=printed", screen);
    Random random(6);
    double worst = 0, least_printed = 1e9;
    for (int i = 0; i < 5000; ++i) {
        const int x = random.integer(0, 1919), y = random.integer(0, 1079);
        const float z = test::depth_at(*screen.camera, random.real(0.5, 50));
        const glm::vec3 normal = any_normal(random);
        worst = std::max(worst, double{glm::length(snell.displacement(x, y, z, normal, 1))});
        const glm::vec3 tilted = glm::normalize(glm::vec3(random.real(0.5, 1), 0, 0.5f));
        least_printed =
            std::min(least_printed, double{glm::length(printed.displacement(960, 540, z, tilted, 1))});
    }
    EXPECT_LT(worst, 5e-3);  // float32 at 1920 pixels, where rays graze
    EXPECT_GT(least_printed, 10);
    // A normal tilted by 45 degrees in the middle of the picture, two metres away: 22.5 degrees off, seen
    // four metres away: 540 / tan 30 * 2 tan 22.5 / 4 = 193.7 pixels.
    const glm::vec3 normal = glm::normalize(glm::vec3(1, 0, 1));
    const glm::vec2 bent = printed.displacement(960, 540, test::depth_at(*screen.camera, 2), normal, 1.0f);
    const double expected = 540 / std::tan(glm::pi<double>() / 6) * 2 * std::tan(glm::pi<double>() / 8) / 4;
    EXPECT_NEAR(std::abs(bent.x), expected, 1.0);  // the pixel's centre is half a pixel off the axis
    // Straight on it is right, as any formula would be.
    EXPECT_NEAR(
        glm::length(printed.displacement(960, 540, test::depth_at(*screen.camera, 2), {0, 0, 1}, 1.5f)),
        glm::length(snell.displacement(960, 540, test::depth_at(*screen.camera, 2), {0, 0, 1}, 1.5f)), 0.5);
}
// Both readings are what fragments export: a fog particle's index is one.
TEST(PhenomenologicalRefraction, ExportsOfAnIndexOfOne) {
    const Screen screen = perspective_screen(640, 480);
    const Fragment f = test::fragment_at(500, 100, 0.9f, 0.5f, {1, 1, 1});
    const Material fog = test::material_of({0, 0, 0}, 0, 1, glm::normalize(glm::vec3(0.5f, 0.5f, 1)));
    for (const std::size_t c : {surface_export::kOffset, surface_export::kOffset + 1}) {
        EXPECT_EQ(shader_of("", screen).shade({f, fog, f.x, f.y, 1})[c], 0.0f);
        EXPECT_NE(shader_of("refraction=printed", screen).shade({f, fog, f.x, f.y, 1})[c], 0.0f);
    }
}

TEST(PhenomenologicalRefraction, TotalReflectionAndRaysThatGoSidewaysShowWhatIsBehind) {
    const Screen screen = perspective_screen(640, 480);
    const SurfaceShader shader = shader_of("", screen);
    const float z = test::depth_at(*screen.camera, 5);
    const auto tilted = [](double degrees) {
        const double a = degrees / 180 * glm::pi<double>();
        return glm::vec3(std::sin(a), 0, std::cos(a));
    };
    // Into matter half as dense the critical angle is 30 degrees; the middle of the picture looks along -z.
    EXPECT_GT(glm::length(shader.displacement(320, 240, z, tilted(29.5), 0.5f)), 100.0f);
    EXPECT_EQ(shader.displacement(320, 240, z, tilted(30.5), 0.5f), glm::vec2(0.0f));
    // Matter so dense that the ray follows the normal, which lies in the plane of the picture.
    EXPECT_EQ(shader.displacement(320, 240, z, tilted(89.9), 1e6f), glm::vec2(0.0f));
    EXPECT_GT(glm::length(shader.displacement(320, 240, z, tilted(80), 1e6f)), 500.0f);
    // Not an index.
    EXPECT_EQ(shader.displacement(320, 240, z, tilted(10), 0), glm::vec2(0.0f));
}

// In the middle the displacement is focal length * depth * slope / (distance + depth).
TEST(PhenomenologicalRefraction, GrowsWithTheDepthBehind) {
    const Screen screen = perspective_screen(641, 481);
    const glm::vec3 normal = glm::normalize(glm::vec3(0.6f, 0, 1));
    for (const double distance : {1.0, 10.0, 90.0}) {
        const float z = test::depth_at(*screen.camera, distance);
        const float two = shader_of("", screen).displacement(320, 240, z, normal, 1.5f).x;
        const float four = shader_of("refraction_depth=4", screen).displacement(320, 240, z, normal, 1.5f).x;
        EXPECT_NEAR(four / two, 2 * (distance + 2) / (distance + 4), 0.002) << distance;
        EXPECT_EQ(shader_of("refraction_depth=0", screen).displacement(320, 240, z, normal, 1.5f).x, 0);
    }
}

// A pane that looks up shows what is farther down, in rows of a greater number; one that looks to the right
// shows what is farther left.
TEST(PhenomenologicalRefraction, DisplacesTheRightWay) {
    const Screen screen = perspective_screen(640, 480);
    const SurfaceShader shader = shader_of("", screen);
    const float z = test::depth_at(*screen.camera, 5);
    EXPECT_GT(shader.displacement(320, 240, z, glm::normalize(glm::vec3(0, 0.5f, 1)), 1.5f).y, 5.0f);
    EXPECT_LT(shader.displacement(320, 240, z, glm::normalize(glm::vec3(0.5f, 0, 1)), 1.5f).x, -5.0f);

    const TraceHeader header = test::pictured(16, 16, 0.999f, [](int, int y) -> std::array<float, 3> {
        return y < 8 ? std::array<float, 3>{1, 0, 0} : std::array<float, 3>{0, 1, 0};
    });
    test::TestFrame frame("phenomenological:refraction_weight=alpha", header);
    const Fragment f = test::fragment_at(8, 6, test::depth_at(*header.camera, 1), 1, {0, 0, 0});
    const Material pane = test::material_of({1, 1, 1}, 1, 1.5f, glm::normalize(glm::vec3(0, 1, 1)));
    frame.draw({&f, 1}, {}, {&pane, 1});
    EXPECT_EQ(frame.color(8, 6), (std::array<float, 3>{0, 1, 0}));
    EXPECT_EQ(frame.color(8, 5), (std::array<float, 3>{1, 0, 0}));
}

}  // namespace
}  // namespace ropsim
