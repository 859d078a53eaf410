// What the reports need of one run's run.json.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace ropsim {

using Measured = std::optional<double>;  // empty: not measured

struct RecordedInterval {
    double low = 0, high = 0;
};

// Bytes of one surface.
struct RecordedTraffic {
    std::string surface;
    Measured worst_case_read, worst_case_write, read, write, pin_read, pin_write;
};

// Cycles of one stage by label.
struct RecordedStage {
    std::string stage;
    Measured busy, idle;
    std::vector<std::pair<std::string, double>> stalls;  // reason, cycles > 0; by reason
};

// One control path of the technique's operation.
struct RecordedPath {
    std::string path;
    Measured count, latency_cycles, interval_cycles;
};

struct RunRecord {
    std::string technique;             // NAME[:key=value,...] as it was asked for
    std::vector<std::string> command;  // that repeats the run
    std::string directory;             // holds run.json and image.exr
    std::string failure;               // why there are no results; empty: there are

    Measured width, height, samples, fragments, cycles, seconds, storage_bits_per_pixel;
    Measured bits_per_pixel_write;
    std::string bottleneck;  // in one line; empty where there is none
    // How much of the frame was simulated and what that leaves open, in one line; empty where all of it was.
    std::string sample;
    Measured rmse8, rmse8_covered, psnr_db, max_abs, mean_signed8, ssim, flip;
    Measured host_seconds, host_processor_seconds, host_fragments_per_second, host_peak_rss_bytes;
    // The 95% intervals of what a sample estimates; empty: exact, or not measured.
    std::optional<RecordedInterval> cycles_interval, pin_read_interval, pin_write_interval;
    Measured cache_hits, cache_misses, dram_read_bytes, dram_write_bytes, dram_row_hits, dram_row_misses,
        dram_row_conflicts, dram_utilisation;
    Measured pool_nodes_used, pool_nodes_overflowed, pool_node_bytes;  // of techniques with lists
    RecordedTraffic total;
    std::vector<RecordedTraffic> surfaces;
    std::vector<RecordedStage> stages;
    std::vector<RecordedPath> paths;
    std::map<std::string, double> pass_seconds;  // by pass, where times were simulated
    std::map<std::string, std::string>
        configuration;  // flattened, dotted keys; the technique's begin with technique.
};

// Fills the measured part of `record` from the text of a run.json; `name` stands for the file in messages.
// Keys that are missing, null or of another type are left empty; an estimate {"value": ...} gives its value.
// Every top-level entry that is not a known group of results is configuration. Throws UserError when the text
// is not a JSON object.
void read_run_json(RunRecord& record, const std::string& text, const std::string& name);

}  // namespace ropsim
