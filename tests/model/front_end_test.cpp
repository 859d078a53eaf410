// The front end with one bottleneck at a time: throughput equals the closed form, and so does the latency of
// a lone quad; what early depth tests and texture caches move.
#include "tests/model/machine_driver.h"

#include <set>

namespace ropsim {
namespace {

using nlohmann::json;

constexpr int kSide = 64;  // pixels: 1024 quads, 64 tiles

class FrontEndTest : public ModelTest {
 protected:
    // Full quads that go over the image again and again, each its own primitive.
    std::string sweep(int quads, TraceHeader header = plain_header(kSide, kSide), float z = 0.5f) const {
        std::vector<Fragment> fragments;
        for (int i = 0; i < quads; ++i)
            for (int p = 0; p < 4; ++p)
                fragments.push_back(fragment_at(i % 32 * 2 + p % 2, i / 32 % 32 * 2 + p / 2, z,
                                                static_cast<std::uint32_t>(i)));
        return write(header, fragments);
    }
    // Everything else is wide and hits the caches.
    json wide(const std::string& trace, const Settings& narrow) const {
        Settings settings = {"clock.rop_mhz=1000",
                             "clock.shader_mhz=1000",
                             "shader.alu_lanes=65536",
                             "shader.latency=20",
                             "shader.quads_in_flight=8192",
                             "shader.raster_quads_per_cycle=64",
                             "shader.raster_tiles_per_cycle=64",
                             "shader.export_quads_per_cycle=64",
                             "rop.partitions=8",
                             "cache.kibibytes=64",
                             "rop.rate.bits_64=1",
                             "hiz.enabled=false"};
        settings.insert(settings.end(), narrow.begin(), narrow.end());
        return run(trace, "alpha_blend", settings);
    }
    void expect_cycles(const json& result, double closed_form, const std::string& what) const {
        EXPECT_GE(result["cycles"].get<double>(), closed_form) << what;
        EXPECT_LE(result["cycles"].get<double>(), 1.02 * closed_form + 400) << what;  // to fill and to drain
    }
};

constexpr int kQuads = 40000;

TEST_F(FrontEndTest, QuadsBoundTheRasteriser) {
    const std::string trace = sweep(kQuads);
    for (const int rate : {1, 2}) {
        const json result = wide(trace, {fmt::format("shader.raster_quads_per_cycle={}", rate)});
        expect_cycles(result, static_cast<double>(kQuads) / rate, "quads");
        EXPECT_NEAR(result["stages"]["rasteriser"]["busy"].get<double>(), static_cast<double>(kQuads) / rate,
                    2);
        EXPECT_EQ(result["front_end"]["quads"], kQuads);
    }
}

TEST_F(FrontEndTest, TilesBoundTheRasteriser) {
    const std::string trace = sweep(kQuads);
    for (const int rate : {1, 3}) {
        const json result = wide(trace, {fmt::format("shader.raster_tiles_per_cycle={}", rate)});
        expect_cycles(result, static_cast<double>(kQuads) / rate, "tiles");
        EXPECT_EQ(result["front_end"]["primitive_tiles"], kQuads);
    }
    // One primitive over whole tiles: sixteen quads a visit, so that the quads bind again.
    std::vector<Fragment> fragments;
    for (int layer = 0; layer < 40; ++layer)
        for (int tile = 0; tile < 64; ++tile)
            for (int quad = 0; quad < 16; ++quad)
                for (int p = 0; p < 4; ++p)
                    fragments.push_back(fragment_at(tile % 8 * 8 + quad % 4 * 2 + p % 2,
                                                    tile / 8 * 8 + quad / 4 * 2 + p / 2, 0.5f,
                                                    static_cast<std::uint32_t>(layer)));
    const std::string layers = write(plain_header(kSide, kSide), fragments, "layers");
    const json result = wide(layers, {"shader.raster_tiles_per_cycle=1", "shader.raster_quads_per_cycle=2"});
    expect_cycles(result, 40 * 1024 / 2.0, "whole tiles");
    EXPECT_EQ(result["front_end"]["primitive_tiles"], 40 * 64);
}

TEST_F(FrontEndTest, ExportBoundsTheThroughput) {
    expect_cycles(wide(sweep(kQuads), {"shader.export_quads_per_cycle=1"}), kQuads, "export");
}

// Little's law: cores x warps x quads in flight, each for the ALU's time and the latency, and for the cycles
// of its export.
TEST_F(FrontEndTest, WarpsInFlightBoundTheThroughput) {
    const std::string trace = sweep(kQuads);
    for (const auto& [cores, warps, latency] : {std::tuple{1, 2, 1000}, std::tuple{3, 4, 3000}}) {
        const json result = wide(
            trace, {fmt::format("shader.cores={}", cores), fmt::format("shader.warps={}", warps),
                    fmt::format("shader.latency={}", latency), "rop.partitions=1", "shader.warp_quads=8"});
        // A warp's eight quads leave one a cycle: the cycle of the last and the next one's entry follow.
        const double warp_time = latency + 16.0 * 32 * cores / 65536;
        const double rounds = kQuads / 8.0 / (cores * warps);
        EXPECT_GE(result["cycles"].get<double>(), rounds * warp_time);
        EXPECT_LE(result["cycles"].get<double>(), 1.02 * rounds * (warp_time + 8.0 * cores * warps))
            << latency;
        EXPECT_EQ(result["front_end"]["warps"], kQuads / 8);
        EXPECT_EQ(result["front_end"]["warp_occupancy"], 1.0);
        EXPECT_EQ(result["front_end"]["quad_occupancy"], 1.0);
    }
}

// A warp of one quad takes the ALU as long as a full one.
TEST_F(FrontEndTest, EmptyLanesTakeTheAluToo) {
    std::vector<Fragment> fragments;
    for (int i = 0; i < 4000; ++i) {
        // Draws take turns: no two quads share a warp.
        fragments.push_back(fragment_at(i % 32 * 2, i / 32 % 32 * 2, 0.5f, static_cast<std::uint32_t>(i)));
        fragments.back().draw = static_cast<std::uint16_t>(i % 2);
    }
    const std::string trace = write(plain_header(kSide, kSide, 2), fragments);
    const json result = wide(trace, {"shader.cores=1", "shader.alu_lanes=32", "shader.warp_quads=8"});
    expect_cycles(result, 4000.0 * 16, "a warp a quad");
    EXPECT_EQ(result["front_end"]["warps"], 4000);
    EXPECT_EQ(result["front_end"]["lanes"]["covered"], 4000);
    EXPECT_EQ(result["front_end"]["lanes"]["helper"], 3 * 4000);
    EXPECT_EQ(result["front_end"]["lanes"]["empty"], 28 * 4000);
}

TraceHeader textured(std::uint32_t fetches, std::uint32_t bytes) {
    TraceHeader header = plain_header(kSide, kSide);
    header.draws[0].full.texture_fetches = fetches;
    header.draws[0].full.texture_bytes = bytes;
    return header;
}

// Two lines a quad, one a cycle and core.
TEST_F(FrontEndTest, TextureLookUpsBoundTheThroughput) {
    const std::string trace = sweep(kQuads, textured(2, 32));
    const json result = wide(trace, {"shader.cores=2", "texture.l1_kibibytes=128", "texture.l1_ways=16"});
    expect_cycles(result, kQuads * 2 / 2.0, "look-ups");
    EXPECT_EQ(result["front_end"]["textures"]["quad_fetches"], 2 * kQuads);
    EXPECT_NEAR(result["stages"]["texture_cache"]["busy"].get<double>(), 2.0 * kQuads, 1.0);
}

// Every quad reads 128 bytes that no cache keeps: the channels move them at the rate of a stream.
TEST_F(FrontEndTest, TextureBandwidthBoundsTheThroughput) {
    const int quads = 16384;  // 16 sweeps over 128 KiB, two cores of 4 KiB
    const std::string trace = sweep(quads, textured(1, 128));
    const Settings settings = {"shader.cores=2",
                               "shader.warps=64",
                               "texture.l1_kibibytes=4",
                               "texture.quads_per_cycle=8",
                               "texture.mshrs=256",
                               "rop.partitions=2",
                               "dram.mapping=row bank column:4 bankgroup column:2"};
    const json result = wide(trace, settings);
    const double bytes = 128.0 * quads;
    EXPECT_EQ(result["traffic"]["textures"]["causes"]["texture"]["miss_port_read_bytes"], bytes);
    const MachineConfig c = configured({"rop.partitions=2"});
    const DramConfig& d = c.dram;
    const double refreshed =
        1 - static_cast<double>(d.trtp + d.trp + d.trfc + d.trcd_rd) / static_cast<double>(d.trefi);
    const double seconds = bytes / (2 * d.peak_bytes_per_second() * refreshed);
    EXPECT_GE(result["seconds"].get<double>(), 0.98 * seconds);
    EXPECT_LE(result["seconds"].get<double>(), 1.05 * seconds);
    // Without a clock the same bytes.
    Settings cached = settings;
    const json untimed = run(trace, "alpha_blend", settings, {"--fidelity", "cached"}, "cached");
    EXPECT_EQ(untimed["traffic"]["textures"]["causes"]["texture"]["miss_port_read_bytes"], bytes);
}

// Of a lone quad: looked up, its texels fetched from a closed row, then the ALU.
TEST_F(FrontEndTest, LatencyOfALoneTexturedQuad) {
    const Settings settings = {"rop.partitions=1", "cache.fast_clear=false", "texture.latency=77"};
    const auto shaded_cycles = [&](const TraceHeader& header) {
        const std::string trace = write(header, {fragment_at(5, 6, 0.5f, 0)});
        return run(trace, "alpha_blend", settings)["stages"]["front_end"]["stall"]["shading"]
            .get<std::uint64_t>();
    };
    const MachineConfig c = configured(settings);
    const std::uint64_t rop = c.rop_period_ps;
    const auto up = [](std::uint64_t value, std::uint64_t unit) { return (value + unit - 1) / unit; };
    const double period = static_cast<double>(c.shader_period_ps);
    const auto entered = static_cast<std::uint64_t>(period / c.front.raster_tiles_per_cycle);
    const std::uint64_t asked = up(entered, rop) * rop;
    const std::uint64_t data =
        (up(asked, c.dram.tck_ps) + c.dram.activate_to_read() + c.dram.read_cycles()) * c.dram.tck_ps;
    const std::uint64_t texels = (up(data, rop) + 77) * rop;
    const double lanes = static_cast<double>(c.shader_alu_lanes) / c.front.shader.cores;
    const auto worked = static_cast<std::uint64_t>(period * 16 * 4 * c.front.shader.warp_quads / lanes);
    EXPECT_EQ(shaded_cycles(textured(1, 16)),
              up(texels + worked + c.shader_latency * c.shader_period_ps, rop));
    EXPECT_EQ(shaded_cycles(plain_header(kSide, kSide)), up(lone_quad_shaded(c, 16), rop));
}

// Half of the quads behind a layer at one depth that is too coarse for the ranges: early, they are not
// shaded.
TEST_F(FrontEndTest, EarlyDepthSavesShading) {
    TraceHeader header = plain_header(kSide, kSide);
    header.opaque.emplace();
    header.opaque->rgb.assign(std::size_t{3} * kSide * kSide, 0.5f);
    header.opaque->depth.assign(std::size_t{kSide} * kSide, 0.4f);
    for (std::size_t i = 0; i < header.opaque->depth.size(); ++i)
        if (i / 2 % 2 == 0) header.opaque->depth[i] = 0.6f;  // every other quad
    const std::string trace = sweep(8192, header);
    const Settings ranges = {"hiz.enabled=true"};
    const json early = wide(trace, {"hiz.enabled=true"});
    const json late = wide(trace, {"hiz.enabled=true", "depth.test=late"});
    EXPECT_EQ(early["front_end"]["hierarchical_depth"]["tested_quads"], 8192);
    EXPECT_EQ(early["front_end"]["early_depth"]["culled_quads"], 4096);
    EXPECT_EQ(early["front_end"]["shaded_quads"], 4096);
    EXPECT_EQ(late["front_end"]["shaded_quads"], 8192);
    EXPECT_EQ(early["error"], late["error"]);
    EXPECT_EQ(early["fragments"], late["fragments"]);
    // 16 KiB of depths, 2 KiB a partition: each sector is read once either way.
    const char* read = "pin_read_bytes";
    EXPECT_EQ(early["traffic"]["opaque_depth"][read], 4 * kSide * kSide);
    EXPECT_EQ(late["traffic"]["opaque_depth"][read], 4 * kSide * kSide);
    const json untimed = run(trace, "alpha_blend", {"hiz.enabled=true"}, {"--fidelity", "cached"}, "cached");
    EXPECT_EQ(untimed["traffic"]["opaque_depth"][read], 4 * kSide * kSide);
    EXPECT_EQ(untimed["front_end"]["hierarchical_depth"], early["front_end"]["hierarchical_depth"]);
    EXPECT_EQ(untimed["front_end"]["shaded_quads"], 4096);
    EXPECT_EQ(early["stages"]["depth_unit"]["busy"], 8192);
}

// Behind a layer that lies at one depth everywhere, nothing is read and nothing reaches a partition.
TEST_F(FrontEndTest, RejectedQuadsCostTheRasteriserAlone) {
    TraceHeader header = plain_header(kSide, kSide);
    header.opaque.emplace();
    header.opaque->rgb.assign(std::size_t{3} * kSide * kSide, 0.5f);
    header.opaque->depth.assign(std::size_t{kSide} * kSide, 0.25f);
    const json result = wide(sweep(kQuads, header), {"hiz.enabled=true", "shader.raster_quads_per_cycle=1"});
    EXPECT_EQ(result["cycles"], kQuads);
    EXPECT_EQ(result["front_end"]["hierarchical_depth"]["rejected_quads"], kQuads);
    EXPECT_EQ(result["front_end"]["hierarchical_depth"]["saved_read_bytes"], 16 * kQuads);
    EXPECT_EQ(result["dram"]["read_bytes"], 0);
}

TEST_F(FrontEndTest, KeysAreChecked) {
    const std::string trace = sweep(4);
    for (const auto& [setting, word] :
         {std::pair{"depth.test=never", "early"}, std::pair{"hiz.bits=3", "4"},
          std::pair{"shader.cores=0", "1"}, std::pair{"depth.ways=64", "depth.kibibytes"},
          std::pair{"texture.l1_ways=65", "64"}}) {
        const ProgramResult r = run_program(
            {"run", trace, "--technique", "alpha_blend", "--set", setting, "-o", path("refused")});
        EXPECT_EQ(r.status, 1) << setting;
        EXPECT_NE(r.err.find(word), std::string::npos) << setting << ": " << r.err;
    }
}

}  // namespace
}  // namespace ropsim
