// The runs that claims stand on: asked for by scene, technique and fidelity, made once, several at a time.
#pragma once

#include "analysis/run_record.h"

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace ropsim {

// A trace: a captured scene, or layers as the alpha and number of them say.
struct ClaimTrace {
    std::string scene;              // of the scene list, or with `layers` one of analysis/claims/layers.h
    std::string size = "1280x720";  // of a full run
    std::string quick_size = "320x180";
    int samples = 1;
    std::string order = {};  // near_to_far, far_to_near, shuffle; empty: as captured
    double alpha = 0;        // of those layers; 0: random ones
    int layers = 0;          // more: no captured scene

    std::string size_of(bool quick) const { return quick ? quick_size : size; }
    std::string name(bool quick) const;  // unique, a file name
    bool operator==(const ClaimTrace&) const = default;
};

struct ClaimRun {
    ClaimTrace trace;
    std::string technique;
    std::string fidelity = "count";  // count, cached (with every codec of compression), timed
    std::string hardware = "desktop";
    std::string engine = "rop";
    int seed = 0;
    bool image = false;  // its image.exr is wanted too

    std::string name(bool quick) const;  // unique, a file name
    bool operator==(const ClaimRun&) const = default;
};

struct ClaimRunsOptions {
    bool quick = false;
    int threads = 0;        // of each run; 0: the cores are shared out
    std::string directory;  // of traces/ and runs/; traces that this build of the program made are used again
    std::string program;    // that understands `capture` and `run`; empty: this one
};

// A claim asks for its runs by using them. It is called twice: first to hear what it asks for, when every
// record is empty and what it returns is thrown away, then with the records.
class ClaimRuns {
 public:
    explicit ClaimRuns(ClaimRunsOptions options) : options_(std::move(options)) {}

    bool quick() const { return options_.quick; }
    bool executed() const { return executed_; }
    const RunRecord& run(const ClaimRun& run);
    // The path of a trace, for what reads its fragments itself: there after execute().
    std::string trace(const ClaimTrace& trace);
    // Captures and runs everything that was asked for; from then on the records are there. A trace that
    // cannot be made fails the claims that need it, and no other.
    void execute();
    // The failures of the runs used since the last call, in one line; empty: none.
    std::string take_failures();

 private:
    struct Entry {
        ClaimRun run;
        RunRecord record;
    };
    std::string trace_file(const ClaimTrace& trace) const;
    std::string program() const;
    void remove_stale_traces() const;
    void make_traces();
    void make_trace(const ClaimTrace& trace) const;
    void set_command(Entry& entry, const std::string& name) const;
    // Why the trace is not there; empty: it is.
    std::string trace_failure(ClaimTrace trace) const;
    void note_failure(const std::string& name, const std::string& failure);

    ClaimRunsOptions options_;
    std::map<std::string, Entry> entries_;
    std::map<std::string, ClaimTrace> traces_;  // asked for without a run
    std::map<std::string, std::string> trace_failures_;
    bool executed_ = false;
    std::string failures_;
};

// A measured number, NaN where there is none: a run that failed fails its claim, not the arithmetic.
double number_of(const Measured& measured);

}  // namespace ropsim
