// Captures with several spatial samples: coverage and depth of hand-made triangles against their edges and
// planes.
#include "base/random.h"
#include "capture/opaque_pass.h"
#include "tests/capture/test_scene.h"
#include "traces/depth_test.h"
#include "traces/sample_positions.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <span>
#include <tuple>

namespace ropsim {
namespace {

using testing::capture_chunk;
using testing::window_draw;
using testing::WindowTriangle;

class SampledCaptureTest : public testing::OpenGlTest {};

constexpr int kWidth = 61;
constexpr int kHeight = 45;

std::vector<WindowTriangle> random_triangles(std::uint32_t count) {
    std::vector<WindowTriangle> list(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto unit = [&](std::uint32_t draw) { return random_unit(mix64(i + 77), draw); };
        const float size = i % 4 == 0 ? 60.0f : 5.0f;
        for (std::uint32_t c = 0; c < 3; ++c)
            list[i].corners[c] = {kWidth * unit(0) + size * (unit(3 * c + 1) - 0.5f),
                                  kHeight * unit(20) + size * (unit(3 * c + 2) - 0.5f),
                                  0.2f + 0.6f * unit(3 * c + 3)};
    }
    return list;
}

// Signed distance in pixels from the triangle's nearest edge line, positive inside; and its depth plane
// there.
struct TriangleFacts {
    double inside;
    double depth;
    double dx, dy;
};

TriangleFacts facts_at(const WindowTriangle& triangle, double x, double y) {
    const glm::dvec3 a(triangle.corners[0]);
    const glm::dvec3 b(triangle.corners[1]);
    const glm::dvec3 c(triangle.corners[2]);
    const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    const auto edge = [&](const glm::dvec3& p, const glm::dvec3& q) {
        const double cross = (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x);
        return std::copysign(1.0, area) * cross / std::hypot(q.x - p.x, q.y - p.y);
    };
    TriangleFacts facts{};
    facts.inside = std::min({edge(a, b), edge(b, c), edge(c, a)});
    facts.dx = ((b.z - a.z) * (c.y - a.y) - (c.z - a.z) * (b.y - a.y)) / area;
    facts.dy = ((c.z - a.z) * (b.x - a.x) - (b.z - a.z) * (c.x - a.x)) / area;
    facts.depth = a.z + facts.dx * (x - a.x) + facts.dy * (y - a.y);
    return facts;
}

using Key = std::tuple<std::uint32_t, int, int>;

TEST_F(SampledCaptureTest, CoverageIsThatOfTheStandardPositions) {
    const GlContext context;
    const std::vector<WindowTriangle> triangles = random_triangles(120);
    Scene scene;
    scene.transparent.push_back(window_draw(triangles, kWidth, kHeight, {0.5f, 0.25f, 0.125f, 0.5f}));
    for (const int samples : {2, 4, 8, 16}) {
        const FragmentChunk chunk = capture_chunk(scene, kWidth, kHeight, samples);
        std::map<Key, std::uint32_t> masks;
        for (const Fragment& f : chunk.fragments) {
            EXPECT_NE(f.coverage, 0);
            EXPECT_TRUE(masks.emplace(Key(primitive_number(f), f.x, f.y), f.coverage).second)
                << "one a pixel";
        }
        int wrong = 0;
        int undecided = 0;
        int decided = 0;
        for (std::uint32_t t = 0; t < triangles.size(); ++t)
            for (int y = 0; y < kHeight; ++y)
                for (int x = 0; x < kWidth; ++x) {
                    const auto found = masks.find(Key(t, x, y));
                    const std::uint32_t mask = found == masks.end() ? 0 : found->second;
                    for (int m = 0; m < samples; ++m) {
                        const SamplePosition at = sample_positions(samples)[static_cast<std::size_t>(m)];
                        const double inside = facts_at(triangles[t], x + 0.5 + static_cast<double>(at.x()),
                                                       y + 0.5 + static_cast<double>(at.y()))
                                                  .inside;
                        // A corner is snapped to a grid of 1/256 pixel (1/128 far edges' slack).
                        if (std::fabs(inside) < 1.0 / 128) {
                            ++undecided;
                            continue;
                        }
                        ++decided;
                        wrong += (inside > 0) != ((mask >> m & 1) != 0);
                    }
                }
        EXPECT_EQ(wrong, 0) << samples << " samples, of " << decided;
        EXPECT_LT(undecided, decided / 100);
    }
}

TEST_F(SampledCaptureTest, DepthsAreThoseOfThePlaneAtEverySample) {
    const GlContext context;
    std::vector<WindowTriangle> triangles = random_triangles(120);
    // Slivers have slopes beyond what depths of 24 bits can tell.
    std::erase_if(triangles, [](const WindowTriangle& t) {
        const TriangleFacts facts = facts_at(t, 0, 0);
        return std::fabs(facts.dx) > 0.1 || std::fabs(facts.dy) > 0.1;
    });
    ASSERT_GT(triangles.size(), 40u);
    Scene scene;
    scene.transparent.push_back(window_draw(triangles, kWidth, kHeight, {0.5f, 0.25f, 0.125f, 0.5f}));
    const FragmentChunk chunk = capture_chunk(scene, kWidth, kHeight, 4);
    ASSERT_EQ(chunk.slopes.size(), chunk.size());
    for (std::size_t i = 0; i < chunk.size(); ++i) {
        const Fragment& f = chunk.fragments[i];
        for (int m = 0; m < 4; ++m) {
            if ((f.coverage >> m & 1) == 0) continue;
            const SamplePosition at = sample_positions(4)[static_cast<std::size_t>(m)];
            const TriangleFacts facts =
                facts_at(triangles[primitive_number(f)], f.x + 0.5 + static_cast<double>(at.x()),
                         f.y + 0.5 + static_cast<double>(at.y()));
            // Corners move by up to 1/512 pixel on the rasteriser's grid, twice that where two of them do.
            const double tolerance = 1e-6 + (std::fabs(facts.dx) + std::fabs(facts.dy)) / 128;
            EXPECT_NEAR(sample_depth(f, chunk.slopes[i], at), facts.depth, tolerance);
        }
        const TriangleFacts facts = facts_at(triangles[primitive_number(f)], f.x + 0.5, f.y + 0.5);
        EXPECT_NEAR(chunk.slopes[i].dx, facts.dx, 2e-6 + 0.02 * std::fabs(facts.dx));
        EXPECT_NEAR(chunk.slopes[i].dy, facts.dy, 2e-6 + 0.02 * std::fabs(facts.dy));
    }
}

TEST_F(SampledCaptureTest, WhereTheCentreIsCoveredTheFragmentIsThatOfOneSample) {
    const GlContext context;
    Scene scene;
    scene.transparent.push_back(
        window_draw(random_triangles(120), kWidth, kHeight, {0.5f, 0.25f, 0.125f, 0.5f}));
    const FragmentChunk one = capture_chunk(scene, kWidth, kHeight, 1);
    EXPECT_TRUE(one.slopes.empty());
    std::map<Key, Fragment> centres;
    for (const Fragment& f : one.fragments) centres[Key(primitive_number(f), f.x, f.y)] = f;
    for (const int samples : {2, 16}) {
        std::size_t found = 0;
        for (Fragment f : capture_chunk(scene, kWidth, kHeight, samples).fragments) {
            const auto centre = centres.find(Key(primitive_number(f), f.x, f.y));
            if (centre == centres.end()) continue;
            ++found;
            f.coverage = 1;
            EXPECT_TRUE(std::ranges::equal(std::as_bytes(std::span(&f, 1)),
                                           std::as_bytes(std::span(&centre->second, 1))));
        }
        EXPECT_GT(found, one.size() * 9 / 10);
    }
}

TEST_F(SampledCaptureTest, PiecesOfAnySizeGiveTheSameFragments) {
    const GlContext context;
    Scene scene;
    scene.transparent.push_back(
        window_draw(random_triangles(60), kWidth, kHeight, {0.5f, 0.25f, 0.125f, 0.5f}, 2, 3));
    FragmentCaptureCounts whole;
    const FragmentChunk expected = capture_chunk(scene, kWidth, kHeight, 4, {}, &whole);
    FragmentCaptureCounts split;
    const FragmentChunk pieces = capture_chunk(scene, kWidth, kHeight, 4, {320, 2}, &split);
    EXPECT_GT(split.retries, 0u);
    ASSERT_EQ(pieces.size(), expected.size());
    EXPECT_EQ(
        std::memcmp(pieces.fragments.data(), expected.fragments.data(), expected.size() * sizeof(Fragment)),
        0);
}

TEST_F(SampledCaptureTest, OpaqueSamplesSeeTheEdge) {
    const GlContext context;
    Scene scene;
    scene.background = {0.1f, 0.2f, 0.3f};
    // Left of x = 4.25: the samples of column 4 with x below .25, i.e. less than -4/16 from the centre.
    scene.opaque.push_back(window_draw({{{{-50, -50, 0.5f}, {4.25f, -50, 0.5f}, {4.25f, 60, 0.5f}}},
                                        {{{-50, -50, 0.5f}, {4.25f, 60, 0.5f}, {-50, 60, 0.5f}}}},
                                       12, 10, {1, 0, 0, 1}));
    const OpaqueLayer layer = draw_opaque_layer(scene, 12, 10, 8);
    ASSERT_EQ(layer.depth.size(), 960u);
    ASSERT_EQ(layer.rgb.size(), 2880u);
    for (int x = 0; x < 12; ++x)
        for (std::size_t m = 0; m < 8; ++m) {
            const std::size_t i = (std::size_t{5} * 12 + static_cast<std::size_t>(x)) * 8 + m;
            const bool covered = static_cast<float>(x) + 0.5f + sample_positions(8)[m].x() < 4.25f;
            EXPECT_EQ(layer.depth[i], covered ? 0.5f : std::numeric_limits<float>::infinity()) << x << m;
            EXPECT_EQ(layer.rgb[3 * i], covered ? 1.0f : 0.1f);
        }
}

TEST_F(SampledCaptureTest, MaterialsComeInCameraSpace) {
    const GlContext context;
    Scene scene;
    scene.transparent.push_back(
        window_draw({{{{0, 0, 0.5f}, {32, 0, 0.5f}, {0, 32, 0.5f}}}}, 16, 16, {1, 1, 1, 0.5f}));
    scene.transparent[0].shading =
        "uniform vec4 u_parameters[8];\n"
        "vec4 shade() { surface_transmission = vec3(0.25, 0.5, 2.0); surface_collimation = 0.75;\n"
        "  surface_eta = 1.5; surface_normal = vec3(0.0, 3.0, 0.0); return u_parameters[0]; }\n";
    scene.camera.view = glm::mat4(0.0f);  // turns world +y into camera +z
    scene.camera.view[0][0] = 1;
    scene.camera.view[1][2] = 1;
    scene.camera.view[2][1] = -1;
    scene.camera.view[3][3] = 1;
    EXPECT_TRUE(capture_chunk(scene, 16, 16, 1).materials.empty());
    scene.materials = true;
    for (const int samples : {1, 4}) {
        const FragmentChunk chunk = capture_chunk(scene, 16, 16, samples);
        ASSERT_EQ(chunk.materials.size(), chunk.size());
        EXPECT_EQ(chunk.slopes.size(), samples > 1 ? chunk.size() : 0u);
        ASSERT_GT(chunk.size(), 200u);
        for (const Material& m : chunk.materials) {
            EXPECT_EQ(m.transmission[0], 0.25f);
            EXPECT_EQ(m.transmission[1], 0.5f);
            EXPECT_EQ(m.transmission[2], 1.0f) << "clamped";
            EXPECT_EQ(m.collimation, 0.75f);
            EXPECT_EQ(m.eta, 1.5f);
            EXPECT_EQ(m.normal[0], 0.0f);
            EXPECT_EQ(m.normal[1], 0.0f);
            EXPECT_EQ(m.normal[2], 1.0f);
        }
    }
}

}  // namespace
}  // namespace ropsim
