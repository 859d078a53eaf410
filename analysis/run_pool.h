// Runs of the program as child processes, several at a time.
#pragma once

#include "analysis/run_record.h"

#include <string>
#include <vector>

namespace ropsim {

struct RunPool {
    int threads = 0;                    // of each run; 0: the cores are shared out among the runs at a time
    std::string program;                // that understands `run`; empty: this one
    std::vector<std::string> unwanted;  // files of each run that are removed when it has been read
};

struct PooledRun {
    RunRecord* run;    // its command and directory say what to run; gets what run.json says, or its failure
    std::string name;  // for progress
};

// Runs all of them, as many at a time as there are cores (fewer if `threads` asks for several each). A run
// that fails is a record with its failure; the others go on. Progress goes to stderr.
void run_all(const std::vector<PooledRun>& runs, const RunPool& pool);

}  // namespace ropsim
