// A run at every combination of values: techniques, hardware keys, engines, ...
#pragma once

#include "analysis/run_record.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace ropsim {

// What takes several values. Its values are told apart as text, as they were given.
struct SweepAxis {
    std::string name;    // "trace", "technique", "hardware", "engine", ... or a hardware key
    std::string option;  // of `ropsim run`: "--engine", ...; "--set" for a hardware key; empty: the trace
    std::vector<std::string> values;
};

struct SweepOptions {
    std::vector<std::string> traces;      // files
    std::vector<std::string> techniques;  // NAME[:key=value,...]
    // Options of `ropsim run` with values separated by commas: {"--engine", "rop,tiled"}.
    std::vector<std::pair<std::string, std::string>> choices;
    std::vector<std::string> settings;  // key=value,value,...; no value has a comma
    int threads = 0;                    // of each run; 0: the cores are shared out among the runs at a time
    std::string directory;
    std::string program;  // that understands `run`; empty: this one
};

struct SweepPoint {
    std::vector<std::string> values;  // by axis
    RunRecord run;
    bool kept = false;  // from an earlier sweep into the same directory
};

struct Sweep {
    std::vector<SweepAxis> axes;     // trace and technique first
    std::vector<SweepPoint> points;  // of the last axis the fastest
};

// The axes: those of one value, too. Throws UserError for what is not key=value, an empty or repeated value,
// a key given twice, a trace that cannot be read, and a technique, hardware or key that no point could take.
std::vector<SweepAxis> sweep_axes(const SweepOptions& options);

// Runs what is not there yet, a process a point, as many at a time as there are cores. A point lives in
// DIR/points/NAME, NAME made from all that decides its result: program version, content of the trace and of a
// hardware file, technique, options and settings in any order. It is there when its run.json is, which a run
// writes last and whole. A combination that a run refuses is a point with its failure, and run again the next
// time.
Sweep run_sweep(const SweepOptions& options);

// One row a point: the axes, then results; what was not measured is empty.
std::string sweep_csv(const Sweep& sweep);
// As aligned text, without the axes of one value.
std::string sweep_table(const Sweep& sweep);

// Of which axis the plot has its x: the first hardware key, then option, then technique, then trace of
// several values. None: nothing is swept.
std::optional<std::size_t> plotted_axis(const Sweep& sweep);
// Whether there is something to plot: an axis, and measured points.
bool has_plot(const Sweep& sweep);
// Writes sweep.svg and sweep.png into the directory: a column a trace, a row each for cycles and bytes, a
// line for each combination of the other axes. Requires has_plot().
void write_sweep_plot(const Sweep& sweep, const std::string& directory);
// gnuplot's commands for it.
std::string sweep_plot_script(const Sweep& sweep, const std::string& svg, const std::string& png);

}  // namespace ropsim
