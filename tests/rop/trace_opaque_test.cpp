// The opaque layer as fragments: the exact picture stays to the bit, whatever the samples, and what cannot
// keep it is refused.
#include "traces/trace_opaque.h"

#include "base/error.h"
#include "rop/reference.h"
#include "tests/traces/scratch.h"
#include "traces/generators.h"

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using testing::HasSubstr;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

void write(const std::string& file, const TraceHeader& header, const FragmentChunk& chunk) {
    TraceWriter writer(file, header);
    writer.append(chunk);
    writer.finish();
}

class TraceOpaque : public ScratchTest {
 protected:
    // Pictures' channels R, G, B.
    std::vector<float> picture(const std::string& name) {
        TraceReader trace(path(name));
        const Image image = reference_image(trace, 1);
        std::vector<float> rgb;
        for (std::size_t i = 0; i < image.values.size(); i += image.channels.size())
            rgb.insert(rgb.end(), &image.values[i], &image.values[i] + 3);
        return rgb;
    }
    std::string refusal(OpaquePlace place) {
        try {
            convert_opaque(path("t"), path("o"), place);
        } catch (const UserError& error) {
            return error.what();
        }
        return "";
    }
};

TEST_F(TraceOpaque, TheExactPictureStays) {
    for (const int samples : {1, 4, 16})
        for (const OpaquePlace place : {OpaquePlace::kFirst, OpaquePlace::kLast}) {
            RandomFragments options;
            options.samples = samples;
            options.count = 4000;
            options.draws = 3;
            options.depth_levels = 13;  // many at the layer's own depth
            options.opaque = options.slopes = options.materials = true;
            options.partial_coverage = samples > 1;
            TraceHeader header = random_header(options);
            // Levels of depth for the layer too; colours that samples share, and no halves.
            for (std::size_t i = 0; i < header.opaque->depth.size(); ++i) {
                float& depth = header.opaque->depth[i];
                if (depth <= 1) depth = std::round(depth * 12) / 12;
                for (std::size_t c = 0; c < 3; ++c)
                    header.opaque->rgb[3 * i + c] = depth > 1 ? header.background[static_cast<int>(c)]
                                                              : 0.1f + 0.3f * static_cast<float>((i + c) % 2);
            }
            FragmentChunk chunk = random_chunk(options);
            for (Fragment& f : chunk.fragments) f.z = std::round(f.z * 12) / 12;
            write(path("t"), header, chunk);
            const OpaqueConversion done = convert_opaque(path("t"), path("o"), place);
            EXPECT_EQ(picture("o"), picture("t")) << samples << " samples";
            const TraceReader converted(path("o"));
            EXPECT_FALSE(converted.header().opaque);
            EXPECT_FALSE(done.layer_left);
            EXPECT_EQ(converted.header().draws.size(), 4u);
            EXPECT_EQ(converted.header().draws[3].name, "opaque");
            EXPECT_EQ(converted.fragment_count(), 4000 + done.fragments - done.ties_removed);
            if (place == OpaquePlace::kFirst) {
                EXPECT_EQ(done.ties_removed, 0u);
            }
            if (place == OpaquePlace::kLast && samples == 1) {
                EXPECT_GT(done.ties_removed, 0u);
            }
        }
}

// One fragment a group of samples with one colour and depth, and every sample that has something in one.
TEST_F(TraceOpaque, SamplesAreGrouped) {
    TraceHeader header;
    header.width = 3;
    header.height = 2;
    header.samples = 4;
    header.draws.resize(1);
    header.opaque = OpaqueLayer{};
    const float depths[6][4] = {{0.5f, 0.5f, 0.5f, 0.5f}, {0.5f, 0.25f, 0.5f, 0.25f},
                                {kInfinity, 1, 1, 1},     {kInfinity, kInfinity, kInfinity, kInfinity},
                                {0.1f, 0.2f, 0.3f, 0.4f}, {0.5f, 0.5f, 0.5f, 0.5f}};
    for (int i = 0; i < 6; ++i)
        for (int m = 0; m < 4; ++m) {
            header.opaque->depth.push_back(depths[i][m]);
            const float red = i == 5 && m >= 2 ? 0.75f : 0.25f;  // the last pixel: two colours at one depth
            const bool drawn = depths[i][m] <= 1;
            header.opaque->rgb.insert(header.opaque->rgb.end(), {drawn ? red : 0, 0, 0});
        }
    write_trace(path("t"), header, {});
    const OpaqueConversion done = convert_opaque(path("t"), path("o"), OpaquePlace::kFirst);
    EXPECT_EQ(done.fragments, 1u + 2 + 1 + 0 + 4 + 2);
    std::map<int, std::set<std::tuple<int, float, float>>> groups;  // of pixel: coverage, depth, red
    std::set<std::uint32_t> primitives;
    for (const Fragment& f : read_fragments(path("o"))) {
        EXPECT_EQ(f.a, 1);
        EXPECT_EQ(f.draw, 1);
        groups[f.y * 3 + f.x].insert({f.coverage, f.z, f.r});
        primitives.insert(f.primitive);
    }
    using Groups = std::set<std::tuple<int, float, float>>;
    EXPECT_EQ(groups[0], (Groups{{15, 0.5f, 0.25f}}));
    EXPECT_EQ(groups[1], (Groups{{5, 0.5f, 0.25f}, {10, 0.25f, 0.25f}}));
    EXPECT_EQ(groups[2], (Groups{{14, 1, 0.25f}}));
    EXPECT_EQ(groups.count(3), 0u);
    EXPECT_EQ(groups[4].size(), 4u);
    EXPECT_EQ(groups[5], (Groups{{3, 0.5f, 0.25f}, {12, 0.5f, 0.75f}}));
    EXPECT_EQ(primitives.size(), done.fragments);
}

// Where nothing opaque was drawn, the layer's colour is the sky: it stays behind.
TEST_F(TraceOpaque, ColoursBehindStay) {
    TraceHeader header;
    header.width = 2;
    header.height = 1;
    header.draws.resize(1);
    header.background = {0.5f, 0.5f, 0.5f};
    header.opaque = OpaqueLayer{{1, 0, 0, 0, 1, 0}, {0.5f, kInfinity}};
    const Fragment f{0.25f, 0, 0, 0.5f, 0.5f, 1, 0, 0, 1, 0};
    write_trace(path("t"), header, {f});
    const OpaqueConversion done = convert_opaque(path("t"), path("o"), OpaquePlace::kFirst);
    EXPECT_TRUE(done.layer_left);
    EXPECT_EQ(done.fragments, 1u);
    const TraceReader converted(path("o"));
    ASSERT_TRUE(converted.header().opaque);
    EXPECT_THAT(converted.header().opaque->depth, testing::Each(kInfinity));
    EXPECT_THAT(converted.header().opaque->rgb, testing::ElementsAre(0.5f, 0.5f, 0.5f, 0, 1, 0));
    EXPECT_EQ(picture("o"), picture("t"));
}

TEST_F(TraceOpaque, ColoursThatAreNoHalvesWidenTheTrace) {
    TraceHeader header;
    header.width = header.height = 1;
    header.draws.resize(1);
    header.color_storage = ColorStorage::kFloat16;
    for (const float red : {0.5f, 0.1f}) {
        header.opaque = OpaqueLayer{{red, 0, 0}, {0.5f}};
        write_trace(path("t"), header, {});
        EXPECT_EQ(convert_opaque(path("t"), path("o"), OpaquePlace::kFirst).widened_colors, red == 0.1f);
        EXPECT_EQ(read_fragments(path("o"))[0].r, red);
    }
}

TEST_F(TraceOpaque, ArrivalIsAsAsked) {
    RandomFragments options;
    options.count = 300;
    options.opaque = true;
    write_trace(path("t"), random_header(options), random_fragments(options));
    for (const OpaquePlace place : {OpaquePlace::kFirst, OpaquePlace::kLast}) {
        convert_opaque(path("t"), path("o"), place);
        const std::vector<Fragment> all = read_fragments(path("o"));
        const auto opaque = [](const Fragment& f) { return f.draw == 1; };
        EXPECT_TRUE(place == OpaquePlace::kFirst ? std::is_partitioned(all.begin(), all.end(), opaque)
                                                 : std::is_partitioned(all.rbegin(), all.rend(), opaque));
    }
}

TEST_F(TraceOpaque, WhatCannotKeepThePictureIsRefused) {
    TraceHeader header;
    header.width = header.height = 1;
    header.draws.resize(2);
    header.draws[1].name = "overlay";
    write_trace(path("t"), header, {});
    EXPECT_THAT(refusal(OpaquePlace::kFirst), HasSubstr("has nothing opaque"));
    header.opaque = OpaqueLayer{{0, 0, 0}, {kInfinity}};
    write_trace(path("t"), header, {});
    EXPECT_THAT(refusal(OpaquePlace::kFirst), HasSubstr("has nothing opaque"));
    header.opaque->depth[0] = 0.5f;
    header.draws[1].depth_test = false;
    Fragment f{0.75f, 0.1f, 0.1f, 0.1f, 0.5f, 0, 0, 0, 1, 1};
    write_trace(path("t"), header, {f});
    for (const OpaquePlace place : {OpaquePlace::kFirst, OpaquePlace::kLast}) {
        EXPECT_THAT(refusal(place), HasSubstr("draw 1 ('overlay') has no depth test"));
        EXPECT_FALSE(std::filesystem::exists(path("o")));
    }
    // At the very depth of the layer it is seen if it comes first.
    f.z = 0.5f;
    write_trace(path("t"), header, {f});
    EXPECT_THAT(refusal(OpaquePlace::kFirst), HasSubstr("overlay"));
    EXPECT_EQ(refusal(OpaquePlace::kLast), "");
    EXPECT_EQ(picture("o"), picture("t"));
}

}  // namespace
}  // namespace ropsim
