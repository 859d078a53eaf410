// Read and write rates of the trace format, and bytes a fragment: `benchmark_traces [TRACE...]`; traces named
// on the command line are read, too, beside zstd unpacking the same fragments.
#include "traces/generators.h"
#include "traces/trace.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <zstd.h>

namespace ropsim {
namespace {

std::string scratch(const std::string& name) {
    return (std::filesystem::temp_directory_path() / name).string();
}

LayeredScene scene(int layers, ColorStorage storage) {
    LayeredScene options;
    options.width = 1280;
    options.height = 720;
    options.layers = layers;
    options.color_storage = storage;
    return options;
}

// The fragments in memory, so that generating them is not measured.
std::vector<Fragment> fragments_of(const LayeredScene& options) {
    const std::string path = scratch("ropsim_benchmark_source.trace");
    TraceWriter writer(path, layered_header(options));
    append_layered(options, writer);
    writer.finish();
    std::vector<Fragment> fragments = read_fragments(path);
    std::filesystem::remove(path);
    return fragments;
}

// Fragments in an order without any coherence: the worst case.
std::vector<Fragment> incoherent(const LayeredScene& scene_options, std::uint64_t count) {
    RandomFragments options;
    options.width = scene_options.width;
    options.height = scene_options.height;
    options.count = count;
    options.color_storage = scene_options.color_storage;
    return random_fragments(options);
}

void report(benchmark::State& state, std::size_t fragments, const std::string& path) {
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(fragments));
    state.counters["bytes_per_fragment"] =
        static_cast<double>(std::filesystem::file_size(path)) / static_cast<double>(fragments);
    std::filesystem::remove(path);
}

ColorStorage storage_of(const benchmark::State& state) {
    return state.range(0) == 16 ? ColorStorage::kFloat16 : ColorStorage::kFloat32;
}

TraceLayoutOptions layout_of(const benchmark::State& state) {
    TraceLayoutOptions layout;
    layout.region_side = static_cast<int>(state.range(1));
    return layout;
}

std::vector<Fragment> source_of(const benchmark::State& state, const LayeredScene& options) {
    return state.range(2) ? fragments_of(options) : incoherent(options, 3000000);
}

void write_rate(benchmark::State& state) {
    const LayeredScene options = scene(4, storage_of(state));
    const std::vector<Fragment> fragments = source_of(state, options);
    const std::string path = scratch("ropsim_benchmark_write.trace");
    for (auto _ : state) {
        TraceWriter writer(path, layered_header(options), layout_of(state));
        writer.append(fragments);
        writer.finish();
    }
    report(state, fragments.size(), path);
}

void read_rate(benchmark::State& state) {
    const LayeredScene options = scene(4, storage_of(state));
    const std::vector<Fragment> fragments = source_of(state, options);
    const std::string path = scratch("ropsim_benchmark_read.trace");
    TraceWriter writer(path, layered_header(options), layout_of(state));
    writer.append(fragments);
    writer.finish();
    std::vector<Fragment> chunk;
    TraceReader reader(path);
    for (auto _ : state) {
        reader.rewind();
        while (reader.next(chunk)) benchmark::DoNotOptimize(chunk.data());
    }
    report(state, fragments.size(), path);
}

// Reads a trace of the user's; a tenth of its tiles, scattered, when `percent` is 10.
void read_file_rate(benchmark::State& state, const std::string& path, int percent) {
    TraceReader reader(path);
    std::vector<std::uint8_t> selected(reader.tile_fragments().size());
    for (std::size_t tile = 0; tile < selected.size(); tile += static_cast<std::size_t>(100 / percent))
        selected[tile] = 1;
    if (percent < 100) reader.select_tiles(selected);
    std::vector<Fragment> chunk;
    for (auto _ : state) {
        reader.rewind();
        while (reader.next(chunk)) benchmark::DoNotOptimize(chunk.data());
    }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(reader.fragment_count()));
    state.counters["bytes_per_fragment"] =
        static_cast<double>(reader.file_bytes()) / static_cast<double>(reader.fragment_count());
}

// The machine's own rate on the same fragments: zstd (level 3) unpacking them as they lie in memory, chunk by
// chunk.
void zstd_rate(benchmark::State& state, const std::string& path) {
    TraceReader reader(path);
    std::vector<std::vector<char>> packed;
    std::vector<Fragment> chunk;
    std::size_t largest = 0;
    std::size_t stored = 0;
    while (reader.next(chunk)) {
        const std::size_t bytes = chunk.size() * sizeof(Fragment);
        std::vector<char> frame(ZSTD_compressBound(bytes));
        frame.resize(ZSTD_compress(frame.data(), frame.size(), chunk.data(), bytes, 3));
        stored += frame.size();
        packed.push_back(std::move(frame));
        largest = std::max(largest, bytes);
    }
    std::vector<char> unpacked(largest);
    for (auto _ : state)
        for (const std::vector<char>& frame : packed)
            benchmark::DoNotOptimize(
                ZSTD_decompress(unpacked.data(), unpacked.size(), frame.data(), frame.size()));
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(reader.fragment_count()));
    state.counters["bytes_per_fragment"] =
        static_cast<double>(stored) / static_cast<double>(reader.fragment_count());
}

void arguments(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"color_bits", "region", "coherent"})->Unit(benchmark::kMillisecond)->UseRealTime();
    for (const int color : {16, 32})
        for (const int region : {64, 128, 256})
            for (const int coherent : {1, 0}) benchmark->Args({color, region, coherent});
}
BENCHMARK(write_rate)->Apply(arguments);
BENCHMARK(read_rate)->Apply(arguments);

}  // namespace
}  // namespace ropsim

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    for (int i = 1; i < argc; ++i) {
        benchmark::RegisterBenchmark(fmt::format("zstd/{}", argv[i]).c_str(), ropsim::zstd_rate,
                                     std::string(argv[i]))
            ->Unit(benchmark::kMillisecond);
        for (const int percent : {100, 10})
            benchmark::RegisterBenchmark(fmt::format("read/{}/tiles:{}%", argv[i], percent).c_str(),
                                         ropsim::read_file_rate, std::string(argv[i]), percent)
                ->Unit(benchmark::kMillisecond);
    }
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
