// The scenes after Salvi et al. 2011: their published counts, and what makes each of them what it is.
#include "capture/capture.h"
#include "capture/scene_list.h"
#include "tests/capture/own_file.h"
#include "tests/capture/test_scene.h"
#include "traces/trace.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <gmock/gmock.h>

namespace ropsim {
namespace {

using PublishedAdaptiveTransparencyTest = testing::OpenGlTest;
using AdaptiveTransparencyScenesTest = testing::OpenGlTest;

// Captures into a file and hands its fragments to `each`.
template <typename Each>
TraceHeader capture(const CaptureOptions& options, const Each& each) {
    const std::string file = test::own_file("trace");
    capture_scene(options, file);
    TraceReader reader(file);
    TraceHeader header = reader.header();
    FragmentChunk chunk;
    while (reader.next(chunk)) {
        for (const Fragment& f : chunk.fragments) each(header, f);
    }
    return header;
}

CaptureOptions small(const std::string& scene) {
    CaptureOptions options;
    options.scene_or_file = scene;
    options.size = {320, 180};
    return options;
}

void expect_counts(const std::string& scene, int samples, double fragments, double deepest) {
    CaptureOptions options;
    options.scene_or_file = scene;
    options.samples = samples;
    std::vector<std::uint32_t> layers;
    double count = 0;
    capture(options, [&](const TraceHeader& header, const Fragment& f) {
        layers.resize(static_cast<std::size_t>(header.width * header.height));
        ++layers[static_cast<std::size_t>(f.y * header.width + f.x)];
        ++count;
    });
    EXPECT_NEAR(count / fragments, 1.0, 0.02) << scene << " x" << samples;
    EXPECT_NEAR(*std::max_element(layers.begin(), layers.end()) / deepest, 1.0, 0.05)
        << scene << " x" << samples;
}

// Table 1 of the paper, which the scene list repeats.
TEST_F(PublishedAdaptiveTransparencyTest, Smoke) {
    expect_counts("smoke", 1, 10.6e6, 312);
}

TEST_F(PublishedAdaptiveTransparencyTest, Forest) {
    expect_counts("forest", 1, 6.0e6, 45);
}

TEST_F(PublishedAdaptiveTransparencyTest, PowerPlantWithOneAndFourSamples) {
    expect_counts("power_plant", 1, 2.69e6, 35);
    expect_counts("power_plant", 4, 3.47e6, 60);
}

TEST_F(AdaptiveTransparencyScenesTest, FragmentsFollowTheRequest) {
    for (const char* scene : {"smoke", "forest", "power_plant"}) {
        for (std::uint64_t wanted : {8000u, 90000u, 900000u}) {
            CaptureOptions options = small(scene);
            options.fragments = wanted;
            double count = 0;
            capture(options, [&](const TraceHeader&, const Fragment&) { ++count; });
            EXPECT_NEAR(count / static_cast<double>(wanted), 1.0, 0.04) << scene << " " << wanted;
        }
        CaptureOptions options = small(scene);
        options.fragments = 1'000'000'000'000u;
        EXPECT_THROW(capture(options, [](const TraceHeader&, const Fragment&) {}), UserError) << scene;
    }
}

TEST_F(AdaptiveTransparencyScenesTest, EveryFragmentCoversSomethingAndNoneIsSorted) {
    for (const char* scene : {"smoke", "forest", "power_plant"}) {
        std::vector<float> last(std::size_t{320} * 180, -1.0f);
        double nearer = 0;
        double pairs = 0;
        float least = 1;
        capture(small(scene), [&](const TraceHeader&, const Fragment& f) {
            least = std::min(least, f.a);
            float& before = last[static_cast<std::size_t>(f.y * 320 + f.x)];
            if (before >= 0) {
                nearer += f.z < before;
                ++pairs;
            }
            before = f.z;
        });
        EXPECT_GT(least, 0.001f) << scene;
        EXPECT_GT(nearer / pairs, 0.3) << scene;
        EXPECT_LT(nearer / pairs, 0.7) << scene;
    }
}

// Depths of the fragments of one pixel, nearest and farthest of each draw.
using DepthRanges = std::map<std::string, std::pair<float, float>>;

TEST_F(AdaptiveTransparencyScenesTest, SmokeIsBeforeAndBehindTheFenceAndTheGlass) {
    std::vector<DepthRanges> pixels(std::size_t{320} * 180);
    const auto is_smoke = [](const std::string& name) { return name.find("smoke") != std::string::npos; };
    capture(small("smoke"), [&](const TraceHeader& header, const Fragment& f) {
        const std::string& name = header.draws[f.draw].name;
        DepthRanges& ranges = pixels[static_cast<std::size_t>(f.y * 320 + f.x)];
        const auto at = ranges.try_emplace(is_smoke(name) ? "smoke" : name, f.z, f.z).first;
        at->second = {std::min(at->second.first, f.z), std::max(at->second.second, f.z)};
    });
    for (const char* thing : {"fence", "car windows", "leaves", "windows"}) {
        int through = 0;
        int clear = 0;
        for (const DepthRanges& ranges : pixels) {
            if (!ranges.contains(thing)) continue;
            const float z = ranges.at(thing).second;
            const bool smoky = ranges.contains("smoke");
            through += smoky && ranges.at("smoke").first < z;
            clear += !smoky || ranges.at("smoke").second > z;
        }
        EXPECT_GT(through, 20) << thing << " behind smoke";
        EXPECT_GT(clear, 5) << thing << " before it or free of it";
    }
    int crossed = 0;
    for (const DepthRanges& ranges : pixels) {
        crossed += ranges.contains("smoke") && ranges.contains("fence") &&
                   ranges.at("smoke").first < ranges.at("fence").first &&
                   ranges.at("smoke").second > ranges.at("fence").second;
    }
    EXPECT_GT(crossed, 300) << "pixels in which smoke passes through the wire";
}

TEST_F(AdaptiveTransparencyScenesTest, LeavesHaveSoftEdges) {
    double count = 0;
    double solid = 0;
    double soft = 0;
    capture(small("forest"), [&](const TraceHeader&, const Fragment& f) {
        ++count;
        solid += f.a > 0.85f;
        soft += f.a > 0.05f && f.a < 0.85f;
    });
    EXPECT_GT(solid / count, 0.02);
    EXPECT_GT(soft / count, 0.4);
}

}  // namespace
}  // namespace ropsim
