// The shader of phenomenological transparency against the equations of McGuire and Mara 2017, section 4, in
// double precision.
#include "tests/rop/phenomenological_scene.h"

#include <numbers>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::perspective_screen;
using test::Random;
using test::shader_of;

constexpr double kPi = std::numbers::pi;

double equation_5(double z, double net) {
    return std::min(std::max(std::pow(10 * (1 - 0.99 * z) * net, 3), 0.01), 30.0);
}

TEST(PhenomenologicalWeight, IsEquation5) {
    const Screen screen = perspective_screen(64, 64);
    const SurfaceShader shader = shader_of("", screen);
    const SurfaceShader listing = shader_of("weight=listing", screen);
    const SurfaceShader g3d = shader_of("weight=g3d", screen);
    EXPECT_NEAR(shader.weight(0.5f, 0.5f), 16.098453125, 1e-5);  // 2.525^3
    EXPECT_FLOAT_EQ(shader.weight(0.2f, 0.0f), 0.01f);
    EXPECT_FLOAT_EQ(shader.weight(1.0f, 1.0f), 0.01f);  // .1^3 = .001 is below the floor
    EXPECT_FLOAT_EQ(shader.weight(0.0f, 1.0f), 30.0f);
    // The floor's end at z = 0: net = cbrt(.01) / 10.
    EXPECT_FLOAT_EQ(shader.weight(0.0f, 0.0215f), 0.01f);
    EXPECT_GT(shader.weight(0.0f, 0.0216f), 0.01005f);
    Random random(1);
    for (int i = 0; i < 2000; ++i) {
        const float z = random.real(0, 1), net = random.real(0, 1);
        const double w = equation_5(z, net);
        // What .99 z is rounded by is a hundred times as much of 1 - .99 z near the far plane, and the cube
        // triples it.
        const double tolerance = 3 * 1.2e-7 / (1 - 0.99 * z) + 1e-6;
        ASSERT_NEAR(shader.weight(z, net), w, tolerance * w) << z << " " << net;
        ASSERT_EQ(shader.weight(z, net), listing.weight(z, net));
        // As the engine the paper points to ships it (G3D 10, DefaultRenderer_OIT_writePixel).
        const double by_depth = std::clamp(1e4 * std::pow(1 - 0.99 * z, 3), 1e-3, 1.0);
        ASSERT_NEAR(g3d.weight(z, net), std::clamp(net * by_depth, 1e-3, 150.0), 3e-5 * by_depth);
    }
}

TEST(PhenomenologicalShader, ExportsAreListing1WithoutItsThird) {
    const Screen screen = perspective_screen(64, 64);
    const SurfaceShader shader = shader_of("", screen);
    const SurfaceShader third = shader_of("beta=third", screen);
    Random random(2);
    for (int i = 0; i < 500; ++i) {
        const Fragment f = test::fragment_at(3, 5, random.real(0.01, 0.99), random.real(0, 1),
                                             {random.real(0, 4), random.real(0, 1), random.real(0, 1)});
        const Material m =
            test::material_of({random.real(0, 1), random.real(0, 1), random.real(0, 1)}, random.real(0, 1));
        const Exports e = shader.shade({f, m, f.x, f.y, 0.995f});
        const double mean = (double{m.transmission[0]} + m.transmission[1] + m.transmission[2]) / 3;
        const double net = f.a * (1 - mean);
        const double w = equation_5(f.z, net);
        const std::array<float, 3> premultiplied = {f.r, f.g, f.b};
        for (std::size_t c = 0; c < 3; ++c) {
            ASSERT_NEAR(e[surface_export::kColor + c], w * premultiplied[c], 4e-6 * w * premultiplied[c]);
            const double absorbed = f.a * (1.0 - m.transmission[c]);
            ASSERT_NEAR(e[surface_export::kAbsorbed + c], absorbed, 1e-7);
            ASSERT_NEAR(third.shade({f, m, f.x, f.y, 0.995f})[surface_export::kAbsorbed + c], absorbed / 3,
                        1e-7);
        }
        ASSERT_NEAR(e[surface_export::kNet], w * net, 4e-6 * w);
        const double d = shader.deviation(f.z, 0.995f, m.collimation, f.a) / 63;
        ASSERT_NEAR(e[surface_export::kDiffusion], d * d, 1e-6 * d * d);
    }
}

// Equation 2 over stacks of up to 30 surfaces, as blended into a target of floats.
TEST(PhenomenologicalShader, BetaIsTheProductOfEquation2) {
    Random random(3);
    for (int stack = 0; stack < 50; ++stack) {
        test::TestFrame frame("phenomenological:format=float32", test::with_materials(test::header_of(1, 1)));
        std::vector<Fragment> fragments;
        std::array<double, 3> beta{1, 1, 1};
        std::array<double, 3> rounding{1e-6, 1e-6, 1e-6};  // relative
        std::vector<Material> materials;
        for (int i = random.integer(1, 30); i > 0; --i) {
            fragments.push_back(test::fragment_at(0, 0, random.real(0.1, 0.9), random.real(0, 1), {1, 1, 1}));
            materials.push_back(test::material_of({random.real(0, 1), random.real(0, 1), random.real(0, 1)}));
            for (std::size_t c = 0; c < 3; ++c) {
                const double a = fragments.back().a;
                const double left = 1 - a + a * materials.back().transmission[c];
                beta[c] *= left;
                rounding[c] += 1.2e-7 / left;  // of 1 - alpha (1 - t)
            }
        }
        frame.draw(fragments, {}, materials);
        for (std::size_t c = 0; c < 3; ++c)
            ASSERT_NEAR(test::word(frame, 0, 0, 4 + c), beta[c], rounding[c] * beta[c]);
    }
}

// By hand: 1080 rows at 60 degrees are 540 / tan 30 = 935.31 pixels a metre at one metre.
TEST(PhenomenologicalDiffusion, IsEquation7AndEquation6OfAPerspectiveView) {
    const Screen screen = perspective_screen(1920, 1080);
    const Camera& camera = *screen.camera;
    const SurfaceShader shader = shader_of("", screen);
    const double pixels = 540 / std::tan(kPi / 6);
    const float near = test::depth_at(camera, 2);
    // Two metres away, half a metre (k1) in front of the background: half of the whole.
    EXPECT_NEAR(shader.deviation(near, test::depth_at(camera, 2.5), 0, 1), pixels * 0.128 / 2 / 2, 0.02);
    EXPECT_NEAR(shader.deviation(near, test::depth_at(camera, 2.5), 0.75f, 0.5f), pixels * 0.128 / 32, 0.005);
    // An infinite background, of either reading, and where nothing opaque was drawn.
    const SurfaceShader infinite = shader_of("background=infinite", screen);
    EXPECT_NEAR(infinite.deviation(near, test::depth_at(camera, 2.5), 0, 1), pixels * 0.128 / 2, 0.02);
    EXPECT_NEAR(shader.deviation(near, std::numeric_limits<float>::infinity(), 0, 1), pixels * 0.128 / 2,
                0.02);
    // At one metre the listing's k0 gives 120 pixels, which is where .128 metres come from.
    EXPECT_NEAR(shader.deviation(test::depth_at(camera, 1), 2.0f, 0, 1), 120, 0.5);
    // Equation 7 itself.
    Random random(4);
    for (int i = 0; i < 1000; ++i) {
        const double x = random.real(0.2, 20), b = x + random.real(0.01, 20);
        const double c = random.real(0, 1), alpha = random.real(0, 1);
        const double exact = pixels * 0.128 * (1 - c) * alpha * (1 - 1 / (1 + std::abs(x - b) / 0.5)) / x;
        const float d = shader.deviation(test::depth_at(camera, x), test::depth_at(camera, b),
                                         static_cast<float>(c), static_cast<float>(alpha));
        // A depth of float32 is known to 6e-8, of which 20 metres are 20^2 / .1 times as much.
        const double known = 6e-8 * b * b / 0.1;
        ASSERT_NEAR(d, exact, exact * (1e-5 + 3 * known / (b - x) + known / x)) << x << " " << b;
    }
}

TEST(PhenomenologicalDiffusion, OfAParallelViewDoesNotShrinkWithDistance) {
    Camera camera;
    camera.projection = glm::ortho(-4.0f, 4.0f, -3.0f, 3.0f, 0.0f, 100.0f);
    const SurfaceShader shader = shader_of("background=infinite", test::screen_with(800, 600, camera));
    EXPECT_NEAR(shader.deviation(0.1f, 2.0f, 0, 1), 12.8, 1e-4);  // 100 pixels a metre
    EXPECT_NEAR(shader.deviation(0.9f, 2.0f, 0, 1), 12.8, 1e-4);
    camera.metres_per_unit = 0.5f;
    const SurfaceShader half = shader_of("", test::screen_with(800, 600, camera));
    // Ten units in front of the background are five metres, of which k1 is a tenth.
    EXPECT_NEAR(half.deviation(0.1f, 0.2f, 0, 1), 25.6 / 1.1, 1e-3);
}

// What hangs on the size of the picture does so linearly: the same scene with thrice the pixels, at pixels
// whose centres coincide.
TEST(PhenomenologicalShader, PixelsScaleWithTheImage) {
    const Screen small = perspective_screen(320, 180), large = perspective_screen(960, 540);
    const SurfaceShader coarse = shader_of("", small), fine = shader_of("", large);
    const float z = test::depth_at(*small.camera, 3);
    const glm::vec3 normal = glm::normalize(glm::vec3(0.3f, -0.5f, 1));
    for (const auto& [x, y] : {std::pair(160, 90), std::pair(0, 0), std::pair(319, 20)}) {
        const glm::vec2 a = coarse.displacement(x, y, z, normal, 1.5f);
        const glm::vec2 b = fine.displacement(3 * x + 1, 3 * y + 1, z, normal, 1.5f);
        EXPECT_NEAR(b.x, 3 * a.x, 1e-3);
        EXPECT_NEAR(b.y, 3 * a.y, 1e-3);
        EXPECT_GT(std::abs(a.x), 2.0f);
    }
    EXPECT_NEAR(fine.deviation(z, 2.0f, 0.5f, 1), 3 * coarse.deviation(z, 2.0f, 0.5f, 1), 1e-4);
}

// Two surfaces in registers: sums, and what is left of beta multiplied.
TEST(PhenomenologicalShader, JoinedExportsAreSumsAndAProduct) {
    const SurfaceShader shader = shader_of("", perspective_screen(64, 64));
    Exports a{}, b{};
    for (std::size_t i = 0; i < kMaxExports; ++i) {
        a[i] = 0.0625f * static_cast<float>(i + 1);
        b[i] = 0.5f - 0.03125f * static_cast<float>(i);
    }
    const Exports both = shader.joined(a, b);
    for (std::size_t i = 0; i < kMaxExports; ++i) {
        const bool multiplied = i >= surface_export::kAbsorbed && i < surface_export::kDiffusion;
        EXPECT_FLOAT_EQ(both[i], multiplied ? 1 - (1 - a[i]) * (1 - b[i]) : a[i] + b[i]) << i;
    }
}

}  // namespace
}  // namespace ropsim
