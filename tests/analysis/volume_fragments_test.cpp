// What `ropsim trace volume` writes beside the numbers of the medium: order, materials, samples, shadows,
// costs, and what it refuses.
#include "analysis/volume_cost.h"
#include "analysis/volume_ray.h"
#include "tests/analysis/volume_views.h"

#include <gmock/gmock.h>

namespace ropsim {
namespace {

using testing::HasSubstr;

std::vector<Fragment> few_fragments(const TraceHeader& header) {
    RandomFragments options;
    options.width = header.width;
    options.height = header.height;
    options.samples = header.samples;
    options.count = 200;
    return random_fragments(options);
}

FragmentChunk everything(const std::string& file) {
    TraceReader reader(file);
    FragmentChunk all, chunk;
    while (reader.next(chunk)) {
        all.fragments.insert(all.fragments.end(), chunk.fragments.begin(), chunk.fragments.end());
        all.slopes.insert(all.slopes.end(), chunk.slopes.begin(), chunk.slopes.end());
        all.materials.insert(all.materials.end(), chunk.materials.begin(), chunk.materials.end());
    }
    return all;
}

bool same(const Material& a, const Material& b) {
    return std::equal(a.transmission, a.transmission + 3, b.transmission) && a.collimation == b.collimation &&
           a.eta == b.eta && std::equal(a.normal, a.normal + 3, b.normal);
}

TEST_F(VolumeTest, IsTheLastDrawAfterAllThatWasThere) {
    TraceHeader header = perspective_view();
    put_wall(header, 7);
    header.draws[0].name = "glass";
    header.draws[0].object_id = 41;
    header.scene = "a room";
    const std::vector<Fragment> before = few_fragments(header);
    write_trace(path("in"), header, before);
    VolumeOptions options;
    options.steps = 5;
    options.medium.collimation = 0.25;
    const VolumeSummary summary = add_volume(path("in"), path("out"), options);
    const TraceReader reader(path("out"));
    ASSERT_EQ(reader.header().draws.size(), 2u);
    const Draw& draw = reader.header().draws[1];
    EXPECT_EQ(reader.header().draws[0].name, "glass");
    EXPECT_EQ(draw.name, "volume");
    EXPECT_EQ(draw.object_id, 42u);
    EXPECT_FALSE(draw.depth_test);
    EXPECT_EQ(draw.full.alu_instructions, summary.draw.full.alu_instructions);
    EXPECT_EQ(reader.header().scene, "a room");
    EXPECT_EQ(reader.header().opaque->depth, header.opaque->depth);
    EXPECT_TRUE(reader.header().materials);
    const FragmentChunk all = everything(path("out"));
    ASSERT_EQ(all.size(), before.size() + summary.fragments);
    for (std::size_t i = 0; i < before.size(); ++i) {
        EXPECT_EQ(all.fragments[i].primitive, before[i].primitive);
        EXPECT_EQ(all.fragments[i].z, before[i].z);
        EXPECT_TRUE(same(all.materials[i], Material{}));
    }
    const PixelRays rays(header);
    for (std::size_t i = before.size(); i < all.size(); ++i) {
        const Fragment& f = all.fragments[i];
        EXPECT_EQ(f.draw, 1);
        EXPECT_EQ(f.primitive, 0u);
        const Material& m = all.materials[i];
        EXPECT_EQ(m.transmission[0] + m.transmission[1] + m.transmission[2], 0);
        EXPECT_EQ(m.collimation, 0.25f);
        EXPECT_EQ(m.eta, 1);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(m.normal[c], rays(f.x, f.y).to_eye[c], 1e-6) << "faces the eye";
    }
}

TEST_F(VolumeTest, APixelsStepsFollowOneAnotherFromNearToFar) {
    TraceHeader header = perspective_view(21, 13);
    put_wall(header, 7);
    write_trace(path("in"), header, {});
    VolumeOptions options;
    options.steps = 9;
    add_volume(path("in"), path("out"), options);
    const FragmentChunk all = everything(path("out"));
    ASSERT_EQ(all.size(), 21u * 13 * 9);
    std::vector<int> tiles;
    for (std::size_t i = 0; i < all.size(); i += 9) {
        const Fragment& first = all.fragments[i];
        for (std::size_t k = 1; k < 9; ++k) {
            const Fragment &f = all.fragments[i + k], &before = all.fragments[i + k - 1];
            EXPECT_EQ(f.x, first.x);
            EXPECT_EQ(f.y, first.y);
            EXPECT_GT(f.z, before.z);
        }
        EXPECT_LT(all.fragments[i + 8].z,
                  header.opaque->depth[static_cast<std::size_t>(first.y) * 21 + first.x]);
        const int tile = first.y / kTileSize * tiles_across(21) + first.x / kTileSize;
        if (tiles.empty() || tiles.back() != tile) tiles.push_back(tile);
    }
    EXPECT_THAT(tiles, testing::ElementsAre(0, 1, 2, 3, 4, 5));
    // Quad by quad within a tile.
    EXPECT_EQ(all.fragments[9].x, 1);
    EXPECT_EQ(all.fragments[18].y, 1);
    EXPECT_EQ(all.fragments[4 * 9].x, 2);
}

// Steps so short that their depths round to the wall's own still lie in front of it.
TEST_F(VolumeTest, NoStepFallsOntoTheOpaqueLayer) {
    TraceHeader header = header_with(glm::perspective(0.7f, 1.0f, 0.01f, kFar), 8, 8);
    put_wall(header, 39);
    write_trace(path("in"), header, {});
    VolumeOptions options;
    options.steps = 20000;  // 2 mm, a fifth of the distance between two depths there
    EXPECT_EQ(add_volume(path("in"), path("out"), options).fragments, 64u * 20000);
    EXPECT_GT(reference().pixel(0, 0)[5], 1000) << "neighbours of one depth";
    for (const Fragment& f : everything(path("out")).fragments)
        ASSERT_LT(f.z, header.opaque->depth[static_cast<std::size_t>(f.y) * 8 + f.x]);
}

TEST_F(VolumeTest, ChannelsThatTheTraceHasStay) {
    RandomFragments random;
    random.slopes = random.materials = true;
    random.samples = 4;
    random.opaque = true;
    TraceHeader header = random_header(random);
    header.camera = perspective_view(random.width, random.height).camera;
    const FragmentChunk before = random_chunk(random);
    TraceWriter writer(path("in"), header);
    writer.append(before);
    writer.finish();
    VolumeOptions options;
    options.steps = 3;
    add_volume(path("in"), path("out"), options);
    const FragmentChunk all = everything(path("out"));
    ASSERT_EQ(all.slopes.size(), all.size());
    for (std::size_t i = 0; i < before.size(); ++i) {
        EXPECT_EQ(all.slopes[i].dx, before.slopes[i].dx);
        EXPECT_TRUE(same(all.materials[i], before.materials[i]));
    }
    for (std::size_t i = before.size(); i < all.size(); ++i) EXPECT_EQ(all.slopes[i].dx, 0);
}

// Each sample has the air in front of its own surface, to a step.
TEST_F(VolumeTest, SamplesEndAtTheirOwnSurface) {
    TraceHeader header = orthographic_view(8, 8);
    header.samples = 4;
    header.depth_slopes = true;
    header.background = {0, 0, 0};
    put_wall(header, 30);
    const std::array<double, 4> walls = {4, 10, 20, 30};
    for (std::size_t i = 0; i < header.opaque->depth.size(); ++i) {
        header.opaque->depth[i] = window_depth(header, -walls[i % 4]);
        header.opaque->rgb[3 * i] = 0;
    }
    VolumeOptions options;
    options.medium.extinction = 0.1;
    options.ambient = glm::dvec3(1);
    options.steps = 500;
    march(header, options);
    double expected = 0;
    for (const double wall : walls) expected += (1 - std::exp(-0.1 * (wall - kNear))) / 4;
    EXPECT_NEAR(reference().pixel(3, 3)[0], expected, 0.1 * 30 / 500);
    EXPECT_NEAR(reference().pixel(3, 3)[3], expected, 0.1 * 30 / 500);
}

// Seen from the side: a light from above, whose view holds a roof over x < 0 and a pane of alpha 1/2 over
// 0 < x < 1.
TEST_F(VolumeTest, ShaftsOfLightEndWhereTheLightsViewIsCovered) {
    TraceHeader light;
    light.width = light.height = 64;
    light.view = "light";
    light.draws.resize(1);
    light.camera.emplace();
    light.camera->view = glm::lookAt(glm::vec3(0, 20, -10), glm::vec3(0, 0, -10), glm::vec3(0, 0, -1));
    light.camera->projection = glm::ortho(-1.5f, 1.5f, -50.0f, 50.0f, 1.0f, 60.0f);
    light.opaque.emplace();
    std::vector<Fragment> pane;
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) {
            const double world = (x + 0.5) / 64 * 3 - 1.5;
            light.opaque->rgb.insert(light.opaque->rgb.end(), {0, 0, 0});
            light.opaque->depth.push_back(world < 0 ? 0.125f : std::numeric_limits<float>::infinity());
            if (world > 0 && world < 1)
                pane.push_back({0.25f, 0, 0, 0, 0.5f, static_cast<std::uint16_t>(x),
                                static_cast<std::uint16_t>(y), 0, 1, 0});
        }
    write_trace(path("light"), light, pane);
    TraceHeader camera = orthographic_view(40, 8);
    camera.light = light.camera;
    VolumeOptions options;
    options.medium.extinction = 0.05;
    options.steps = 6;
    options.ambient = glm::dvec3(0.25);
    options.light = glm::dvec3(4 * 3.14159265358979);
    options.shadows = path("light");
    march(camera, options);
    const auto pixels = by_pixel();
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        const double x = (static_cast<double>(i % 40) + 0.5) / 40 * 4 - 2;
        const double lit = x < -1.5 || x > 1 ? 1 : x < 0 ? 0 : 0.5;  // what the light does not see is lit
        if (std::abs(x) < 0.06 || std::abs(x - 1) < 0.06 || std::abs(x + 1.5) < 0.06) continue;
        for (const Fragment& f : pixels[i]) EXPECT_NEAR(f.r / f.a, 0.25 + lit, 1e-5) << x;
    }
    // A square of texels blurs the edge and nothing else.
    options.filter = 5;
    EXPECT_EQ(march(camera, options, "blurred").draw.full.texture_fetches, 25u);
    const auto blurred = by_pixel("blurred");
    EXPECT_NEAR(blurred[10][0].r / blurred[10][0].a, 0.25, 1e-5);
    EXPECT_NE(blurred[29][0].r, pixels[29][0].r);
}

TEST_F(VolumeTest, JitterMovesTheStepsOfEachPixelTogether) {
    TraceHeader header = orthographic_view();
    VolumeOptions options;
    options.medium.extinction = 0.1;
    options.steps = 10;
    options.jitter = true;
    options.seed = 5;
    march(header, options);
    const double step = (kFar - kNear) / 10;
    double mean = 0, squares = 0;
    const PixelRays rays(header);
    for (const auto& fragments : by_pixel()) {
        const PixelRay ray = rays(fragments[0].x, fragments[0].y);
        const double place = (ray.distance(static_cast<double>(fragments[0].z)) - kNear) / step;
        EXPECT_GE(place, -1e-5);
        EXPECT_LE(place, 1 + 1e-5);
        mean += place / 240;
        squares += place * place / 240;
        for (std::size_t k = 1; k < 10; ++k)
            EXPECT_NEAR((ray.distance(static_cast<double>(fragments[k].z)) - kNear) / step,
                        place + static_cast<double>(k), 1e-4);
        EXPECT_NEAR(transmittance(fragments), std::exp(-0.1 * (kFar - kNear)), 1e-6);
    }
    // Uniform: mean 1/2 and variance 1/12, within five standard errors of 240 pixels.
    EXPECT_NEAR(mean, 0.5, 5 * std::sqrt(1.0 / 12 / 240));
    EXPECT_NEAR(squares - mean * mean, 1.0 / 12, 5 * std::sqrt(1.0 / 180 / 240));
    const std::string hash = TraceReader(path("out")).hash();
    options.seed = 6;
    march(header, options);
    EXPECT_NE(TraceReader(path("out")).hash(), hash);
}

TEST_F(VolumeTest, ThreadsChangeNothing) {
    TraceHeader header = perspective_view(70, 45);
    put_wall(header, 9);
    header.light = header.camera;
    VolumeOptions options;
    options.jitter = true;
    options.medium.height_falloff = 3;
    std::string hash;
    for (const int threads : {1, 2, 5}) {
        options.threads = threads;
        march(header, options);
        const TraceReader reader(path("out"));
        if (hash.empty()) hash = reader.hash();
        EXPECT_EQ(reader.hash(), hash);
    }
}

TEST(VolumeCost, GrowsWithWhatAStepDoes) {
    VolumeShader shader;
    shader.steps = 64;
    const auto alu = [&] { return measure_volume_cost(shader).full.alu_instructions; };
    const std::uint32_t ambient = alu();
    shader.falloff = true;
    const std::uint32_t falloff = alu();
    EXPECT_GT(falloff, ambient);
    shader.light = true;
    const std::uint32_t light = alu();
    EXPECT_GE(light, falloff);  // of a far light the phase is the same all along a ray
    shader.point_light = true;
    EXPECT_GT(alu(), light) << "phase and distance in every step";
    shader.point_light = false;
    shader.shadow_texels = 3;
    const VolumeCost shadows = measure_volume_cost(shader);
    EXPECT_GT(shadows.full.alu_instructions, light + 12) << "a point into the light's view";
    EXPECT_EQ(shadows.full.texture_fetches, 9u);
    EXPECT_EQ(shadows.full.texture_bytes, 36u);
    // Alpha alone: no light, no shadows.
    EXPECT_EQ(shadows.alpha.texture_fetches, 0u);
    EXPECT_LT(shadows.alpha.alu_instructions, ambient + 10);
    EXPECT_THAT(shadows.source, HasSubstr("1/64"));
    // A march of one step pays what a pixel does once, the fetch of the opaque depth too.
    shader.steps = 1;
    const VolumeCost single = measure_volume_cost(shader);
    EXPECT_GT(single.full.alu_instructions, shadows.full.alu_instructions + 20);
    EXPECT_EQ(single.full.texture_fetches, 10u);
    EXPECT_EQ(single.alpha.texture_fetches, 1u);
}

class VolumeRefusals : public VolumeTest {
 protected:
    void expect_refused(const TraceHeader& header, const VolumeOptions& options,
                        const std::string& words) const {
        try {
            march(header, options);
            ADD_FAILURE() << "not refused: " << words;
        } catch (const UserError& error) {
            EXPECT_THAT(error.where() + ": " + error.what(), HasSubstr(words));
        }
        EXPECT_FALSE(std::filesystem::exists(path("out")));
    }
};

TEST_F(VolumeRefusals, OptionsOutOfRange) {
    const auto refused = [&](const char* words, auto&& change) {
        VolumeOptions options;
        change(options);
        expect_refused(perspective_view(), options, words);
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    refused("--extinction: -1", [](VolumeOptions& o) { o.medium.extinction = -1; });
    refused("--extinction: nan", [&](VolumeOptions& o) { o.medium.extinction = nan; });
    refused("--albedo: 1.5", [](VolumeOptions& o) { o.medium.albedo.g = 1.5; });
    for (const double g : {-1.0, 1.0, 7.0, nan})
        refused("--anisotropy", [&](VolumeOptions& o) { o.medium.anisotropy = g; });
    refused("--height-falloff: 0", [](VolumeOptions& o) { o.medium.height_falloff = 0; });
    refused("--collimation: 2", [](VolumeOptions& o) { o.medium.collimation = 2; });
    refused("--steps: 0", [](VolumeOptions& o) { o.steps = 0; });
    refused("--near: -1", [](VolumeOptions& o) { o.near = -1; });
    refused("--far: 2 m is not beyond --near, 3 m", [](VolumeOptions& o) { o.near = 3, o.far = 2; });
    refused("--ambient: -1", [](VolumeOptions& o) { o.ambient.b = -1; });
    refused("--light: inf", [](VolumeOptions& o) { o.light = glm::dvec3(HUGE_VAL); });
    refused("--filter: 4", [](VolumeOptions& o) { o.filter = 4; });
}

TEST_F(VolumeRefusals, TracesWithoutWhatTheMarchNeeds) {
    VolumeOptions options;
    TraceHeader header = perspective_view();
    header.camera.reset();
    expect_refused(header, options, "has no camera");
    header = perspective_view();
    header.camera->projection = glm::mat4(0.0f);
    expect_refused(header, options, "cannot be inverted");
    header = header_with(glm::infinitePerspective(0.7f, 1.6f, 0.5f));
    expect_refused(header, options, "say with --far");
    options.far = 10;
    EXPECT_EQ(march(header, options).pixels, 240u);
    std::filesystem::remove(path("out"));
    options.light = glm::dvec3(1);
    expect_refused(perspective_view(), options, "has no light");
    options.light.reset();
    options.shadows = path("in");
    expect_refused(perspective_view(), options, "has no light");
    header = perspective_view();
    header.light = header.camera;
    expect_refused(header, options, "--view light");
}

}  // namespace
}  // namespace ropsim
