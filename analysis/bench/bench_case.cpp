// Child processes, one at a time, between two calibrations.
#include "analysis/bench/bench_case.h"

#include "analysis/bench/calibration.h"
#include "analysis/child_process.h"
#include "analysis/comparison_table.h"
#include "base/atomic_file.h"
#include "base/error.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

namespace ropsim {
namespace {

// Under a limit of processor time the process's clock moves by ticks, and can stand still for a short run.
constexpr double kLeastSeconds = 1e-4;

std::optional<RecordedInterval> sum_of(const std::optional<RecordedInterval>& a,
                                       const std::optional<RecordedInterval>& b) {
    if (!a || !b) return {};
    return RecordedInterval{a->low + b->low, a->high + b->high};
}

BenchRepeat repeat_of(const RunRecord& run) {
    BenchRepeat repeat;
    CHECK(run.host_seconds && run.host_processor_seconds && run.host_peak_rss_bytes, "{}", run.directory);
    repeat.wall_seconds = *run.host_seconds;
    repeat.processor_seconds = std::max(kLeastSeconds, *run.host_processor_seconds);
    repeat.peak_rss_bytes = *run.host_peak_rss_bytes;
    repeat.cycles = run.cycles;
    repeat.frame_seconds = run.seconds;
    repeat.pin_bytes = ropsim::sum_of(run.total.pin_read, run.total.pin_write);
    repeat.touched_bytes = ropsim::sum_of(run.total.read, run.total.write);
    repeat.cycles_interval = run.cycles_interval;
    repeat.pin_interval = sum_of(run.pin_read_interval, run.pin_write_interval);
    return repeat;
}

// Throws UserError where the run does.
BenchRepeat run_once(const BenchCase& c, int number, const std::string& program,
                     const std::string& directory) {
    std::vector<std::string> arguments{
        program,      "run", c.trace,  "--technique", c.technique, "--threads", std::to_string(c.threads),
        "--no-error", "-o",  directory};
    arguments.insert(arguments.end(), c.options.begin(), c.options.end());
    if (c.sampled) arguments.insert(arguments.end(), {"--sample-seed", std::to_string(number)});
    const double before = calibration_seconds();
    const ChildResult result = run_child(arguments);
    const double after = calibration_seconds();
    if (const std::string failure = result.failure(); !failure.empty()) throw UserError(c.id(), failure);
    RunRecord run;
    const std::string file = directory + "/run.json";
    read_run_json(run, read_file(file), file);
    BenchRepeat repeat = repeat_of(run);
    repeat.calibration_seconds = (before + after) / 2;
    return repeat;
}

}  // namespace

std::string BenchCase::id() const {
    return fmt::format("{} {} {} {} {:g} threads {}", part, series, technique, mode, x, threads);
}

std::vector<double> over_repeats(const BenchCase& c, double BenchRepeat::*quantity) {
    std::vector<double> values;
    for (const BenchRepeat& repeat : c.repeats) values.push_back(repeat.*quantity);
    return values;
}

std::vector<double> paired_ratios(const BenchCase& above, const BenchCase& below,
                                  double BenchRepeat::*quantity) {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < std::min(above.repeats.size(), below.repeats.size()); ++i)
        ratios.push_back(above.repeats[i].*quantity / below.repeats[i].*quantity);
    return ratios;
}

void run_cases(std::span<BenchCase> cases, int repeats, const std::string& program,
               const std::string& directory, const std::function<void(const BenchCase& done)>& finished) {
    const std::string scratch = directory + "/run";
    for (int number = 0; number < repeats; ++number) {
        for (std::size_t i = 0; i < cases.size(); ++i) {
            BenchCase& c = cases[number % 2 == 0 ? i : cases.size() - 1 - i];
            if (c.failure.empty() && number < c.most_repeats) {
                try {
                    c.repeats.push_back(run_once(c, number, program, scratch));
                } catch (const UserError& error) {
                    c.failure = error.what();
                    c.repeats.clear();
                }
            }
            finished(c);
        }
    }
    std::error_code gone;
    std::filesystem::remove_all(scratch, gone);
}

}  // namespace ropsim
