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

}  // namespace
}  // namespace ropsim
