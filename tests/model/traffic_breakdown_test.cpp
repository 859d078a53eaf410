// Bytes by pass, draw and tile: by hand, summed, and against where lines lie.
#include "model/cached_machine.h"
#include "tests/model/machine_driver.h"
#include "traces/image.h"
#include "traces/overdraw_picture.h"

#include <gmock/gmock.h>

namespace ropsim {
namespace {

class TrafficBreakdownTest : public ModelTest {
 protected:
    MachineResult cached(const std::string& trace_path, const std::string& technique,
                         const Settings& settings = {}) {
        TraceReader trace(trace_path);
        const MachineConfig config = configured(settings);
        const auto operation = operation_for(technique, trace.header());
        Frame frame(trace, *operation, config, 1, true);
        return run_cached_machine(frame, config, 1);
    }
};

// A cache of 8 lines of one set. Draw 0 writes 6 tiles, draw 1 four others: draw 0's first two lines leave
// meanwhile, for draw 1, but they are draw 0's; the rest leaves at the end of the frame and is still theirs
// who wrote it.
TEST_F(TrafficBreakdownTest, WritesBelongToWhoWroteLast) {
    TraceHeader header = plain_header(128, 8, 2);
    std::vector<Fragment> fragments;
    for (int tile = 0; tile < 10; ++tile) {
        fragments.push_back(fragment_at(8 * tile, 0, 0.5f, static_cast<std::uint32_t>(tile)));
        fragments.back().draw = tile < 6 ? 0 : 1;
    }
    const std::string trace = write(header, fragments);
    const MachineResult result =
        cached(trace, "alpha_blend", {"rop.partitions=1", "cache.kibibytes=1", "cache.ways=8"});
    ASSERT_EQ(result.breakdown.draws().size(), 3u);
    EXPECT_EQ(result.breakdown.draws()[0].write, 6u * 32);
    EXPECT_EQ(result.breakdown.draws()[1].write, 4u * 32);
    EXPECT_EQ(result.breakdown.draws()[2].sum(), 0u);
    for (std::size_t tile = 0; tile < 16; ++tile)
        EXPECT_EQ(result.breakdown.tiles()[tile].write, tile < 10 ? 32u : 0u) << tile;
    const auto& passes = result.breakdown.passes();
    ASSERT_EQ(passes.size(), 4u);
    EXPECT_EQ(passes[0].name, "initialise");
    EXPECT_EQ(passes[1].bytes.write, 10u * 32);
    EXPECT_EQ(passes[2].name, "resolve");
    EXPECT_EQ(passes[3].name, "end_of_frame");
}

// A draw over another one's lines takes them over; what it reads is its own.
TEST_F(TrafficBreakdownTest, ASecondDrawTakesLinesOver) {
    TraceHeader header = plain_header(8, 8, 2);
    std::vector<Fragment> fragments{fragment_at(0, 0, 0.5f, 0), fragment_at(0, 0, 0.5f, 1)};
    fragments[1].draw = 1;
    const MachineResult result = cached(write(header, fragments), "alpha_blend");
    EXPECT_EQ(result.breakdown.draws()[0].sum(), 0u);
    EXPECT_EQ(result.breakdown.draws()[1].write, 32u);
}

// run.json's parts sum to its whole, whatever the technique: lists, several passes, low resolutions, states.
TEST_F(TrafficBreakdownTest, PartsSumToTheWhole) {
    LayeredScene scene;
    scene.width = 100;
    scene.height = 75;
    const std::string trace = write_layers(scene);
    for (const std::string fidelity : {"cached", "timed"}) {
        for (const std::string technique :
             {"a_buffer", "stochastic:samples=4", "phenomenological", "adaptive:nodes=4"}) {
            const nlohmann::json run = this->run(trace, technique, {}, {"--fidelity", fidelity}, "out");
            ASSERT_FALSE(run.is_null());
            std::uint64_t read = 0, write = 0;
            for (const auto& [surface, entry] : run["traffic"].items()) {
                if (!entry.contains("causes")) continue;
                for (const auto& [cause, bytes] : entry["causes"].items()) {
                    read += bytes["miss_port_read_bytes"].get<std::uint64_t>();
                    write += bytes["miss_port_write_bytes"].get<std::uint64_t>();
                }
            }
            ASSERT_GT(write, 0u);
            for (const char* parts : {"traffic_by_pass", "traffic_by_draw"}) {
                std::uint64_t part_read = 0, part_write = 0;
                for (const nlohmann::json& part : run[parts]) {
                    part_read += part["miss_port_read_bytes"].get<std::uint64_t>();
                    part_write += part["miss_port_write_bytes"].get<std::uint64_t>();
                }
                EXPECT_EQ(part_read, read) << technique << " " << parts;
                EXPECT_EQ(part_write, write) << technique << " " << parts;
            }
            const Image tiles = read_exr(path("out/tiles.exr"));
            ASSERT_THAT(tiles.channels, ::testing::UnorderedElementsAre("read", "write"));
            EXPECT_EQ(tiles.width, 13);
            EXPECT_EQ(tiles.height, 10);
            double sum = 0;
            for (const float value : tiles.values) sum += value;
            EXPECT_EQ(sum, static_cast<double>(read + write)) << technique;
            EXPECT_TRUE(std::filesystem::exists(path("out/tiles.png")));

            std::uint64_t pins = 0;
            for (const nlohmann::json& channel : run["dram"]["channels"])
                pins +=
                    channel["read_bytes"].get<std::uint64_t>() + channel["write_bytes"].get<std::uint64_t>();
            EXPECT_EQ(pins, run["traffic"]["total"]["pin_read_bytes"].get<std::uint64_t>() +
                                run["traffic"]["total"]["pin_write_bytes"].get<std::uint64_t>());
            if (fidelity != "timed") {
                EXPECT_TRUE(run["read_latency"].is_null());
                continue;
            }
            const nlohmann::json& all = run["read_latency"]["all"];
            std::uint64_t reads = 0;
            double largest = 0;
            for (const auto& [surface, latency] : run["read_latency"]["surfaces"].items()) {
                reads += latency["reads"].get<std::uint64_t>();
                largest = std::max(largest, latency["max_ns"].get<double>());
            }
            EXPECT_EQ(all["reads"], reads);
            EXPECT_EQ(all["max_ns"], largest);
            if (reads == 0) continue;
            EXPECT_LE(all["p50_ns"], all["p99_ns"]);
            EXPECT_LE(all["p99_ns"], all["max_ns"]);
            // Not below a row's activation, a read and its burst in an idle GDDR6 channel.
            EXPECT_GT(all["p50_ns"].get<double>(), 20.0);
        }
    }
}

// Pictures of a run before must not stand beside one that has none.
TEST_F(TrafficBreakdownTest, CountHasNoTiles) {
    const std::string trace = write(plain_header(16, 16), {fragment_at(1, 1, 0.5f, 0)});
    ASSERT_FALSE(run(trace, "alpha_blend", {}, {"--fidelity", "cached"}, "out").is_null());
    EXPECT_TRUE(std::filesystem::exists(path("out/tiles.exr")));
    const nlohmann::json count = run(trace, "alpha_blend", {}, {"--fidelity", "count"}, "out");
    EXPECT_FALSE(std::filesystem::exists(path("out/tiles.exr")));
    EXPECT_FALSE(std::filesystem::exists(path("out/tiles.png")));
    for (const char* key : {"traffic_by_pass", "traffic_by_draw", "read_latency"})
        EXPECT_TRUE(count[key].is_null()) << key;
}

TEST(TilePicture, ScaleNamesItsUnit) {
    const std::vector<std::uint32_t> counts{1, 2, 300, 4};
    const Image plain = overdraw_picture(counts, 2, 2);
    const Image named = overdraw_picture(counts, 2, 2, "KiB");
    ASSERT_EQ(named.height, plain.height);
    const auto row = static_cast<std::size_t>(plain.width) * 3;
    // The map is enlarged to 256 pixels; below it the scale makes room for three letters at the right.
    EXPECT_TRUE(std::equal(plain.values.begin(),
                           plain.values.begin() + static_cast<std::ptrdiff_t>(256 * row),
                           named.values.begin()));
    int inked = 0;
    for (int y = 256; y < named.height; ++y)
        for (int x = named.width - 32; x < named.width; ++x) inked += named.pixel(x, y)[0] > 0.5f ? 1 : 0;
    // K has 10 dots, i 4 and B 10, of four pixels each.
    EXPECT_EQ(inked, 4 * (10 + 4 + 10));
}

// At low resolution a tile covers several of the screen, each of which gets its share.
TEST(TrafficBreakdown, LowResolutionIsSharedOut) {
    TrafficBreakdown bytes({"pass", "end_of_frame"}, 1, 3, 3);
    bytes.add({0, 0, 0, 2}, 103, false);
    bytes.add({4, 0, 0, 2}, 32, true);  // tile (1, 1) covers only (2, 2): the screen ends
    bytes.add(bytes.end_of_frame(), 7, true);
    EXPECT_EQ(bytes.tiles()[0].read, 28u);  // 25 and what is left
    for (const std::size_t tile : {1u, 3u, 4u}) EXPECT_EQ(bytes.tiles()[tile].read, 25u);
    EXPECT_EQ(bytes.tiles()[8].write, 32u);
    EXPECT_EQ(bytes.without_tile().write, 7u);
    BytesByCause port(1);
    port[0][0] = {103, 39, 0};
    bytes.check(port);
    port[0][0].write = 40;
    EXPECT_DEATH(bytes.check(port), "passes: 103 and 39 of 103 and 40");
}

}  // namespace
}  // namespace ropsim
