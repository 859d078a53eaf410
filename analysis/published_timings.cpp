#include "analysis/published_timings.h"

#include "analysis/child_process.h"
#include "analysis/progress.h"
#include "analysis/text_table.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "base/outputs.h"
#include "base/parallel.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Seconds of a run's passes by name, or why there are none.
struct Simulated {
    std::map<std::string, double> seconds;
    std::string failure;
};

std::vector<const PublishedTiming*> chosen(const std::vector<std::string>& ids) {
    std::vector<const PublishedTiming*> list;
    for (const PublishedTiming& timing : published_timings())
        if (ids.empty() || std::ranges::find(ids, timing.id) != ids.end()) list.push_back(&timing);
    for (const std::string& id : ids)
        if (std::ranges::find(list, id, [](const PublishedTiming* t) { return t->id; }) == list.end())
            throw UserError("ID",
                            fmt::format("there is no timing '{}'; `ropsim timings --list` names them", id));
    return list;
}

std::string trace_file(const TimingOptions& options, const TimedRun& run) {
    return options.directory + "/traces/" + run.trace_name() + ".trace";
}

void capture(const TimingOptions& options, const std::string& program, const TimedRun& run) {
    const ChildResult child = run_child({program, "capture", run.scene, "--size", run.size, "--samples",
                                         std::to_string(run.samples), "-o", trace_file(options, run)});
    if (!child.failure().empty()) throw UserError(run.scene, child.failure());
}

Simulated simulate(const TimingOptions& options, const std::string& program, const TimedRun& run,
                   int threads) {
    const std::string directory = options.directory + "/runs/" + run.name();
    std::vector<std::string> arguments{program,
                                       "run",
                                       trace_file(options, run),
                                       "--technique",
                                       run.technique,
                                       "--hardware",
                                       run.hardware,
                                       "--engine",
                                       run.engine,
                                       "--threads",
                                       std::to_string(threads),
                                       "-o",
                                       directory};
    for (const std::string& setting : options.settings) arguments.insert(arguments.end(), {"--set", setting});
    const ChildResult child = run_child(arguments);
    Simulated result{{}, child.failure()};
    if (!result.failure.empty()) return result;
    const Json json = Json::parse(read_file(directory + "/run.json"));
    for (const Json& pass : json.at("traffic_by_pass"))
        result.seconds[pass.at("pass").get<std::string>()] += pass.at("seconds").get<double>();
    return result;
}

double milliseconds(const Simulated& run, const TimeOf& time) {
    double seconds = 0;
    for (const auto& [pass, of_pass] : run.seconds)
        if (time.passes.empty() || std::ranges::find(time.passes, pass) != time.passes.end())
            seconds += of_pass;
    return 1e3 * seconds;
}

}  // namespace

std::string TimedRun::trace_name() const {
    return fmt::format("{}-{}-{}x", scene, size, samples);
}

std::string TimedRun::name() const {
    std::string name = fmt::format("{} {} {} {}", trace_name(), technique, hardware, engine);
    for (char& c : name)
        if (c == ' ' || c == ':' || c == ',' || c == '=') c = '-';
    return name;
}

double TimingResult::simulated() const {
    return timing->difference ? milliseconds - base_milliseconds : milliseconds / base_milliseconds;
}

std::vector<TimingResult> run_published_timings(const TimingOptions& options) {
    const std::vector<const PublishedTiming*> timings = chosen(options.ids);
    std::map<std::string, const TimedRun*> traces;
    std::map<std::string, const TimedRun*> runs;
    for (const PublishedTiming* timing : timings) {
        for (const TimeOf* time : {&timing->time, &timing->base}) {
            runs.emplace(time->run.name(), &time->run);
            traces.emplace(time->run.trace_name(), &time->run);
        }
    }
    std::erase_if(traces, [&](const auto& t) { return fs::exists(trace_file(options, *t.second)); });
    start_directory(options.directory + "/traces");
    start_directory(options.directory + "/runs");
    const std::string program = options.program.empty() ? own_program_path() : options.program;
    Progress progress(traces.size() + runs.size());
    for (const auto& [name, run] : traces) {
        capture(options, program, *run);
        progress.finished("capture " + name);
    }
    std::vector<std::pair<std::string, const TimedRun*>> queue(runs.begin(), runs.end());
    std::vector<Simulated> simulated(queue.size());
    const int jobs = std::clamp(default_threads(), 1, static_cast<int>(queue.size()));
    parallel_for(jobs, static_cast<int>(queue.size()), [&](int i) {
        const auto at = static_cast<std::size_t>(i);
        simulated[at] = simulate(options, program, *queue[at].second, 1);
        progress.finished(queue[at].first, simulated[at].failure);
    });
    std::map<std::string, const Simulated*> by_name;
    for (std::size_t i = 0; i < queue.size(); ++i) by_name[queue[i].first] = &simulated[i];
    std::vector<TimingResult> results;
    for (const PublishedTiming* timing : timings) {
        const Simulated& time = *by_name[timing->time.run.name()];
        const Simulated& base = *by_name[timing->base.run.name()];
        TimingResult result{timing, milliseconds(time, timing->time), milliseconds(base, timing->base),
                            time.failure.empty() ? base.failure : time.failure};
        results.push_back(std::move(result));
    }
    return results;
}

std::string timings_table(const std::vector<TimingResult>& results) {
    std::vector<std::vector<std::string>> rows{
        {"id", "preset", "engines", "printed", "simulated", "ms", "base ms"}};
    for (const TimingResult& result : results) {
        const PublishedTiming& timing = *result.timing;
        const std::string engines = timing.time.run.engine == timing.base.run.engine
                                        ? timing.time.run.engine
                                        : timing.time.run.engine + "/" + timing.base.run.engine;
        const auto shown = [&](double value) {
            return fmt::format("{:.2f}{}", value, timing.difference ? " ms" : "");
        };
        const bool failed = !result.failure.empty();
        rows.push_back({timing.id, timing.time.run.hardware, engines, shown(timing.printed),
                        failed ? "failed" : shown(result.simulated()),
                        failed ? "-" : fmt::format("{:.3f}", result.milliseconds),
                        failed ? "-" : fmt::format("{:.3f}", result.base_milliseconds)});
    }
    std::string text = aligned_table(rows);
    for (const TimingResult& result : results)
        if (!result.failure.empty()) text += fmt::format("{}: {}\n", result.timing->id, result.failure);
    return text;
}

std::string timings_json(const std::vector<TimingResult>& results) {
    const auto time_json = [](const TimeOf& time, double value, bool failed) {
        return Json{{"scene", time.run.scene},       {"size", time.run.size},
                    {"samples", time.run.samples},   {"technique", time.run.technique},
                    {"hardware", time.run.hardware}, {"engine", time.run.engine},
                    {"passes", time.passes},         {"milliseconds", failed ? Json(nullptr) : Json(value)}};
    };
    Json json = Json::array();
    for (const TimingResult& result : results) {
        const PublishedTiming& timing = *result.timing;
        const bool failed = !result.failure.empty();
        json.push_back({{"id", timing.id},
                        {"paper", timing.paper},
                        {"place", timing.place},
                        {"claim", timing.claim},
                        {"unit", timing.difference ? "ms" : "ratio"},
                        {"printed", timing.printed},
                        {"simulated", failed ? Json(nullptr) : Json(result.simulated())},
                        {"time", time_json(timing.time, result.milliseconds, failed)},
                        {"base", time_json(timing.base, result.base_milliseconds, failed)},
                        {"failure", failed ? Json(result.failure) : Json(nullptr)}});
    }
    return json.dump(2) + "\n";
}

}  // namespace ropsim
