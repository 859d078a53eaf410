// The alpha of fragments that transmit, as those see it who know alpha alone.
#include "traces/least_alpha.h"

#include "tests/traces/scratch.h"
#include "tests/traces/trace_conversion.h"
#include "tests/traces/trace_round_trip.h"
#include "traces/generators.h"

#include <array>
#include <limits>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using LeastAlpha = ScratchTest;

Material transmitting(float r, float g, float b) {
    Material m;
    m.transmission[0] = r;
    m.transmission[1] = g;
    m.transmission[2] = b;
    return m;
}

// Of all alphas a' <= a for which some transmission t' in [0, 1] lets the same through in every channel,
// 1 - a' (1 - t') = 1 - a (1 - t), none is less: searched for by steps.
TEST(LeastAlphaTest, NoLessAlphaMeansTheSame) {
    for (const float a : {1.0f, 0.7f, 0.25f})
        for (const std::array<float, 3> t : {std::array{0.9f, 0.9f, 0.9f}, std::array{0.2f, 0.8f, 0.5f},
                                             std::array{1.0f, 0.0f, 1.0f}, std::array{1.0f, 0.6f, 1.0f}}) {
            double least = 1;
            for (int step = 1; step <= 100'000; ++step) {
                const double candidate = static_cast<double>(a) * step / 100'000.0;
                bool possible = true;
                for (const float channel : t)
                    possible = possible && static_cast<double>(a) * (1.0 - static_cast<double>(channel)) <=
                                               candidate * (1 + 1e-7);
                if (!possible) continue;
                least = candidate;
                break;
            }
            EXPECT_NEAR(least_alpha(a, transmitting(t[0], t[1], t[2])), least, 2e-5) << a << " " << t[0];
        }
}

TEST(LeastAlphaTest, WhatStopsAChannelKeepsItsBits) {
    for (const float a : {1.0f, 0.3f, 1.0f / 255, 1e-5f, 1e-42f, 0.0f})
        EXPECT_EQ(least_alpha(a, transmitting(0.7f, 0, 1)), a);
}

// Reflections need a trace of alpha to be carried by; what had less of it keeps what it had.
TEST(LeastAlphaTest, ClearMatterKeepsATrace) {
    EXPECT_EQ(least_alpha(1, transmitting(1, 1, 1)), 1.0f / 255);
    EXPECT_EQ(least_alpha(0.5f, transmitting(0.999f, 1, 1)), 1.0f / 255);
    EXPECT_EQ(least_alpha(0.001f, transmitting(1, 1, 1)), 0.001f);
}

TEST_F(LeastAlpha, ReadersGiveItWhereAskedFor) {
    RandomFragments options = rich_options();
    options.slopes = options.materials = true;
    FragmentChunk stored = random_chunk(options);
    TraceWriter writer(path("t"), random_header(options), {1000, 32});
    writer.append(stored);
    writer.finish();
    TraceReader reader(path("t"));
    std::size_t changed = 0;
    for (const unsigned channels : {kNoChannels, kSlopeChannels, kMaterialChannels, kAllChannels}) {
        std::size_t at = 0;
        FragmentChunk chunk;
        reader.rewind();
        while (reader.next(chunk, channels | kLeastAlpha)) {
            EXPECT_EQ(chunk.slopes.size(), (channels & kSlopeChannels) != 0 ? chunk.size() : 0u);
            EXPECT_EQ(chunk.materials.size(), (channels & kMaterialChannels) != 0 ? chunk.size() : 0u);
            for (const Fragment& f : chunk.fragments) {
                const Fragment& original = stored.fragments[at];
                ASSERT_EQ(f.a, least_alpha(original.a, stored.materials[at])) << at;
                ASSERT_EQ(f.r, original.r);
                changed += f.a != original.a;
                ++at;
            }
        }
        EXPECT_EQ(at, stored.size());
    }
    EXPECT_GT(changed, stored.size());
    // Who does not ask gets what is stored.
    reader.rewind();
    EXPECT_TRUE(same_bytes(read_all(reader), stored.fragments));
}

TEST_F(LeastAlpha, TracesWithoutMaterialsStay) {
    const RandomFragments options = rich_options();
    const std::vector<Fragment> stored = random_fragments(options);
    write(path("t"), random_header(options), stored, {});
    TraceReader reader(path("t"));
    FragmentChunk chunk;
    std::vector<Fragment> all;
    while (reader.next(chunk, kAllChannels | kLeastAlpha))
        all.insert(all.end(), chunk.fragments.begin(), chunk.fragments.end());
    EXPECT_TRUE(same_bytes(all, stored));
}

// Values are brought into range first: NaN transmits nothing.
TEST_F(LeastAlpha, OfValuesThatAreNotFinite) {
    TraceHeader header;
    header.width = header.height = 8;
    header.materials = header.non_finite = true;
    header.draws.resize(1);
    FragmentChunk stored;
    stored.fragments.resize(2);
    for (Fragment& f : stored.fragments) f = {0.5f, 0, 0, 0, 1, 0, 0, 0, 1, 0};
    const float nan = std::numeric_limits<float>::quiet_NaN();
    stored.materials = {transmitting(nan, 0.5f, 0.5f), transmitting(0.75f, 7, 0.75f)};
    TraceWriter writer(path("t"), header);
    writer.append(stored);
    writer.finish();
    TraceReader reader(path("t"));
    FragmentChunk chunk;
    ASSERT_TRUE(reader.next(chunk, kLeastAlpha));
    EXPECT_EQ(chunk.fragments[0].a, 1.0f);
    EXPECT_EQ(chunk.fragments[1].a, 0.25f);
}

}  // namespace
}  // namespace ropsim
