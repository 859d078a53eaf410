// --probe-cycles, --timeline and --vcd: see observation_options.h.
#include "cli/observation_options.h"

#include "base/atomic_file.h"
#include "base/error.h"
#include "base/outputs.h"

#include <charconv>

#include <fmt/format.h>

namespace ropsim {

namespace {

// What is kept of a window stands in memory until the end of the run.
constexpr std::uint64_t kLongestWindow = 1'000'000;

bool read_number(std::string_view text, std::uint64_t& value) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size();
}

void read_window(const std::string& text, ObservationOptions& options) {
    const std::size_t colon = text.find(':');
    const std::string_view whole = text;
    if (colon == std::string::npos || !read_number(whole.substr(0, colon), options.vcd_from) ||
        !read_number(whole.substr(colon + 1), options.vcd_to) || options.vcd_from >= options.vcd_to)
        throw UserError(
            "--vcd-window",
            fmt::format("'{}' is not FROM:TO in ROP cycles, FROM below TO, such as 0:20000", text));
    if (options.vcd_to - options.vcd_from > kLongestWindow)
        throw UserError("--vcd-window", fmt::format("{} cycles are more than {}; choose a shorter window",
                                                    text, kLongestWindow));
}

// Fails now rather than after the run.
void check_writable(const std::string& file) {
    const AtomicFile probe(file);
}

}  // namespace

void ObservationFiles::add_to(CLI::App& command) {
    command
        .add_option(
            "--probe-cycles", options_.probe_cycles,
            "ROP cycles between samples of queues and waits; results but for those do not depend on it")
        ->check(CLI::Range(1, 1'000'000));
    command.add_option(
        "--timeline", timeline_,
        "Also write this file: stages, queues, channels and passes over time, for ui.perfetto.dev or "
        "chrome://tracing");
    command.add_option("--timeline-events", options_.timeline_events, "About as many events, at most")
        ->check(CLI::Range(1'000, 100'000'000));
    command.add_option("--vcd", vcd_,
                       "Also write this file: queues and stages cycle by cycle, for a waveform viewer");
    command.add_option("--vcd-window", window_, "The cycles in it, FROM:TO without TO");
}

ObservationOptions ObservationFiles::prepare(const std::vector<std::string>& inputs, bool timed) {
    options_.timeline = !timeline_.empty();
    options_.vcd = !vcd_.empty();
    read_window(window_, options_);
    std::vector<std::string> outputs;
    for (const auto& [name, file] : {std::pair("--timeline", timeline_), std::pair("--vcd", vcd_)}) {
        if (file.empty()) continue;
        if (!timed) throw UserError(name, "shows a machine with a clock: it needs --fidelity timed");
        outputs.push_back(file);
    }
    if (outputs.size() == 2 && timeline_ == vcd_)
        throw UserError("--vcd", fmt::format("'{}' is also the file of --timeline", vcd_));
    keep_inputs(inputs, outputs);
    for (const std::string& file : outputs) check_writable(file);
    return options_;
}

void ObservationFiles::write(const MachineObservation& observation) const {
    if (options_.timeline) write_file(timeline_, observation.timeline);
    if (options_.vcd) write_file(vcd_, observation.vcd);
}

}  // namespace ropsim
