// `ropsim shadow` where light falls aslant: what a variance map is held against.
#include "rop/shadow/light_space.h"
#include "tests/cli/cli_driver.h"
#include "tests/cli/shadow_views.h"

namespace ropsim {
namespace {

// A pane at y = 0.2 over the floor, without end, and a light that falls on them at 45 degrees.
class SlantedShadowCli : public Cli {
 protected:
    static constexpr int kTexels = 48;

    // Depth at which the light meets the plane y = height in texel (x, y).
    static float met(const TraceHeader& light, int x, int y, double height) {
        const double near = LightSpace::world(light, {x + 0.5, y + 0.5, 0}).y;
        const double far = LightSpace::world(light, {x + 0.5, y + 0.5, 1}).y;
        return static_cast<float>((near - height) / (near - far));
    }
    void write(const std::string& name, const TraceHeader& header, const FragmentChunk& chunk) const {
        TraceWriter writer(path(name), header);
        writer.append(chunk);
        writer.finish();
    }
    void SetUp() override {
        Cli::SetUp();
        TraceHeader light = seen_from_above("light", 1);
        light.width = light.height = kTexels;
        light.materials = true;
        light.camera->view = glm::lookAt(glm::vec3(4, 4, 0), glm::vec3(0), glm::vec3(0, 0, -1));
        light.camera->projection = glm::ortho(-1.0f, 1.0f, -1.0f, 1.0f, 1.0f, 13.0f);
        light.opaque->rgb.assign(std::size_t{3} * kTexels * kTexels, 1.0f);
        light.opaque->depth.clear();
        TraceHeader camera = seen_from_above("camera", 0.2f);
        camera.light = light.camera;
        camera.materials = true;
        FragmentChunk lit;
        for (int y = 0; y < kTexels; ++y)
            for (int x = 0; x < kTexels; ++x) {
                light.opaque->depth.push_back(met(light, x, y, 0));
                lit.fragments.push_back({met(light, x, y, 0.2), 0.5f, 0.5f, 0.5f, 0.5f,
                                         static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y), 0, 1,
                                         0});
            }
        lit.materials.resize(lit.fragments.size());
        FragmentChunk seen;
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x)
                seen.fragments.push_back({0.45f, 0.5f, 0.5f, 0.5f, 0.5f, static_cast<std::uint16_t>(x),
                                          static_cast<std::uint16_t>(y), 0, 1, 0});
        seen.materials.resize(seen.fragments.size());
        write("light", light, lit);
        write("camera", camera, seen);
    }
};

TEST_F(SlantedShadowCli, NoSurfaceShadesItselfInWhatAVarianceMapIsHeldAgainst) {
    // The second slope bias is below the surfaces' own 0.0035 a texel.
    for (const char* slope_bias : {"0.01", "0.002"}) {
        expect_done({"shadow", path("light"), path("camera"), "--technique",
                     "colored_shadow_map:wavelengths=1,samples=4", "--slope-bias", slope_bias, "--ambient",
                     "0", "-o", path("out")});
        const auto json = nlohmann::json::parse(read_file(path("out/shadow.json")));
        EXPECT_EQ(json["opaque"]["in_opaque_shadow"], 0);
        EXPECT_EQ(json["opaque"]["outside"], 0);
        const auto mean = [&](const char* receivers) {
            return json[receivers]["wavelengths"]["all"]["mean_exact_visibility"].get<double>();
        };
        EXPECT_NEAR(mean("fragments"), 1.0, 1e-12) << slope_bias;
        EXPECT_NEAR(mean("opaque"), 0.5, 1e-12) << slope_bias;
        for (const Fragment& f : read_fragments(path("out/exact.trace"))) EXPECT_FLOAT_EQ(f.r, 0.5f);
    }
}

}  // namespace
}  // namespace ropsim
