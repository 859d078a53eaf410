// Depth ranges against the depth test itself, fragment by fragment: what they decide is never wrong, and what
// they leave undecided could not be decided by the tile's nearest and farthest depth.
#include "model/hierarchical_depth.h"

#include "tests/model/machine_driver.h"
#include "traces/depth_test.h"

#include <random>

namespace ropsim {
namespace {

// Tiles of every kind: empty background, a slanted plane, noise, one that is half background.
TraceHeader scenery(int width, int height, int samples, unsigned seed) {
    TraceHeader header = plain_header(width, height);
    header.samples = samples;
    header.depth_slopes = samples > 1;
    header.opaque.emplace();
    const auto count = static_cast<std::size_t>(width * height * samples);
    header.opaque->rgb.assign(3 * count, 0.0f);
    header.opaque->depth.assign(count, std::numeric_limits<float>::infinity());
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(0.0f, 1.0f);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int m = 0; m < samples; ++m) {
                const int kind = (x / 8 + y / 8) % 4;
                float& z = header.opaque->depth[static_cast<std::size_t>((y * width + x) * samples + m)];
                if (kind == 1) z = 0.3f + 0.01f * static_cast<float>(x % 8) + 0.001f * static_cast<float>(m);
                if (kind == 2) z = unit(random);
                if (kind == 3 && x % 8 < 4) z = 0.5f;
            }
    return header;
}

struct Decided {
    int behind = 0, in_front = 0, undecided = 0, avoidable = 0;
};

Decided decide_many(const TraceHeader& header, const HierarchicalDepthConfig& config, unsigned seed) {
    const HierarchicalDepth ranges(header, config, 1);
    const OpaqueDepthTest test(header);
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(0.0f, 1.0f);
    Decided decided;
    for (int i = 0; i < 20000; ++i) {
        const int x = static_cast<int>(random() % static_cast<unsigned>(header.width));
        const int y = static_cast<int>(random() % static_cast<unsigned>(header.height));
        float z = unit(random);
        const auto samples = static_cast<std::size_t>(header.samples);
        const std::size_t pixel = (static_cast<std::size_t>(y) * static_cast<std::size_t>(header.width) +
                                   static_cast<std::size_t>(x)) *
                                  samples;
        // Every third exactly at a depth that is there, or next to it.
        if (i % 3 == 0) z = std::min(header.opaque->depth[pixel], 1.0f);
        if (i % 9 == 0) z = std::nextafter(z, 0.0f);
        Fragment f = fragment_at(x, y, z, 0);
        f.coverage = static_cast<std::uint16_t>((1u << header.samples) - 1u);
        DepthSlope slope;
        if (header.depth_slopes && i % 2 == 0) slope = {unit(random) - 0.5f, unit(random) * 1e-6f};
        const std::uint32_t visible = test.visible_samples(f, slope);
        const std::uint8_t answer = ranges.decide(f, slope);
        if (answer == kDepthBehind) {
            EXPECT_EQ(visible, 0u) << x << "," << y << " z " << z;
        }
        if (answer == kDepthInFront) {
            EXPECT_EQ(visible, f.coverage) << x << "," << y << " z " << z;
        }
        decided.behind += answer == kDepthBehind ? 1 : 0;
        decided.in_front += answer == kDepthInFront ? 1 : 0;
        decided.undecided += answer == kDepthUndecided ? 1 : 0;
        // Of the tile: by brute force.
        float nearest = std::numeric_limits<float>::infinity();
        float farthest = 0;
        for (int v = y / 8 * 8; v < std::min(y / 8 * 8 + 8, header.height); ++v)
            for (int u = x / 8 * 8; u < std::min(x / 8 * 8 + 8, header.width); ++u)
                for (int m = 0; m < header.samples; ++m) {
                    const float at =
                        header.opaque
                            ->depth[static_cast<std::size_t>((v * header.width + u) * header.samples + m)];
                    nearest = std::min(nearest, at);
                    farthest = std::max(farthest, at);
                }
        const bool possible = slope.dx == 0 && (z >= farthest || z < nearest);
        decided.avoidable += answer == kDepthUndecided && possible ? 1 : 0;
    }
    return decided;
}

TEST(HierarchicalDepthTest, NeverContradictsTheDepthTest) {
    for (const int samples : {1, 4}) {
        const TraceHeader header = scenery(61, 43, samples, 5);
        for (const std::uint32_t bits : {4u, 14u, 24u, 32u}) {
            HierarchicalDepthConfig config;
            config.bits = bits;
            const Decided d = decide_many(header, config, 6);
            EXPECT_GT(d.behind, 1000) << bits;
            EXPECT_GT(d.in_front, 1000) << bits;
            EXPECT_GT(d.undecided, 1000) << bits;
            if (bits == 32) {
                EXPECT_EQ(d.avoidable, 0);
            }
        }
    }
}

TEST(HierarchicalDepthTest, KeepsWhatItIsGiven) {
    const TraceHeader header = scenery(64, 64, 1, 7);
    HierarchicalDepthConfig config;
    EXPECT_EQ(HierarchicalDepth(header, config, 1).bytes(), 64u * 28 / 8);
    config.accepts = false;
    EXPECT_EQ(HierarchicalDepth(header, config, 1).bytes(), 64u * 14 / 8);
    EXPECT_EQ(decide_many(header, config, 8).in_front, 0);
    config.enabled = false;
    EXPECT_EQ(HierarchicalDepth(header, config, 1).bytes(), 0u);
    const Decided none = decide_many(header, config, 8);
    EXPECT_EQ(none.behind + none.in_front, 0);
    // A KiB of floats holds 128 pairs: of 16 x 16 tiles the upper half.
    const TraceHeader large = scenery(128, 128, 1, 9);
    config = {.bits = 32, .kibibytes = 1};
    const HierarchicalDepth half(large, config, 1);
    EXPECT_EQ(half.bytes(), 1024u);
    Fragment f = fragment_at(3, 3, 0.5f, 0);  // over the background
    EXPECT_EQ(half.decide(f, {}), kDepthInFront);
    f.y = 67;
    EXPECT_EQ(half.decide(f, {}), kDepthUndecided);
}

// At half the resolution a tile's range is that of the depths at its samples.
TEST(HierarchicalDepthTest, LowResolutionTilesSpanMore) {
    TraceHeader header = plain_header(32, 16);
    header.opaque.emplace();
    header.opaque->rgb.assign(3 * 32 * 16, 0.0f);
    header.opaque->depth.assign(32 * 16, 0.75f);
    header.opaque->depth[1 * 32 + 13] = 0.5f;   // a sample: the low tile's nearest
    header.opaque->depth[1 * 32 + 12] = 0.25f;  // none
    HierarchicalDepthConfig config;
    config.bits = 32;
    const HierarchicalDepth low(header, config, 2);
    EXPECT_EQ(low.decide(fragment_at(0, 0, 0.49f, 0), {}), kDepthInFront);
    EXPECT_EQ(low.decide(fragment_at(0, 0, 0.5f, 0), {}), kDepthUndecided);
    EXPECT_EQ(low.decide(fragment_at(8, 0, 0.74f, 0), {}), kDepthInFront);
    EXPECT_EQ(low.decide(fragment_at(8, 0, 0.75f, 0), {}), kDepthBehind);
}

class HierarchicalDepthRunTest : public ModelTest {};

// The same image, fewer reads; the worst case stays every tested fragment.
TEST_F(HierarchicalDepthRunTest, SavesReadsAndNothingElse) {
    RandomFragments options;
    options.seed = 11;
    options.width = 48;
    options.height = 48;
    options.count = 4000;
    options.opaque = true;
    const std::string trace = write(random_header(options), random_fragments(options));
    const FrameResult with = run_frame(trace, "adaptive:nodes=4", configured(), 1, true);
    const FrameResult without =
        run_frame(trace, "adaptive:nodes=4", configured({"hiz.enabled=false"}), 1, true);
    EXPECT_EQ(with.image.values, without.image.values);
    EXPECT_EQ(with.counts.operated, without.counts.operated);
    const SurfaceTraffic& less = with.surface("opaque_depth");
    const SurfaceTraffic& all = without.surface("opaque_depth");
    EXPECT_EQ(all.read, 2u * 4000 * 4);
    EXPECT_EQ(all.worst_read, all.read);
    EXPECT_EQ(less.worst_read, all.read);
    EXPECT_LT(less.read, all.read);
    EXPECT_GT(less.read, 0u);
    // Quads are the same; those that are decided have no depth among their lines.
    ASSERT_EQ(with.quads.size(), without.quads.size());
    for (std::size_t q = 0; q < with.quads.size(); ++q) {
        EXPECT_EQ(with.quads[q].kind, without.quads[q].kind);
        EXPECT_EQ(with.quads[q].line_count, without.quads[q].line_count);
        const int saved = without.quads[q].depth_lines - with.quads[q].depth_lines;
        EXPECT_EQ(saved, with.quads[q].is_shaded() && !with.quads[q].depth_tested() ? 1 : 0);
        if (with.quads[q].rejected()) {
            EXPECT_EQ(with.quads[q].kind, QuadKind::kCulled);
        }
    }
    // Without threads and with quads or not: the same reads.
    const FrameResult counted = run_frame(trace, "adaptive:nodes=4", configured(), 2, false);
    EXPECT_EQ(counted.surface("opaque_depth").read, less.read);
}

}  // namespace
}  // namespace ropsim
