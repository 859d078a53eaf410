// The points of a sweep: which there are, which are done, and running the others.
#include "analysis/sweep.h"

#include "analysis/comparison.h"
#include "analysis/run_pool.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "base/outputs.h"
#include "base/version.h"
#include "model/machine_config.h"
#include "model/run.h"
#include "rop/registry.h"
#include "traces/trace.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include <fmt/ranges.h>

namespace ropsim {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> split_values(const std::string& where, const std::string& text) {
    std::vector<std::string> values;
    std::size_t from = 0;
    for (std::size_t comma = 0; comma != std::string::npos; from = comma + 1) {
        comma = text.find(',', from);
        const std::string value = text.substr(from, comma == std::string::npos ? comma : comma - from);
        if (value.empty())
            throw UserError(
                where, fmt::format("'{}' has an empty value; give values separated by single commas", text));
        if (std::ranges::find(values, value) != values.end())
            throw UserError(where, fmt::format("'{}' has '{}' twice; leave one out", text, value));
        values.push_back(value);
    }
    return values;
}

void check_no_repetition(const SweepAxis& axis) {
    const std::set<std::string> different(axis.values.begin(), axis.values.end());
    if (different.size() != axis.values.size())
        throw UserError(axis.option.empty() ? "TRACE" : axis.option,
                        fmt::format("a {} is given twice; leave one out", axis.name));
}

// What `run` would refuse as a command line that is wrong, for every point with it.
void check_choices(const SweepAxis& axis) {
    static const std::map<std::string, std::vector<std::string>> known{
        {"--fidelity", {"count", "cached", "timed"}},
        {"--engine", {"rop", "shader", "tiled"}},
        {"--order", {"trace", "machine"}}};
    const auto found = known.find(axis.option);
    if (found == known.end()) return;
    for (const std::string& value : axis.values)
        if (std::ranges::find(found->second, value) == found->second.end())
            throw UserError(axis.option,
                            fmt::format("'{}' is none of {}", value, fmt::join(found->second, ", ")));
}

// All combinations of the axes' values, of the last axis the fastest.
std::vector<std::vector<std::string>> combinations(const std::vector<SweepAxis>& axes) {
    std::vector<std::vector<std::string>> all(1);
    for (const SweepAxis& axis : axes) {
        std::vector<std::vector<std::string>> longer;
        for (const auto& before : all) {
            for (const std::string& value : axis.values) {
                longer.push_back(before);
                longer.back().push_back(value);
            }
        }
        all = std::move(longer);
    }
    return all;
}

// Throws what a run would of its hardware and settings.
void check_point_hardware(const std::vector<SweepAxis>& axes, const std::vector<std::string>& values) {
    std::string hardware = RunOptions().hardware;
    for (std::size_t a = 0; a < axes.size(); ++a)
        if (axes[a].option == "--hardware") hardware = values[a];
    Parameters parameters = hardware_parameters(hardware);
    for (std::size_t a = 0; a < axes.size(); ++a)
        if (axes[a].option == "--set") parameters.set(axes[a].name, values[a], "--set");
    machine_config(parameters, hardware);
    parameters.close();
}

// Some of the combinations may be impossible; if all are, it is an error, and the sooner said the better.
void check_hardware_of(const std::vector<SweepAxis>& axes) {
    std::vector<SweepAxis> hardware;
    for (const SweepAxis& axis : axes)
        if (axis.option == "--hardware" || axis.option == "--set") hardware.push_back(axis);
    std::optional<UserError> failure;
    for (const auto& values : combinations(hardware)) {
        try {
            check_point_hardware(hardware, values);
            return;
        } catch (const UserError& error) {
            if (!failure) failure = error;
        }
    }
    if (failure) throw UserError(*failure);
}

// FNV-1a of 64 bits (Fowler, Noll and Vo).
std::uint64_t hash_of(const std::string& text) {
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
    return hash;
}

// All that decides a point's result, in one text.
std::string identity_of(const std::vector<SweepAxis>& axes, const std::vector<std::string>& values,
                        const std::map<std::string, std::string>& hash_of_trace) {
    std::set<std::string> lines;
    for (std::size_t a = 0; a < axes.size(); ++a) {
        if (axes[a].option.empty())
            lines.insert(fmt::format("trace {}", hash_of_trace.at(values[a])));
        else
            lines.insert(fmt::format("{} {}={}", axes[a].option, axes[a].name, values[a]));
        if (axes[a].option == "--hardware" && fs::is_regular_file(values[a]))
            lines.insert("hardware file " + read_file(values[a]));
    }
    return fmt::format("ropsim {}\n{}\n", kVersion, fmt::join(lines, "\n"));
}

SweepPoint point_of(const std::vector<SweepAxis>& axes, const std::vector<std::string>& values,
                    const std::string& directory) {
    SweepPoint point{values, {}, false};
    RunRecord& run = point.run;
    run.directory = directory;
    run.command = {"ropsim", "run"};
    for (std::size_t a = 0; a < axes.size(); ++a) {
        if (axes[a].option.empty())
            run.command.push_back(values[a]);
        else if (axes[a].option == "--set")
            run.command.insert(run.command.end(), {"--set", axes[a].name + "=" + values[a]});
        else
            run.command.insert(run.command.end(), {axes[a].option, values[a]});
        if (axes[a].option == "--technique") run.technique = values[a];
    }
    run.command.insert(run.command.end(), {"-o", run.directory});
    return point;
}

// A result that is whole, of an earlier sweep.
bool is_there(SweepPoint& point) {
    const std::string file = point.run.directory + "/run.json";
    if (!fs::exists(file)) return false;
    try {
        read_run_json(point.run, read_file(file), file);
    } catch (const UserError&) {
        return false;
    }
    return true;
}

}  // namespace

std::vector<SweepAxis> sweep_axes(const SweepOptions& options) {
    std::vector<SweepAxis> axes{{"trace", "", options.traces},
                                {"technique", "--technique", options.techniques}};
    for (const SweepAxis& axis : axes) check_no_repetition(axis);
    for (const auto& [option, text] : options.choices) {
        axes.push_back({option.substr(2), option, split_values(option, text)});
        check_choices(axes.back());
    }
    for (const std::string& setting : options.settings) {
        const std::size_t equals = setting.find('=');
        if (equals == std::string::npos || equals == 0)
            throw UserError("--set", fmt::format("'{}' is not key=value or key=value,value,...", setting));
        const std::string key = setting.substr(0, equals);
        if (std::ranges::any_of(axes,
                                [&](const SweepAxis& a) { return a.option == "--set" && a.name == key; }))
            throw UserError(
                "--set",
                fmt::format("'{}' is given twice; give its values in one, separated by commas", key));
        axes.push_back({key, "--set", split_values("--set", setting.substr(equals + 1))});
    }
    for (const std::string& technique : options.techniques) parse_technique(technique, "--technique");
    check_hardware_of(axes);
    return axes;
}

Sweep run_sweep(const SweepOptions& options) {
    Sweep sweep{sweep_axes(options), {}};
    std::map<std::string, std::string> hashes;
    for (const std::string& trace : options.traces) hashes[trace] = TraceReader(trace).hash();
    const std::string points = options.directory + "/points";
    start_directory(points);
    std::vector<PooledRun> missing;
    for (const auto& values : combinations(sweep.axes)) {
        const std::uint64_t name = hash_of(identity_of(sweep.axes, values, hashes));
        sweep.points.push_back(point_of(sweep.axes, values, fmt::format("{}/{:016x}", points, name)));
        sweep.points.back().kept = is_there(sweep.points.back());
    }
    for (SweepPoint& point : sweep.points) {
        std::vector<std::string> swept;
        for (std::size_t a = 0; a < sweep.axes.size(); ++a)
            if (sweep.axes[a].values.size() > 1) swept.push_back(point.values[a]);
        if (!point.kept) missing.push_back({&point.run, fmt::format("{}", fmt::join(swept, " "))});
    }
    if (missing.size() < sweep.points.size())
        fmt::print(stderr, "{} of {} points are there already\n", sweep.points.size() - missing.size(),
                   sweep.points.size());
    run_all(missing, {options.threads, options.program, {"image.exr", "tiles.exr", "tiles.png"}});
    return sweep;
}

}  // namespace ropsim
