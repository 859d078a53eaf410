// Exact visibility against the product of equation 3 taken fragment by fragment.
#include "rop/shadow/deep_shadow_map.h"
#include "tests/traces/scratch.h"
#include "traces/generators.h"

#include <limits>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using DeepShadowMapTest = ScratchTest;

constexpr double kFar = std::numeric_limits<double>::infinity();

TEST_F(DeepShadowMapTest, IsTheProductOverNearerFragments) {
    RandomFragments options;
    options.width = 19;
    options.height = 13;
    options.count = 4000;
    options.depth_levels = 9;  // equal depths too
    options.opaque = true;
    const TraceHeader header = random_header(options);
    const std::vector<Fragment> fragments = random_fragments(options);
    write_trace(path("light"), header, fragments);
    TraceReader reader(path("light"));
    const DeepShadowMap map(reader, 3);
    int hidden = 0;
    for (int y = 0; y < options.height; ++y) {
        for (int x = 0; x < options.width; ++x) {
            const float opaque = header.opaque->depth[static_cast<std::size_t>(y * options.width + x)];
            EXPECT_EQ(map.opaque_depth(x, y), opaque);
            double total = 1;
            for (int step = 0; step <= 40; ++step) {
                const double z = step / 40.0;
                double product = 1;
                total = 1;
                for (const Fragment& f : fragments) {
                    if (f.x != x || f.y != y || !(f.z < opaque)) continue;
                    if (static_cast<double>(f.z) < z) product *= 1 - static_cast<double>(f.a);
                    total *= 1 - static_cast<double>(f.a);
                }
                hidden += z > static_cast<double>(opaque) ? 1 : 0;
                if (z > static_cast<double>(opaque)) product = 0;
                EXPECT_NEAR(map.visibility(x, y, z), product, 1e-12) << x << ',' << y << ' ' << z;
            }
            EXPECT_NEAR(map.total_alpha(x, y), 1 - total, 1e-12);
        }
    }
    EXPECT_GT(hidden, 100);
}

// Frosted glass covers its texel and lets three quarters of the light through.
TEST_F(DeepShadowMapTest, GlassShadowsByWhatItAbsorbs) {
    TraceHeader header;
    header.width = header.height = 1;
    header.draws.resize(1);
    header.materials = true;
    FragmentChunk pane;
    pane.fragments = {{0.5f, 0, 0, 0, 1, 0, 0, 0, 1, 0}};
    pane.materials.resize(1);
    for (float& t : pane.materials[0].transmission) t = 0.75f;
    TraceWriter writer(path("light"), header);
    writer.append(pane);
    writer.finish();
    TraceReader reader(path("light"));
    EXPECT_EQ(DeepShadowMap(reader, 1).visibility(0, 0, kFar), 0.75);
}

TEST_F(DeepShadowMapTest, AFragmentDoesNotShadowItsOwnDepth) {
    TraceHeader header;
    header.width = header.height = 1;
    header.draws.resize(1);
    write_trace(path("light"), header,
                {{0.5f, 0, 0, 0, 0.25f, 0, 0, 0, 1, 0}, {0.75f, 0, 0, 0, 0.5f, 0, 0, 1, 1, 0}});
    TraceReader reader(path("light"));
    const DeepShadowMap map(reader, 1);
    EXPECT_EQ(map.visibility(0, 0, 0.25), 1);
    EXPECT_EQ(map.visibility(0, 0, 0.5), 1);
    EXPECT_EQ(map.visibility(0, 0, std::nextafter(0.5, 1.0)), 0.75);
    EXPECT_EQ(map.visibility(0, 0, 0.75), 0.75);
    EXPECT_EQ(map.visibility(0, 0, kFar), 0.375);
    EXPECT_EQ(map.total_alpha(0, 0), 0.625);
}

// Two fragments that take 0.5 of red and, behind, 0.25 of it; alpha says otherwise.
TEST_F(DeepShadowMapTest, TakesAnotherShareThanAlphaWhereAsked) {
    TraceHeader header;
    header.width = header.height = 1;
    header.materials = true;
    header.draws.resize(1);
    header.opaque.emplace();
    header.opaque->rgb = {0, 0, 0};
    header.opaque->depth = {0.875f};
    FragmentChunk chunk;
    chunk.fragments = {{0.5f, 0, 0, 0, 1.0f, 0, 0, 0, 1, 0}, {0.25f, 0, 0, 0, 1.0f, 0, 0, 1, 1, 0}};
    chunk.materials.resize(2);
    chunk.materials[0].transmission[0] = 0.75f;
    chunk.materials[1].transmission[0] = 0.5f;
    TraceWriter writer(path("light"), header);
    writer.append(chunk);
    writer.finish();
    TraceReader reader(path("light"));
    const auto red = [](const Fragment& f, const Material& m) {
        return static_cast<double>(f.a * (1 - m.transmission[0]));
    };
    const DeepShadowMap without(reader, red, false, 1);
    EXPECT_EQ(without.visibility(0, 0, 0.375), 0.5);
    EXPECT_EQ(without.visibility(0, 0, 0.75), 0.375);
    EXPECT_EQ(without.visibility(0, 0, 0.9), 0.375) << "the opaque layer is left out";
    EXPECT_EQ(DeepShadowMap(reader, red, true, 1).visibility(0, 0, 0.9), 0.0);
    // What a stochastic map keeps: 0.25 in half of all cases, 0.5 in an eighth, else nothing.
    const DeepShadowMap::DepthMean kept = without.depth_kept(0, 0, 1.0);
    EXPECT_DOUBLE_EQ(kept.mean, 0.5 * 0.25 + 0.125 * 0.5 + 0.375);
    EXPECT_DOUBLE_EQ(kept.square, 0.5 * 0.0625 + 0.125 * 0.25 + 0.375);
    EXPECT_DOUBLE_EQ(kept.variance(), kept.square - kept.mean * kept.mean);
    EXPECT_DOUBLE_EQ(without.depth_kept(0, 0, 0.875).mean, 0.5 * 0.25 + 0.125 * 0.5 + 0.375 * 0.875);
}

}  // namespace
}  // namespace ropsim
