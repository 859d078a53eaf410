// How the error of techniques falls with one of their parameters, above all with stored samples: Enderton et
// al. 2011, section 3.1 (slope -1/2 for independent samples, steeper with stratification), Laine and Karras
// 2011, Table 1.
#pragma once

#include "analysis/convergence_fit.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace ropsim {

struct ConvergenceOptions {
    std::string trace;                    // file
    std::vector<std::string> techniques;  // NAME[:key=value,...] without `key`
    std::string key = "samples";
    std::vector<std::string> values = {"4", "8", "16", "32", "64"};  // of `key`: numbers > 0
    int seeds = 4;    // seeds 1..seeds; a technique without randomness runs seed 1
    int threads = 0;  // of each run; 0: the cores are shared out among the runs at a time
};

// What one functional run measured.
struct ConvergenceRun {
    std::uint64_t seed = 1;
    double rmse8 = 0;          // these three as in rop/image_metrics.h
    double rmse8_covered = 0;  // NaN where no pixel has a transparent fragment
    double mean_signed8 = 0;
    double worst_case_bytes_per_fragment =
        0;  // read and written, a fragment of the trace; NaN without fragments
    double touched_bytes_per_fragment = 0;  // the same of what the run asked for, before caches
};

struct ConvergenceAtValue {
    std::string text;  // as given
    double value = 0;
    int storage_bits_per_pixel = 0;
    std::vector<ConvergenceRun> runs;  // by seed
    std::optional<MeanSd> ratio;  // rmse8 to the first technique's, over paired seeds; absent for the first

    // One number of each run.
    std::vector<double> all(double ConvergenceRun::*member) const;
};

struct ConvergenceOfTechnique {
    std::string technique;                          // as given
    std::map<std::string, std::string> parameters;  // resolved, the swept one left out
    bool random = false;
    std::vector<ConvergenceAtValue> values;  // ascending
    PowerLawFit fit;                         // of rmse8
};

struct Convergence {
    ConvergenceOptions options;
    std::string trace_hash;
    std::string scene;  // what was captured; may be empty
    int width = 0;
    int height = 0;
    int samples = 1;  // spatial
    std::uint64_t fragments = 0;
    std::vector<ConvergenceOfTechnique> techniques;  // in the order given
};

// Refuses what cannot be swept: a value that is no positive number or stands twice, a technique given twice
// or with the key, a key that it does not know, a value that it does not take. Reads the trace's header only.
// Throws UserError naming technique and value.
void check_convergence(const ConvergenceOptions& options);

// Runs everything with fidelity `count`, as many runs at a time as there are cores (fewer if `threads` asks
// for several each), with progress on stderr. Throws UserError as check_convergence, and for a faulty trace.
Convergence run_convergence(const ConvergenceOptions& options);

}  // namespace ropsim
