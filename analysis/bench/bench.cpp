// The traces, and the parts one after the other.
#include "analysis/bench/bench.h"

#include "analysis/child_process.h"
#include "analysis/comparison.h"
#include "analysis/progress.h"
#include "base/error.h"
#include "base/outputs.h"
#include "base/parallel.h"
#include "rop/registry.h"
#include "traces/trace.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <span>

#include <fmt/format.h>
#include <sys/utsname.h>
#include <unistd.h>

namespace ropsim {
namespace {

namespace fs = std::filesystem;

// Thin smoke, many crossing parts, and fine strands.
constexpr const char* kScenes[] = {"smoke", "motor", "hair"};

double load_of_a_minute() {
    std::array<double, 3> load{};
    return getloadavg(load.data(), 3) > 0 ? load[0] : 0;
}

// The first processor of /proc/cpuinfo. A virtual machine often has but a family for a name.
std::string processor_name() {
    std::map<std::string, std::string> values;
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line) && !line.empty();) {
        const std::size_t colon = std::min(line.size(), line.find(':'));
        values[line.substr(0, line.find_last_not_of(" \t:", colon) + 1)] =
            line.substr(std::min(line.size(), colon + 2));
    }
    std::string name = values["model name"];
    for (const char* key : {"cpu family", "model", "stepping", "cache size"})
        if (!values[key].empty()) name += fmt::format(", {} {}", key, values[key]);
    return name;
}

BenchHost this_host() {
    BenchHost host;
    host.processor = processor_name();
    utsname name{};
    if (::uname(&name) == 0) host.system = fmt::format("{} {} {}", name.sysname, name.release, name.machine);
    host.cores = default_threads();
    host.memory_bytes =
        static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGE_SIZE));
    host.load_before = load_of_a_minute();
    return host;
}

std::string program_of(const BenchOptions& options) {
    return options.program.empty() ? own_program_path() : options.program;
}

bool wants(const BenchOptions& options, BenchPart part) {
    return options.parts.contains(part);
}

// A square of layers where it must be quick and the same everywhere; else scenes through OpenGL.
std::vector<std::string> own_traces(const BenchOptions& options, const std::string& directory) {
    if (options.quick) {
        constexpr int kLayers = 8;
        int edge = 8;
        while (static_cast<std::uint64_t>(edge) * static_cast<std::uint64_t>(edge) * kLayers <
               options.fragments)
            edge += 8;
        const std::string file = directory + "/layers.trace";
        make_layered_trace(file, {edge, kLayers, edge});
        return {file};
    }
    std::vector<std::string> files;
    for (const char* scene : kScenes) {
        files.push_back(fmt::format("{}/{}.trace", directory, scene));
        fmt::print(stderr, "capturing {}\n", scene);
        const ChildResult result =
            run_child({program_of(options), "capture", scene, "--size", "640x360", "--fragments",
                       std::to_string(options.fragments), "-o", files.back()});
        if (!result.failure().empty())
            throw UserError(scene, fmt::format("cannot be captured: {}; give traces", result.failure()));
    }
    return files;
}

std::optional<Tradeoff> technique_part(const BenchOptions& options, const std::vector<std::string>& traces) {
    if (!wants(options, BenchPart::kTechniques)) return {};
    TradeoffOptions study;
    study.traces = traces;
    study.techniques = options.techniques;
    if (study.techniques.empty() && options.quick) study.techniques = default_techniques();
    study.bytes = TradeoffBytes::kFrameTime;
    study.directory = options.directory;
    study.program = options.program;
    return run_tradeoff(study);
}

void measure(BenchGroup& group, const BenchOptions& options, Progress& progress) {
    for (BenchCase& c : group.cases) {
        if (!c.layers) continue;
        if (!fs::exists(c.trace)) make_layered_trace(c.trace, *c.layers);
        c.trace_hash = TraceReader(c.trace).hash();
    }
    run_cases(group.cases, options.repeats, program_of(options), options.directory,
              [&](const BenchCase& done) { progress.finished(done.id(), done.failure); });
}

// Those that no later group reads.
void remove_traces(const BenchGroup& group, std::span<const BenchGroup> later) {
    for (const BenchCase& c : group.cases) {
        const auto reads = [&](const BenchCase& other) { return other.trace == c.trace; };
        const bool wanted = std::ranges::any_of(
            later, [&](const BenchGroup& next) { return std::ranges::any_of(next.cases, reads); });
        std::error_code gone;
        if (c.layers && !wanted) fs::remove(c.trace, gone);
    }
}

}  // namespace

void check_bench(const BenchOptions& options) {
    TradeoffOptions study;
    study.traces = options.traces;
    study.techniques = options.techniques;
    if (options.traces.empty())
        for (const std::string& technique : options.techniques) parse_technique(technique, "--technique");
    else
        check_tradeoff(study);
}

Bench run_bench(const BenchOptions& options) {
    check_bench(options);
    Bench bench;
    bench.options = options;
    bench.host = this_host();
    const std::string directory = options.directory + "/traces";
    start_directory(directory);
    const bool scenes = wants(options, BenchPart::kTechniques) || wants(options, BenchPart::kSimulator);
    std::vector<std::string> traces = options.traces;
    if (traces.empty() && scenes) traces = own_traces(options, directory);
    bench.techniques = technique_part(options, traces);
    std::vector<BenchGroup> groups;
    if (wants(options, BenchPart::kSimulator)) groups = simulator_groups(options, traces);
    if (wants(options, BenchPart::kScaling))
        for (BenchGroup& group : scaling_groups(options)) groups.push_back(std::move(group));
    std::size_t runs = 0;
    for (const BenchGroup& group : groups)
        runs += group.cases.size() * static_cast<std::size_t>(options.repeats);
    Progress progress(runs);
    for (std::size_t g = 0; g < groups.size(); ++g) {
        measure(groups[g], options, progress);
        remove_traces(groups[g], std::span(groups).subspan(g + 1));
    }
    for (BenchGroup& group : groups) std::ranges::move(group.cases, std::back_inserter(bench.cases));
    bench.simulator = simulator_rows(bench.cases);
    bench.fits = scaling_fits(bench.cases);
    bench.threads = thread_rows(bench.cases);
    bench.host.load_after = load_of_a_minute();
    return bench;
}

}  // namespace ropsim
