// Compressed surfaces in whole frames: the bytes that follow the operations are the pixels' stored state,
// images do not change, and both machines move the same bytes where they access memory in the same order.
#include "model/cached_partition.h"
#include "rop/stored_bytes.h"
#include "tests/model/machine_driver.h"

#include <map>

namespace ropsim {
namespace {

const Settings compressed = {"compression.depth=best", "compression.color=delta",
                             "compression.nodes=used_delta", "cache.kibibytes=4", "cache.request_queue=32"};

Settings with(Settings settings, const Settings& more) {
    settings.insert(settings.end(), more.begin(), more.end());
    return settings;
}

class CompressedRunTest : public ModelTest {
 protected:
    // Layers in front of, and behind, an opaque layer of slopes and steps.
    std::string write_scene(const LayeredScene& scene) const {
        TraceHeader header = layered_header(scene);
        OpaqueLayer opaque;
        for (int y = 0; y < scene.height; ++y) {
            for (int x = 0; x < scene.width; ++x) {
                const bool wall = x / 16 % 2 == 0;
                for (int c = 0; c < 3; ++c)
                    opaque.rgb.push_back(wall ? 0.25f : static_cast<float>(x + c * y) / 512.0f);
                opaque.depth.push_back(wall ? 0.5f : 0.5f + 0.0009765625f * static_cast<float>(x + y % 64));
            }
        }
        header.opaque = std::move(opaque);
        TraceWriter writer(path("trace"), header);
        append_layered(scene, writer);
        writer.finish();
        return path("trace");
    }
};
class CompressedFrame : public CompressedRunTest, public testing::WithParamInterface<const char*> {};

INSTANTIATE_TEST_SUITE_P(Techniques, CompressedFrame,
                         testing::Values("alpha_blend", "adaptive:nodes=4", "a_buffer",
                                         "stochastic:samples=4", "laine_karras:samples=8", "slab",
                                         "phenomenological", "mlab:layers=4",
                                         "k_buffer:layers=4,format=float32", "weighted_blended",
                                         "moment_based", "wavelet", "depth_peeling"),
                         [](const auto& technique) {
                             std::string name = technique.param;
                             std::ranges::replace_if(
                                 name, [](char c) { return std::isalnum(c) == 0; }, '_');
                             return name;
                         });

// What memory and cache hold at the end, byte by byte, is what the pixels' functional words store.
TEST_P(CompressedFrame, MemoryHoldsThePixelsState) {
    const std::string trace_path = write_scene({.width = 70, .height = 45, .layers = 6, .cell = 12});
    TraceReader trace(trace_path);
    for (const char* order : {"quads", "rows", "morton"}) {
        const MachineConfig config =
            configured(with(compressed, {std::string("layout.pixels=") + order, "rop.partitions=3"}));
        const auto operation = operation_for(GetParam(), trace.header());
        Frame frame(trace, *operation, config, 1, true);
        const SurfaceMap& map = frame.surfaces();
        const Declaration& declaration = operation->declaration();
        std::vector<std::unique_ptr<CachedPartition>> partitions;
        for (std::uint32_t p = 0; p < config.partitions; ++p)
            partitions.push_back(std::make_unique<CachedPartition>(
                config, map,
                compressed_surfaces(config, map, declaration, frame.initial_pixels(), static_cast<int>(p))));
        QuadBatch batch;
        while (frame.advance(batch))
            for (const QuadOperation& q : batch.quads) partitions[q.partition]->operate(q, batch);
        for (const auto& p : partitions) p->flush();
        std::vector<std::uint8_t> expected, stored;
        std::uint64_t compared = 0;
        for (int y = 0; y < trace.header().height; ++y) {
            for (int x = 0; x < trace.header().width; ++x) {
                const std::uint32_t* words = frame.stores().store(x, y).find_pixel(x, y);
                if (words == nullptr) continue;
                const auto tile = static_cast<std::size_t>(
                    y / kTileSize * tiles_across(trace.header().width) + x / kTileSize);
                const auto quad = static_cast<std::uint32_t>(y % 8 / 2 * 4 + x % 8 / 2);
                const auto pixel = static_cast<std::uint32_t>(y % 2 * 2 + x % 2);
                CompressedMemory& memory =
                    partitions[static_cast<std::size_t>(map.partition_of(tile))]->compressed()->memory;
                for (int s = 0; s < map.technique_surfaces(); ++s) {
                    const Surface& surface = declaration.surfaces[static_cast<std::size_t>(s)];
                    if (surface.layout == Layout::kPool || surface.scale > 1) continue;
                    const auto bytes = static_cast<std::size_t>(surface.element_bytes());
                    expected.assign(bytes, 0);
                    stored.assign(bytes, 0);
                    for (std::uint32_t e = 0; e < static_cast<std::uint32_t>(surface.elements); ++e) {
                        store_elements(surface, words + surface.first_word, std::uint64_t{1} << e,
                                       expected.data());
                        memory.read(s, map.address(s, tile, quad, pixel, e),
                                    static_cast<std::uint32_t>(bytes), stored.data());
                        ASSERT_EQ(stored, expected)
                            << surface.name << " of " << x << ", " << y << " element " << e;
                        ++compared;
                    }
                }
                if (!declaration.resolves) continue;
                const std::uint32_t texel = map.pixel_bytes(map.image());
                expected.assign(texel, 0);
                stored.assign(texel, 0);
                store_color(declaration.image_format, frame.image().pixel(x, y), texel, expected.data());
                memory.read(map.image(), map.address(map.image(), tile, quad, pixel, 0), texel,
                            stored.data());
                ASSERT_EQ(stored, expected) << "image at " << x << ", " << y;
            }
        }
        EXPECT_GT(compared, 1000u);
    }
}

// With one quad at a time, whose lines the cache can hold, the clock changes little: a quad takes all its
// lines before it writes the first, so a block that one of them pushes out may leave before or after a value
// of its own.
TEST_P(CompressedFrame, TimedMovesTheBytesOfCached) {
    // Lines that are written are used twice, here with the read and there at the end: with dozens of lines a
    // quad the order of replacement differs.
    if (std::string_view(GetParam()).starts_with("laine_karras")) GTEST_SKIP() << "too many lines a quad";
    const std::string trace = write_scene({.width = 48, .height = 40, .layers = 5, .cell = 12});
    const Settings settings = with(compressed, {"rop.quads_in_flight=1", "rop.partitions=2",
                                                "metadata.kibibytes=1", "cache.kibibytes=16"});
    const auto timed = run(trace, GetParam(), settings, {"--fidelity", "timed"}, "timed");
    const auto cached = run(trace, GetParam(), settings, {"--fidelity", "cached"}, "cached");
    ASSERT_FALSE(timed.is_null() || cached.is_null());
    for (const auto& [name, surface] : cached["traffic"].items()) {
        if (!surface.contains("causes")) continue;
        for (const auto& [cause, bytes] : surface["causes"].items())
            for (const char* key : {"miss_port_read_bytes", "miss_port_write_bytes"}) {
                const double expected = bytes[key].get<double>();
                constexpr double kBlocks = 4 * 256;
                EXPECT_NEAR(timed["traffic"][name]["causes"][cause][key].get<double>(), expected,
                            0.01 * expected + kBlocks)
                    << name << " " << cause;
            }
    }
}

// Compression moves other bytes, never other colours; off, there is no trace of it.
TEST_F(CompressedRunTest, ImagesAndOperationsAreTheSame) {
    const std::string trace = write_scene({.width = 64, .height = 64, .layers = 8, .cell = 12});
    const auto off = run(trace, "adaptive:nodes=8", {}, {"--fidelity", "timed"}, "off");
    const auto on = run(trace, "adaptive:nodes=8", compressed, {"--fidelity", "timed"}, "on");
    EXPECT_EQ(read_file(path("off") + "/image.exr"), read_file(path("on") + "/image.exr"));
    EXPECT_TRUE(off["compression"].is_null());
    EXPECT_EQ(off["operation"], on["operation"]);
    const auto& nodes = on["compression"]["surfaces"]["nodes"];
    EXPECT_EQ(nodes["tried_bytes"].get<std::uint64_t>() % 256, 0u);
    EXPECT_GT(nodes["ratio"].get<double>(), 1.0);
}

// States of blocks that are fetched, not kept on chip, cost bytes and never time nothing.
TEST_F(CompressedRunTest, StatesInMemoryCostBytes) {
    const std::string trace = write_scene({.width = 128, .height = 128, .layers = 4, .cell = 12});
    const auto chip = run(trace, "mlab:layers=4", compressed, {"--fidelity", "cached"}, "chip");
    const auto memory = run(trace, "mlab:layers=4", with(compressed, {"metadata.kibibytes=1"}),
                            {"--fidelity", "cached"}, "memory");
    const auto metadata = [](const nlohmann::json& json) {
        std::uint64_t bytes = 0;
        for (const auto& [name, surface] : json["traffic"].items())
            if (surface.contains("causes") && surface["causes"].contains("metadata"))
                bytes += surface["causes"]["metadata"]["miss_port_read_bytes"].get<std::uint64_t>() +
                         surface["causes"]["metadata"]["miss_port_write_bytes"].get<std::uint64_t>();
        return bytes;
    };
    const auto pins = [](const nlohmann::json& json) {
        return json["dram"]["read_bytes"].get<std::uint64_t>() +
               json["dram"]["write_bytes"].get<std::uint64_t>();
    };
    EXPECT_EQ(metadata(chip), 0u);
    EXPECT_GT(metadata(memory), 0u);
    EXPECT_EQ(pins(memory) - pins(chip), metadata(memory));  // bursts of 32 bytes: no padding
}

// A million requests of a whole machine, compressed and not: what crosses the miss ports, cause by cause,
// reaches the pins, with padding to whole bursts and without what the channels answered themselves.
TEST_F(CompressedRunTest, BytesAreConservedOverAMillionRequests) {
    const std::string trace = write_scene({.width = 320, .height = 240, .layers = 14, .cell = 12});
    const std::pair<Settings, const char*> machines[] = {
        {{}, "gddr5x"}, {with(compressed, {"metadata.kibibytes=1"}), "gddr5x"}, {compressed, "gddr6"}};
    for (const auto& [compression, device] : machines) {
        const auto json = run(
            trace, "adaptive:nodes=8",
            with(compression, {"cache.kibibytes=1", "cache.ways=2", std::string("dram.device=") + device}),
            {"--fidelity", "timed"});
        std::uint64_t port = 0, pins = 0, padding = 0, forwarded = 0;
        for (const auto& [name, surface] : json["traffic"].items()) {
            if (!surface.contains("causes")) continue;
            for (const auto& [cause, bytes] : surface["causes"].items()) {
                const auto of = [&json = bytes](const char* key) {
                    return json[key].template get<std::uint64_t>();
                };
                EXPECT_EQ(of("miss_port_read_bytes") + of("miss_port_write_bytes") + of("padding_bytes"),
                          of("pin_read_bytes") + of("pin_write_bytes") + of("forwarded_bytes"))
                    << name << " " << cause;
                port += of("miss_port_read_bytes") + of("miss_port_write_bytes");
                pins += of("pin_read_bytes") + of("pin_write_bytes");
                padding += of("padding_bytes");
                forwarded += of("forwarded_bytes");
            }
        }
        EXPECT_EQ(port + padding, pins + forwarded);
        // Bursts of 64 bytes for sectors of 32 pad; bursts of 32 do not.
        EXPECT_EQ(padding > 0, std::string_view(device) == "gddr5x");
        EXPECT_EQ(pins, json["dram"]["read_bytes"].get<std::uint64_t>() +
                            json["dram"]["write_bytes"].get<std::uint64_t>());
        EXPECT_GT(json["dram"]["reads"].get<std::uint64_t>() + json["dram"]["writes"].get<std::uint64_t>(),
                  1'000'000u);
    }
}

// Whole frames on machines that are short of everything: none may stop, and each must balance its bytes.
TEST_F(CompressedRunTest, ScarceMachinesReachTheEnd) {
    const std::string trace = write_scene({.width = 48, .height = 40, .layers = 5, .cell = 12});
    const std::pair<const char*, Settings> machines[] = {
        {"laine_karras:samples=8", {"cache.sector_bytes=16", "l2.kibibytes=12", "rop.partitions=1"}},
        {"stochastic:samples=8", with(compressed, {"metadata.kibibytes=1", "metadata.ways=1",
                                                   "l2.kibibytes=4", "cache.kibibytes=1", "cache.ways=2"})},
        {"laine_karras:samples=8",
         {"compression.nodes=used", "metadata.kibibytes=1", "metadata.ways=2", "l2.kibibytes=4",
          "layout.elements=interleaved", "layout.tiles=morton", "rop.partitions=2"}},
        {"stochastic:samples=16", {"cache.sector_bytes=8", "cache.port_bytes=1", "cache.request_queue=64"}},
        {"adaptive:nodes=8",
         with(compressed, {"cache.port_bytes=2", "metadata.kibibytes=1", "l2.kibibytes=8", "cache.mshrs=1"})},
        {"adaptive:nodes=8", {"dram.merge_writes=true", "cache.kibibytes=1"}},
    };
    for (const auto& [technique, settings] : machines)
        EXPECT_FALSE(run(trace, technique, settings, {"--fidelity", "timed"}).is_null()) << technique;
}

TEST_F(CompressedRunTest, WrongKeysAreRefused) {
    const std::string trace = write_scene({.width = 16, .height = 16, .layers = 1});
    const std::pair<Settings, std::string> wrong[] = {
        {{"compression.levels=64 32"}, "compression.levels"},
        {{"compression.levels=64 256"}, "compression.levels"},
        {{"compression.color=delta", "compression.block_bytes=64"}, "compression.block_bytes"},
        {{"compression.color=delta", "compression.block_bytes=192"}, "compression.block_bytes"},
        {{"compression.nodes=planes"}, "compression.nodes"},
        {{"metadata.kibibytes=4", "compression.block_bytes=96", "compression.levels=32 64"},
         "compression.block_bytes"},
        {{"metadata.kibibytes=4", "cache.line_bytes=256", "cache.sector_bytes=8", "cache.request_queue=32"},
         "cache.request_queue"},
        {{"compression.color=delta", "cache.line_bytes=256", "cache.request_queue=16",
          "cache.sector_bytes=16"},
         "cache.request_queue"},
    };
    for (const auto& [settings, key] : wrong) {
        std::vector<std::string> arguments = {"run",         trace, "--technique",
                                              "alpha_blend", "-o",  path("wrong")};
        for (const std::string& s : settings) arguments.insert(arguments.end(), {"--set", s});
        const ProgramResult result = run_program(arguments);
        EXPECT_EQ(result.status, 1) << key;
        EXPECT_NE(result.err.find(key), std::string::npos) << result.err;
    }
}

}  // namespace
}  // namespace ropsim
