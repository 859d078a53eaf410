// `ropsim shadow`: what a whole study leaves, and what it refuses.
#include "tests/cli/cli_driver.h"
#include "tests/cli/shadow_views.h"

#include <array>
#include <cmath>
#include <limits>

namespace ropsim {
namespace {

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

// The pane takes half of red, a quarter of green and nothing of blue.
class ColoredShadowCli : public ShadowCli {
 protected:
    void SetUp() override {
        ShadowCli::SetUp();
        for (const char* name : {"light", "camera"}) {
            TraceHeader header = std::string(name) == "light" ? light_ : camera_;
            header.materials = true;
            FragmentChunk chunk;
            chunk.fragments = pane_;
            chunk.materials.resize(pane_.size());
            for (Material& m : chunk.materials) {
                m.transmission[1] = 0.5f;
                m.transmission[2] = 1.0f;
            }
            TraceWriter writer(path(name), header);
            writer.append(chunk);
            writer.finish();
        }
    }
};

TEST_F(ColoredShadowCli, CastsEachColourItsOwnShadow) {
    const nlohmann::json json =
        study({"--technique", "colored_shadow_map:samples=64", "--filter", "tent:side=5", "--ambient", "0"});
    EXPECT_EQ(json["map"]["storage_bits_per_texel"], 3 * 64 * 32);
    EXPECT_EQ(json["filter"]["kind"], "tent");
    EXPECT_EQ(json["filter"]["side"].dump(), "5") << "a number, as of --filter 5";
    constexpr std::uint64_t kPixels = std::uint64_t{kSide} * kSide;
    const std::array<double, 3> exact = {0.5, 0.75, 1.0};
    const auto& receivers = json["opaque"];
    EXPECT_EQ(receivers["in_opaque_shadow"], 0);
    EXPECT_EQ(receivers["fetches"], 75 * kPixels);
    EXPECT_EQ(receivers["bytes_read"], std::uint64_t{75} * 64 * 4 * kPixels);
    EXPECT_EQ(receivers["opaque_bytes_read"], 4 * kPixels);
    std::size_t c = 0;
    for (const char* color : {"red", "green", "blue"}) {
        const auto& errors = receivers["wavelengths"][color];
        EXPECT_NEAR(errors["mean_exact_visibility"].get<double>(), exact[c], 1e-12);
        // Tents of side 5 leave (19 / 81)^2 of a texel's variance.
        const double deviation = std::sqrt(exact[c] * (1 - exact[c]) / 64) * 19 / 81;
        EXPECT_NEAR(errors["expected_noise_rmse"].get<double>(), deviation, 1e-12) << color;
        EXPECT_NEAR(errors["error"]["rmse"].get<double>(), deviation, 0.5 * deviation) << color;
        EXPECT_NEAR(errors["error"]["mean"].get<double>(), 0.0, deviation) << color;
        EXPECT_EQ(errors["error_against_transmittance"], errors["error"]) << "index 1 casts no caustic";
        ++c;
    }
    const TraceReader trace(path("out/exact.trace"));
    EXPECT_FLOAT_EQ(trace.header().opaque->rgb[0], 0.5f);
    EXPECT_FLOAT_EQ(trace.header().opaque->rgb[1], 0.75f);
    EXPECT_FLOAT_EQ(trace.header().opaque->rgb[2], 1.0f);
}

TEST_F(ColoredShadowCli, AVarianceMapIsOneFetchAWavelength) {
    const Arguments options = {"--technique", "colored_shadow_map:samples=16",
                               "--filter",    "variance:tent=5,downsample=2",
                               "--seed",      "4"};
    const nlohmann::json json = study(options);
    constexpr std::uint64_t kPixels = std::uint64_t{kSide} * kSide;
    EXPECT_EQ(json["conversion"]["width"], kSide / 2);
    EXPECT_EQ(json["conversion"]["storage_bits_per_texel"], 3 * 64);
    EXPECT_EQ(json["opaque"]["fetches"], 3 * kPixels);
    EXPECT_EQ(json["opaque"]["bytes_read"], 3 * kPixels * 4 * 8);
    EXPECT_EQ(json["filter"]["tent"].dump(), "5");
    EXPECT_EQ(json["filter"]["min_variance"], 1e-6);
    EXPECT_EQ(json["filter"]["fetch"], "bilinear");
    const auto& saving = json["saving"];
    EXPECT_EQ(saving["direct_fetches_a_lookup"], 21);
    EXPECT_EQ(saving["lookups"].dump(), std::to_string(2 * kPixels)) << "a whole number";
    EXPECT_GT(saving["conversion_cached"]["ratio"].get<double>(), 0.0);
    for (const char* color : {"red", "green"}) {
        const auto& errors = json["opaque"]["wavelengths"][color];
        // One layer before a floor that is in the map: the bound is the visibility, but for the bias.
        EXPECT_NEAR(errors["error"]["mean"].get<double>(), 0.0, 0.02) << color;
        EXPECT_GT(errors["noise"]["rmse"].get<double>(), 0.0);
        const auto& stored = json["conversion"]["variance_of_mean_depth"][color]["stored"];
        const double share = color[0] == 'r' ? 0.5 : 0.25;
        EXPECT_NEAR(stored["expected"].get<double>(), share * (1 - share) * 0.0625 / 16, 1e-9);
        // 576 means of 16 coins, whose squares have a relative deviation below the root of 2.
        EXPECT_NEAR(stored["measured"].get<double>() / stored["expected"].get<double>(), 1.0,
                    5 * std::sqrt(2.0 / kPixels));
    }
    EXPECT_EQ(json["opaque"]["wavelengths"]["blue"]["error"]["max"], 0.0);
    const std::string shadowed = read_file(path("out/shadowed.trace"));
    Arguments threaded = options;
    threaded.insert(threaded.end(), {"--threads", "3"});
    nlohmann::json again = study(threaded);
    EXPECT_EQ(read_file(path("out/shadowed.trace")), shadowed);
    again.erase("host");
    nlohmann::json first = json;
    first.erase("host");
    EXPECT_EQ(first, again);
    // Kept apart from the opaque layer, the map knows no receiver, and most of the shadow is lost.
    const nlohmann::json far = study({"--technique", "colored_shadow_map:samples=16,empty=far"});
    EXPECT_EQ(far["filter"]["kind"], "variance");
    EXPECT_GT(far["opaque"]["wavelengths"]["red"]["error"]["mean"].get<double>(), 0.15);
}

TEST_F(ColoredShadowCli, WhereNothingIsLookedUpThereIsNoRatio) {
    TraceHeader header = camera_;
    header.opaque->depth.assign(header.opaque->depth.size(), std::numeric_limits<float>::infinity());
    write_trace(path("camera"), header, {});
    const nlohmann::json saving = study({"--technique", "colored_shadow_map"})["saving"];
    EXPECT_EQ(saving["lookups"], 0);
    EXPECT_GT(saving["conversion_cached"]["conversion_bytes"], 0);
    EXPECT_TRUE(saving["conversion_cached"]["ratio"].is_null());
    EXPECT_TRUE(saving["conversion_uncached"]["ratio"].is_null());
}

TEST_F(ShadowCli, HelpNamesTheFilterThatIsTaken) {
    EXPECT_NE(expect_done({"shadow", "--help"}).find("by default 3"), std::string::npos);
}

TEST_F(ColoredShadowCli, OneWavelengthDimsAllColoursAlike) {
    const nlohmann::json json =
        study({"--technique", "colored_shadow_map:wavelengths=1,caustics=off", "--filter", "disc:side=3"});
    EXPECT_EQ(json["map"]["storage_bits_per_texel"], 32);
    EXPECT_NEAR(json["opaque"]["wavelengths"]["all"]["mean_exact_visibility"].get<double>(), 0.75, 1e-12);
    EXPECT_FALSE(json["opaque"]["wavelengths"]["all"].contains("error_against_transmittance"));
    const TraceReader trace(path("out/shadowed.trace"));
    const std::vector<float>& rgb = trace.header().opaque->rgb;
    for (std::size_t i = 0; i < rgb.size(); i += 3) EXPECT_EQ(rgb[i], rgb[i + 2]);
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
    expect_misused(shadow("light", "camera", {"--filter", "-3"}));
    expect_refused(shadow("light", "camera", {"--filter", "cone"}), {"--filter", "'cone'", "variance"});
    expect_refused(shadow("light", "camera", {"--filter", "tent:side=4"}), {"--filter", "odd"});
    expect_refused(shadow("light", "camera", {"--filter", "tent:width=5"}), {"width", "--filter"});
    expect_refused(shadow("light", "camera", {"--filter", "variance"}), {"--filter", "colored_shadow_map"});
    expect_refused(shadow("light", "camera", {"--filter", "disc", "--taps", "4"}), {"--taps", "disc"});
    const Arguments colored = {"--technique", "colored_shadow_map"};
    const auto with_filter = [&](const std::string& filter) {
        Arguments all = colored;
        all.insert(all.end(), {"--filter", filter});
        return shadow("light", "camera", all);
    };
    expect_refused(with_filter("variance:tent=4"), {"--filter", "odd"});
    expect_refused(with_filter("variance:downsample=0"), {"downsample", "--filter"});
    expect_refused(with_filter("variance:reduction=box"), {"reduction", "kept"});
    expect_refused(with_filter("variance:min_variance=-1"), {"min_variance"});
    expect_refused(shadow("light", "camera", {"--technique", "colored_shadow_map:wavelengths=2"}),
                   {"wavelengths"});
    expect_refused(shadow("light", "camera", {"--technique", "colored_shadow_map:samples=0"}), {"samples"});
    expect_misused(shadow("light", "camera", {"--ambient", "1.5"}));
    for (const char* option : {"--ambient", "--bias", "--slope-bias"})
        expect_misused(shadow("light", "camera", {option, "nan"}));
    expect_misused(shadow("light", "camera", {"--taps", "-1"}));
    write_file(path("file"), "x");
    expect_refused({"shadow", path("light"), path("camera"), "-o", path("file")}, {path("file")});
    EXPECT_FALSE(exists("out"));
}

TEST_F(ShadowCli, AnInputIsNotReplaced) {
    std::filesystem::create_directory(path("out"));
    const std::string light = read_file(path("light"));
    const std::string camera = read_file(path("camera"));
    std::filesystem::rename(path("light"), path("out/shadowed.trace"));
    expect_refused(shadow("out/shadowed.trace", "camera"), {path("out/shadowed.trace"), "also an input"});
    EXPECT_TRUE(read_file(path("out/shadowed.trace")) == light);
    std::filesystem::rename(path("out/shadowed.trace"), path("light"));
    std::filesystem::rename(path("camera"), path("out/exact.trace"));
    expect_refused(shadow("light", "out/exact.trace"), {path("out/exact.trace"), "also an input"});
    EXPECT_TRUE(read_file(path("out/exact.trace")) == camera);
    EXPECT_FALSE(exists("out/map.png"));
}

}  // namespace
}  // namespace ropsim
