// Whole captures: what each scene promises, the same bytes for any driver threads, and refusals.
#include "capture/capture.h"
#include "tests/capture/own_file.h"
#include "tests/capture/test_scene.h"
#include "traces/trace.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <gmock/gmock.h>

namespace ropsim {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 180;

class ScenesTest : public testing::OpenGlTest {
 protected:
    std::string path(const std::string& name) const { return test::own_file(name); }
};

CaptureOptions options_for(const std::string& scene) {
    CaptureOptions options;
    options.scene_or_file = scene;
    options.size = {kWidth, kHeight};
    return options;
}

bool models_installed() {
    return std::filesystem::exists("/usr/share/glmark2/models/horse.3ds");
}

struct TraceFacts {
    std::uint64_t fragments = 0;
    double mean_layers = 0;
    std::uint32_t deepest = 0;
    double mean_alpha = 0;
    std::string hash;
    TraceHeader header;
};

TraceFacts read_facts(const std::string& file) {
    TraceReader reader(file);
    TraceFacts facts;
    facts.header = reader.header();
    facts.hash = reader.hash();
    std::vector<std::uint32_t> layers(static_cast<std::size_t>(facts.header.width * facts.header.height));
    std::vector<Fragment> chunk;
    while (reader.next(chunk)) {
        for (const Fragment& f : chunk) {
            ++layers[static_cast<std::size_t>(f.y * facts.header.width + f.x)];
            facts.mean_alpha += f.a;
            EXPECT_LE(std::max({f.r, f.g, f.b}), 4 * f.a) << "colour is premultiplied";
        }
        facts.fragments += chunk.size();
    }
    const auto covered = static_cast<double>(layers.size()) -
                         static_cast<double>(std::count(layers.begin(), layers.end(), 0u));
    facts.mean_layers = static_cast<double>(facts.fragments) / covered;
    facts.deepest = *std::max_element(layers.begin(), layers.end());
    facts.mean_alpha /= static_cast<double>(facts.fragments);
    return facts;
}

TEST_F(ScenesTest, MeshSceneIsDeepEnoughAndHasACameraAndDepth) {
    if (!models_installed()) GTEST_SKIP() << "glmark2-data is not installed";
    for (const char* name : {"horse", "bunny"}) {
        const CaptureSummary summary = capture_scene(options_for(name), path(name));
        const TraceFacts facts = read_facts(path(name));
        EXPECT_EQ(facts.fragments, summary.fragments);
        EXPECT_GE(facts.mean_layers, 8.0) << name;
        // A million at 1280x720, in proportion to the pixels.
        EXPECT_GE(facts.fragments, 1000000u * kWidth * kHeight / (1280 * 720)) << name;
        ASSERT_TRUE(facts.header.camera.has_value());
        EXPECT_GT(facts.header.camera->near_plane, 0);
        ASSERT_TRUE(facts.header.opaque.has_value());
        const auto [nearest, farthest] =
            std::minmax_element(facts.header.opaque->depth.begin(), facts.header.opaque->depth.end());
        EXPECT_LT(*nearest, *farthest);
        EXPECT_EQ(facts.header.color_storage, ColorStorage::kFloat16);
    }
}

TEST_F(ScenesTest, HairIsOver300LayersDeep) {
    capture_scene(options_for("hair"), path("hair"));
    const TraceFacts facts = read_facts(path("hair"));
    EXPECT_GE(facts.deepest, 300u);
    EXPECT_GT(facts.mean_alpha, 0.1);
    EXPECT_LT(facts.mean_alpha, 0.4);
}

TEST_F(ScenesTest, PlumeIsThinAndUnsorted) {
    capture_scene(options_for("plume"), path("plume"));
    const TraceFacts facts = read_facts(path("plume"));
    EXPECT_NEAR(facts.mean_alpha, 0.05, 0.02);
    EXPECT_THAT(facts.header.scene, ::testing::HasSubstr("100000 particles"));
    // Of neighbours in a pixel, about half are nearer than the one before.
    TraceReader reader(path("plume"));
    std::vector<Fragment> chunk;
    std::vector<float> last(static_cast<std::size_t>(kWidth * kHeight), -1.0f);
    double nearer = 0;
    double pairs = 0;
    while (reader.next(chunk)) {
        for (const Fragment& f : chunk) {
            float& before = last[static_cast<std::size_t>(f.y * kWidth + f.x)];
            if (before >= 0) {
                nearer += f.z < before;
                pairs += 1;
            }
            before = f.z;
        }
    }
    EXPECT_NEAR(nearer / pairs, 0.5, 0.02);
}

TEST_F(ScenesTest, FragmentsFollowTheRequest) {
    std::vector<std::pair<std::string, std::uint64_t>> requests = {
        {"hair", 60000}, {"hair", 700000}, {"plume", 50000}, {"plume", 900000}};
    if (models_installed()) {
        requests.insert(requests.end(), {{"horse", 20000}, {"horse", 400000}, {"bunny", 60000}});
    }
    for (const auto& [name, wanted] : requests) {
        CaptureOptions options = options_for(name);
        options.fragments = wanted;
        const CaptureSummary summary = capture_scene(options, path("trace"));
        EXPECT_NEAR(static_cast<double>(summary.fragments) / static_cast<double>(wanted), 1.0, 0.03) << name;
        if (name == "horse") {
            EXPECT_GE(read_facts(path("trace")).mean_layers, 7.8) << wanted;
        }
    }
}

TEST_F(ScenesTest, SeedDecidesTheTrace) {
    CaptureOptions options = options_for("plume");
    options.fragments = 50000;
    const auto hash_of = [&](std::uint64_t seed) {
        options.seed = seed;
        capture_scene(options, path("trace"));
        return TraceReader(path("trace")).hash();
    };
    const std::string first = hash_of(5);
    EXPECT_EQ(hash_of(5), first);
    EXPECT_NE(hash_of(6), first);
}

std::string bytes_of(const std::string& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

// The driver reads its number of threads once a process, so each count is a run of the program.
TEST_F(ScenesTest, AnyNumberOfDriverThreadsGivesTheSameBytes) {
    if (!std::filesystem::exists(ROPSIM_PROGRAM)) GTEST_SKIP() << ROPSIM_PROGRAM << " is not built";
    for (const char* scene : {"hair --size 240x135", "plume --size 333x187 --fragments 300000"}) {
        std::string files[2];
        for (int threads : {1, 2}) {
            const std::string file = path(std::to_string(threads));
            const std::string command = fmt::format(
                "LP_NUM_THREADS={} ROPSIM_GL=surfaceless '{}' capture {} -o '{}' "
                "2>&1",
                threads, ROPSIM_PROGRAM, scene, file);
            ASSERT_EQ(std::system(command.c_str()), 0) << command;
            files[threads - 1] = bytes_of(file);
        }
        EXPECT_GT(files[0].size(), 10000u);
        EXPECT_TRUE(files[0] == files[1]) << scene;
    }
}

// where() + ": " + what() of the refusal; nothing may be left under the trace's name.
std::string refusal(const CaptureOptions& options, const std::string& file) {
    try {
        capture_scene(options, file);
    } catch (const UserError& error) {
        EXPECT_FALSE(std::filesystem::exists(file));
        return error.where() + ": " + error.what();
    }
    return "";
}

TEST_F(ScenesTest, BadRequestsAreRefusedInOneLine) {
    const std::string file = path("trace");
    EXPECT_THAT(refusal(options_for("hiar"), file),
                ::testing::AllOf(::testing::HasSubstr("did you mean 'hair'"), ::testing::HasSubstr("plume")));
    EXPECT_THAT(refusal(options_for("none.obj"), file), ::testing::HasSubstr("none.obj: no such mesh file"));
    CaptureOptions options = options_for("hair");
    options.samples = 3;
    EXPECT_THAT(refusal(options, file), ::testing::HasSubstr("--samples"));
    options = options_for("hair");
    options.size = {0, 100};
    EXPECT_THAT(refusal(options, file), ::testing::HasSubstr("--size"));
    options = options_for("hair");
    options.fragments = 0;
    EXPECT_THAT(refusal(options, file), ::testing::HasSubstr("--fragments"));
    options.fragments = 1000000000000u;
    EXPECT_THAT(refusal(options, file), ::testing::HasSubstr("--fragments"));
    EXPECT_THAT(refusal(options_for("plume"), "/nowhere/at/all"), ::testing::HasSubstr("/nowhere"));
}

TEST(GlContextTest, UnknownPlatformIsRefused) {
    ::setenv("ROPSIM_GL", "teapot", 1);
    try {
        const GlContext context;
        FAIL() << "accepted";
    } catch (const UserError& error) {
        EXPECT_EQ(error.where(), "ROPSIM_GL");
        EXPECT_THAT(error.what(), ::testing::HasSubstr("surfaceless"));
    }
    ::unsetenv("ROPSIM_GL");
}

}  // namespace
}  // namespace ropsim
