// `ropsim trace volume` and `ropsim reference --transmission`: what they write, say and refuse.
#include "tests/cli/cli_driver.h"
#include "traces/image.h"
#include "traces/trace.h"

#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {
namespace {

using ::testing::HasSubstr;

class VolumeCli : public Cli {
 protected:
    void SetUp() override {
        Cli::SetUp();
        TraceHeader header;
        header.width = header.height = 16;
        header.background = {0, 0, 0};
        header.camera.emplace();
        header.camera->projection = glm::ortho(-1.0f, 1.0f, -1.0f, 1.0f, 1.0f, 11.0f);
        header.light = header.camera;
        write_trace(path("view"), header, {});
    }
    Arguments volume(const Arguments& more = {}) const {
        Arguments all = {"trace", "volume", path("view"), "-o", path("fog")};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
};

TEST_F(VolumeCli, FillsAViewWithFog) {
    const ProgramResult r = run_program(volume(
        {"--extinction", "0.1", "--albedo", "1,0.5,0", "--light", "0", "--ambient", "2", "--steps", "4"}));
    EXPECT_EQ(r.status, 0) << r.err;
    EXPECT_THAT(r.err, HasSubstr("draw 'volume': 1024 fragments in 256 pixels"));
    expect_done({"reference", path("fog"), "-o", path("fog.exr")});
    const Image image = read_exr(path("fog.exr"));
    const double air = 2 * (1 - std::exp(-1));
    EXPECT_NEAR(image.pixel(3, 3)[0], air, 1e-5);
    EXPECT_NEAR(image.pixel(3, 3)[1], air / 2, 1e-5);
    EXPECT_EQ(image.pixel(3, 3)[2], 0);
    EXPECT_EQ(expect_json({"trace", "info", path("fog"), "--json"})["draw_list"][0]["name"], "volume");
}

TEST_F(VolumeCli, RefusesWhatMakesNoMedium) {
    expect_refused(volume({"--anisotropy", "1"}), {"--anisotropy", "between -1 and 1"});
    expect_refused(volume({"--extinction", "-0.5"}), {"--extinction", "-0.5"});
    for (const char* rgb : {"1,2", "1,1,1,1", "red", "", "1,,1", "1,1,", "1,", "1,1,1,", ",1"})
        expect_refused(volume({"--albedo", rgb}), {"--albedo", "R,G,B"});
    expect_refused(volume({"--far", "0"}), {"--far"});
    expect_refused(volume({"--shadows", path("view")}), {"view", "--view light"});
    expect_refused(volume({"--shadows", path("none"), "--light", "0"}), {"--shadows", "--light of 0"});
    expect_refused(volume({"--filter", "3"}), {"--filter", "without --shadows"});
    expect_refused(volume({"--base-height", "2"}), {"--base-height", "without --height-falloff"});
    expect_refused(volume({"--seed", "2"}), {"--seed", "without --jitter"});
    expect_refused({"trace", "volume", path("trace"), "-o", path("x")}, {"has no camera"});
    expect_misused(volume({"--steps", "many"}));
    expect_misused(volume({"--color", "float64"}));
    expect_misused({"trace", "volume", path("view")});
    EXPECT_FALSE(exists("fog"));
}

TEST_F(VolumeCli, ASecondMediumIsRefused) {
    expect_done(volume());
    expect_refused({"trace", "volume", path("fog"), "-o", path("fogs")}, {path("fog"), "'volume' already"});
    EXPECT_FALSE(exists("fogs"));
}

TEST_F(VolumeCli, AReferenceIsAPngByAnyCaseOfItsName) {
    for (const char* name : {"x.png", "x.PNG", "x.Png"}) {
        expect_done({"reference", path("view"), "-o", path(name)});
        EXPECT_EQ(read_file(path(name)).substr(1, 3), "PNG") << name;
    }
    expect_done({"reference", path("view"), "-o", path("png")});
    EXPECT_EQ(read_exr(path("png")).width, 16);
}

TEST_F(VolumeCli, TheReferenceKnowsTwoTransmissions) {
    TraceHeader header;
    header.width = header.height = 1;
    header.background = {1, 1, 1};
    header.draws.resize(1);
    header.materials = true;
    FragmentChunk pane;
    pane.fragments = {{0.5f, 0, 0, 0, 1, 0, 0, 0, 1, 0}};
    pane.materials.resize(1);
    pane.materials[0].transmission[1] = 0.5f;
    TraceWriter writer(path("pane"), header);
    writer.append(pane);
    writer.finish();
    expect_done({"reference", path("pane"), "-o", path("default.exr")});
    expect_done({"reference", path("pane"), "-o", path("alpha.exr"), "--transmission", "alpha"});
    expect_done({"reference", path("pane"), "-o", path("colored.exr"), "--transmission", "colored"});
    EXPECT_EQ(read_exr(path("default.exr")).values, read_exr(path("alpha.exr")).values);
    EXPECT_EQ(read_exr(path("alpha.exr")).pixel(0, 0)[1], 0);
    EXPECT_EQ(read_exr(path("colored.exr")).pixel(0, 0)[1], 0.5f);
    expect_misused({"reference", path("pane"), "-o", path("x.exr"), "--transmission", "red"});
}

}  // namespace
}  // namespace ropsim
