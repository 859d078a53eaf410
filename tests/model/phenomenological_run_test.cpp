// Phenomenological transparency through the whole program: images that do not depend on how they are
// computed, and bytes counted by hand.
#include "tests/model/machine_driver.h"

#include <bit>

#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {
namespace {

void add_camera(TraceHeader& header) {
    Camera camera;
    camera.near_plane = 0.1f;
    camera.far_plane = 100;
    camera.fovy_degrees = 60;
    camera.projection =
        glm::perspective(glm::radians(60.0f),
                         static_cast<float>(header.width) / static_cast<float>(header.height), 0.1f, 100.0f);
    header.camera = camera;
}

class PhenomenologicalRunTest : public ModelTest {
 protected:
    // Glass, smoke and hair over an opaque layer, in tiles that both sides cut off.
    std::string write_scene(int chunk_fragments = 1 << 18) const {
        RandomFragments options;
        options.seed = 5;
        options.width = 45;
        options.height = 37;
        options.count = 9000;
        options.alpha_high = 0.5f;
        options.opaque = true;
        options.materials = true;
        options.draws = 3;
        TraceHeader header = random_header(options);
        add_camera(header);
        const char* names[] = {"glass", "smoke", "hair"};
        for (std::size_t d = 0; d < 3; ++d) header.draws[d].name = names[d];
        FragmentChunk chunk = random_chunk(options);
        for (std::size_t i = 0; i < chunk.size(); ++i) {
            Fragment& f = chunk.fragments[i];
            // Runs of the smoke's fragments at a pixel, as a ray march makes them, some behind the opaque
            // layer.
            const Fragment& first = chunk.fragments[i - i % 8];
            if (first.draw == 1) {
                f.x = first.x;
                f.y = first.y;
                f.draw = 1;
            }
            if (f.draw == 2) chunk.materials[i] = Material{};
        }
        std::string at = path("scene" + std::to_string(chunk_fragments));
        TraceWriter writer(at, header, {chunk_fragments, 16});
        writer.append(chunk);
        writer.finish();
        return at;
    }
    std::string image_of(const std::string& trace, const std::string& technique, const std::string& fidelity,
                         const std::string& threads, const Settings& settings = {"rop.partitions=3"}) const {
        const auto json = run(trace, technique, settings, {"--fidelity", fidelity, "--threads", threads});
        return json.is_null() ? "failed" : read_file(path("run/image.exr"));
    }
};

constexpr const char* kTechniques[] = {
    "phenomenological:refraction_weight=alpha",
    "phenomenological:low_resolution=4,low_draws=smoke",
    "phenomenological:low_resolution=2,low_draws=smoke+glass,upsample=bilinear,filter=gaussian,gather=exact",
    "phenomenological:aggregate_draws=hair",
    "phenomenological:aggregate_draws=hair,low_resolution=2",
    "phenomenological:aggregate_draws=hair,low_draws=smoke,low_resolution=4",
    "phenomenological:register_draws=smoke",
    "phenomenological:register_draws=all,low_draws=smoke,low_resolution=2",
};

// Timed runs also hold what goes into the memories against what comes out.
TEST_F(PhenomenologicalRunTest, ImagesDoNotDependOnFidelityThreadsOrPartitions) {
    const std::string trace = write_scene();
    for (const char* technique : kTechniques) {
        const std::string one = image_of(trace, technique, "count", "1");
        EXPECT_TRUE(one == image_of(trace, technique, "count", "4")) << technique;
        EXPECT_TRUE(one == image_of(trace, technique, "cached", "4")) << technique;
        EXPECT_TRUE(one == image_of(trace, technique, "timed", "2")) << technique;
        EXPECT_TRUE(one == image_of(trace, technique, "count", "1", {"rop.partitions=1"})) << technique;
    }
}

// A run of joined fragments that a chunk's end cuts waits for the rest of it.
TEST_F(PhenomenologicalRunTest, ChunksDoNotShow) {
    const std::string whole = write_scene();
    for (const int chunk : {1, 7, 100}) {
        const std::string pieces = write_scene(chunk);
        for (const char* technique : {kTechniques[5], kTechniques[6], kTechniques[7]})
            for (const char* fidelity : {"count", "cached"}) {
                EXPECT_TRUE(image_of(whole, technique, fidelity, "1") ==
                            image_of(pieces, technique, fidelity, "2"))
                    << technique << " " << chunk << " " << fidelity;
            }
    }
    const auto joined = [&](const std::string& trace) {
        return run(trace, "phenomenological:register_draws=smoke", {}, {"--fidelity", "count"})["fragments"];
    };
    const auto counts = joined(whole);
    EXPECT_GT(counts["joined"], 500);
    EXPECT_EQ(counts, joined(path("scene1")));
}

// Quads of the passes after the fragments hold each pixel of their resolution once: the aggregation those of
// half of it, which ends within a tile, upsampling and resolve those of the image.
TEST_F(PhenomenologicalRunTest, ImagePassesGoOverThePixelsOfTheirResolution) {
    constexpr int kSize = 20;
    TraceHeader header = plain_header(kSize, kSize);
    header.draws[0].name = "hair";
    std::vector<Fragment> fragments;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x)
            fragments.push_back(fragment_at(x, y, 0.5f, static_cast<std::uint32_t>(kSize * y + x)));
    TraceReader trace(write(header, fragments));
    TechniqueSpec spec =
        parse_technique("phenomenological:aggregate_draws=hair,low_resolution=2", "--technique");
    const auto operation = make_operation(spec, screen_of(trace.header(), 0));
    const MachineConfig config = configured({"rop.partitions=3"});
    Frame frame(trace, *operation, config, 1, true);
    QuadBatch batch;
    int pixels = 0;
    while (frame.advance(batch))
        for (const QuadOperation& q : batch.quads)
            if (q.kind == QuadKind::kResolve) pixels += std::popcount(q.pixels);
    EXPECT_EQ(pixels, kSize / 2 * kSize / 2 + 2 * kSize * kSize);
}

// A march of 5 steps at each pixel of a tile leaves the shader as 16 quads, each with the shading of all its
// steps: 4 lanes for the last of each, one for every step before. The last pixel waits to see whether the
// trace goes on, and is a quad by itself.
TEST_F(PhenomenologicalRunTest, JoinedStepsLeaveTheShaderOnce) {
    constexpr int kSteps = 5;
    TraceHeader header = plain_header(8, 8);
    header.draws[0].name = "fog";
    std::vector<Fragment> fragments;
    for (int i = 0; i < 64; ++i)
        for (int step = 0; step < kSteps; ++step) {
            const int x = i / 4 % 4 * 2 + i % 2, y = i / 16 * 2 + i % 4 / 2;  // quad by quad
            fragments.push_back(fragment_at(x, y, 0.1f + 0.1f * static_cast<float>(step), 0));
        }
    TraceReader trace(write(header, fragments));
    TechniqueSpec spec = parse_technique("phenomenological:register_draws=fog", "--technique");
    const auto operation = make_operation(spec, screen_of(trace.header(), 0));
    const MachineConfig config = configured({});
    Frame frame(trace, *operation, config, 1, true);
    QuadBatch batch;
    int quads = 0;
    std::uint64_t lane_cycles = 0;
    while (frame.advance(batch))
        for (const QuadOperation& q : batch.quads)
            if (q.kind == QuadKind::kDraw) {
                ++quads;
                lane_cycles += q.shader_lane_cycles;
                EXPECT_EQ(q.pixels, quads == 16 ? 0x7 : quads == 17 ? 0x8 : 0xF);
            }
    EXPECT_EQ(quads, 17);
    EXPECT_EQ(frame.fragments().joined, 64u * (kSteps - 1));
    const auto shading = header.draws[0].full.alu_instructions +
                         static_cast<std::uint32_t>(operation->declaration().added_shading.alu_instructions);
    EXPECT_EQ(lane_cycles, shading * (17 * 4 + 64 * (kSteps - 1)));
}

// One fragment at each of 16 x 16 pixels, drawn at a quarter of the resolution: 16 of them are.
class QuarterTest : public PhenomenologicalRunTest {
 protected:
    nlohmann::json count(const std::string& keys) const {
        TraceHeader header = plain_header(16, 16);
        add_camera(header);
        header.materials = true;
        header.draws[0].name = "fog";
        header.opaque.emplace();
        header.opaque->rgb.assign(std::size_t{3} * 256, 0.5f);
        header.opaque->depth.assign(256, 0.9f);
        FragmentChunk chunk;
        for (int y = 0; y < 16; ++y)
            for (int x = 0; x < 16; ++x)
                chunk.fragments.push_back(fragment_at(x, y, 0.5f, static_cast<std::uint32_t>(16 * y + x)));
        chunk.materials.resize(256);
        TraceWriter writer(path("quarter"), header);
        writer.append(chunk);
        writer.finish();
        return run(path("quarter"), "phenomenological:low_draws=fog,low_resolution=4" + keys, {},
                   {"--fidelity", "count"});
    }
};

TEST_F(QuarterTest, FragmentsBetweenSamplesAreCountedAndNotDrawn) {
    const auto json = count("");
    EXPECT_EQ(json["fragments"]["input"], 256);
    EXPECT_EQ(json["fragments"]["between_samples"], 240);
    EXPECT_EQ(json["fragments"]["operated"], 16);
    // 112, and a sixteenth of them for the small targets (64, 32 and 16 bits) and their depths (32).
    EXPECT_EQ(json["storage_bits_per_pixel"], 112 + 4 + 2 + 1 + 2);
    EXPECT_EQ(json["passes"], 2);
}

TEST_F(QuarterTest, BytesByHand) {
    const auto traffic = count("")["traffic"];
    const auto bytes = [&](const char* surface, const char* what) {
        return traffic[surface][what].get<int>();
    };
    constexpr int kPixels = 256, kDrawn = 16, kTaps = 49, kTile = 64;
    struct Target {
        const char *low, *full;
        int bytes;
    };
    for (const Target& t : {Target{"low_accumulated", "accumulated", 8}, Target{"low_beta", "beta", 4},
                            Target{"low_delta", "delta", 2}}) {
        EXPECT_EQ(bytes(t.low, "read_bytes"), (kDrawn + kPixels * kTaps) * t.bytes) << t.low;
        EXPECT_EQ(bytes(t.low, "write_bytes"), kDrawn * t.bytes) << t.low;
        EXPECT_EQ(bytes(t.low, "worst_case_read_bytes"), (kDrawn + kPixels * kTaps) * t.bytes) << t.low;
        // Upsampling blends into the large ones once, the resolve reads each once.
        EXPECT_EQ(bytes(t.full, "read_bytes"), 2 * kPixels * t.bytes) << t.full;
        EXPECT_EQ(bytes(t.full, "write_bytes"), kPixels * t.bytes) << t.full;
    }
    // The small depths: a tile of them copied, then every tap; those drawn lie before all of the tile, so
    // that their depth test need not read it.
    EXPECT_EQ(bytes("low_depth", "write_bytes"), kTile * 4);
    EXPECT_EQ(bytes("low_depth", "read_bytes"), kPixels * kTaps * 4);
    // The copy, each pixel's own in upsampling.
    EXPECT_EQ(bytes("opaque_depth", "read_bytes"), (kTile + kPixels) * 4);
    EXPECT_EQ(bytes("opaque_color", "read_bytes"), kPixels * 8);
    EXPECT_EQ(bytes("image", "write_bytes"), kPixels * 8);
    // The bilinear kernel reads four.
    const auto four = count(",upsample=bilinear")["traffic"];
    EXPECT_EQ(four["low_accumulated"]["read_bytes"], (kDrawn + kPixels * 4) * 8);
    EXPECT_EQ(four["low_depth"]["read_bytes"], kPixels * 4 * 4);
}

}  // namespace
}  // namespace ropsim
