// Host speed of the block codecs next to memcpy: benchmark_block_codec [--benchmark_filter=REGEX]. Bytes are
// of blocks; `ratio` is the bytes of blocks over those of their levels.
#include "memory/block_codec.h"
#include "tests/memory/block_samples.h"

#include <cstring>
#include <string>

#include <benchmark/benchmark.h>

namespace ropsim {
namespace {

using block_samples::Content;

constexpr std::uint32_t kTiles = 16;  // within the first-level cache's reach

std::vector<std::uint8_t> tiles(const BlockFormat& format, Content content) {
    std::vector<std::uint8_t> all;
    for (std::uint32_t t = 0; t < kTiles; ++t) {
        const std::vector<std::uint8_t> one = block_samples::tile(format, content, t);
        all.insert(all.end(), one.begin(), one.end());
    }
    return all;
}

void compress(benchmark::State& state, CodecKind kind, const BlockFormat& format, Content content) {
    const BlockCodec codec(kind, format, {32, 64, 128});
    const std::vector<std::uint8_t> bytes = tiles(format, content);
    const std::size_t tile = bytes.size() / kTiles;
    std::array<std::uint8_t, 256> out;
    std::uint64_t stored = 0;
    for (auto _ : state)
        for (std::size_t at = 0; at < bytes.size(); at += 256) {
            stored += codec.compress(bytes.data() + at, static_cast<std::uint32_t>(at % tile), out.data());
            benchmark::DoNotOptimize(out);
        }
    const auto total = static_cast<double>(state.iterations()) * static_cast<double>(bytes.size());
    state.SetBytesProcessed(static_cast<std::int64_t>(total));
    state.counters["ratio"] = total / static_cast<double>(stored);
}

void decompress(benchmark::State& state, CodecKind kind, const BlockFormat& format, Content content) {
    const BlockCodec codec(kind, format, {32, 64, 128});
    const std::vector<std::uint8_t> bytes = tiles(format, content);
    const std::size_t tile = bytes.size() / kTiles;
    std::vector<std::uint8_t> packed = bytes;
    std::vector<std::uint32_t> levels;
    for (std::size_t at = 0; at < bytes.size(); at += 256)
        levels.push_back(
            codec.compress(bytes.data() + at, static_cast<std::uint32_t>(at % tile), packed.data() + at));
    std::array<std::uint8_t, 256> out;
    for (auto _ : state)
        for (std::size_t at = 0; at < bytes.size(); at += 256) {
            codec.decompress(packed.data() + at, levels[at / 256], static_cast<std::uint32_t>(at % tile),
                             out.data());
            benchmark::DoNotOptimize(out);
        }
    state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations()) *
                            static_cast<std::int64_t>(bytes.size()));
}

void copy(benchmark::State& state) {
    const std::vector<std::uint8_t> bytes(kTiles * 256, 7);
    std::array<std::uint8_t, 256> out;
    for (auto _ : state)
        for (std::size_t at = 0; at < bytes.size(); at += 256) {
            std::memcpy(out.data(), bytes.data() + at, 256);
            benchmark::DoNotOptimize(out);
        }
    state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations()) *
                            static_cast<std::int64_t>(bytes.size()));
}

struct Case {
    const char* name;
    CodecKind kind;
    std::size_t surface;  // of block_samples::surfaces()
    Content content;
};

constexpr Case kCases[] = {
    {"depth_planes/float32/plane", CodecKind::kDepthPlanes, 0, Content::kPlane},
    {"depth_planes/float32/two_planes", CodecKind::kDepthPlanes, 0, Content::kTwoPlanes},
    {"depth_planes/float32/random", CodecKind::kDepthPlanes, 0, Content::kRandom},
    {"depth_delta/float32/two_planes", CodecKind::kDepthDelta, 0, Content::kTwoPlanes},
    {"depth_delta/float32/random", CodecKind::kDepthDelta, 0, Content::kRandom},
    {"depth_best/float32/two_planes", CodecKind::kDepthBest, 0, Content::kTwoPlanes},
    {"color_delta/unorm8/constant", CodecKind::kColorDelta, 5, Content::kOneValue},
    {"color_delta/unorm8/noise", CodecKind::kColorDelta, 5, Content::kNoise},
    {"color_delta/unorm8/random", CodecKind::kColorDelta, 5, Content::kRandom},
    {"color_delta/float16/noise", CodecKind::kColorDelta, 6, Content::kNoise},
    {"color_delta/float16/random", CodecKind::kColorDelta, 6, Content::kRandom},
    {"color_delta/float32/noise", CodecKind::kColorDelta, 7, Content::kNoise},
    {"color_delta/float32/random", CodecKind::kColorDelta, 7, Content::kRandom},
    {"node_delta/8_bytes/sorted", CodecKind::kNodeDelta, 13, Content::kSortedNodes},
    {"nodes_used/8_bytes/sorted", CodecKind::kNodesUsed, 13, Content::kSortedNodes},
    {"nodes_used_delta/8_bytes/sorted", CodecKind::kNodesUsedDelta, 13, Content::kSortedNodes},
    {"nodes_used_delta/8_bytes/random", CodecKind::kNodesUsedDelta, 13, Content::kRandom},
    {"nodes_used_delta/12_bytes/sorted", CodecKind::kNodesUsedDelta, 15, Content::kSortedNodes},
};

}  // namespace
}  // namespace ropsim

int main(int argc, char** argv) {
    using namespace ropsim;
    const std::vector<BlockFormat> surfaces = block_samples::surfaces();
    benchmark::RegisterBenchmark("memcpy", copy);
    for (const Case& c : kCases) {
        const BlockFormat& format = surfaces[c.surface];
        benchmark::RegisterBenchmark(("compress/" + std::string(c.name)).c_str(), compress, c.kind, format,
                                     c.content);
        benchmark::RegisterBenchmark(("decompress/" + std::string(c.name)).c_str(), decompress, c.kind,
                                     format, c.content);
    }
    benchmark::Initialize(&argc, argv);
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
