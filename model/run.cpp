#include "model/run.h"

#include "base/atomic_file.h"
#include "base/error.h"
#include "base/outputs.h"
#include "model/bottleneck_summary.h"
#include "model/cached_machine.h"
#include "model/interlock_cost.h"
#include "model/interlock_machine.h"
#include "model/interlock_order.h"
#include "model/run_json.h"
#include "model/skip_json.h"
#include "model/tile_pictures.h"
#include "model/tiled_quads.h"
#include "model/timed_machine.h"
#include "rop/reference.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>

#include <sys/resource.h>

namespace ropsim {

namespace {

std::optional<MachineResult> run_machine(Frame& frame, const MachineConfig& config, const RunOptions& options,
                                         TiledQuads* tiled, InterlockOrder* order) {
    switch (options.fidelity) {
        case Fidelity::kTimed:
            return run_timed_machine(frame, config, options.threads, options.observe, tiled, order);
        case Fidelity::kCached:
            return config.interlock.executes ? run_cached_interlock(frame, config, options.threads)
                                             : run_cached_machine(frame, config, options.threads, tiled);
        case Fidelity::kCount:
            break;
    }
    QuadBatch batch;
    while (tiled != nullptr ? tiled->advance(batch) : frame.advance(batch)) {
    }
    return std::nullopt;
}

// Estimates instead of a machine's result.
TileSample run_sample(Frame& frame, const TraceReader& trace, const MachineConfig& config,
                      const RunOptions& options) {
    if (options.engine != Engine::kRop)
        throw UserError("--sample-tiles", "estimates the engine rop alone; leave it out or use --engine rop");
    if (options.order != Order::kTrace)
        throw UserError("--sample-tiles",
                        "replays the trace's order alone; leave it out or use --order trace");
    const SampledFidelity fidelity = options.fidelity == Fidelity::kTimed    ? SampledFidelity::kTimed
                                     : options.fidelity == Fidelity::kCached ? SampledFidelity::kCached
                                                                             : SampledFidelity::kCount;
    return sample_frame(frame, trace, config, options.sample_percent,
                        options.sample_seed.value_or(options.seed), fidelity);
}

// The image's own channels plus, for each pixel, its signed error against the reference and its layers.
Image with_error_channels(const Image& image, const Image& reference) {
    Image out(image.width, image.height, {"R", "G", "B", "error.R", "error.G", "error.B", "layers"});
    const int layers = reference.channel("layers");
    const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    const std::size_t in = image.channels.size();
    const std::size_t ref = reference.channels.size();
    for (std::size_t i = 0; i < pixels; ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            out.values[7 * i + c] = image.values[in * i + c];
            out.values[7 * i + 3 + c] = image.values[in * i + c] - reference.values[ref * i + c];
        }
        out.values[7 * i + 6] =
            layers >= 0 ? reference.values[ref * i + static_cast<std::size_t>(layers)] : 0.0f;
    }
    return out;
}

std::uint64_t peak_rss() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

// Of all threads; to the nanosecond, which getrusage() is not.
double processor_seconds() {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// What the host spends on a run, from here on.
class HostCost {
 public:
    void measure(RunResult& result) const {
        const auto now = std::chrono::steady_clock::now();
        result.host_seconds = std::chrono::duration<double>(now - start_).count();
        result.host_processor_seconds = processor_seconds() - processor_;
        result.peak_rss_bytes = peak_rss();
    }

 private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    double processor_ = processor_seconds();
};

Image reference_of(const RunResult& result, TraceReader& trace) {
    return cached_reference_image(
        trace, result.options.threads, result.declaration.display_filter,
        result.declaration.colored_transmission ? Transmission::kColored : Transmission::kAlpha);
}

void collect(const Frame& frame, RunResult& result) {
    const SurfaceMap& map = frame.surfaces();
    for (int s = 0; s < map.surfaces(); ++s) result.surfaces.push_back(map.name(s));
    result.declaration = frame.operation().declaration();
    result.counts = frame.fragments();
    result.skipped = frame.skipped();
    result.traffic = frame.traffic();
    for (std::size_t p = 0; p < frame.cost().size(); ++p) {
        if (frame.cost()[p].name.empty()) continue;
        result.operations.push_back({frame.cost()[p], frame.path_count(p), frame.path_steps(p)});
    }
    result.passes = frame.geometry_passes_run();
    result.touched_tiles = frame.touched_tiles();
    result.pool_nodes_used = frame.pool_used();
    result.pool_nodes_overflowed = frame.pool_overflowed();
    if (result.tiled) {
        SurfaceTraffic& bins = result.traffic[static_cast<std::size_t>(map.bins())];
        bins.read = bins.worst_read = result.tiled->bin_read;
        bins.write = bins.worst_write = result.tiled->bin_written;
    }
    result.image = frame.image();
}

// Whether operations can come to a pixel in another order than the trace's.
bool unordered(const MachineConfig& config) {
    return config.interlock.executes && config.interlock.mode == InterlockMode::kSpin;
}

// What engine, order and technique must have in common. Throws UserError.
void check_order(const RunOptions& options, const MachineConfig& config, const Declaration& declaration) {
    if (options.order != Order::kMachine) return;
    if (options.fidelity != Fidelity::kTimed)
        throw UserError("--order machine",
                        "only --fidelity timed knows the order in which a machine operates");
    const std::string reason = unordered(config) ? no_replay(declaration) : "";
    if (!reason.empty())
        throw UserError("--order machine",
                        fmt::format("technique '{}' {}, so its operations cannot be put in the machine's "
                                    "order; use --order trace",
                                    options.technique, reason));
}

// The image of the operations in the machine's order, and what it has to do with that of the trace's.
OrderReport run_in_order(TraceReader& trace, const FramebufferOperation& operation,
                         const MachineConfig& config, const RunOptions& options, const InterlockOrder& order,
                         Image& image) {
    InterlockReplay replay(trace, operation.declaration(), order);
    Frame frame(trace, operation, config, options.threads, false);
    frame.take_fragments_from(replay);
    QuadBatch batch;
    while (frame.advance(batch)) {
    }
    OrderReport report;
    report.inversions = order.inversions();
    const std::size_t channels = image.channels.size();
    for (std::size_t i = 0; i < image.values.size(); i += channels)
        report.pixels_different +=
            std::equal(&image.values[i], &image.values[i] + channels, &frame.image().values[i]) ? 0 : 1;
    report.rmse8 = image_error(frame.image(), image).rmse8;
    image = frame.image();
    return report;
}

}  // namespace

RunResult run_simulation(const RunOptions& options) {
    RunResult result;
    result.options = options;
    result.technique = parse_technique(options.technique, "--technique");
    result.hardware = hardware_parameters(options.hardware);
    for (const std::string& setting : options.settings) set_from_text(result.hardware, setting, "--set");
    MachineConfig config = machine_config(result.hardware, options.hardware);
    result.hardware.close();
    if (config.skip.saturated) end_saturated_pixels(result.technique);
    if (options.engine == Engine::kShader) config = interlock_machine(config);

    const HostCost cost;
    TraceReader trace(options.trace);
    result.trace = trace.header();
    result.trace_hash = trace.hash();
    result.fragments = trace.fragment_count();
    const auto operation = make_operation(result.technique, screen_of(trace.header(), options.seed));
    check_order(options, config, operation->declaration());
    std::optional<InterlockOrder> order;
    std::vector<std::uint8_t> covered;
    {
        const bool sampled = options.sample_percent < 100;
        std::optional<TileBins> bins;
        if (options.engine == Engine::kTiled)
            bins.emplace(prepare_tiled(trace, operation->declaration(), config));
        Frame frame(trace, *operation, config, options.threads,
                    sampled || options.fidelity != Fidelity::kCount || bins);
        // Beside a timed machine decoding costs nothing, and memory is not free either.
        if (options.fidelity == Fidelity::kTimed) frame.keep_no_fragments();
        if (options.order == Order::kMachine && unordered(config))
            order.emplace(trace.tile_fragments(), frame.pass_names().size());
        std::optional<TiledQuads> tiled;
        if (bins) tiled.emplace(frame, trace, config, *bins);
        if (sampled)
            result.sample = run_sample(frame, trace, config, options);
        else
            result.machine =
                run_machine(frame, config, options, tiled ? &*tiled : nullptr, order ? &*order : nullptr);
        if (tiled) result.tiled = tiled->report();
        if (result.machine && (config.compression.any() || config.compression.metadata.size_bytes != 0))
            result.compression = config.compression;
        collect(frame, result);
        if (result.machine && result.machine->timed) {
            auto& found = result.machine->observation.bottlenecks;
            found = bottleneck_summary(*result.machine, config, result.surfaces);
            if (!found.empty()) result.machine->bottleneck = found.front().text;
        }
        covered = frame.covered();
        if (result.sample) {
            result.counts.input = result.fragments;
            cost.measure(result);
            if (options.error && result.declaration.image_is_color && !result.sample->function_complete)
                estimate_error(frame, trace, config, reference_of(result, trace), covered, *result.sample);
            if (!result.sample->function_complete) return result;
        }
    }
    if (options.order == Order::kMachine) result.order.emplace();
    if (order) result.order = run_in_order(trace, *operation, config, options, *order, result.image);
    cost.measure(result);
    if (options.error && result.declaration.image_is_color) {
        const Image reference = reference_of(result, trace);
        result.error = image_error(result.image, reference, covered);
        result.image = with_error_channels(result.image, reference);
    }
    return result;
}

void write_run(const RunResult& result, const std::string& directory) {
    start_directory(directory, {"run.json", "tiles.exr", "tiles.png"});
    write_exr(directory + "/image.exr", result.image);
    write_png(directory + "/image.png", result.image);
    if (result.machine) write_tiles(result.machine->breakdown, directory);
    write_file(directory + "/run.json", run_json(result));
}

}  // namespace ropsim
