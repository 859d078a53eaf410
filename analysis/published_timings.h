// The run times that the papers print, next to simulated ones on a preset of the paper's part: ratios, since
// neither the scenes nor the parts are the papers' own.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace ropsim {

// One simulation: a scene, captured as the paper rendered it, and `ropsim run` on it.
struct TimedRun {
    std::string scene;  // of the scene list
    std::string size;   // "1280x720"
    int samples = 1;
    std::string technique;
    std::string hardware;
    std::string engine;  // rop, shader, tiled

    std::string trace_name() const;  // unique by scene, size and samples
    std::string name() const;        // unique, a file name
};

// A time of a run: of the whole frame, or of some of its passes, by the names that run.json has.
struct TimeOf {
    TimedRun run;
    std::vector<std::string> passes;  // empty: the whole
};

// What a paper prints as a ratio of times, or what follows from two times that it prints.
struct PublishedTiming {
    std::string id;     // "slab-8-to-st-8"
    std::string paper;  // "Wyman 2016"
    std::string place;  // "section 3"
    std::string claim;  // what is compared, one line
    double printed = 0;
    TimeOf time;
    TimeOf base;              // what `time` is divided by,
    bool difference = false;  // or what is taken from it: then `printed` is in milliseconds
};

const std::vector<PublishedTiming>& published_timings();

struct TimingResult {
    const PublishedTiming* timing = nullptr;
    double milliseconds = 0;       // simulated, of `time`
    double base_milliseconds = 0;  // of `base`
    std::string failure;           // why there is no result; empty: there is

    double simulated() const;  // what stands against `printed`
};

struct TimingOptions {
    std::vector<std::string> ids;  // empty: all
    std::string directory;         // traces/ and runs/ are made here; traces that are there are used again
    std::vector<std::string> settings;  // hardware key=value, on top of each preset
    std::string program;                // that understands `capture` and `run`; empty: this one
};

// Captures the scenes that are not there yet and simulates, a process a run, with progress on stderr. Throws
// UserError for an unknown id or a directory that cannot be written; a run that fails is a result with its
// failure.
std::vector<TimingResult> run_published_timings(const TimingOptions& options);

std::string timings_table(const std::vector<TimingResult>& results);
std::string timings_json(const std::vector<TimingResult>& results);

}  // namespace ropsim
