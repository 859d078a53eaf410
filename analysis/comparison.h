// Runs several techniques on traces, one process a run, and collects their results.
#pragma once

#include "analysis/run_record.h"
#include "traces/image.h"

#include <string>
#include <vector>

namespace ropsim {

struct ComparisonOptions {
    std::vector<std::string> traces;       // files
    std::vector<std::string> techniques;   // NAME[:key=value,...]; empty: default_techniques()
    std::vector<std::string> run_options;  // passed through to `ropsim run`
    int threads = 0;        // of each run; 0: the cores are shared out among the runs at a time
    std::string directory;  // one run goes to DIR/<slug>, or DIR/<trace>/<slug> with several traces
    std::string program;    // that understands `run`; empty: this one
    std::vector<std::string> unwanted = {};  // files of each run that are removed when it has been read
};

struct ComparisonOfOneTrace {
    std::string trace;  // file
    std::string name;   // short, unique
    std::string scene;  // what was captured; may be empty
    std::string hash;
    int width = 0;
    int height = 0;
    int samples = 1;
    double fragments = 0;
    Image reference;              // of reference_image()
    std::vector<RunRecord> runs;  // in the order of the techniques
};

// The techniques that stand for their families.
std::vector<std::string> default_techniques();

// File-name-safe short names, one each, all different: "slab:layers=8,bits=16" gives "slab-layers-8-bits-16".
std::vector<std::string> slugs(const std::vector<std::string>& names);

// Runs everything, as many processes at a time as there are cores (fewer if `threads` asks for several each).
// A run that fails is a record with its failure; the others go on. Progress goes to stderr. Throws UserError
// when a trace cannot be read, the directory cannot be made, or a technique is given twice.
std::vector<ComparisonOfOneTrace> run_comparison(const ComparisonOptions& options);

}  // namespace ropsim
