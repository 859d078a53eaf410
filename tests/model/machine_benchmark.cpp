// How fast a trace is simulated: fragments of the trace a second, by technique and fidelity, each run in a
// process of its own. Prints what must not change with speed, too: cycles, and bytes on the pins.
#include "base/isolated_call.h"
#include "model/run.h"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <sys/resource.h>

namespace ropsim {
namespace {

double processor_seconds() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::string measured(const RunOptions& options) {
    const double before = processor_seconds();
    const RunResult r = run_simulation(options);
    const double processor = processor_seconds() - before;
    std::uint64_t read = 0;
    std::uint64_t write = 0;
    std::uint64_t cycles = 0;
    if (r.machine) {
        cycles = r.machine->rop_cycles;
        for (const auto& causes : r.machine->pins) {
            for (const CauseBytes& cause : causes) {
                read += cause.read;
                write += cause.write;
            }
        }
    }
    const auto fragments = static_cast<double>(r.fragments);
    return fmt::format(
        "{:6.2f} M fragments/s wall, {:6.2f} of processor time, {:.2f} GiB; {} cycles, pins {} "
        "read {} written",
        1e-6 * fragments / r.host_seconds, 1e-6 * fragments / processor,
        static_cast<double>(r.peak_rss_bytes) / (1 << 30), cycles, read, write);
}

int run(int argc, char** argv) {
    CLI::App app("Fragments simulated a second of the host");
    RunOptions options;
    options.threads = 1;
    options.error = false;
    std::vector<std::string> fidelities{"count", "cached", "timed"};
    std::vector<std::string> techniques{"adaptive:nodes=8", "alpha_blend"};
    int repeat = 1;
    app.add_option("trace", options.trace, "Trace file")->required();
    app.add_option("--technique", techniques, "Repeatable");
    app.add_option("--fidelity", fidelities, "Repeatable")
        ->check(CLI::IsMember({"count", "cached", "timed"}));
    std::string engine = "rop";
    std::string order = "trace";
    app.add_option("--engine", engine)->check(CLI::IsMember({"rop", "shader", "tiled"}));
    app.add_option("--order", order)->check(CLI::IsMember({"trace", "machine"}));
    app.add_option("--hardware", options.hardware, "Preset or file");
    app.add_option("--set", options.settings, "key=value, repeatable")->expected(1)->take_all();
    app.add_option("--threads", options.threads, "On the host");
    app.add_option("--repeat", repeat, "Runs of each");
    CLI11_PARSE(app, argc, argv);
    options.engine = engine == "shader" ? Engine::kShader : engine == "tiled" ? Engine::kTiled : Engine::kRop;
    options.order = order == "machine" ? Order::kMachine : Order::kTrace;
    for (const std::string& technique : techniques) {
        for (const std::string& fidelity : fidelities) {
            options.technique = technique;
            options.fidelity = fidelity == "count"    ? Fidelity::kCount
                               : fidelity == "cached" ? Fidelity::kCached
                                                      : Fidelity::kTimed;
            for (int i = 0; i < repeat; ++i) {
                const IsolationLimits limits{.cpu_seconds = 3600, .wait_seconds = 3600};
                const std::string line =
                    call_isolated(options.trace, limits, [&] { return measured(options); });
                fmt::print("{} {} {} threads: {}\n", technique, fidelity, options.threads, line);
                std::fflush(stdout);
            }
        }
    }
    return 0;
}

}  // namespace
}  // namespace ropsim

int main(int argc, char** argv) {
    return ropsim::run(argc, argv);
}
