// `ropsim bench`: run time against error, of the techniques and of the simulator.
#include "analysis/bench/against.h"
#include "analysis/bench/bench_output.h"
#include "analysis/child_process.h"
#include "analysis/gnuplot.h"
#include "analysis/report/report_rows.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "base/outputs.h"
#include "cli/commands.h"
#include "cli/study_options.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace ropsim {
namespace {

// Small enough to be run after a change.
constexpr int kQuickRepeats = 5;
constexpr std::uint64_t kQuickFragments = 400000;
constexpr std::uint64_t kQuickLargest = 400000;

struct BenchCommandOptions {
    BenchOptions bench;
    AgainstOptions against;
    std::string baseline;
    double least_percent = 5;
    std::vector<std::string> parts;
    int repeats = 0;  // these three, 0: the defaults
    std::uint64_t fragments = 0, largest = 0;
    bool json = false;
};

BenchOptions resolved(const BenchCommandOptions& options) {
    BenchOptions bench = options.bench;
    if (bench.quick) {
        bench.repeats = kQuickRepeats;
        bench.fragments = kQuickFragments;
        bench.largest = kQuickLargest;
    }
    if (options.repeats > 0) bench.repeats = options.repeats;
    if (options.fragments > 0) bench.fragments = options.fragments;
    if (options.largest > 0) bench.largest = options.largest;
    if (options.parts.empty()) return bench;
    bench.parts.clear();
    for (std::size_t i = 0; i < std::size(kBenchParts); ++i)
        if (std::ranges::find(options.parts, kBenchParts[i]) != options.parts.end())
            bench.parts.insert(static_cast<BenchPart>(i));
    return bench;
}

// That repeats this benchmark.
std::vector<std::string> bench_command(const BenchCommandOptions& options) {
    std::vector<std::string> command{"ropsim", "bench"};
    const auto add = [&](const char* name, const std::string& value) {
        command.insert(command.end(), {name, value});
    };
    command.insert(command.end(), options.bench.traces.begin(), options.bench.traces.end());
    for (const std::string& technique : options.bench.techniques) add("--technique", technique);
    for (const std::string& part : options.parts) add("--part", part);
    if (options.bench.quick) command.emplace_back("--quick");
    if (options.repeats > 0) add("--repeats", std::to_string(options.repeats));
    if (options.fragments > 0) add("--fragments", std::to_string(options.fragments));
    if (options.largest > 0) add("--largest", std::to_string(options.largest));
    if (!options.baseline.empty()) {
        add("--against", options.baseline);
        add("--least", fmt::format("{}", options.least_percent));
    }
    add("-o", options.bench.directory);
    return command;
}

void fail_on_failures(const Bench& bench) {
    std::size_t failed = bench.techniques ? broken_runs(*bench.techniques).size() : 0;
    for (const BenchCase& c : bench.cases) failed += c.failure.empty() ? 0 : 1;
    if (failed > 0)
        throw UserError("bench", fmt::format("{} cases failed; their reasons stand in the tables", failed));
}

void run_bench_command(const BenchCommandOptions& given) {
    const BenchOptions options = resolved(given);
    check_bench(options);
    std::optional<Baseline> then;
    if (!given.baseline.empty()) then = read_baseline(given.baseline);
    gnuplot_program();  // missing, it is missed before the runs
    const std::string& directory = options.directory;
    const auto files = {"bench.json",           "bench.txt",
                        "report.html",          "baseline.json",
                        "bench-techniques.svg", "bench-techniques.png",
                        "bench-simulator.svg",  "bench-simulator.png",
                        "bench-scaling.svg",    "bench-scaling.png"};
    std::vector<std::string> inputs = options.traces;
    if (then) inputs.push_back(given.baseline);
    keep_inputs(inputs, files_in(directory, files));
    start_directory(directory, files);
    const Bench bench = run_bench(options);
    const Baseline now = baseline_of(bench);
    std::optional<Against> against;
    if (then) {
        AgainstOptions judged = given.against;
        judged.least_effect = given.least_percent / 100;
        against = compare_baselines(*then, now, judged);
        against->file = given.baseline;
    }
    write_bench_pictures(bench, directory);
    const std::string text = bench_tables(bench) + (against ? "\n" + against_table(*against) : "");
    const std::string json = bench_json(bench, against);
    write_file(directory + "/baseline.json", baseline_json(now));
    write_file(directory + "/bench.txt", text);
    write_file(directory + "/bench.json", json);
    write_file(directory + "/report.html", bench_report(json, shell_line(bench_command(given))));
    fmt::print("{}", given.json ? json : text);
    fmt::print(stderr, "{}/bench.json\n", directory);
    fail_on_failures(bench);
    const std::string failure = against ? against_failure(*against) : "";
    if (!failure.empty()) throw UserError("--against", failure);
}

}  // namespace

void add_bench_command(CLI::App& app) {
    auto options = std::make_shared<BenchCommandOptions>();
    BenchOptions& bench = options->bench;
    CLI::App* command = app.add_subcommand(
        "bench", "Run time against error: of every technique, and of the simulator's fidelities and samples");
    command->add_option(
        "TRACE", bench.traces,
        "fragment traces for the parts techniques and simulator; without, smoke, motor and hair "
        "are captured at 640x360");
    add_technique_option(
        *command, bench.techniques,
        "of the part techniques, NAME[:key=value,...], repeatable; default: those of `tradeoff`");
    command->add_option("--part", options->parts, "measure this part only, repeatable")
        ->check(CLI::IsMember(std::vector<std::string>(std::begin(kBenchParts), std::end(kBenchParts))))
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command->add_flag(
        "--quick", bench.quick,
        "some minutes: one made-up trace, few techniques and sizes; what baselines are made of");
    command->add_option("--repeats", options->repeats, "of each measurement; 7, with --quick 5")
        ->check(CLI::Range(1, 100))  // the exact test's counts of ranks fit into a double
        ->default_str("");
    command
        ->add_option("--fragments", options->fragments,
                     "about so many in each trace of its own; 500,000, with --quick 400,000")
        ->check(CLI::Range(1000, 100000000))
        ->default_str("");
    command
        ->add_option("--largest", options->largest,
                     "fragments of the largest trace of the part scaling; 100 million, with --quick 400,000")
        ->check(CLI::Range(1000, 1000000000))
        ->default_str("");
    command->add_option("--against", options->baseline, "baseline.json of an earlier run to compare with");
    command
        ->add_option("--least", options->least_percent,
                     "with --against: per cent of run time below which no difference counts")
        ->check(CLI::Range(0.0, 1000.0));
    command->add_flag("--json", options->json, "print bench.json instead of the tables");
    command
        ->add_option(
            "-o,--output", bench.directory,
            "directory of bench.json, bench.txt, report.html, baseline.json, of the pictures and the runs")
        ->required();
    command->footer(
        "techniques: simulated time and bytes on the pins against image error, each technique once (fidelity "
        "timed).\n"
        "simulator: what count, cached and timed on 2, 5, 10 and 20% of the tiles cost the host, against "
        "timed on "
        "all of\n"
        "them, and how wrong they are. scaling: seconds and memory with fragments, pixels, depth complexity "
        "and "
        "threads.\n"
        "Runs go one at a time; those compared with each other run back to back in every repeat, forwards "
        "and "
        "backwards in\n"
        "turn, and ratios are taken within a repeat. Exit code 1 where --against finds a case slower beyond "
        "noise, or a\n"
        "result that depends on the inputs alone changed.");
    command->callback([options] { run_bench_command(*options); });
}

}  // namespace ropsim
