// A benchmark as JSON, tables and pictures.
#pragma once

#include "analysis/bench/against.h"
#include "analysis/bench/bench.h"

#include <string>
#include <vector>

namespace ropsim {

// One object with every measurement, "units" saying what each is in, and under "plots" tables of points as a
// plot takes them; what was not measured is null.
std::string bench_json(const Bench& bench, const std::optional<Against>& against);
// Aligned tables, one after the other, of what was measured.
std::string bench_tables(const Bench& bench);
// The names of the pictures that there is something for, without ending: "bench-techniques", ...
std::vector<std::string> bench_pictures(const Bench& bench);
// Writes each as .svg and .png, atomically. Throws UserError when gnuplot is missing or fails.
void write_bench_pictures(const Bench& bench, const std::string& directory);

}  // namespace ropsim
