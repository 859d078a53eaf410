// How fast a trace is simulated: fragments of the trace a second, by technique and fidelity, each run in a
// process of its own. Prints what must not change with speed, too: cycles, bytes on the pins and the image's
// hash; and the ratio to a plain loop by hand over the same decoded fragments, for the two techniques that
// have one.
#include "base/isolated_call.h"
#include "model/run.h"
#include "tests/rop/hand_written.h"
#include "traces/depth_test.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <sstream>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <xxhash.h>

namespace ropsim {
namespace {

// Of all threads; to the nanosecond, which getrusage() is not.
double processor_seconds() {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// Fragments of the trace a second of processor time that a loop over those in front of the opaque layer
// takes, without reading them: `operations`, one a pass, each over all of them.
template <class Pixel, class... Operations>
double by_hand(const std::string& path, const Pixel& cleared, Operations... operations) {
    TraceReader trace(path);
    const TraceHeader& header = trace.header();
    const OpaqueDepthTest depth_test(header);
    const auto width = static_cast<std::size_t>(header.width);
    std::vector<Pixel> pixels(width * static_cast<std::size_t>(header.height), cleared);
    std::vector<Fragment> fragments;
    double seconds = 0;
    const auto pass = [&](auto operation) {
        trace.rewind();
        FragmentChunk chunk;
        while (trace.next(chunk, kSlopeChannels)) {
            fragments.clear();
            for (std::size_t i = 0; i < chunk.size(); ++i) {
                const DepthSlope slope = chunk.slopes.empty() ? DepthSlope{} : chunk.slopes[i];
                if (depth_test.visible_samples(chunk.fragments[i], slope) != 0)
                    fragments.push_back(chunk.fragments[i]);
            }
            const double before = processor_seconds();
            for (const Fragment& f : fragments) operation(pixels[f.y * width + f.x], f);
            seconds += processor_seconds() - before;
        }
    };
    (pass(operations), ...);
    // So that nothing was done for nobody.
    const volatile Pixel last = pixels[pixels.size() / 2];
    static_cast<void>(last);
    return static_cast<double>(trace.fragment_count()) / seconds;
}

// 0: nothing to compare with.
double rate_by_hand(const std::string& trace, const std::string& technique) {
    if (technique == "alpha_blend") return by_hand(trace, test::BlendedPixel{}, test::hand_written_blend);
    if (technique == "adaptive:nodes=8")
        return by_hand(trace, test::cleared_pixel(), test::hand_written_insert, test::hand_written_composite);
    return 0;
}

std::string measured(const RunOptions& options, double rate_by_hand) {
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
    const std::string ratio = rate_by_hand > 0
                                  ? fmt::format("; by hand {:.2f} M, {:.1f} times as fast",
                                                1e-6 * rate_by_hand, rate_by_hand * processor / fragments)
                                  : "";
    return fmt::format(
        "{:6.2f} M fragments/s wall, {:6.2f} of processor time, {:.2f} GiB; {} cycles, pins {} "
        "read {} written, image {:016x}{}",
        1e-6 * fragments / r.host_seconds, 1e-6 * fragments / processor,
        static_cast<double>(r.peak_rss_bytes) / (1 << 30), cycles, read, write,
        XXH3_64bits(r.image.values.data(), r.image.values.size() * sizeof(float)), ratio);
}

// A run's processor time, cycles and bytes on the pins, or what a sample says of them.
struct Figures {
    double seconds = 0;
    Estimate cycles, bytes;
    double timed_share = 0;
};

std::string as_text(const Figures& f) {
    std::string text;
    for (const double v : {f.seconds, f.cycles.value, f.cycles.low, f.cycles.high, f.bytes.value, f.bytes.low,
                           f.bytes.high, f.timed_share})
        text += fmt::format("{} ", v);
    return text;
}

Figures from_text(const std::string& text) {
    std::istringstream in(text);
    Figures f;
    in >> f.seconds >> f.cycles.value >> f.cycles.low >> f.cycles.high >> f.bytes.value >> f.bytes.low >>
        f.bytes.high >> f.timed_share;
    return f;
}

Figures figures(const RunOptions& options) {
    const double before = processor_seconds();
    const RunResult r = run_simulation(options);
    Figures f;
    f.seconds = processor_seconds() - before;
    if (r.sample) {
        f.cycles = r.sample->cycles();
        f.bytes = r.sample->pin_bytes();
        f.timed_share = r.sample->timed_share;
    } else if (r.machine) {
        f.cycles.value = static_cast<double>(r.machine->rop_cycles);
        for (const auto& causes : r.machine->pins)
            for (const CauseBytes& cause : causes)
                f.bytes.value += static_cast<double>(cause.read + cause.write);
    }
    return f;
}

Figures isolated_figures(const RunOptions& options) {
    const IsolationLimits limits{.cpu_seconds = 3600, .wait_seconds = 3600};
    return from_text(call_isolated(options.trace, limits, [&] { return as_text(figures(options)); }));
}

// Of one quantity over all seeds: errors, and how often the interval held the truth.
struct Coverage {
    double squares = 0, sum = 0, largest = 0, half_width = 0;
    int covered = 0;
    void add(const Estimate& e, double truth) {
        const double error = e.value / truth - 1;
        squares += error * error;
        sum += error;
        largest = std::max(largest, std::abs(error));
        half_width += (e.high - e.low) / 2 / truth;
        covered += e.covers(truth) ? 1 : 0;
    }
    std::string report(int seeds) const {
        return fmt::format(
            "mean error {:+.2f} %, RMS {:.2f} %, largest {:.2f} %, half interval {:.2f} %, "
            "covered {} of {}",
            100 * sum / seeds, 100 * std::sqrt(squares / seeds), 100 * largest, 100 * half_width / seeds,
            covered, seeds);
    }
};

// The whole frame, then samples of it with one seed after the other.
void sample_seeds(RunOptions options, double percent, int seeds, Figures truth) {
    if (truth.cycles.value == 0) truth = isolated_figures(options);
    options.sample_percent = percent;
    Coverage cycles;
    Coverage bytes;
    double seconds = 0;
    double timed_share = 0;
    for (int seed = 0; seed < seeds; ++seed) {
        options.sample_seed = static_cast<std::uint64_t>(seed);
        const Figures f = isolated_figures(options);
        cycles.add(f.cycles, truth.cycles.value);
        bytes.add(f.bytes, truth.bytes.value);
        seconds += f.seconds / seeds;
        timed_share += f.timed_share / seeds;
    }
    fmt::print(
        "{} {}: all {:.2f} s, {:.0f} cycles, {:.0f} bytes; {} % of it: {:.2f} s ({:.1f} times faster), "
        "{:.1f} % timed\n  cycles: {}\n  bytes: {}\n",
        options.trace, options.technique, truth.seconds, truth.cycles.value, truth.bytes.value, percent,
        seconds, truth.seconds / seconds, 100 * timed_share, cycles.report(seeds), bytes.report(seeds));
    std::fflush(stdout);
}

int run(int argc, char** argv) {
    CLI::App app("Fragments simulated a second of the host");
    RunOptions options;
    options.threads = 1;
    options.error = false;
    std::vector<std::string> fidelities{"count", "cached", "timed"};
    std::vector<std::string> techniques{"adaptive:nodes=8", "alpha_blend"};
    int repeat = 1;
    double sample_percent = 0;
    int seeds = 1;
    Figures truth;
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
    app.add_option("--sample-tiles", sample_percent,
                   "Compare samples of so many percent with the whole frame, timed")
        ->check(CLI::Range(0.01, 99.99));
    app.add_option("--seeds", seeds, "Samples to take")->check(CLI::Range(1, 10000));
    app.add_option("--true-cycles", truth.cycles.value, "Of the whole frame, where they are known");
    app.add_option("--true-bytes", truth.bytes.value, "On its pins");
    CLI11_PARSE(app, argc, argv);
    options.engine = engine == "shader" ? Engine::kShader : engine == "tiled" ? Engine::kTiled : Engine::kRop;
    options.order = order == "machine" ? Order::kMachine : Order::kTrace;
    if (sample_percent > 0) {
        for (const std::string& technique : techniques) {
            options.technique = technique;
            sample_seeds(options, sample_percent, seeds, truth);
        }
        return 0;
    }
    for (const std::string& technique : techniques) {
        const double hand = rate_by_hand(options.trace, technique);
        for (const std::string& fidelity : fidelities) {
            options.technique = technique;
            options.fidelity = fidelity == "count"    ? Fidelity::kCount
                               : fidelity == "cached" ? Fidelity::kCached
                                                      : Fidelity::kTimed;
            for (int i = 0; i < repeat; ++i) {
                const IsolationLimits limits{.cpu_seconds = 3600, .wait_seconds = 3600};
                const std::string line =
                    call_isolated(options.trace, limits, [&] { return measured(options, hand); });
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
