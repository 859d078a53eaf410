// Work left out: with every switch the image is the same, and bytes and cycles differ by what was counted.
#include "tests/model/machine_driver.h"

#include <cmath>
#include <random>

namespace ropsim {
namespace {

using nlohmann::json;
using SkipTest = ModelTest;

// 64x48 pixels with an opaque layer at a depth of 0.5. Random fragments, a quarter of them behind it and an
// eighth of zero alpha, in a quarter of the screen.
TraceHeader screen() {
    TraceHeader header = plain_header(64, 48);
    header.opaque.emplace();
    header.opaque->depth.assign(std::size_t{64} * 48, 0.5f);
    for (int i = 0; i < 64 * 48 * 3; ++i) header.opaque->rgb.push_back(static_cast<float>(i % 97) / 128.0f);
    return header;
}

std::vector<Fragment> corner(int count) {
    std::mt19937 random(3);
    std::vector<Fragment> fragments;
    for (int i = 0; i < count; ++i) {
        const auto x = static_cast<int>(random() % 32);
        const auto y = static_cast<int>(random() % 24);
        const float z = static_cast<float>(random() % 1000) / 1000.0f * (random() % 2 == 0 ? 0.5f : 1.0f);
        const bool zero = random() % 8 == 0;
        fragments.push_back(fragment_at(x, y, z, static_cast<std::uint32_t>(i), zero ? 0.0f : 0.375f));
    }
    return fragments;
}

std::uint64_t all_bytes(const FrameResult& frame) {
    std::uint64_t sum = 0;
    for (const SurfaceTraffic& t : frame.traffic) sum += t.read + t.write;
    return sum;
}

std::uint64_t lane_cycles(const FrameResult& frame) {
    std::uint64_t sum = 0;
    for (const QuadOperation& q : frame.quads) sum += q.kind == QuadKind::kDraw ? q.shader_lane_cycles : 0;
    return sum;
}

bool same(const Image& a, const Image& b) {
    return a.values == b.values;
}

const char* const kTechniques[] = {"alpha_blend",           "a_buffer",         "adaptive:nodes=4",
                                   "stochastic:samples=4",  "weighted_blended", "moment_based:moments=4",
                                   "slab:layers=4,bits=32", "hashed_alpha",     "depth_peeling"};

// Of two images that may differ by the rounding of 8 bits: a technique that keeps the opaque layer's colour
// as UNORM8 rounds it where its resolve goes.
void expect_near(const Image& a, const Image& b) {
    ASSERT_EQ(a.values.size(), b.values.size());
    for (std::size_t i = 0; i < a.values.size(); ++i)
        ASSERT_LE(std::abs(a.values[i] - b.values[i]), 0.5f / 255 + 1e-3f) << i;
}

// 8x6 tiles, of which 4x3 are drawn to. Cleared surfaces are written too without fast clear.
TEST_F(SkipTest, UntouchedTiles) {
    const TraceHeader header = screen();
    const std::string trace = write(header, corner(3000));
    for (const std::string technique : kTechniques) {
        for (const std::string clear : {"cache.fast_clear=true", "cache.fast_clear=false"}) {
            SCOPED_TRACE(technique + " " + clear);
            const MachineConfig on_config = configured({clear});
            const MachineConfig off_config = configured({clear, "skip.untouched_tiles=false"});
            const FrameResult on = run_frame(trace, technique, on_config, 1, true);
            const FrameResult off = run_frame(trace, technique, off_config, 1, true);
            const bool rounds = technique.starts_with("stochastic") || technique == "hashed_alpha";
            EXPECT_TRUE(rounds || same(on.image, off.image));
            expect_near(on.image, off.image);
            EXPECT_EQ(off.skipped.initialise_tiles, 0u);
            EXPECT_EQ(off.skipped.resolve_tiles, 0u);
            const auto operation = operation_for(technique, header);
            const Declaration& declared = operation->declaration();
            EXPECT_EQ(on.skipped.resolve_tiles, declared.resolves ? 36u : 0u);
            // Beside what is known: the state that a resolve reads of a pixel never drawn to.
            std::uint64_t state = 0;
            for (std::size_t s = 0; s < declared.surfaces.size(); ++s)
                state += off.traffic[s].read - on.traffic[s].read;
            EXPECT_EQ(all_bytes(off) - all_bytes(on),
                      on.skipped.initialise_bytes + on.skipped.resolve_bytes + state);
            EXPECT_GE(on.skipped.resolve_bytes, declared.resolves ? 36u * 64 * 8 : 0u);
            EXPECT_EQ(state > 0, declared.resolves);
        }
    }
}

// Without rounding, the same bits whatever is kept.
TEST_F(SkipTest, UntouchedTilesKeepTheOpaqueLayer) {
    const std::string trace = write(screen(), corner(3000));
    const MachineConfig on = configured();
    const MachineConfig off = configured({"skip.untouched_tiles=false"});
    for (const std::string technique :
         {"stochastic:samples=4,format=float32", "hashed_alpha:format=float32",
          "stochastic:samples=4,correction=coverage,format=float32", "laine_karras:samples=4,format=float32"})
        EXPECT_TRUE(same(run_frame(trace, technique, on, 1, true).image,
                         run_frame(trace, technique, off, 1, true).image))
            << technique;
}

// Written out for one technique: 36 tiles of 64 pixels, a resolve that reads 8 bytes of colour and one of
// revealage, 8 behind, and writes 8; an initial clear that writes 9.
TEST_F(SkipTest, UntouchedTilesCostWhatTheyHold) {
    const std::string trace = write(screen(), corner(3000));
    const FrameResult on =
        run_frame(trace, "weighted_blended", configured({"cache.fast_clear=false"}), 1, true);
    EXPECT_EQ(on.skipped.initialise_tiles, 36u);
    EXPECT_EQ(on.skipped.initialise_bytes, 36u * 64 * 9);
    EXPECT_EQ(on.skipped.resolve_bytes, 36u * 64 * 16);
    const FrameResult off =
        run_frame(trace, "weighted_blended",
                  configured({"cache.fast_clear=false", "skip.untouched_tiles=false"}), 1, true);
    EXPECT_EQ(all_bytes(off) - all_bytes(on), 36u * 64 * (9 + 16 + 9));
    EXPECT_EQ(off.quads.size() - on.quads.size(), 36u * (4 + 1 + 16));  // lines of 128 bytes; quads
    const json run_on = run(trace, "weighted_blended", {"cache.fast_clear=false"});
    const json run_off =
        run(trace, "weighted_blended", {"cache.fast_clear=false", "skip.untouched_tiles=false"});
    EXPECT_EQ(run_on["skipped"]["untouched_tiles"]["resolved"], 36);
    EXPECT_EQ(run_on["skipped"]["untouched_bytes"]["initialised"], 36 * 64 * 9);
    EXPECT_EQ(run_off["skipped"]["untouched_tiles"]["resolved"], 0);
    EXPECT_GT(run_off["cycles"], run_on["cycles"]);
}

TEST_F(SkipTest, ZeroAlpha) {
    const auto fragments = corner(3000);
    const std::string trace = write(screen(), fragments);
    std::uint64_t zero = 0;
    for (const Fragment& f : fragments) zero += f.z < 0.5f && f.a == 0.0f ? 1 : 0;
    ASSERT_GT(zero, 100u);
    int harmless = 0;
    for (const std::string technique : kTechniques) {
        SCOPED_TRACE(technique);
        if (!operation_for(technique, screen())->declaration().zero_alpha_harmless) continue;
        ++harmless;
        const FrameResult on = run_frame(trace, technique, configured(), 1, true);
        const FrameResult off = run_frame(trace, technique, configured({"skip.zero_alpha=false"}), 1, true);
        EXPECT_TRUE(same(on.image, off.image));
        EXPECT_EQ(on.counts.zero_alpha, zero);
        EXPECT_EQ(off.counts.zero_alpha, 0u);
        EXPECT_EQ(off.skipped.zero_alpha_fragments, 0u);
        EXPECT_EQ(on.skipped.zero_alpha_fragments % zero, 0u);  // in every pass
        EXPECT_GE(on.skipped.zero_alpha_fragments, zero);
        EXPECT_EQ(off.counts.operated, on.counts.operated + zero);
        EXPECT_GE(all_bytes(off), all_bytes(on));
        if (technique == "alpha_blend") {
            EXPECT_EQ(all_bytes(off) - all_bytes(on), zero * 16);
        }
    }
    EXPECT_GE(harmless, 5);
    const json on = run(trace, "alpha_blend", {});
    const json off = run(trace, "alpha_blend", {"skip.zero_alpha=false"});
    EXPECT_EQ(on["skipped"]["zero_alpha_fragments"], zero);
    // Two cycles of a lane for each, one fragment a quad.
    EXPECT_EQ(off["stages"]["rop_operation"]["busy"].get<std::uint64_t>(),
              on["stages"]["rop_operation"]["busy"].get<std::uint64_t>() + 2 * zero);
}

// Shaded, exported and tested after all. Bytes are the same: the depth is read either way.
TEST_F(SkipTest, Occluded) {
    const auto fragments = corner(3000);
    const std::string trace = write(screen(), fragments);
    std::uint64_t behind = 0;
    for (const Fragment& f : fragments) behind += f.z >= 0.5f ? 1 : 0;
    for (const std::string technique : kTechniques) {
        SCOPED_TRACE(technique);
        const FrameResult on = run_frame(trace, technique, configured(), 1, true);
        const FrameResult off = run_frame(trace, technique, configured({"skip.occluded=false"}), 1, true);
        EXPECT_TRUE(same(on.image, off.image));
        EXPECT_EQ(all_bytes(off), all_bytes(on));
        EXPECT_EQ(on.skipped.occluded_fragments % behind, 0u);
        EXPECT_GE(on.skipped.occluded_fragments, behind);
        EXPECT_EQ(off.skipped.occluded_fragments, 0u);
        EXPECT_EQ(off.skipped.occluded_lane_cycles, 0u);
        EXPECT_EQ(lane_cycles(off), lane_cycles(on) + on.skipped.occluded_lane_cycles);
    }
    // Where shading is all that takes time, the frame is longer by it.
    const Settings narrow = {"shader.alu_lanes=4", "shader.cores=1", "shader.warp_quads=1",
                             "clock.shader_mhz=1000", "clock.rop_mhz=1000"};
    Settings late = narrow;
    late.emplace_back("skip.occluded=false");
    const json on = run(trace, "alpha_blend", narrow);
    const json off = run(trace, "alpha_blend", late);
    const double more = on["skipped"]["occluded_shader_lane_cycles"].get<double>() / 4;
    EXPECT_EQ(more, static_cast<double>(behind) * 4 * 16 / 4);
    EXPECT_NEAR(off["cycles"].get<double>() - on["cycles"].get<double>(), more, 0.02 * more);
}

TEST_F(SkipTest, OutsideTheRegionOfInterest) {
    const TraceHeader header = screen();
    const auto fragments = corner(3000);
    const std::string trace = write(header, fragments);
    const ScreenRegion region = {5, 3, 21, 40};
    std::uint64_t outside = 0;
    for (const Fragment& f : fragments) outside += region.contains(f.x, f.y) ? 0 : 1;
    for (const std::string technique : kTechniques) {
        SCOPED_TRACE(technique);
        const FrameResult whole = run_frame(trace, technique, configured(), 1, true);
        const MachineConfig config = configured({"skip.region=5 3 21 40"});
        const FrameResult part = run_frame(trace, technique, config, 1, true);
        const FrameResult counted = run_frame(trace, technique, config, 2, false);
        EXPECT_TRUE(same(part.image, counted.image));
        EXPECT_EQ(part.skipped.outside_fragments % outside, 0u);
        EXPECT_GE(part.skipped.outside_fragments, outside);
        EXPECT_EQ(part.counts.input, fragments.size() - outside);
        EXPECT_LT(all_bytes(part), all_bytes(whole));
        // Outside is the opaque layer, as it was or as the technique keeps it.
        const std::string nothing = write(header, {}, "empty");
        const FrameResult empty = run_frame(nothing, technique, configured(), 1, true);
        const FrameResult kept =
            run_frame(nothing, technique, configured({"skip.untouched_tiles=false"}), 1, true);
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 64; ++x) {
                const std::size_t at = 3 * (static_cast<std::size_t>(y) * 64 + static_cast<std::size_t>(x));
                for (std::size_t c = at; c < at + 3; ++c) {
                    const float value = part.image.values[c];
                    const bool expected = region.contains(x, y) ? value == whole.image.values[c]
                                                                : value == empty.image.values[c] ||
                                                                      value == kept.image.values[c];
                    ASSERT_TRUE(expected) << x << ", " << y << ": " << value;
                }
            }
    }
    EXPECT_EQ(run(trace, "alpha_blend", {"skip.region=5 3 21 40"})["skipped"]["outside_region_fragments"],
              outside);
}

// A display filter reads the pixels around: they are kept, too.
TEST_F(SkipTest, TheRegionHasWhatItsFilterReads) {
    const std::string trace = write(screen(), corner(3000));
    const std::string technique = "stochastic:samples=4,filter=gaussian";
    const FrameResult whole = run_frame(trace, technique, configured(), 1, true);
    const FrameResult part = run_frame(trace, technique, configured({"skip.region=5 3 21 20"}), 1, true);
    EXPECT_GT(part.skipped.outside_fragments, 0u);
    for (std::size_t y = 3; y < 20; ++y)
        for (std::size_t c = 3 * (y * 64 + 5); c < 3 * (y * 64 + 21); ++c)
            ASSERT_EQ(part.image.values[c], whole.image.values[c]);
}

TEST_F(SkipTest, RegionsThatCannotBeAreRefused) {
    for (const std::string bad : {"1 2 3", "1 2 3 4 5", "5 5 5 9", "-1 0 4 4", "a b c d", "0 0 4 4x"})
        EXPECT_THROW(configured({"skip.region=" + bad}), UserError) << bad;
    const std::string trace = write(screen(), corner(10));
    EXPECT_THROW(run_frame(trace, "alpha_blend", configured({"skip.region=64 0 70 9"}), 1, true), UserError);
    EXPECT_THROW(run_frame(trace, "phenomenological", configured({"skip.region=0 0 8 8"}), 1, true),
                 UserError);
}

// The technique's own early termination: fewer bytes, the same image.
TEST_F(SkipTest, SaturatedPixels) {
    TraceHeader header = plain_header(32, 32);
    std::vector<Fragment> layers;
    for (std::uint32_t layer = 0; layer < 12; ++layer)
        for (int i = 0; i < 1024; ++i)
            layers.push_back(
                fragment_at(i % 32, i / 32, 0.1f + 0.05f * static_cast<float>(layer), layer, 0.9f));
    const std::string trace = write(header, layers);
    const json off = run(trace, "stochastic:samples=8", {}, {}, "off");
    const json on = run(trace, "stochastic:samples=8", {"skip.saturated=true"}, {}, "on");
    EXPECT_EQ(read_file(path("on") + "/image.exr"), read_file(path("off") + "/image.exr"));
    EXPECT_TRUE(off["skipped"]["saturated_operations"].is_null());
    EXPECT_GT(on["skipped"]["saturated_operations"], 1000);
    EXPECT_LT(on["traffic"]["total"]["read_bytes"], off["traffic"]["total"]["read_bytes"]);
    const ProgramResult refused = run_program(
        {"run", trace, "--technique", "alpha_blend", "--set", "skip.saturated=true", "-o", path("refused")});
    EXPECT_EQ(refused.status, 1);
    EXPECT_NE(refused.err.find("skip.saturated"), std::string::npos) << refused.err;
}

}  // namespace
}  // namespace ropsim
