// What must hold of every built-in scene: its trace survives every interchange format bit for bit, is the
// same for any number of driver threads, and follows --fragments.
#include "capture/capture.h"
#include "capture/scene_list.h"
#include "tests/capture/own_file.h"
#include "tests/capture/test_scene.h"
#include "tests/traces/trace_conversion.h"
#include "traces/interchange/csv.h"
#include "traces/interchange/deep_exr.h"
#include "traces/trace.h"

#include <cstdlib>
#include <filesystem>

#include <gmock/gmock.h>

namespace ropsim {
namespace {

class EverySceneTest : public testing::OpenGlTest, public ::testing::WithParamInterface<std::string> {
 protected:
    void SetUp() override {
        OpenGlTest::SetUp();
        if ((GetParam() == "horse" || GetParam() == "bunny") &&
            !std::filesystem::exists("/usr/share/glmark2/models/horse.3ds"))
            GTEST_SKIP() << "glmark2-data is not installed";
        directory_ = test::own_file("scene");
        std::filesystem::create_directories(directory_);
    }
    void TearDown() override {
        if (!directory_.empty()) std::filesystem::remove_all(directory_);
    }
    std::string path(const std::string& name) const { return directory_ + "/" + name; }

    CaptureSummary capture(const std::string& name, int samples = 1) const {
        CaptureOptions options;
        options.scene_or_file = GetParam();
        options.size = {80, 45};
        options.samples = samples;
        return capture_scene(options, path(name));
    }
    std::string hash(const std::string& name) const { return TraceReader(path(name)).hash(); }

    std::string directory_;
};

TEST_P(EverySceneTest, SurvivesEveryFormatAtOneAndFourSamples) {
    for (const int samples : {1, 4}) {
        capture("scene.trace", samples);
        const FragmentChunk original = read_raw(path("scene.trace"));
        ASSERT_GT(original.size(), 0u);
        EXPECT_EQ(original.slopes.size(), samples > 1 ? original.size() : 0u);
        export_deep_exr(path("scene.trace"), path("scene.exr"));
        import_deep_exr(path("scene.exr"), path("deep.trace"));
        EXPECT_EQ(hash("deep.trace"), hash("scene.trace")) << samples << " samples";
        export_csv(path("scene.trace"), path("scene.csv"));
        import_csv(path("scene.csv"), path("text.trace"));
        const FragmentChunk text = read_raw(path("text.trace"));
        EXPECT_TRUE(same_content(text, original)) << samples << " samples";
    }
}

TEST_P(EverySceneTest, IsTheSameForAnyDriverThreadsAndRun) {
    setenv("LP_NUM_THREADS", "1", 1);
    capture("one.trace", 4);
    setenv("LP_NUM_THREADS", "2", 1);
    capture("two.trace", 4);
    capture("again.trace", 4);
    unsetenv("LP_NUM_THREADS");
    EXPECT_EQ(hash("one.trace"), hash("two.trace"));
    EXPECT_EQ(hash("two.trace"), hash("again.trace"));
}

TEST_P(EverySceneTest, LightSeesTheTransparentGeometry) {
    CaptureOptions options;
    options.scene_or_file = GetParam();
    options.size = {64, 64};
    options.light_view = true;
    const CaptureSummary summary = capture_scene(options, path("light.trace"));
    EXPECT_GT(summary.fragments, 500u);
    TraceReader reader(path("light.trace"));
    EXPECT_EQ(reader.header().view, "light");
    ASSERT_TRUE(reader.header().light);
    EXPECT_EQ(reader.header().camera->view, reader.header().light->view);
}

TEST_P(EverySceneTest, DrawsSayWhatTheyAreAndCost) {
    capture("scene.trace");
    const TraceReader reader(path("scene.trace"));
    for (const Draw& draw : reader.header().draws) {
        EXPECT_FALSE(draw.name.empty());
        EXPECT_GT(draw.full.alu_instructions, 0u) << draw.name;
        EXPECT_LE(draw.alpha.alu_instructions, draw.full.alu_instructions) << draw.name;
        EXPECT_LE(draw.alpha.texture_fetches, draw.full.texture_fetches) << draw.name;
        EXPECT_EQ(draw.full.texture_bytes == 0, draw.full.texture_fetches == 0) << draw.name;
        EXPECT_NE(draw.cost_source, "default") << draw.name;
    }
}

TEST_P(EverySceneTest, FollowsTheNumberOfFragmentsAskedFor) {
    CaptureOptions options;
    options.scene_or_file = GetParam();
    options.size = {320, 180};
    for (const double factor : {0.4, 1.6}) {
        options.fragments.reset();
        const double base = static_cast<double>(capture_scene(options, path("base.trace")).fragments);
        options.fragments = static_cast<std::uint64_t>(factor * base);
        const double got = static_cast<double>(capture_scene(options, path("asked.trace")).fragments);
        EXPECT_NEAR(got / (factor * base), 1.0, 0.05) << factor;
    }
}

std::vector<std::string> scene_names() {
    std::vector<std::string> names;
    for (const SceneInfo& scene : scene_list()) names.push_back(scene.name);
    return names;
}

INSTANTIATE_TEST_SUITE_P(Scenes, EverySceneTest, ::testing::ValuesIn(scene_names()),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace ropsim
