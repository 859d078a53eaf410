// Engine `shader` with and without a clock: the same loads and stores, depths and texels included.
#include "tests/model/tiled_driver.h"

namespace ropsim {
namespace {

class InterlockBytes : public TiledEngineTest, public ::testing::WithParamInterface<std::string> {};

ReadWriteBytes sum_of(const BytesByCause& bytes) {
    ReadWriteBytes sum;
    for (const auto& surface : bytes) {
        for (const CauseBytes& cause : surface) {
            sum.read += cause.read;
            sum.write += cause.write;
        }
    }
    return sum;
}

TEST_P(InterlockBytes, CachedAsksForWhatTimedAsksFor) {
    RandomFragments scene;
    scene.width = 96;
    scene.height = 64;
    scene.count = 20000;
    scene.draws = 3;
    scene.opaque = true;
    TraceHeader header = random_header(scene);
    for (std::size_t d = 0; d < header.draws.size(); ++d) {
        header.draws[d].full.texture_fetches = static_cast<std::uint32_t>(d);
        header.draws[d].full.texture_bytes = static_cast<std::uint32_t>(d) * 20;
    }
    const std::string trace = write(header, random_fragments(scene));
    // A warp waits long for its next quad, without a clock as with it, and finds its texels in one cache.
    const Settings settings = {"rop.partitions=2", "cache.kibibytes=8",   "shader.pack_timeout=1000000",
                               "shader.cores=1",   "texture.mebibytes=4", "pool.mebibytes=64"};
    const RunResult timed = run_with(trace, GetParam(), Engine::kShader, Fidelity::kTimed, settings);
    const RunResult cached = run_with(trace, GetParam(), Engine::kShader, Fidelity::kCached, settings);
    EXPECT_EQ(timed.machine->quads, cached.machine->quads);
    EXPECT_EQ(timed.machine->front_end.early_culled, cached.machine->front_end.early_culled);
    EXPECT_GT(timed.machine->front_end.early_culled, 0u);
    EXPECT_EQ(timed.machine->front_end.shaded_quads, cached.machine->front_end.shaded_quads);
    const auto textures =
        static_cast<std::size_t>(std::ranges::find(timed.surfaces, "textures") - timed.surfaces.begin());
    ASSERT_LT(textures, timed.surfaces.size());
    for (std::size_t s = 0; s < timed.surfaces.size(); ++s) {
        for (std::size_t c = 0; c < kMemoryCauses; ++c) {
            const CauseBytes& one = timed.machine->miss_port[s][c];
            const CauseBytes& other = cached.machine->miss_port[s][c];
            EXPECT_EQ(one.write, other.write) << timed.surfaces[s] << " cause " << c;
            const bool cached_before = s == textures || (timed.surfaces[s] == "opaque_depth" &&
                                                         static_cast<MemoryCause>(c) == MemoryCause::kFill);
            // A cache with a clock spares the lines that are on their way.
            if (cached_before)
                EXPECT_NEAR(static_cast<double>(one.read), static_cast<double>(other.read),
                            0.002 * static_cast<double>(one.read))
                    << timed.surfaces[s];
            else
                EXPECT_EQ(one.read, other.read) << timed.surfaces[s] << " cause " << c;
        }
    }
    // Below, the slices see another order.
    const ReadWriteBytes a = sum_of(timed.machine->pins);
    const ReadWriteBytes b = sum_of(cached.machine->pins);
    const double ratio = static_cast<double>(b.read + b.write) / static_cast<double>(a.read + a.write);
    EXPECT_GT(ratio, 0.6);
    EXPECT_LT(ratio, 1.1);
    EXPECT_LE(cached.machine->rop_cycles, timed.machine->rop_cycles + timed.machine->rop_cycles / 50);
}

INSTANTIATE_TEST_SUITE_P(Techniques, InterlockBytes,
                         ::testing::Values("alpha_blend", "adaptive:nodes=4", "a_buffer", "k_buffer:layers=4",
                                           "stochastic:samples=8", "weighted_blended",
                                           "depth_peeling:layers=3"),
                         [](const auto& test) { return test.param.substr(0, test.param.find(':')); });

}  // namespace
}  // namespace ropsim
