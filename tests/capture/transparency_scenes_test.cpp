// The scenes of the stochastic transparency papers, and the splats: what is published about them holds.
#include "capture/capture.h"
#include "capture/geometry/shuffled_order.h"
#include "capture/scene_list.h"
#include "capture/scenes/motor_parts.h"
#include "tests/capture/own_file.h"
#include "tests/capture/test_scene.h"
#include "traces/trace.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <gmock/gmock.h>

namespace ropsim {
namespace {

class PublishedTransparencyScenesTest : public testing::OpenGlTest {};

const SceneInfo& info(const std::string& name) {
    for (const SceneInfo& scene : scene_list())
        if (scene.name == name) return scene;
    throw std::out_of_range(name);
}

struct Facts {
    std::uint64_t fragments = 0;
    double mean_layers = 0;
    double mean_alpha = 0;
    float least_alpha = 1;
    float most_alpha = 0;
    double nearer = 0;  // share of neighbours in a pixel of which the later is nearer
};

Facts capture_facts(const std::string& scene, std::optional<std::pair<int, int>> size = {}) {
    CaptureOptions options;
    options.scene_or_file = scene;
    options.size = size;
    const std::string path = test::own_file(std::string(scene) + ".trace");
    capture_scene(options, path);
    TraceReader reader(path);
    const int width = reader.header().width;
    const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(reader.header().height);
    std::vector<std::uint32_t> layers(pixels);
    std::vector<float> last(pixels);
    Facts facts;
    double pairs = 0;
    std::vector<Fragment> chunk;
    while (reader.next(chunk)) {
        for (const Fragment& f : chunk) {
            const std::size_t pixel = static_cast<std::size_t>(f.y) * static_cast<std::size_t>(width) + f.x;
            if (layers[pixel]++ > 0) {
                facts.nearer += f.z < last[pixel];
                ++pairs;
            }
            last[pixel] = f.z;
            facts.mean_alpha += f.a;
            facts.least_alpha = std::min(facts.least_alpha, f.a);
            facts.most_alpha = std::max(facts.most_alpha, f.a);
        }
        facts.fragments += chunk.size();
    }
    const auto covered = pixels - static_cast<std::size_t>(std::count(layers.begin(), layers.end(), 0u));
    facts.mean_layers = static_cast<double>(facts.fragments) / static_cast<double>(covered);
    facts.mean_alpha /= static_cast<double>(facts.fragments);
    facts.nearer /= pairs;
    return facts;
}

std::uint64_t triangles(const Scene& scene) {
    std::uint64_t sum = 0;
    for (const SceneDraw& draw : scene.transparent) sum += std::uint64_t{draw.primitives} * draw.instances;
    return sum;
}

TEST_F(PublishedTransparencyScenesTest, MotorHas322000TrianglesOfAlpha30PercentTwentyLayersDeep) {
    const SceneInfo& motor = info("motor");
    EXPECT_EQ(triangles(motor.make(1.0, 1)->build({})), motor.published.primitives);
    EXPECT_EQ(motor.published.primitives, 322000u);
    EXPECT_EQ(std::pair(motor.width, motor.height), std::pair(500, 500));
    const Facts facts = capture_facts("motor");
    EXPECT_NEAR(facts.mean_layers, 20, 2);
    EXPECT_EQ(facts.least_alpha, 0.3f);
    EXPECT_EQ(facts.most_alpha, 0.3f);
}

TEST_F(PublishedTransparencyScenesTest, ClothIsAlpha40PercentInRandomOrder) {
    const Facts facts = capture_facts("cloth");
    EXPECT_GT(facts.mean_layers, 3);
    EXPECT_EQ(facts.least_alpha, 0.4f);
    EXPECT_EQ(facts.most_alpha, 0.4f);
    EXPECT_NEAR(facts.nearer, 0.5, 0.01);
}

TEST_F(PublishedTransparencyScenesTest, PlumeIs100000BillboardsOfAlpha5Percent) {
    const SceneInfo& plume = info("plume");
    EXPECT_EQ(triangles(plume.make(1.6, 1)->build({})), 2 * *plume.published.primitives);
    EXPECT_EQ(plume.published.primitives, 100000u);
    EXPECT_NEAR(capture_facts("plume", std::pair(640, 360)).mean_alpha, 0.05, 0.002);
}

TEST_F(PublishedTransparencyScenesTest, SplatsAreAMillionUnsortedAndNoneFainterThanOneStep) {
    const SceneInfo& splats = info("splats");
    EXPECT_EQ(triangles(splats.make(1.6, 1)->build({})), 2 * *splats.published.primitives);
    EXPECT_EQ(splats.published.primitives, 1000000u);
    const Facts facts = capture_facts("splats", std::pair(160, 90));
    EXPECT_GE(facts.least_alpha, 1.0f / 255);
    EXPECT_LE(facts.most_alpha, 0.99f);
    EXPECT_NEAR(facts.nearer, 0.5, 0.01);
}

TEST_F(PublishedTransparencyScenesTest, FragmentsFollowTheRequest) {
    for (const auto& [scene, wanted] :
         {std::pair("motor", 100000u), std::pair("motor", 900000u), std::pair("cloth", 100000u),
          std::pair("cloth", 250000u), std::pair("splats", 100000u)}) {
        CaptureOptions options;
        options.scene_or_file = scene;
        options.size = {200, 150};
        options.fragments = wanted;
        const CaptureSummary summary = capture_scene(options, test::own_file("requested.trace"));
        EXPECT_NEAR(static_cast<double>(summary.fragments) / wanted, 1.0, 0.03) << scene << " " << wanted;
    }
}

// Twice the volume that the triangles enclose with the origin, by assembly: cutting must not change it.
double volume(const std::vector<MotorAssembly>& assemblies) {
    double sum = 0;
    for (const MotorAssembly& assembly : assemblies) {
        const TriangleMesh& mesh = assembly.mesh;
        for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
            sum += glm::dot(glm::dvec3(mesh.positions[mesh.indices[i]]),
                            glm::cross(glm::dvec3(mesh.positions[mesh.indices[i + 1]]),
                                       glm::dvec3(mesh.positions[mesh.indices[i + 2]])));
    }
    return sum;
}

TEST(MotorPartsTest, RefiningReachesTheCountAndKeepsTheSurface) {
    std::vector<MotorAssembly> assemblies = motor_assemblies();
    std::uint32_t before = 0;
    for (const MotorAssembly& assembly : assemblies) before += assembly.mesh.triangles();
    const double enclosed = volume(assemblies);
    refine_to(assemblies, before + 1000);
    std::uint32_t after = 0;
    for (const MotorAssembly& assembly : assemblies) after += assembly.mesh.triangles();
    EXPECT_EQ(after, before + 1000);
    EXPECT_NEAR(volume(assemblies) / enclosed, 1, 1e-6);
}

TEST(MotorPartsTest, EveryPartIsClosed) {
    for (const MotorAssembly& assembly : motor_assemblies()) {
        // By position, to a micrometre: edges of one surface meet, whatever their vertices.
        std::map<std::vector<long>, int> edges;
        const TriangleMesh& mesh = assembly.mesh;
        for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
            const auto cells = [&](std::size_t at) {
                const glm::vec3 p = mesh.positions[mesh.indices[at]] * 1e5f;
                return std::array{std::lround(p.x), std::lround(p.y), std::lround(p.z)};
            };
            const auto [ax, ay, az] = cells(i);
            const auto [bx, by, bz] = cells(i % 3 == 2 ? i - 2 : i + 1);
            ++edges[{ax, ay, az, bx, by, bz}];
            --edges[{bx, by, bz, ax, ay, az}];
        }
        int open = 0;
        for (const auto& [edge, count] : edges) open += count != 0;
        EXPECT_EQ(open, 0) << assembly.name << " of " << mesh.triangles();
    }
}

TEST(ShuffledOrderTest, HoldsEveryNumberOnceAndEveryOrderIsAsLikely) {
    std::map<std::vector<std::uint32_t>, int> seen;
    for (std::uint64_t seed = 0; seed < 6000; ++seed) ++seen[shuffled_order(3, seed)];
    EXPECT_EQ(seen.size(), 6u);
    for (const auto& [order, count] : seen) EXPECT_NEAR(count, 1000, 120);
    std::vector<std::uint32_t> order = shuffled_order(1000, 7);
    EXPECT_EQ(order, shuffled_order(1000, 7));
    std::sort(order.begin(), order.end());
    for (std::uint32_t i = 0; i < 1000; ++i) EXPECT_EQ(order[i], i);
}

}  // namespace
}  // namespace ropsim
