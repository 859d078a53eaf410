// Captured fragments of hand-made triangles against the rasterisation rules.
#include "capture/fragment_capture.h"

#include "base/random.h"
#include "capture/opaque_pass.h"
#include "tests/capture/test_scene.h"

#include <cmath>
#include <cstring>
#include <map>
#include <set>

namespace ropsim {
namespace {

using testing::capture_all;
using testing::window_draw;
using testing::WindowTriangle;

class FragmentCaptureTest : public testing::OpenGlTest {};

bool same(const std::vector<Fragment>& a, const std::vector<Fragment>& b) {
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Fragment)) == 0);
}

// Seeded triangles of many sizes over the image, some of them full screen.
Scene random_scene(int width, int height, std::uint32_t triangles, std::uint32_t instances) {
    std::vector<WindowTriangle> list;
    for (std::uint32_t i = 0; i < triangles; ++i) {
        WindowTriangle triangle{};
        const float size = i % 16 == 0 ? 3.0f : 0.3f;
        const glm::vec2 middle(random_unit(mix64(i), 0), random_unit(mix64(i), 1));
        for (std::uint32_t c = 0; c < 3; ++c) {
            const glm::vec2 offset(random_unit(mix64(i), 3 * c + 2) - 0.5f,
                                   random_unit(mix64(i), 3 * c + 3) - 0.5f);
            const glm::vec2 at = (middle + size * offset) * glm::vec2(width, height);
            triangle.corners[c] = {at, random_unit(mix64(i), 3 * c + 4)};
        }
        list.push_back(triangle);
    }
    Scene scene;
    scene.transparent.push_back(window_draw(list, width, height, {0.5f, 0.25f, 0.125f, 0.5f}, instances, 3));
    return scene;
}

TEST_F(FragmentCaptureTest, TriangleCoversThePixelsWhoseCentresLieInside) {
    const GlContext context;
    // x + y < 8.5: the pixel (i, j) with centre (i + 0.5, j + 0.5) is inside when i + j <= 7, which is 36
    // pixels.
    Scene scene;
    scene.transparent.push_back(window_draw({{{{0, 0, 0.25f}, {8.5f, 0, 0.5f}, {0, 8.5f, 0.75f}}}}, 16, 16,
                                            {0.5f, 0.25f, 1.0f, 0.5f}));
    const std::vector<Fragment> fragments = capture_all(scene, 16, 16);
    ASSERT_EQ(fragments.size(), 36u);
    std::set<std::pair<int, int>> pixels;
    for (const Fragment& f : fragments) {
        pixels.insert({f.x, f.y});
        EXPECT_LE(f.x + f.y, 7);
        const double z = 0.25 + 0.25 * (f.x + 0.5) / 8.5 + 0.5 * (f.y + 0.5) / 8.5;
        EXPECT_NEAR(f.z, z, 1e-6) << f.x << ',' << f.y;
        EXPECT_EQ(f.r, 0.25f);
        EXPECT_EQ(f.g, 0.125f);
        EXPECT_EQ(f.b, 0.5f);
        EXPECT_EQ(f.a, 0.5f);
        EXPECT_EQ(f.coverage, 1);
        EXPECT_EQ(f.draw, 0);
        EXPECT_EQ(primitive_number(f), 0u);
    }
    EXPECT_EQ(pixels.size(), 36u);
}

TEST_F(FragmentCaptureTest, TrianglesThatShareAnEdgeCoverEachPixelOnce) {
    const GlContext context;
    // The diagonal runs through pixel centres.
    Scene scene;
    scene.transparent.push_back(window_draw(
        {{{{2, 3, 0.5f}, {12, 3, 0.5f}, {12, 13, 0.5f}}}, {{{2, 3, 0.5f}, {12, 13, 0.5f}, {2, 13, 0.5f}}}},
        16, 16, {1, 1, 1, 0.25f}));
    const std::vector<Fragment> fragments = capture_all(scene, 16, 16);
    std::map<std::pair<int, int>, int> layers;
    for (const Fragment& f : fragments) ++layers[{f.x, f.y}];
    EXPECT_EQ(fragments.size(), 100u);
    EXPECT_EQ(layers.size(), 100u);
    EXPECT_EQ(layers.begin()->first, std::make_pair(2, 3));
    EXPECT_EQ(layers.rbegin()->first, std::make_pair(11, 12));
}

TEST_F(FragmentCaptureTest, PrimitivesCountThroughInstancesAndDrawsFollow) {
    const GlContext context;
    const std::vector<WindowTriangle> triangles = {{{{0, 0, 0.5f}, {4, 0, 0.5f}, {0, 4, 0.5f}}},
                                                   {{{0, 8, 0.5f}, {4, 8, 0.5f}, {0, 12, 0.5f}}}};
    Scene scene;
    scene.transparent.push_back(window_draw(triangles, 32, 16, {1, 1, 1, 0.5f}, 3, 8));
    scene.transparent.push_back(window_draw({triangles[1]}, 32, 16, {1, 1, 1, 0.25f}));
    scene.transparent[0].indices = {0, 1, 2, 3, 4, 5};  // one draw with indices, one without
    const std::vector<Fragment> fragments = capture_all(scene, 32, 16);
    ASSERT_FALSE(fragments.empty());
    std::set<std::pair<int, std::uint32_t>> seen;
    for (const Fragment& f : fragments) {
        seen.insert({f.draw, primitive_number(f)});
        if (f.draw == 0) {
            EXPECT_EQ(f.x / 8u, primitive_number(f) / 2) << "instance";
            EXPECT_EQ(f.y / 8u, primitive_number(f) % 2) << "triangle";
            EXPECT_EQ(f.a, 0.5f);
        } else {
            EXPECT_EQ(f.a, 0.25f);
        }
    }
    EXPECT_EQ(seen.size(), 7u);
}

TEST_F(FragmentCaptureTest, OrderIsPrimitiveThenTileThenQuadThenPixel) {
    const GlContext context;
    constexpr int kWidth = 61;  // not a multiple of a tile
    constexpr int kHeight = 45;
    const std::vector<Fragment> fragments =
        capture_all(random_scene(kWidth, kHeight, 40, 2), kWidth, kHeight);
    // The pixels in raster order, spelled out.
    std::map<std::pair<int, int>, int> rank;
    for (int tile_y = 0; tile_y < kHeight; tile_y += 8) {
        for (int tile_x = 0; tile_x < kWidth; tile_x += 8) {
            for (int quad_y = 0; quad_y < 8; quad_y += 2) {
                for (int quad_x = 0; quad_x < 8; quad_x += 2) {
                    for (int pixel = 0; pixel < 4; ++pixel) {
                        const int next = static_cast<int>(rank.size());
                        rank[{tile_x + quad_x + pixel % 2, tile_y + quad_y + pixel / 2}] = next;
                    }
                }
            }
        }
    }
    for (std::size_t i = 1; i < fragments.size(); ++i) {
        const auto place = [&](const Fragment& f) {
            return std::make_pair(primitive_number(f), rank.at({f.x, f.y}));
        };
        ASSERT_LT(place(fragments[i - 1]), place(fragments[i])) << i;
    }
}

TEST_F(FragmentCaptureTest, OverflowingPiecesAreSplitWithoutATrace) {
    const GlContext context;
    const Scene scene = random_scene(120, 80, 200, 3);
    FragmentCaptureCounts whole;
    FragmentCaptureCounts split;
    const std::vector<Fragment> expected = capture_all(scene, 120, 80, {}, &whole);
    EXPECT_EQ(expected.size(), count_layers(scene, 120, 80).fragments);
    for (std::size_t limit : {std::size_t{64}, std::size_t{1000}, expected.size() - 1, expected.size()}) {
        const std::vector<Fragment> fragments = capture_all(scene, 120, 80, {limit, 2}, &split);
        EXPECT_TRUE(same(fragments, expected)) << limit;
        EXPECT_EQ(split.retries > 0, limit < expected.size()) << limit;
    }
    // 64 is one tile: triangles over the whole image had to be split by tiles.
    EXPECT_EQ(whole.retries, 0u);
}

TEST_F(FragmentCaptureTest, NeitherOpaqueGeometryNorFacingRemovesFragments) {
    const GlContext context;
    const WindowTriangle clockwise{{{1, 1, 0.5f}, {9, 1, 0.5f}, {1, 9, 0.5f}}};
    const WindowTriangle counter{{{1, 1, 0.5f}, {1, 9, 0.5f}, {9, 1, 0.5f}}};
    Scene scene;
    scene.opaque.push_back(
        window_draw({{{{-40, -40, 0.1f}, {80, -40, 0.1f}, {-40, 80, 0.1f}}}}, 16, 16, {1, 1, 1, 1}));
    scene.transparent.push_back(window_draw({clockwise, counter}, 16, 16, {1, 1, 1, 0.5f}));
    const std::size_t both = capture_all(scene, 16, 16).size();
    // Each covers the pixels with i + j <= 6 from (1, 1): those with i + j = 7 have their centres on the long
    // edge, which is a bottom right one.
    EXPECT_EQ(both, 2 * 28u);
    scene.transparent[0].state.cull = CullMode::kBack;
    const std::vector<Fragment> front = capture_all(scene, 16, 16);
    EXPECT_EQ(front.size(), both / 2);
    // Counter-clockwise as seen is OpenGL's front, whatever the origin of the image.
    for (const Fragment& f : front) EXPECT_EQ(primitive_number(f), 1u);
}

TEST_F(FragmentCaptureTest, OpaqueLayerKeepsTheNearestAndMarksTheRest) {
    const GlContext context;
    Scene scene;
    scene.background = {0.1f, 0.2f, 0.3f};
    // Left 6 columns at depth 0.6; on top of it the upper 5 rows of the first 3 columns at 0.25, drawn first.
    const auto rectangle = [](float x, float y, float z) {
        return std::vector<WindowTriangle>{{{{0, 0, z}, {x, 0, z}, {x, y, z}}},
                                           {{{0, 0, z}, {x, y, z}, {0, y, z}}}};
    };
    scene.opaque.push_back(window_draw(rectangle(3, 5, 0.25f), 12, 10, {2.0f, 0.5f, 0.25f, 1}));
    scene.opaque.push_back(window_draw(rectangle(6, 10, 0.625f), 12, 10, {0.0f, 1.0f, 0.0f, 1}));
    const OpaqueLayer layer = draw_opaque_layer(scene, 12, 10, 1);
    ASSERT_EQ(layer.depth.size(), 120u);
    ASSERT_EQ(layer.rgb.size(), 360u);
    for (int y = 0; y < 10; ++y) {
        for (int x = 0; x < 12; ++x) {
            const auto i = static_cast<std::size_t>(y * 12 + x);
            const glm::vec3 color(layer.rgb[3 * i], layer.rgb[3 * i + 1], layer.rgb[3 * i + 2]);
            if (x >= 6) {
                EXPECT_EQ(layer.depth[i], std::numeric_limits<float>::infinity());
                EXPECT_EQ(color, scene.background);
            } else if (x < 3 && y < 5) {
                EXPECT_EQ(layer.depth[i], 0.25f);
                EXPECT_EQ(color, glm::vec3(2.0f, 0.5f, 0.25f));
            } else {
                EXPECT_EQ(layer.depth[i], 0.625f);
                EXPECT_EQ(color, glm::vec3(0, 1, 0));
            }
        }
    }
}

TEST_F(FragmentCaptureTest, DiscardedFragmentsAreNeitherCapturedNorCounted) {
    const GlContext context;
    Scene scene;
    scene.transparent.push_back(
        window_draw({{{{0, 0, 0.5f}, {32, 0, 0.5f}, {0, 32, 0.5f}}}}, 16, 16, {1, 1, 1, 0.5f}));
    scene.transparent[0].shading =
        "uniform vec4 u_parameters[8];\n"
        "vec4 shade() { if (mod(floor(gl_FragCoord.x), 3.0) < 0.5) discard; return u_parameters[0]; }\n";
    const std::vector<Fragment> fragments = capture_all(scene, 16, 16);
    EXPECT_EQ(fragments.size(), 10u * 16u);  // columns 0, 3, 6, 9, 12, 15 are gone
    for (const Fragment& f : fragments) EXPECT_NE(f.x % 3, 0);
    const LayerCounts counts = count_layers(scene, 16, 16);
    EXPECT_EQ(counts.fragments, 160u);
    EXPECT_EQ(counts.covered, 160u);
    EXPECT_EQ(counts.deepest, 1u);
}

}  // namespace
}  // namespace ropsim
