// `ropsim shadow`: what a whole study leaves, and what it refuses.
#include "tests/cli/cli_driver.h"

#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {
namespace {

constexpr int kSide = 24;

// A pane of alpha 0.5 at y = 1 over the floor at y = 0, both as large as the views, each seen straight from
// above: by the light in all of x, z in [-1, 1] and by the camera in the middle half of it.
TraceHeader seen_from_above(const std::string& view, float half_side) {
    TraceHeader header;
    header.width = header.height = kSide;
    header.scene = "a pane above a floor";
    header.view = view;
    header.draws.resize(1);
    header.camera.emplace();
    header.camera->view = glm::lookAt(glm::vec3(0, 4, 0), glm::vec3(0), glm::vec3(0, 0, -1));
    header.camera->projection = glm::ortho(-half_side, half_side, -half_side, half_side, 2.0f, 6.0f);
    constexpr auto kPixels = static_cast<std::size_t>(kSide) * kSide;
    header.opaque.emplace();
    header.opaque->rgb.assign(3 * kPixels, 1.0f);
    header.opaque->depth.assign(kPixels, 0.5f);
    return header;
}

class ShadowCli : public Cli {
 protected:
    void SetUp() override {
        Cli::SetUp();
        std::vector<Fragment> pane;
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x)
                pane.push_back({0.25f, 0.5f, 0.5f, 0.5f, 0.5f, static_cast<std::uint16_t>(x),
                                static_cast<std::uint16_t>(y), 0, 1, 0});
        light_ = seen_from_above("light", 1);
        camera_ = seen_from_above("camera", 0.5f);
        camera_.light = light_.camera;
        pane_ = pane;
        write_trace(path("light"), light_, pane);
        write_trace(path("camera"), camera_, pane);
    }
    Arguments shadow(const std::string& light, const std::string& camera, const Arguments& more = {}) const {
        Arguments all = {"shadow", path(light), path(camera), "-o", path("out")};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
    nlohmann::json study(const Arguments& more = {}) const {
        expect_done(shadow("light", "camera", more));
        return nlohmann::json::parse(read_file(path("out/shadow.json")));
    }

    TraceHeader light_, camera_;
    std::vector<Fragment> pane_;
};

TEST_F(ShadowCli, AStudyLeavesTracesPicturesAndNumbers) {
    const nlohmann::json json =
        study({"--technique", "shadow_map:samples=8,total_alpha=on", "--ambient", "0.25", "--threads", "2"});
    for (const char* name : {"out/map.png", "out/shadowed.png", "out/shadowed.trace", "out/exact.trace"})
        EXPECT_TRUE(exists(name)) << name;
    constexpr std::uint64_t kPixels = std::uint64_t{kSide} * kSide;
    constexpr std::uint64_t kTexels = 9 * kPixels;  // of a 3 x 3 filter
    EXPECT_EQ(json["map"]["samples"], 8);
    EXPECT_EQ(json["map"]["storage_bits_per_texel"], 8 * 32 + 16);
    EXPECT_GT(json["map"]["traffic"]["depth"]["write_bytes"], 0);
    EXPECT_EQ(json["map"]["fragments"]["operated"], kPixels);
    // Nothing shadows the pane; it takes half of the floor's light, and total alpha says so exactly.
    EXPECT_EQ(json["fragments"]["count"], kPixels);
    EXPECT_EQ(json["fragments"]["outside"], 0);
    EXPECT_EQ(json["fragments"]["mean_exact_visibility"], 1.0);
    EXPECT_EQ(json["fragments"]["error"]["max"], 0.0);
    EXPECT_EQ(json["fragments"]["samples_read"], 8 * kTexels);
    EXPECT_EQ(json["fragments"]["bytes_read"], (8 * 4 + 2 + 4) * kTexels);
    EXPECT_EQ(json["opaque"]["count"], kPixels);
    EXPECT_EQ(json["opaque"]["mean_exact_visibility"], 0.5);
    EXPECT_EQ(json["opaque"]["error"]["max"], 0.0);
    EXPECT_EQ(json["opaque"]["bytes_read"], (2 + 4) * kTexels);
    for (const char* name : {"out/shadowed.trace", "out/exact.trace"}) {
        const TraceReader trace(path(name));
        for (const float c : trace.header().opaque->rgb) EXPECT_EQ(c, 0.25f + 0.75f * 0.5f);
        EXPECT_EQ(trace.header().view, "camera");
        for (const Fragment& f : read_fragments(path(name))) EXPECT_EQ(f.r, 0.5f);
    }
    // The shadowed trace is a trace like another.
    expect_done({"run", path("out/shadowed.trace"), "--technique", "a_buffer", "--fidelity", "count", "-o",
                 path("run")});
}

TEST_F(ShadowCli, UncorrectedFloorsAreRightOnAverageAndThreadsDoNotMatter) {
    const nlohmann::json json = study({"--technique", "shadow_map:samples=1", "--seed", "5"});
    EXPECT_EQ(json["map"]["storage_bits_per_texel"], 32);
    // 14 x 14 texels of one coin each lie under the camera's view and its filter, 12 x 12 of them in its
    // middle.
    EXPECT_NEAR(json["opaque"]["error"]["mean"].get<double>(), 0.0, 5 * 0.5 / 12);
    EXPECT_GT(json["opaque"]["error"]["rmse"].get<double>(), 0.05);
    const std::string shadowed = read_file(path("out/shadowed.trace"));
    nlohmann::json again = study({"--technique", "shadow_map:samples=1", "--seed", "5", "--threads", "3"});
    EXPECT_EQ(read_file(path("out/shadowed.trace")), shadowed);
    nlohmann::json first = json;
    first.erase("host");
    again.erase("host");
    EXPECT_EQ(first, again);
    study({"--technique", "shadow_map:samples=1", "--seed", "6"});
    EXPECT_NE(read_file(path("out/shadowed.trace")), shadowed);
    const nlohmann::json taps = study({"--filter", "11", "--taps", "16"});
    EXPECT_EQ(taps["filter"]["taps"], 16);
    EXPECT_EQ(taps["opaque"]["texels_read"], std::uint64_t{16} * kSide * kSide);
}

TEST_F(ShadowCli, TracesThatDoNotBelongTogetherAreRefused) {
    const auto with = [&](const std::string& name, const TraceHeader& header) {
        write_trace(path(name), header, pane_);
        return name;
    };
    expect_refused(shadow("camera", "camera"), {path("camera"), "--view light"});
    expect_refused(shadow("light", "light"), {path("light"), "view of the light"});
    TraceHeader header = camera_;
    header.camera.reset();
    expect_refused(shadow("light", with("blind", header)), {path("blind"), "no camera"});
    header = camera_;
    header.scene = "another";
    expect_refused(shadow("light", with("another", header)), {path("another"), "'another'", "one scene"});
    header = camera_;
    header.light->view[3][0] += 1;
    expect_refused(shadow("light", with("elsewhere", header)), {path("elsewhere"), "another light"});
    header = camera_;
    header.camera->projection = glm::mat4(0.0f);
    expect_refused(shadow("light", with("flat", header)), {path("flat"), "inverted"});
    expect_refused(shadow("missing", "camera"), {path("missing")});
    header = light_;
    header.samples = 2;
    header.opaque.reset();
    expect_refused(shadow(with("two", header), "camera"), {path("two"), "--samples 1"});
    EXPECT_FALSE(exists("out"));
}

TEST_F(ShadowCli, OptionsThatMakeNoSenseAreRefused) {
    expect_refused(shadow("light", "camera", {"--filter", "4"}), {"--filter", "odd"});
    expect_refused(shadow("light", "camera", {"--technique", "stochastic"}), {"--technique", "shadow_map"});
    expect_refused(shadow("light", "camera", {"--technique", "shadow_map:sample=2"}), {"sample", "samples"});
    expect_refused(shadow("light", "camera", {"--hardware", "toaster"}), {"toaster"});
    expect_misused(shadow("light", "camera", {"--filter", "65"}));
    expect_misused(shadow("light", "camera", {"--ambient", "1.5"}));
    expect_misused(shadow("light", "camera", {"--taps", "-1"}));
    write_file(path("file"), "x");
    expect_refused({"shadow", path("light"), path("camera"), "-o", path("file")}, {path("file")});
    EXPECT_FALSE(exists("out"));
}

}  // namespace
}  // namespace ropsim
