// What a benchmark measures several times: a run of the program, with all that its repeats said.
#pragma once

#include "analysis/bench/layered_traces.h"
#include "analysis/run_record.h"

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace ropsim {

// One run, on the host and in the machine that it simulated.
struct BenchRepeat {
    double wall_seconds = 0, processor_seconds = 0;  // of the host, without the program's start
    double calibration_seconds = 0;                  // at that moment: mean of before and after
    double peak_rss_bytes = 0;
    Measured cycles, frame_seconds, pin_bytes, touched_bytes;
    std::optional<RecordedInterval> cycles_interval, pin_interval;  // of a sample's estimates
};

struct BenchCase {
    std::string part;       // "simulator", "scaling"
    std::string series;     // the trace's name, or what is varied
    std::string technique;  // NAME[:key=value,...]
    std::string mode;       // fidelity, with the share of a sample
    double x = 0;           // the value of what is varied
    std::string trace;      // file
    std::string trace_hash;
    double fragments = 0;
    std::optional<LayeredSize> layers;  // of a trace that is made for its group and then removed
    std::vector<std::string> options;   // of `ropsim run`
    bool sampled = false;               // each repeat takes another sample
    int threads = 1;
    int most_repeats = 1000;  // fewer where one takes minutes

    std::vector<BenchRepeat> repeats;
    std::string failure;  // why there are none; empty: there are

    // Unique, and the same in every run of the benchmark.
    std::string id() const;
};

// Values of one quantity, a repeat each.
std::vector<double> over_repeats(const BenchCase& c, double BenchRepeat::*quantity);
// Of two cases measured together, repeat by repeat: what both share, such as the machine's load, falls out.
std::vector<double> paired_ratios(const BenchCase& above, const BenchCase& below,
                                  double BenchRepeat::*quantity);

// Runs the cases `repeats` times, one process at a time: all of them back to back, in the next repeat in the
// opposite order, so that a drift of the machine's speed does not favour one of them. The calibration loop
// runs before and after each. A case that fails is not run again. `finished` is told of every run.
void run_cases(std::span<BenchCase> cases, int repeats, const std::string& program,
               const std::string& directory, const std::function<void(const BenchCase& done)>& finished);

}  // namespace ropsim
