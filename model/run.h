// One simulation from a trace to its results.
#pragma once

#include "base/parameters.h"
#include "model/frame.h"
#include "model/machine_config.h"
#include "model/machine_result.h"
#include "model/tile_sample.h"
#include "model/tiled_report.h"
#include "rop/image_metrics.h"
#include "rop/registry.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ropsim {

enum class Fidelity { kCount, kCached, kTimed };
// Who executes the operation: the ROP, the pixel shader under an interlock, or either with the pixel state of
// one tile kept on chip.
enum class Engine { kRop, kShader, kTiled };
// Of operations on a pixel: the trace's, or the one in which an unordered machine came to them.
enum class Order { kTrace, kMachine };

struct RunOptions {
    std::string trace;      // file
    std::string technique;  // NAME[:key=value,...]
    std::string hardware = "desktop";
    std::vector<std::string> settings;  // key=value
    Fidelity fidelity = Fidelity::kTimed;
    Engine engine = Engine::kRop;
    Order order = Order::kTrace;
    std::uint64_t seed = 0;
    double sample_percent = 100;               // of the frame; less: estimates from a sample
    std::optional<std::uint64_t> sample_seed;  // of what is in it; without, `seed`
    int threads = 1;
    bool error = true;           // compare with the reference image
    ObservationOptions observe;  // timed
};

// What came of running the frame again in the machine's order.
struct OrderReport {
    std::uint64_t inversions = 0;        // pairs of operations on a pixel in the other order than the trace's
    std::uint64_t pixels_different = 0;  // of the image, to the trace's order
    double rmse8 = 0;                    // to the image in the trace's order, as an error's
};

struct OperationCount {
    PathCost cost;
    std::uint64_t count = 0;
    std::array<std::uint64_t, 2> steps{};
};

// Everything a run measured. What the fidelity does not measure is absent.
struct RunResult {
    RunOptions options;
    TechniqueSpec technique;
    Parameters hardware;
    TraceHeader trace;
    std::string trace_hash;
    std::uint64_t fragments = 0;

    Declaration declaration;
    std::vector<std::string> surfaces;  // names, technique's first
    FragmentCounts counts;
    SkipCounts skipped;
    std::vector<SurfaceTraffic> traffic;
    std::vector<OperationCount> operations;
    int passes = 0;  // over the transparent fragments, every round of a repeated one
    std::uint64_t touched_tiles = 0;
    std::uint64_t pool_nodes_used = 0, pool_nodes_overflowed = 0;
    std::optional<OrderReport> order;              // Order::kMachine
    std::optional<TiledReport> tiled;              // of the tiled engine
    std::optional<TileSample> sample;              // then the numbers around are those of its tiles alone
    std::optional<MachineResult> machine;          // cached and timed, without a sample
    std::optional<CompressionConfig> compression;  // where the machine compresses, or keeps states in memory
    std::optional<ImageError> error;
    Image image;                        // R, G, B and, with an error, its channels
    double host_seconds = 0;            // reading the trace and simulating, without the reference
    double host_processor_seconds = 0;  // of all threads meanwhile
    std::uint64_t peak_rss_bytes = 0;
};

// Throws UserError for anything wrong with the trace, the technique or the hardware. At most one timed run a
// process.
RunResult run_simulation(const RunOptions& options);

// Writes run.json, image.exr, image.png and, where there is a machine, tiles.exr and tiles.png into
// `directory`, created if need be; each file is atomic, run.json last.
void write_run(const RunResult& result, const std::string& directory);

}  // namespace ropsim
