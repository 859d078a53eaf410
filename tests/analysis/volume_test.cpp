// Marched media against closed forms: Beer's law, single scattering, height fog, a point light's airlight.
#include "tests/analysis/volume_views.h"

#include <array>
#include <numbers>

namespace ropsim {
namespace {

constexpr double kPi = std::numbers::pi;

VolumeOptions uniform(double extinction, int steps) {
    VolumeOptions options;
    options.medium.extinction = extinction;
    options.steps = steps;
    options.ambient = {0.5, 0.25, 1};
    return options;
}

// In front of the wall, and as far as the far plane where there is none; slant and straight rays.
class UniformFog : public VolumeTest, public testing::WithParamInterface<bool> {};
INSTANTIATE_TEST_SUITE_P(Views, UniformFog, testing::Bool(),
                         [](const auto& view) { return view.param ? "Perspective" : "Orthographic"; });

TEST_P(UniformFog, IsBeersLawAndItsAirlightWhateverTheSteps) {
    TraceHeader header = GetParam() ? perspective_view() : orthographic_view();
    put_wall(header, 7);
    header.camera->metres_per_unit = 0.5f;
    constexpr double kExtinction = 0.3;
    for (const int steps : {1, 2, 7, 64, 1000}) {
        VolumeOptions options = uniform(kExtinction, steps);
        options.medium.albedo = {1, 0.5, 0.25};
        const VolumeSummary summary = march(header, options);
        EXPECT_EQ(summary.pixels, 240u);
        EXPECT_EQ(summary.fragments, 240u * static_cast<unsigned>(steps));
        const auto pixels = by_pixel();
        const Image image = reference();
        for (int y = 0; y < header.height; ++y) {
            for (int x = 0; x < header.width; ++x) {
                const bool wall = 2 * x < header.width;
                const double length =
                    0.5 * ((wall ? 7 : kFar) - kNear) * (GetParam() ? slant(header, x, y) : 1);
                const double left = std::exp(-kExtinction * length);
                const auto& fragments = pixels[static_cast<std::size_t>(y * header.width + x)];
                EXPECT_NEAR(transmittance(fragments), left, 1e-7);
                const std::array<double, 3> behind = {1, 0.5, 0};
                const std::array<double, 3> air = {0.5 * 1, 0.25 * 0.5, 1 * 0.25};
                for (std::size_t c = 0; c < 3; ++c)
                    EXPECT_NEAR(image.pixel(x, y)[c], behind[c] * left + air[c] * (1 - left), 1e-6);
            }
        }
    }
}

TEST_F(VolumeTest, NearAndFarBoundTheMarch) {
    TraceHeader header = orthographic_view();
    put_wall(header, 7);
    VolumeOptions options = uniform(0.25, 8);
    options.near = 3;
    options.far = 5;
    march(header, options);
    for (const auto& fragments : by_pixel()) EXPECT_NEAR(transmittance(fragments), std::exp(-0.5), 1e-6);
    options.near = 10;
    options.far = 20;
    EXPECT_EQ(march(header, options).pixels, 120u) << "nothing before the wall";
    options.near = 0;
    options.medium.extinction = 0;
    EXPECT_EQ(march(header, options).fragments, 0u) << "steps of no extinction are not written";
}

// Colours are exact to the rounding of halves, which thin steps make systematic.
TEST_F(VolumeTest, HalvesRoundEveryStepsColor) {
    TraceHeader header = orthographic_view(8, 8);
    header.color_storage = ColorStorage::kFloat16;
    VolumeOptions options = uniform(0.02, 1024);
    options.ambient = glm::dvec3(0.1);
    const double air = 0.1 * (1 - std::exp(-0.02 * (kFar - kNear)));
    const double through = std::exp(-0.02 * (kFar - kNear));
    const auto relative_error = [&] { return (reference().pixel(3, 3)[0] - 0.25 * through - air) / air; };
    march(header, options);
    EXPECT_LT(std::abs(relative_error()), 5e-4 + 3e-8 / (air / 1024));
    EXPECT_GT(std::abs(relative_error()), 1e-5);
    options.color = ColorStorage::kFloat32;
    march(header, options);
    EXPECT_LT(std::abs(relative_error()), 1e-6);
    EXPECT_EQ(TraceReader(path("out")).header().color_storage, ColorStorage::kFloat32);
}

Camera light_along(const glm::vec3& direction,
                   const glm::mat4& projection = glm::ortho(-9, 9, -9, 9, 1, 50)) {
    Camera light;
    const glm::vec3 up = std::abs(direction.y) > 0.9f ? glm::vec3(0, 0, 1) : glm::vec3(0, 1, 0);
    light.view = glm::lookAt(-20.0f * direction, glm::vec3(0), up);
    light.projection = projection;
    light.near_plane = 1;
    return light;
}

// Light that travels towards the eye has kept its direction, light from behind the eye has turned back.
TEST_F(VolumeTest, AFarLightScattersByThePhaseFunction) {
    TraceHeader header = orthographic_view();
    constexpr double g = 0.6;
    const glm::dvec3 slanted = glm::normalize(glm::dvec3(2, -1, 0.5));
    for (const auto& [direction, cosine] :
         {std::pair(glm::dvec3(0, 0, 1), 1.0), std::pair(glm::dvec3(0, 0, -1), -1.0),
          std::pair(glm::dvec3(0, -1, 0), 0.0), std::pair(slanted, slanted.z)}) {
        header.light = light_along(direction);
        VolumeOptions options = uniform(0.1, 3);
        options.medium.anisotropy = g;
        options.ambient = glm::dvec3(0);
        options.light = {2, 4, 8};
        march(header, options);
        const double phase = (1 - g * g) / (4 * kPi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
        for (const auto& fragments : by_pixel())
            for (const Fragment& f : fragments) {
                const double alpha = f.a;
                EXPECT_NEAR(f.r, 2 * phase * alpha, 1e-6 * phase);
                EXPECT_NEAR(f.b, 8 * phase * alpha, 1e-6 * phase);
            }
    }
}

// Airlight of an isotropic point light a height h off the ray, in a medium too thin to dim anything:
// extinction / (4 pi h) times the angle under which the light sees the ray.
TEST_F(VolumeTest, ANearLightFallsWithTheSquareOfItsDistance) {
    TraceHeader header = orthographic_view(1, 1);
    header.background = {0, 0, 0};
    header.camera->metres_per_unit = 0.5f;
    header.light = light_along({0, -1, 0}, glm::perspective(1.0f, 1.0f, 0.1f, 50.0f));
    header.light->view = glm::lookAt(glm::vec3(0, 3, -10), glm::vec3(0, 0, -10), glm::vec3(1, 0, 0));
    VolumeOptions options = uniform(1e-4, 4096);
    options.ambient = glm::dvec3(0);
    options.light = glm::dvec3(10);
    march(header, options);
    const double h = 0.5 * 3;
    const double angle = std::atan(0.5 * (10 - kNear) / h) + std::atan(0.5 * (kFar - 10) / h);
    const double expected = 10 * 1e-4 / (4 * kPi * h) * angle;
    EXPECT_NEAR(reference().pixel(0, 0)[0], expected, 3e-3 * expected);  // it does dim: 2e-3 at the far end
    header.light->near_plane = 0.1f;
    // Through the light itself the near plane bounds what arrives.
    header.light->view = glm::lookAt(glm::vec3(0, 0, -10), glm::vec3(0, -1, -10), glm::vec3(1, 0, 0));
    march(header, options);
    double brightest = 0;
    const std::vector<Fragment> through_the_light = by_pixel()[0];
    for (const Fragment& f : through_the_light)
        brightest = std::max(brightest, static_cast<double>(f.r) / static_cast<double>(f.a));
    EXPECT_LT(brightest, 10 / (4 * kPi) / (0.05 * 0.05) * 1.001);
    EXPECT_GT(brightest, 10 / (4 * kPi) / (0.05 * 0.05) * 0.9);
}

// Optical depth along a slanted ray through a layer that thins with height, in closed form; the middle of
// each step is a midpoint rule: twice the steps, a quarter of the error.
TEST_F(VolumeTest, HeightFogConvergesToItsIntegral) {
    TraceHeader header = orthographic_view(1, 1);
    const double rise = 0.2;  // of the ray, per metre
    header.camera->view =
        glm::lookAt(glm::vec3(0, 1, 0), glm::vec3(0, 1 + 10 * rise, -10 * std::sqrt(1 - rise * rise)),
                    glm::vec3(0, 1, 0));
    VolumeOptions options = uniform(0.3, 16);
    options.medium.height_falloff = 2;
    options.medium.base_height = 0.5;
    const auto share = [&](double distance) { return std::exp(-(1 + rise * distance - 0.5) / 2); };
    const double depth = 0.3 * 2 / rise * (share(kNear) - share(kFar));
    std::vector<double> errors;
    for (const int steps : {16, 32, 64}) {
        options.steps = steps;
        march(header, options);
        errors.push_back(std::abs(-std::log(transmittance(by_pixel()[0])) - depth));
    }
    EXPECT_LT(errors[0], 0.03 * depth);
    EXPECT_NEAR(errors[0] / errors[1], 4, 0.2);
    EXPECT_NEAR(errors[1] / errors[2], 4, 0.2);
}

}  // namespace
}  // namespace ropsim
