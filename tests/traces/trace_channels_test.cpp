// Slopes, materials and values that are not finite: kept bit for bit, left out where not wanted, brought into
// range.
#include "base/error.h"
#include "tests/traces/scratch.h"
#include "tests/traces/trace_conversion.h"
#include "tests/traces/trace_round_trip.h"
#include "traces/generators.h"
#include "traces/trace.h"

#include <limits>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using TraceChannels = ScratchTest;

FragmentChunk read_channels(TraceReader& reader, bool raw = false) {
    FragmentChunk all;
    FragmentChunk chunk;
    reader.rewind();
    while (raw ? reader.next_raw(chunk) : reader.next(chunk)) {
        all.fragments.insert(all.fragments.end(), chunk.fragments.begin(), chunk.fragments.end());
        all.slopes.insert(all.slopes.end(), chunk.slopes.begin(), chunk.slopes.end());
        all.materials.insert(all.materials.end(), chunk.materials.begin(), chunk.materials.end());
    }
    return all;
}

TEST_F(TraceChannels, ChannelsRoundTripBitwiseAndMayBeLeftOut) {
    for (const ColorStorage storage : {ColorStorage::kFloat32, ColorStorage::kFloat16})
        for (int kinds = 1; kinds <= 3; ++kinds) {
            RandomFragments options = rich_options();
            options.color_storage = storage;
            options.slopes = (kinds & 1) != 0;
            options.materials = (kinds & 2) != 0;
            const FragmentChunk chunk = random_chunk(options);
            TraceWriter writer(path("t"), random_header(options), {1000, 32});
            writer.append(chunk);
            writer.finish();
            TraceReader reader(path("t"));
            EXPECT_TRUE(same_bytes(read_all(reader), chunk.fragments));
            EXPECT_TRUE(same_content(read_channels(reader), chunk)) << kinds;
            reader.rewind();
            FragmentChunk slopes_alone;
            ASSERT_TRUE(reader.next(slopes_alone, kSlopeChannels));
            EXPECT_EQ(slopes_alone.slopes.size(), options.slopes ? 1000u : 0u);
            EXPECT_TRUE(slopes_alone.materials.empty());
            // Of a selection, too.
            std::vector<std::uint8_t> selected(reader.tile_fragments().size());
            selected[40] = 1;
            reader.select_tiles(selected);
            const FragmentChunk some = read_channels(reader);
            FragmentChunk expected;
            for (std::size_t i = 0; i < chunk.size(); ++i) {
                const Fragment& f = chunk.fragments[i];
                if (f.y / kTileSize * 38 + f.x / kTileSize != 40) continue;
                expected.fragments.push_back(f);
                if (options.slopes) expected.slopes.push_back(chunk.slopes[i]);
                if (options.materials) expected.materials.push_back(chunk.materials[i]);
            }
            EXPECT_GT(some.size(), 0u);
            EXPECT_TRUE(same_content(some, expected));
        }
}

TEST_F(TraceChannels, FragmentsAloneGetDefaultChannels) {
    RandomFragments options = rich_options();
    options.slopes = options.materials = true;
    options.count = 10;
    write(path("t"), random_header(options), random_fragments(options), {});
    TraceReader reader(path("t"));
    const FragmentChunk chunk = read_channels(reader);
    ASSERT_EQ(chunk.materials.size(), 10u);
    EXPECT_EQ(chunk.materials[3].eta, 1.0f);
    EXPECT_EQ(chunk.materials[3].normal[2], 1.0f);
    EXPECT_EQ(chunk.slopes[3].dx, 0.0f);
}

TEST_F(TraceChannels, NonFiniteValuesAreKeptAndBroughtIntoRangeForThoseWhoSimulate) {
    RandomFragments options;
    options.count = 6;
    options.slopes = options.materials = true;
    TraceHeader header = random_header(options);
    FragmentChunk chunk = random_chunk(options);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float infinity = std::numeric_limits<float>::infinity();
    chunk.fragments[0].z = nan;
    chunk.fragments[1].a = nan;
    chunk.fragments[2].g = -infinity;
    chunk.fragments[3].z = -infinity;
    chunk.slopes[4].dy = infinity;
    chunk.materials[5].transmission[1] = nan;
    EXPECT_THROW(TraceWriter(path("t"), header).append(chunk), UserError);
    header.non_finite = true;
    TraceWriter writer(path("t"), header);
    writer.append(chunk);
    writer.finish();
    TraceReader reader(path("t"));
    EXPECT_TRUE(same_content(read_channels(reader, true), chunk));
    const FragmentChunk mended = read_channels(reader);
    EXPECT_EQ(mended.fragments[0].z, 1.0f);
    EXPECT_EQ(mended.fragments[1].a, 0.0f);
    EXPECT_EQ(mended.fragments[2].g, -65504.0f);
    EXPECT_EQ(mended.fragments[3].z, 0.0f);
    EXPECT_EQ(mended.slopes[4].dy, 0.0f);
    EXPECT_EQ(mended.materials[5].transmission[1], 0.0f);
    EXPECT_EQ(mended.fragments[5].r, chunk.fragments[5].r);
    EXPECT_EQ(read_all(reader)[1].a, 0.0f);
    header.color_storage = ColorStorage::kFloat16;
    EXPECT_THROW(TraceWriter(path("t"), header), UserError);
}

}  // namespace
}  // namespace ropsim
