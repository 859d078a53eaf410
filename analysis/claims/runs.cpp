// Traces first, then every run of the program once.
#include "analysis/claims/runs.h"

#include "analysis/child_process.h"
#include "analysis/claims/layers.h"
#include "analysis/progress.h"
#include "analysis/run_pool.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "base/outputs.h"
#include "base/parallel.h"
#include "traces/trace_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

namespace ropsim {
namespace {

namespace fs = std::filesystem;

const std::map<std::string, ArrivalOrder> arrival_orders{{"near_to_far", ArrivalOrder::kNearToFar},
                                                         {"far_to_near", ArrivalOrder::kFarToNear},
                                                         {"shuffle", ArrivalOrder::kShuffle}};

// What "caches and compression on" means: every class of surface by the codec that saves the most of it.
constexpr std::array<const char*, 3> kCompression{"compression.depth=planes", "compression.color=delta",
                                                  "compression.nodes=used_delta"};

std::string as_file_name(std::string text) {
    for (char& c : text)
        if (c == ' ' || c == ':' || c == ',' || c == '=') c = '-';
    return text;
}

void run_or_throw(const std::vector<std::string>& arguments, const std::string& what) {
    const ChildResult child = run_child(arguments);
    if (!child.failure().empty()) throw UserError(what, child.failure());
}

}  // namespace

std::string ClaimTrace::name(bool quick) const {
    std::string text = fmt::format("{}-{}-{}x", scene, size_of(quick), samples);
    if (layers > 0) text += fmt::format("-{}-of-{}", layers, alpha > 0 ? fmt::format("{:g}", alpha) : "any");
    if (!order.empty()) text += "-" + order;
    return text;
}

std::string ClaimRun::name(bool quick) const {
    return as_file_name(
        fmt::format("{} {} {} {} {} {}", trace.name(quick), technique, fidelity, hardware, engine, seed));
}

double number_of(const Measured& measured) {
    return measured.value_or(NAN);
}

const RunRecord& ClaimRuns::run(const ClaimRun& run) {
    const std::string name = run.name(quick());
    if (!executed_) {
        Entry& entry = entries_.try_emplace(name, Entry{run, {}}).first->second;
        ClaimRun with_image = run;
        with_image.image = entry.run.image = entry.run.image || run.image;
        CHECK(entry.run == with_image, "two runs are called {}", name);
        return entry.record;
    }
    const auto found = entries_.find(name);
    CHECK(found != entries_.end(), "{} was not asked for", name);
    if (!found->second.record.failure.empty()) note_failure(name, found->second.record.failure);
    return found->second.record;
}

std::string ClaimRuns::trace(const ClaimTrace& trace) {
    const auto [entry, first] = traces_.emplace(trace.name(quick()), trace);
    CHECK(entry->second == trace, "two traces are called {}", entry->first);
    if (const std::string failure = executed_ ? trace_failure(trace) : ""; !failure.empty())
        note_failure(entry->first, failure);
    return trace_file(trace);
}

void ClaimRuns::note_failure(const std::string& name, const std::string& failure) {
    failures_ += fmt::format("{}{}: {}", failures_.empty() ? "" : "; ", name, failure);
}

std::string ClaimRuns::trace_failure(ClaimTrace trace) const {
    for (const bool as_captured : {false, true}) {
        if (as_captured) trace.order.clear();
        const auto found = trace_failures_.find(trace.name(quick()));
        if (found != trace_failures_.end()) return found->second;
    }
    return "";
}

std::string ClaimRuns::take_failures() {
    return std::exchange(failures_, {});
}

std::string ClaimRuns::trace_file(const ClaimTrace& trace) const {
    return fmt::format("{}/traces/{}.trace", options_.directory, trace.name(quick()));
}

std::string ClaimRuns::program() const {
    return options_.program.empty() ? own_program_path() : options_.program;
}

// A trace that another build of the program made may not be what this one makes. A build is known by its
// file's size and time.
void ClaimRuns::remove_stale_traces() const {
    const fs::path directory = options_.directory + "/traces";
    const std::string stamp = (directory / "made_by").string();
    const std::string build = fmt::format("{} bytes, written {}\n", fs::file_size(program()),
                                          fs::last_write_time(program()).time_since_epoch().count());
    if (fs::exists(stamp) && read_file(stamp) == build) return;
    std::vector<fs::path> stale;
    for (const fs::directory_entry& entry : fs::directory_iterator(directory))
        if (entry.path().extension() == ".trace") stale.push_back(entry.path());
    for (const fs::path& file : stale) fs::remove(file);
    write_file(stamp, build);
}

// The file under its final name is complete: every command writes atomically.
void ClaimRuns::make_trace(const ClaimTrace& trace) const {
    const std::string file = trace_file(trace);
    if (fs::exists(file)) return;
    if (!trace.order.empty()) {
        ClaimTrace captured = trace;
        captured.order.clear();
        order_trace(trace_file(captured), file, arrival_orders.at(trace.order), 1);
    } else if (trace.scene == "surfaces") {
        write_surfaces(file, trace, quick());
    } else if (trace.layers > 0) {
        write_layers(file, trace, quick());
    } else {
        run_or_throw({program(), "capture", trace.scene, "--size", trace.size_of(quick()), "--samples",
                      std::to_string(trace.samples), "-o", file},
                     trace.scene);
    }
}

void ClaimRuns::make_traces() {
    std::map<std::string, ClaimTrace> captured;
    std::map<std::string, ClaimTrace> reordered;
    std::map<std::string, ClaimTrace> wanted = traces_;
    for (const auto& [name, entry] : entries_) wanted.emplace(entry.run.trace.name(quick()), entry.run.trace);
    for (auto [name, trace] : wanted) {
        if (!trace.order.empty()) reordered.emplace(trace.name(quick()), trace);
        trace.order.clear();
        captured.emplace(trace.name(quick()), trace);
    }
    Progress progress(captured.size() + reordered.size());
    for (const auto& traces : {captured, reordered}) {
        std::vector<ClaimTrace> queue;
        for (const auto& [name, trace] : traces)
            if (trace_failure(trace).empty()) queue.push_back(trace);
        std::vector<std::string> failures(queue.size());
        parallel_for(default_threads(), static_cast<int>(queue.size()), [&](int i) {
            const auto at = static_cast<std::size_t>(i);
            const std::string name = queue[at].name(quick());
            try {
                make_trace(queue[at]);
            } catch (const UserError& error) {
                failures[at] = fmt::format("{}: {}", error.where(), error.what());
            }
            progress.finished("trace " + name, failures[at]);
        });
        for (std::size_t i = 0; i < queue.size(); ++i)
            if (!failures[i].empty()) trace_failures_.emplace(queue[i].name(quick()), failures[i]);
    }
}

void ClaimRuns::set_command(Entry& entry, const std::string& name) const {
    const ClaimRun& run = entry.run;
    RunRecord& record = entry.record;
    record.technique = run.technique;
    record.directory = fmt::format("{}/runs/{}", options_.directory, name);
    record.command = {"ropsim",
                      "run",
                      trace_file(run.trace),
                      "--technique",
                      run.technique,
                      "--hardware",
                      run.hardware,
                      "--fidelity",
                      run.fidelity,
                      "--engine",
                      run.engine,
                      "--seed",
                      std::to_string(run.seed),
                      "-o",
                      record.directory};
    if (run.fidelity == "cached")
        for (const char* setting : kCompression)
            record.command.insert(record.command.end(), {"--set", setting});
}

void ClaimRuns::execute() {
    executed_ = true;
    if (entries_.empty() && traces_.empty()) return;
    start_directory(options_.directory + "/traces");
    start_directory(options_.directory + "/runs");
    remove_stale_traces();
    make_traces();
    std::vector<PooledRun> with_image;
    std::vector<PooledRun> without;
    for (auto& [name, entry] : entries_) {
        set_command(entry, name);
        entry.record.failure = trace_failure(entry.run.trace);
        if (entry.record.failure.empty())
            (entry.run.image ? with_image : without).push_back({&entry.record, name});
    }
    RunPool pool{options_.threads, options_.program, {"image.png", "tiles.exr", "tiles.png"}};
    run_all(with_image, pool);
    pool.unwanted.emplace_back("image.exr");
    run_all(without, pool);
}

}  // namespace ropsim
