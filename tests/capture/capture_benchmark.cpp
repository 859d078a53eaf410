// How fast scenes become trace files: `benchmark_capture [SCENE...]`, from the start of the scene's making,
// and from the first draw, to the finished file.
#include "capture/capture.h"
#include "capture/scene_list.h"

#include <filesystem>
#include <string>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

namespace ropsim {
namespace {

void capture_rate(benchmark::State& state, const std::string& scene) {
    const std::string path =
        (std::filesystem::temp_directory_path() / "ropsim_benchmark_capture.trace").string();
    CaptureOptions options;
    options.scene_or_file = scene;
    double drawing = 0;
    std::uint64_t fragments = 0;
    for (auto _ : state) {
        const CaptureSummary summary = capture_scene(options, path);
        fragments += summary.fragments;
        drawing += summary.drawing_seconds;
        state.SetIterationTime(summary.seconds);
    }
    state.SetItemsProcessed(static_cast<std::int64_t>(fragments));
    state.counters["from_first_draw"] =
        benchmark::Counter(static_cast<double>(fragments) / drawing, benchmark::Counter::kDefaults);
    std::filesystem::remove(path);
}

}  // namespace
}  // namespace ropsim

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    const auto add = [](const std::string& scene) {
        benchmark::RegisterBenchmark(scene.c_str(), ropsim::capture_rate, scene)
            ->Unit(benchmark::kMillisecond)
            ->UseManualTime();
    };
    for (int i = 1; i < argc; ++i) add(argv[i]);
    if (argc == 1)
        for (const ropsim::SceneInfo& scene : ropsim::scene_list()) add(scene.name);
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
