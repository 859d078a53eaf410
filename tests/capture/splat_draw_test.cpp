// Splats as fragments, against the formulas in double precision.
#include "capture/scenery/splat_draw.h"

#include "capture/capture.h"
#include "capture/scenery/scene_parts.h"
#include "tests/capture/splat_ply.h"
#include "tests/capture/test_scene.h"
#include "traces/trace.h"

#include <cmath>
#include <map>

#include <glm/gtc/matrix_transform.hpp>
#include <gmock/gmock.h>

namespace ropsim {
namespace {

constexpr int kWidth = 160;
constexpr int kHeight = 100;

class SplatDrawTest : public testing::OpenGlTest {};

SplatFile one_splat(glm::vec3 position, glm::vec3 scales, glm::quat rotation, float opacity) {
    SplatFile splats;
    splats.positions = {position};
    splats.scales = {scales};
    splats.rotations = {glm::normalize(rotation)};
    splats.opacities = {opacity};
    splats.harmonics = {glm::vec3(0.5f, 0.0f, -0.5f)};
    return splats;
}

Scene scene_of(const SplatFile& splats, const Camera& camera, glm::vec3 eye) {
    Scene scene;
    scene.camera = camera;
    scene.transparent = splat_draws("splats", splats, eye);
    return scene;
}

using Pixels = std::map<std::pair<int, int>, double>;

Pixels alphas_of(const std::vector<Fragment>& fragments) {
    Pixels pixels;
    for (const Fragment& f : fragments)
        EXPECT_TRUE(pixels.emplace(std::pair(int{f.x}, int{f.y}), f.a).second)
            << "two fragments in pixel " << f.x << "," << f.y;
    return pixels;
}

// Alpha at the pixels' centres by the paper's equations (5) and (6): Sigma' = J W Sigma W^T J^T,
// differentiated numerically here, so that no Jacobian is written down twice.
Pixels expected_alphas(const SplatFile& splats, const Camera& camera) {
    const glm::dmat4 whole = glm::dmat4(camera.projection) * glm::dmat4(camera.view);
    const auto to_pixels = [&](glm::dvec3 p) {
        const glm::dvec4 clip = whole * glm::dvec4(p, 1);
        return glm::dvec2((0.5 + 0.5 * clip.x / clip.w) * kWidth, (0.5 - 0.5 * clip.y / clip.w) * kHeight);
    };
    const glm::dvec3 centre(splats.positions[0]);
    const glm::dmat3 axes = glm::mat3_cast(glm::dquat(splats.rotations[0]));
    double xx = 0.3;
    double xy = 0;
    double yy = 0.3;
    for (int axis = 0; axis < 3; ++axis) {
        constexpr double kStep = 1e-5;
        const glm::dvec2 slope =
            (to_pixels(centre + kStep * axes[axis]) - to_pixels(centre - kStep * axes[axis])) / (2 * kStep) *
            static_cast<double>(splats.scales[0][axis]);
        xx += slope.x * slope.x;
        xy += slope.x * slope.y;
        yy += slope.y * slope.y;
    }
    const double determinant = xx * yy - xy * xy;
    const glm::dvec2 middle = to_pixels(centre);
    Pixels pixels;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const glm::dvec2 d = glm::dvec2(x + 0.5, y + 0.5) - middle;
            const double distance = (yy * d.x * d.x - 2 * xy * d.x * d.y + xx * d.y * d.y) / determinant;
            const double alpha = std::min(0.99, splats.opacities[0] * std::exp(-0.5 * distance));
            if (alpha >= 1.0 / 255) pixels[{x, y}] = alpha;
        }
    return pixels;
}

void expect_same(const Pixels& got, const Pixels& expected) {
    EXPECT_GT(expected.size(), 20u);
    for (const auto& [pixel, alpha] : expected) {
        const auto found = got.find(pixel);
        const double drawn = found == got.end() ? 1.0 / 255 : found->second;
        EXPECT_NEAR(drawn, alpha, 2e-4) << pixel.first << "," << pixel.second;
    }
    for (const auto& [pixel, alpha] : got)
        EXPECT_TRUE(expected.count(pixel) == 1 || alpha < 1.002 / 255) << pixel.first << "," << pixel.second;
}

TEST_F(SplatDrawTest, RoundSplatInTheMiddleIsAGaussian) {
    const GlContext context;
    const Camera camera = look_at({0, 0, 5}, {0, 0, 0}, 40, 1.6, 1.0, 0.5f, 50);
    const SplatFile splats = one_splat({0, 0, 0}, glm::vec3(0.2f), glm::quat(1, 0, 0, 0), 0.8f);
    const std::vector<Fragment> fragments =
        testing::capture_all(scene_of(splats, camera, {0, 0, 5}), kWidth, kHeight);
    // Pixels a scene unit at that distance, and the variance in square pixels.
    const double focal = 0.5 * kHeight / std::tan(glm::radians(20.0)) / 5;
    const double variance = 0.2 * 0.2 * focal * focal + 0.3;
    std::size_t expected = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const double square = std::pow(x + 0.5 - kWidth / 2, 2) + std::pow(y + 0.5 - kHeight / 2, 2);
            expected += 0.8 * std::exp(-0.5 * square / variance) >= 1.0 / 255;
        }
    EXPECT_NEAR(static_cast<double>(fragments.size()), static_cast<double>(expected), 4);
    const float depth = 0.5f * (50.0f + 0.5f - 2 * 50.0f * 0.5f / 5.0f) / (50.0f - 0.5f) + 0.5f;
    for (const Fragment& f : fragments) {
        const double square = std::pow(f.x + 0.5 - kWidth / 2, 2) + std::pow(f.y + 0.5 - kHeight / 2, 2);
        EXPECT_NEAR(f.a, 0.8 * std::exp(-0.5 * square / variance), 1e-4);
        // The centre's everywhere; display colours 0.5 + 0.282 * (0.5, 0, -0.5), made linear, times alpha.
        EXPECT_NEAR(f.z, depth, 1e-5);
        EXPECT_NEAR(f.r / f.a, std::pow((0.5 + 0.2820948 / 2 + 0.055) / 1.055, 2.4), 1e-4);
        EXPECT_NEAR(f.g / f.a, 0.2140411, 1e-4);
        EXPECT_NEAR(f.b / f.a, std::pow((0.5 - 0.2820948 / 2 + 0.055) / 1.055, 2.4), 1e-4);
    }
}

TEST_F(SplatDrawTest, TurnedFlatSplatsFollowTheProjection) {
    const GlContext context;
    const glm::vec3 eye(1.2f, 0.7f, 4);
    const Camera camera = look_at(eye, {0, 0, 0}, 50, 1.6, 1.0, 0.5f, 50);
    for (int i = 0; i < 12; ++i) {
        const auto turn = static_cast<float>(i);
        const glm::quat rotation(1 + 0.3f * turn, 0.7f - 0.2f * turn, 0.4f * std::sin(turn),
                                 0.9f * std::cos(turn));
        const SplatFile splats =
            one_splat({0.9f * std::cos(2 * turn), 0.5f * std::sin(3 * turn), 0.3f * turn - 2},
                      {0.3f, 0.08f, 0.01f + 0.02f * turn}, rotation, i % 3 == 0 ? 0.999f : 0.3f);
        expect_same(alphas_of(testing::capture_all(scene_of(splats, camera, eye), kWidth, kHeight)),
                    expected_alphas(splats, camera));
    }
}

TEST_F(SplatDrawTest, OrthographicViewsOfALightAreTheSameFormula) {
    const GlContext context;
    const Camera camera = light_camera(light_direction(), glm::vec3(0), 2.0f);
    const SplatFile splats =
        one_splat({0.3f, -0.2f, 0.1f}, {0.5f, 0.1f, 0.02f}, glm::quat(1, 0.5f, -0.4f, 0.8f), 0.7f);
    expect_same(alphas_of(testing::capture_all(scene_of(splats, camera, {0, 0, 5}), kWidth, kHeight)),
                expected_alphas(splats, camera));
}

TEST_F(SplatDrawTest, FaintOrUnseenSplatsGiveNothing) {
    const GlContext context;
    const Camera camera = look_at({0, 0, 5}, {0, 0, 0}, 40, 1.6, 1.0, 0.5f, 50);
    const glm::quat upright(1, 0, 0, 0);
    for (const SplatFile& splats :
         {one_splat({0, 0, 0}, glm::vec3(0.2f), upright, 0.0039f),  // below 1/255
          one_splat({0, 0, 9}, glm::vec3(0.2f), upright, 0.9f),     // behind the eye
          one_splat({0, 0, 4.7f}, glm::vec3(0.2f), upright, 0.9f),  // before the near plane
          one_splat({0, 0, -60}, glm::vec3(9), upright, 0.9f)})     // beyond the far one
        EXPECT_TRUE(testing::capture_all(scene_of(splats, camera, {0, 0, 5}), kWidth, kHeight).empty());
}

TEST(SplatColorTest, HarmonicsOfDegreeOneFollowTheDirection) {
    // The reference's basis: -y, z, -x.
    const glm::vec3 harmonics[4] = {glm::vec3(0), glm::vec3(0.3f, 0, 0), glm::vec3(0, 0.3f, 0),
                                    glm::vec3(0, 0, 0.3f)};
    const auto display = [](float linear) { return 1.055 * std::pow(linear, 1 / 2.4) - 0.055; };
    const double lobe = 0.3 * std::sqrt(3 / (4 * 3.14159265358979));
    EXPECT_NEAR(display(splat_color(harmonics, 1, {0, 1, 0}).r), 0.5 - lobe, 1e-5);
    EXPECT_NEAR(display(splat_color(harmonics, 1, {0, 0, 1}).g), 0.5 + lobe, 1e-5);
    EXPECT_NEAR(display(splat_color(harmonics, 1, {1, 0, 0}).b), 0.5 - lobe, 1e-5);
}

TEST(SplatColorTest, BasisIsOrthonormal) {
    // Products of basis functions, integrated over the sphere by the Fibonacci lattice.
    constexpr int kDirections = 20000;
    double products[16][16] = {};
    for (int i = 0; i < kDirections; ++i) {
        const double z = 1 - (2.0 * i + 1) / kDirections;
        const double angle = 2.399963229728653 * i;
        const double out = std::sqrt(1 - z * z);
        const glm::vec3 direction(out * std::cos(angle), out * std::sin(angle), z);
        double basis[16];
        for (int term = 0; term < 16; ++term) {
            glm::vec3 harmonics[16] = {};
            // Small, so that no clamping or bend of the transfer function matters.
            harmonics[term] = glm::vec3(0.1f);
            const double linear = splat_color(harmonics, 3, direction).r;
            basis[term] = (1.055 * std::pow(linear, 1 / 2.4) - 0.055 - 0.5) / 0.1;
        }
        for (int a = 0; a < 16; ++a)
            for (int b = 0; b < 16; ++b)
                products[a][b] += basis[a] * basis[b] * 4 * 3.14159265358979 / kDirections;
    }
    for (int a = 0; a < 16; ++a)
        for (int b = 0; b < 16; ++b) EXPECT_NEAR(products[a][b], a == b ? 1 : 0, 2e-3) << a << " " << b;
}

TEST(SplatCopiesTest, ThinningAndCloningFollowTheCount) {
    SplatFile splats;
    for (int i = 0; i < 20000; ++i) {
        splats.positions.emplace_back(i, 0, 0);
        splats.scales.emplace_back(0.5f, 0.1f, 0.1f);
        splats.rotations.emplace_back(1, 0, 0, 0);
        splats.opacities.push_back(0.5f);
        splats.harmonics.emplace_back(0.1f);
    }
    for (const double count : {0.1, 0.5, 1.0, 1.7, 3.0}) {
        const SplatFile other = thinned_or_cloned(splats, count, 3);
        EXPECT_NEAR(static_cast<double>(other.size()), 20000 * count, 250) << count;
        EXPECT_EQ(other.harmonics.size(), other.size());
        for (const glm::vec3& p : other.positions) EXPECT_LE(std::fabs(p.x - std::round(p.x)), 0.2501f);
    }
    EXPECT_EQ(thinned_or_cloned(splats, 1, 3).positions, splats.positions);
}

TEST_F(SplatDrawTest, FilesAreCapturedAndSeenFromInFront) {
    // A red splat nearer to COLMAP's camera (smaller z) than a blue one, and a green one above (smaller y).
    std::vector<testing::PlyProperty> properties;
    const auto add = [&](const char* name, std::vector<double> values) {
        properties.push_back({"float", name, std::move(values)});
    };
    add("x", {0, 0, 0});
    add("y", {0, 0, -1});
    add("z", {-1, 1, 0});
    add("f_dc_0", {1.5, -1.5, -1.5});
    add("f_dc_1", {-1.5, -1.5, 1.5});
    add("f_dc_2", {-1.5, 1.5, -1.5});
    add("opacity", {2, 2, 2});
    for (const char* name : {"scale_0", "scale_1", "scale_2"}) add(name, {-2, -2, -2});
    add("rot_0", {1, 1, 1});
    for (const char* name : {"rot_1", "rot_2", "rot_3"}) add(name, {0, 0, 0});
    const std::string file = ::testing::TempDir() + "/three_splats.ply";
    testing::write_bytes(file, testing::splat_ply(properties));
    CaptureOptions options;
    options.scene_or_file = file;
    options.size = {kWidth, kHeight};
    const std::string trace = ::testing::TempDir() + "/three_splats.trace";
    capture_scene(options, trace);
    TraceReader reader(trace);
    EXPECT_THAT(reader.header().scene, ::testing::HasSubstr("3 splats"));
    double depth[3] = {};
    double height[3] = {};
    double weight[3] = {};
    std::vector<Fragment> chunk;
    while (reader.next(chunk))
        for (const Fragment& f : chunk) {
            const int color = f.r > f.g && f.r > f.b ? 0 : (f.b > f.g ? 1 : 2);
            depth[color] += f.a * f.z;
            height[color] += f.a * f.y;
            weight[color] += f.a;
        }
    for (int color = 0; color < 3; ++color) {
        ASSERT_GT(weight[color], 0) << color;
        depth[color] /= weight[color];
        height[color] /= weight[color];
    }
    EXPECT_LT(depth[0], depth[1]);
    EXPECT_LT(height[2], height[0]);
    EXPECT_LT(height[2], height[1]);
}

}  // namespace
}  // namespace ropsim
