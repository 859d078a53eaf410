// Trace files: what is written is what is read, bit for bit and in order.
#include "base/atomic_file.h"
#include "base/error.h"
#include "tests/traces/scratch.h"
#include "tests/traces/trace_round_trip.h"
#include "traces/generators.h"
#include "traces/trace.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using TraceFile = ScratchTest;

TEST_F(TraceFile, RoundTripIsBitwise) {
    const RandomFragments options = rich_options();
    const std::vector<Fragment> fragments = random_fragments(options);
    for (const TraceLayoutOptions layout : {TraceLayoutOptions{}, TraceLayoutOptions{999, 8},
                                            TraceLayoutOptions{1, 64}, TraceLayoutOptions{4096, 256}}) {
        const std::vector<Fragment> some(fragments.begin(),
                                         fragments.begin() + (layout.chunk_fragments == 1 ? 500 : 20000));
        write(path("t"), random_header(options), some, layout);
        TraceReader reader(path("t"));
        EXPECT_EQ(reader.fragment_count(), some.size());
        EXPECT_TRUE(same_bytes(read_all(reader), some))
            << layout.chunk_fragments << ", " << layout.region_side;
        EXPECT_TRUE(same_bytes(read_all(reader), some)) << "second pass";
    }
}

TEST_F(TraceFile, ChunksAreBoundedAndInArrivalOrder) {
    RandomFragments options;
    options.count = (1u << 18) + 12345;
    const std::vector<Fragment> fragments = random_fragments(options);
    write(path("t"), random_header(options), fragments, {});
    TraceReader reader(path("t"));
    std::vector<Fragment> chunk;
    ASSERT_TRUE(reader.next(chunk));
    EXPECT_EQ(chunk.size(), std::size_t{1} << 18);
    ASSERT_TRUE(reader.next(chunk));
    EXPECT_EQ(chunk.size(), 12345u);
    EXPECT_EQ(chunk[0].primitive, 1u << 18);  // the generator numbers fragments by arrival
    EXPECT_FALSE(reader.next(chunk));
    EXPECT_TRUE(chunk.empty());
    EXPECT_FALSE(reader.next(chunk));
}

TEST_F(TraceFile, HeaderRoundTrips) {
    TraceHeader header = random_header(rich_options());
    header.scene = "smoke, \"thick\" \xc3\xa9";
    header.background = {0.1f, 2.5f, 1e-30f};
    Camera camera;
    camera.near_plane = 0.1f;
    camera.far_plane = std::numeric_limits<float>::infinity();
    camera.fovy_degrees = 45.3f;
    camera.metres_per_unit = 0.01f;
    camera.view[3][1] = 0.3333333f;
    camera.projection[2][3] = -1;
    header.camera = camera;
    header.draws[2] = Draw{"glass",          4000000000u, false,     true,     BlendMode::kMultiply,
                           CullMode::kFront, {1, 2, 5},   {3, 4, 6}, "counted"};
    write(path("t"), header, {}, {});
    const TraceReader reader(path("t"));
    const TraceHeader& read = reader.header();
    EXPECT_EQ(read.width, header.width);
    EXPECT_EQ(read.height, header.height);
    EXPECT_EQ(read.samples, header.samples);
    EXPECT_EQ(read.scene, header.scene);
    EXPECT_EQ(read.background, header.background);
    EXPECT_EQ(read.color_storage, header.color_storage);
    ASSERT_TRUE(read.camera);
    EXPECT_EQ(read.camera->view, camera.view);
    EXPECT_EQ(read.camera->projection, camera.projection);
    EXPECT_EQ(read.camera->near_plane, camera.near_plane);
    EXPECT_EQ(read.camera->far_plane, camera.far_plane);
    EXPECT_EQ(read.camera->fovy_degrees, camera.fovy_degrees);
    EXPECT_EQ(read.camera->metres_per_unit, camera.metres_per_unit);
    ASSERT_EQ(read.draws.size(), header.draws.size());
    const Draw& draw = read.draws[2];
    EXPECT_EQ(draw.name, "glass");
    EXPECT_EQ(draw.object_id, 4000000000u);
    EXPECT_FALSE(draw.depth_test);
    EXPECT_TRUE(draw.depth_write);
    EXPECT_EQ(draw.blend, BlendMode::kMultiply);
    EXPECT_EQ(draw.cull, CullMode::kFront);
    EXPECT_EQ(draw.full.alu_instructions, 1u);
    EXPECT_EQ(draw.full.texture_fetches, 2u);
    EXPECT_EQ(draw.full.texture_bytes, 5u);
    EXPECT_EQ(draw.alpha.alu_instructions, 3u);
    EXPECT_EQ(draw.alpha.texture_fetches, 4u);
    EXPECT_EQ(draw.alpha.texture_bytes, 6u);
    EXPECT_EQ(draw.cost_source, "counted");
    ASSERT_TRUE(read.opaque);
    EXPECT_EQ(read.opaque->rgb, header.opaque->rgb);
    EXPECT_EQ(read.opaque->depth, header.opaque->depth);
}

TEST_F(TraceFile, SameInputsSameBytes) {
    const RandomFragments options = rich_options();
    write(path("a"), random_header(options), random_fragments(options), {});
    write(path("b"), random_header(options), random_fragments(options), {});
    EXPECT_EQ(read_file(path("a")), read_file(path("b")));
}

TEST_F(TraceFile, Float16RoundsToNearestAndClamps) {
    RandomFragments options;
    options.color_storage = ColorStorage::kFloat16;
    std::vector<Fragment> fragments(1);
    fragments[0] = {0.5f, 1.0f + 0x1.8p-11f, -1e9f, 0x1.4p-24f, 0.3f, 1, 2, 3, 1, 0};
    write_trace(path("t"), random_header(options), fragments);
    const Fragment read = read_fragments(path("t"))[0];
    EXPECT_EQ(read.r, 1.0f + 0x1p-10f);
    EXPECT_EQ(read.g, -65504.0f);
    EXPECT_EQ(read.b, 0x1p-24f);
    EXPECT_EQ(read.a, 0.3f);  // alpha stays float32
}

TEST_F(TraceFile, EmptyTraceIsValid) {
    TraceHeader header;
    header.width = 5;
    header.height = 3;
    write(path("t"), header, {}, {});
    TraceReader reader(path("t"));
    std::vector<Fragment> chunk(7);
    EXPECT_FALSE(reader.next(chunk));
    EXPECT_TRUE(chunk.empty());
    EXPECT_EQ(reader.fragment_count(), 0u);
    EXPECT_EQ(reader.tile_fragments(), std::vector<std::uint64_t>{0});
    EXPECT_EQ(reader.hash().size(), 16u);
}

TEST_F(TraceFile, TileCountsAreTheEnumeratedOnes) {
    const RandomFragments options = rich_options();
    const std::vector<Fragment> fragments = random_fragments(options);
    write(path("t"), random_header(options), fragments, {});
    std::vector<std::uint64_t> expected(38 * 18);  // ceil(300 / 8) * ceil(141 / 8)
    for (const Fragment& f : fragments) ++expected[static_cast<std::size_t>(f.y / 8 * 38 + f.x / 8)];
    EXPECT_EQ(TraceReader(path("t")).tile_fragments(), expected);
}

TEST_F(TraceFile, SelectionReturnsTheSelectedTilesInOrder) {
    const RandomFragments options = rich_options();
    const std::vector<Fragment> fragments = random_fragments(options);
    write(path("t"), random_header(options), fragments, {3000, 64});
    TraceReader reader(path("t"));
    std::vector<std::uint8_t> selected(38 * 18);
    for (std::size_t tile = 0; tile < selected.size(); tile += 7) selected[tile] = 1;
    std::vector<Fragment> expected;
    for (const Fragment& f : fragments)
        if (selected[static_cast<std::size_t>(f.y / 8 * 38 + f.x / 8)]) expected.push_back(f);
    reader.select_tiles(selected);
    EXPECT_TRUE(same_bytes(read_all(reader), expected));
    reader.select_tiles({});
    EXPECT_TRUE(same_bytes(read_all(reader), fragments));
}

TEST_F(TraceFile, BlocksWithoutASelectedTileAreNotDecoded) {
    const RandomFragments options = rich_options();
    write(path("t"), random_header(options), random_fragments(options),
          {5000, 64});  // 4 chunks, 5 x 3 regions
    TraceReader reader(path("t"));
    std::vector<std::uint8_t> selected(38 * 18);
    selected[0] = selected[1] = 1;  // one region
    reader.select_tiles(selected);
    const std::size_t count = read_all(reader).size();
    EXPECT_EQ(reader.decoded_blocks(), 4u);
    EXPECT_EQ(count, reader.tile_fragments()[0] + reader.tile_fragments()[1]);
    reader.select_tiles({});
    read_all(reader);
    EXPECT_EQ(reader.decoded_blocks(), 4u + 60u);
    reader.select_tiles(std::vector<std::uint8_t>(38 * 18));
    EXPECT_TRUE(read_all(reader).empty());
    EXPECT_EQ(reader.decoded_blocks(), 64u);
}

TEST_F(TraceFile, UnfinishedWriterLeavesNothing) {
    {
        RandomFragments options;
        TraceWriter writer(path("t"), random_header(options), {1000, 64});
        writer.append(random_fragments(options));
    }
    EXPECT_EQ(entries(), 0u);
}

TEST_F(TraceFile, WriterRefusesWhatATraceCannotHold) {
    RandomFragments options;
    TraceHeader header = random_header(options);
    const auto refused = [&](auto&& change) {
        TraceHeader other = header;
        change(other);
        EXPECT_THROW(TraceWriter(path("t"), other), UserError);
    };
    refused([](TraceHeader& h) { h.width = 0; });
    refused([](TraceHeader& h) { h.height = 16385; });
    refused([](TraceHeader& h) { h.samples = 3; });
    refused([](TraceHeader& h) { h.background.r = NAN; });
    refused([](TraceHeader& h) { h.opaque = OpaqueLayer{{1, 2, 3}, {0.5f}}; });
    TraceWriter writer(path("t"), header);
    const auto refused_fragment = [&](auto&& change) {
        Fragment f{};
        f.coverage = 1;
        change(f);
        EXPECT_THROW(writer.append(&f, 1), UserError);
    };
    refused_fragment([](Fragment& f) { f.z = -0.1f; });
    refused_fragment([](Fragment& f) { f.z = NAN; });
    refused_fragment([](Fragment& f) { f.a = 1.01f; });
    refused_fragment([](Fragment& f) { f.b = INFINITY; });
    Fragment outside{};
    outside.x = 32;
    EXPECT_DEATH(writer.append(&outside, 1), "fragment 0 at \\(32, 0\\)");
    EXPECT_THROW(TraceWriter("/nonexistent/t", header), UserError);
}

TEST_F(TraceFile, TypicalSceneTakesAtMost16BytesAFragment) {
    LayeredScene options;
    TraceWriter writer(path("t"), layered_header(options));
    append_layered(options, writer);
    writer.finish();
    const TraceReader reader(path("t"));
    EXPECT_EQ(reader.fragment_count(), 640u * 360u * 8u);
    EXPECT_LE(reader.file_bytes(), 16 * reader.fragment_count());
}

}  // namespace
}  // namespace ropsim
