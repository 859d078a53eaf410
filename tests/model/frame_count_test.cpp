// Counts and uncached bytes of the functional frame on traces small enough to count by hand.
#include "tests/model/machine_driver.h"

#include <limits>
#include <map>

namespace ropsim {
namespace {

using FrameCountTest = ModelTest;

// 16x8 pixels; the left tile has an opaque layer at depth 0.5, the right none. Draw 0 is depth-tested, draw 1
// is not.
TraceHeader two_tiles() {
    TraceHeader header = plain_header(16, 8, 2);
    header.draws[1].depth_test = false;
    header.opaque.emplace();
    header.opaque->rgb.assign(std::size_t{16} * 8 * 3, 0.375f);
    header.opaque->depth.assign(std::size_t{16} * 8, std::numeric_limits<float>::infinity());
    for (std::size_t y = 0; y < 8; ++y)
        for (std::size_t x = 0; x < 8; ++x) header.opaque->depth[y * 16 + x] = 0.5f;
    return header;
}

TEST_F(FrameCountTest, CountsEveryFragmentOnce) {
    std::vector<Fragment> f = {
        fragment_at(0, 0, 0.25f, 0),  // in front
        fragment_at(1, 0, 0.5f, 1),   // at the opaque depth: behind (GL_LESS)
        fragment_at(2, 0, 0.75f, 2),  // behind
        fragment_at(2, 1, 0.75f, 3),  // behind, but not tested
        fragment_at(9, 0, 1.0f, 4),   // nothing opaque there
        fragment_at(3, 0, 0.25f, 5),  // zero alpha and colour
        fragment_at(4, 0, 0.25f, 6),  // zero alpha, but it adds light
        fragment_at(5, 0, 0.75f, 7),  // behind, zero: culled first
    };
    f[3].draw = 1;
    f[5].a = f[5].r = f[5].g = f[5].b = 0;
    f[6].a = 0;
    f[7].a = f[7].r = f[7].g = f[7].b = 0;
    const std::string trace = write(two_tiles(), f);
    const FrameResult drops = run_frame(trace, "alpha_blend", configured(), 1, true);
    EXPECT_EQ(drops.counts.input, 8u);
    EXPECT_EQ(drops.counts.depth_culled, 3u);
    EXPECT_EQ(drops.counts.zero_alpha, 1u);
    EXPECT_EQ(drops.counts.operated, 4u);
    // Laine and Karras' coverage tracking sees fragments of zero alpha.
    const FrameResult keeps = run_frame(trace, "laine_karras:samples=8", configured(), 1, true);
    EXPECT_EQ(keeps.counts.zero_alpha, 0u);
    EXPECT_EQ(keeps.counts.operated, 5u);
    // Quads that only the depth test sees are quads all the same. Fragments of different primitives share
    // none.
    std::map<QuadKind, int> kinds;
    for (const QuadOperation& q : drops.quads) ++kinds[q.kind];
    EXPECT_EQ(kinds[QuadKind::kCulled], 3);
    EXPECT_EQ(kinds[QuadKind::kDraw], 5);  // the dropped one has been shaded
    EXPECT_EQ(kinds[QuadKind::kResolve], 0);
}

TEST_F(FrameCountTest, QuadsHoldThePixelsOfOnePrimitive) {
    // One primitive over four pixels, then the same pixel twice (two quads), then a helper-heavy single.
    std::vector<Fragment> f = {fragment_at(2, 4, 0.25f, 7), fragment_at(3, 4, 0.25f, 7),
                               fragment_at(2, 5, 0.25f, 7), fragment_at(3, 5, 0.25f, 7),
                               fragment_at(3, 5, 0.25f, 7), fragment_at(3, 5, 0.25f, 8)};
    const FrameResult frame =
        run_frame(write(plain_header(8, 8), f), "alpha_blend", configured({"rop.lanes=4"}), 1, true);
    ASSERT_EQ(frame.quads.size(), 3u);
    EXPECT_EQ(frame.quads[0].pixels, 15u);
    EXPECT_EQ(frame.quads[1].pixels, 8u);
    EXPECT_EQ(frame.quads[2].pixels, 8u);
    for (const QuadOperation& q : frame.quads) {
        EXPECT_EQ(q.quad_id, 2u * 4u + 1u);  // row 2, column 1 of the tile's 4 x 4 quads
        EXPECT_EQ(q.shader_lane_cycles, 4u * 16u);
        EXPECT_EQ(q.interval, 2u);  // RGBA16F: half rate
    }
    // With one lane the four pixels take turns: the last starts after six cycles.
    const FrameResult narrow = run_frame(path("trace"), "alpha_blend", configured({"rop.lanes=1"}), 1, true);
    EXPECT_EQ(narrow.quads[0].interval, 8u);
    EXPECT_EQ(narrow.quads[0].latency, frame.quads[0].latency + 6);
    EXPECT_EQ(narrow.quads[1].interval, 2u);
}

TEST_F(FrameCountTest, BytesOfAlphaBlendByHand) {
    const std::string trace = write(two_tiles(), {fragment_at(0, 0, 0.25f, 0), fragment_at(1, 0, 0.75f, 1),
                                                  fragment_at(9, 3, 0.25f, 2), fragment_at(9, 3, 0.25f, 3)});
    const FrameResult frame = run_frame(trace, "alpha_blend", configured(), 1, true);
    // Three operations on RGBA16F, four depth tests of a float; nothing is initialised, copied or resolved.
    EXPECT_EQ(frame.surface("color").read, 3u * 8u);
    EXPECT_EQ(frame.surface("color").write, 3u * 8u);
    EXPECT_EQ(frame.surface("color").worst_read, 3u * 8u);
    EXPECT_EQ(frame.surface("color").worst_write, 3u * 8u);
    // The left tile lies at one depth, the right one at none: no test needs to read it.
    EXPECT_EQ(frame.surface("opaque_depth").read, 0u);
    EXPECT_EQ(frame.surface("opaque_depth").worst_read, 4u * 4u);
    const FrameResult reads = run_frame(trace, "alpha_blend", configured({"hiz.enabled=false"}), 1, true);
    EXPECT_EQ(reads.surface("opaque_depth").read, 4u * 4u);
    EXPECT_EQ(frame.surface("opaque_color").read, 0u);
    EXPECT_EQ(frame.surface("image").write, 0u);
}

TEST_F(FrameCountTest, BytesOfAdaptiveByHand) {
    TraceHeader header = two_tiles();
    // Pixel (9,3): nearest first, so that the second insertion leaves node 0 alone. Node: depth and
    // transmittance, 8 bytes.
    const std::string trace = write(header, {fragment_at(9, 3, 0.25f, 0), fragment_at(9, 3, 0.5f, 1)});
    const FrameResult frame = run_frame(trace, "adaptive:nodes=2", configured(), 1, true);
    const std::uint64_t tile = 64;
    EXPECT_EQ(frame.surface("nodes").read,
              2 * 16 /* insert */ + 2 * 16 /* composite */ + tile * 8 /* resolve: the last node */);
    EXPECT_EQ(frame.surface("nodes").write, 16u + 8u);
    EXPECT_EQ(frame.surface("nodes").worst_read, 2 * 16 + 2 * 16 + tile * 8);
    EXPECT_EQ(frame.surface("nodes").worst_write, 2u * 16u);
    EXPECT_EQ(frame.surface("accumulated_color").read, (2 + tile) * 8);
    EXPECT_EQ(frame.surface("accumulated_color").write, 2u * 8u);
    EXPECT_EQ(frame.surface("opaque_color").read, tile * 8);
    EXPECT_EQ(frame.surface("image").write, tile * 8);
    EXPECT_EQ(frame.surface("opaque_depth").worst_read, 2 * 2 * 4u);  // each pass tests
    EXPECT_EQ(frame.surface("opaque_depth").read, 0u);
    // Without fast clear the touched tile of each surface is written first.
    const FrameResult cleared =
        run_frame(trace, "adaptive:nodes=2", configured({"cache.fast_clear=false"}), 1, true);
    EXPECT_EQ(cleared.surface("nodes").write, 16 + 8 + tile * 16);
    EXPECT_EQ(cleared.surface("accumulated_color").write, (2 + tile) * 8);
}

// Four samples whose opaque depths differ: the test is per sample, what is left of the mask reaches the
// technique.
TEST_F(FrameCountTest, DepthIsTestedSampleBySample) {
    TraceHeader header = plain_header(8, 8);
    header.samples = 4;
    header.depth_slopes = true;
    header.opaque.emplace();
    const std::size_t samples = 256;  // 64 pixels of four
    header.opaque->rgb.assign(3 * samples, 0.0f);
    header.opaque->depth.assign(samples, std::numeric_limits<float>::infinity());
    const std::size_t at = 36;  // sample 0 of pixel (1, 1)
    const float depths[4] = {0.2f, 0.4f, 0.6f, 0.8f};
    for (std::size_t m = 0; m < 4; ++m) {
        header.opaque->depth[at + m] = depths[m];
        header.opaque->rgb[3 * (at + m) + 1] = static_cast<float>(m);  // green: 0, 1, 2, 3
    }
    FragmentChunk chunk;
    chunk.fragments = {fragment_at(1, 1, 0.9f, 0, 1.0f), fragment_at(1, 1, 0.1f, 1, 1.0f),
                       fragment_at(2, 1, 0.5f, 2, 1.0f)};
    // In front of every opaque depth at the centre, but not at sample 3 of its plane: the samples lie at y =
    // -6, -2, 2 and 6 sixteenths.
    chunk.slopes = {{0, 0}, {0, 2.4f}, {0, 0}};  // 0, 0, 0.4, 1
    for (Fragment& f : chunk.fragments) f.coverage = 0b1111;
    TraceWriter writer(path("trace"), header);
    writer.append(chunk);
    writer.finish();
    const FrameResult frame =
        run_frame(path("trace"), "stochastic:samples=4,format=float32", configured(), 1, true);
    EXPECT_EQ(frame.counts.depth_culled, 1u);
    EXPECT_EQ(frame.counts.operated, 2u);
    // Three tests, and the copy of the touched tile, each of four floats a pixel.
    EXPECT_EQ(frame.surface("opaque_depth").read, (3 + 64) * 4 * 4u);
    EXPECT_EQ(frame.surface("opaque_color").read, 64 * 4 * 16u);  // floats, as the format asks
    // Red of the fragment is 0.5: three of the four samples of the first pixel, all of the second.
    EXPECT_FLOAT_EQ(frame.image.pixel(1, 1)[0], 0.375f);
    EXPECT_FLOAT_EQ(frame.image.pixel(2, 1)[0], 0.5f);
    EXPECT_FLOAT_EQ(frame.image.pixel(1, 1)[1], (3 * 0.25f + 3) / 4);
    EXPECT_FLOAT_EQ(frame.image.pixel(5, 5)[1], 0.0f);
}

}  // namespace
}  // namespace ropsim
