// Run time against error: of every technique in the machine, and of the simulator itself on the host.
#pragma once

#include "analysis/bench/bench_case.h"
#include "analysis/bench/rank_statistics.h"
#include "analysis/convergence_fit.h"
#include "analysis/tradeoff.h"

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace ropsim {

enum class BenchPart : std::uint8_t { kTechniques, kSimulator, kScaling };
inline constexpr const char* kBenchParts[] = {"techniques", "simulator", "scaling"};

struct BenchOptions {
    std::vector<std::string> traces;      // files; empty: scenes of its own
    std::vector<std::string> techniques;  // of the part `techniques`; empty: standard_techniques()
    std::set<BenchPart> parts{BenchPart::kTechniques, BenchPart::kSimulator, BenchPart::kScaling};
    int repeats = 7;
    bool quick = false;                 // made-up traces, few techniques and sizes
    std::uint64_t fragments = 500000;   // about so many in each of its own traces
    std::uint64_t largest = 100000000;  // of the series of fragments
    std::string directory;
    std::string program;  // that understands `run` and `capture`; empty: this one
};

// Where it ran.
struct BenchHost {
    std::string processor, system;
    int cores = 0;
    double memory_bytes = 0;
    double load_before = 0, load_after = 0;  // processes that wanted a core, mean of a minute
};

// A mode of the simulator against `timed` on all tiles, of one trace and technique.
struct SimulatorRow {
    std::string trace, technique, mode;
    double seconds = 0;                                       // of processor time, median
    std::optional<RankInterval> processor_ratio, wall_ratio;  // to `timed`, paired
    // Relative errors over the repeats; absent where the mode gives no such number.
    Measured cycles_rms, cycles_largest, pins_rms, pins_largest;
    int intervals = 0, cycles_held = 0,
        pins_held = 0;   // how many 95% intervals there were, and held the truth
    bool front = false;  // no other mode has less of one of processor time and error of the cycles
};

struct ScalingFit {
    std::string series, technique, mode;
    PowerLawFit time, memory;  // processor seconds and bytes of memory over x
};

// With several threads against one, paired.
struct ThreadRow {
    std::string technique, mode;
    int threads = 1;
    RankInterval speed_up;         // one thread's wall time over this
    RankInterval processor_ratio;  // to one thread's
};

struct Bench {
    BenchOptions options;
    BenchHost host;
    std::optional<Tradeoff> techniques;  // time and error of each; bytes on the pins too
    std::vector<BenchCase> cases;        // of the simulator and of scaling
    std::vector<SimulatorRow> simulator;
    std::vector<ScalingFit> fits;
    std::vector<ThreadRow> threads;
};

// What the cases of the parts are; each group is measured together.
struct BenchGroup {
    std::string name;
    std::vector<BenchCase> cases;
};
std::vector<BenchGroup> simulator_groups(const BenchOptions& options, const std::vector<std::string>& traces);
std::vector<BenchGroup> scaling_groups(const BenchOptions& options);

std::vector<SimulatorRow> simulator_rows(const std::vector<BenchCase>& cases);
std::vector<ScalingFit> scaling_fits(const std::vector<BenchCase>& cases);
std::vector<ThreadRow> thread_rows(const std::vector<BenchCase>& cases);

// Throws UserError for a trace that cannot be read and a technique that cannot be run.
void check_bench(const BenchOptions& options);
// Runs everything, with progress on stderr. Throws UserError as check_bench, and where no scene can be
// captured.
Bench run_bench(const BenchOptions& options);

}  // namespace ropsim
