// A benchmark against an earlier one: what of it is slower, and what is noise.
#pragma once

#include "analysis/bench/bench.h"

#include <map>
#include <string>
#include <vector>

namespace ropsim {

// Of one case, what a later benchmark compares.
struct BaselineEntry {
    std::string id, trace_hash;
    std::vector<double> speed;             // a repeat each: processor time over the calibration loop's
    std::map<std::string, double> values;  // that depend on the inputs alone
};

struct Baseline {
    std::string version, processor;
    std::vector<BaselineEntry> entries;
};

Baseline baseline_of(const Bench& bench);
std::string baseline_json(const Baseline& baseline);
// Throws UserError for a file that is none.
Baseline read_baseline(const std::string& file);

enum class SpeedVerdict : std::uint8_t {
    kSame,       // no difference of more than the least effect is beyond noise
    kRegressed,  // slower by more than the least effect, beyond noise
    kImproved,
    kUndecided,   // too few repeats for the confidence
    kChanged,     // a value that depends on the inputs alone is another
    kOtherTrace,  // the inputs are others: nothing to compare
};
const char* name_of(SpeedVerdict verdict);

struct AgainstOptions {
    double confidence = 0.99;    // of each interval of speed
    double least_effect = 0.05;  // a ratio nearer to 1 is no regression, however certain
};

struct AgainstRow {
    std::string id;
    SpeedVerdict verdict = SpeedVerdict::kSame;
    std::optional<RankInterval> ratio;  // of speeds, now over then; its confidence
    std::string changed;                // "cycles 100 -> 101, ...": values
};

struct Against {
    AgainstOptions options;
    std::string file;
    bool other_processor = false;  // speeds are shown, not judged
    std::vector<AgainstRow> rows;
    std::size_t only_then = 0, only_now = 0;  // cases that the other has not

    std::size_t count(SpeedVerdict verdict) const;
};

// How far apart two sets of speeds are: by the rank-sum test's interval of their logarithms' shift.
AgainstRow compare_speeds(const std::vector<double>& then, const std::vector<double>& now,
                          const AgainstOptions& options);

Against compare_baselines(const Baseline& then, const Baseline& now, const AgainstOptions& options);

// Aligned text: what differs, then the counts.
std::string against_table(const Against& against);
// Why the benchmark fails against it, one line; empty: it does not. Values that changed fail it anywhere,
// speeds on the processor of the baseline.
std::string against_failure(const Against& against);

}  // namespace ropsim
