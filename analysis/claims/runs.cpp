// Traces first, then every run of the program once.
#include "analysis/claims/runs.h"

#include "analysis/child_process.h"
#include "analysis/claims/layers.h"
#include "analysis/progress.h"
#include "analysis/run_pool.h"
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
    if (!executed_) return entries_.try_emplace(name, Entry{run, {}}).first->second.record;
    const auto found = entries_.find(name);
    CHECK(found != entries_.end(), "{} was not asked for", name);
    const RunRecord& record = found->second.record;
    if (!record.failure.empty())
        failures_ += fmt::format("{}{}: {}", failures_.empty() ? "" : "; ", name, record.failure);
    return record;
}

std::string ClaimRuns::trace(const ClaimTrace& trace) {
    traces_.emplace(trace.name(quick()), trace);
    return trace_file(trace);
}

std::string ClaimRuns::take_failures() {
    return std::exchange(failures_, {});
}

std::string ClaimRuns::trace_file(const ClaimTrace& trace) const {
    return fmt::format("{}/traces/{}.trace", options_.directory, trace.name(quick()));
}

// The file under its final name is complete: every command writes atomically.
void ClaimRuns::make_trace(const ClaimTrace& trace, const std::string& program) const {
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
        run_or_throw({program, "capture", trace.scene, "--size", trace.size_of(quick()), "--samples",
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
    const std::string program = options_.program.empty() ? own_program_path() : options_.program;
    Progress progress(captured.size() + reordered.size());
    for (const auto& traces : {captured, reordered}) {
        std::vector<ClaimTrace> queue;
        for (const auto& [name, trace] : traces) queue.push_back(trace);
        parallel_for(default_threads(), static_cast<int>(queue.size()), [&](int i) {
            const ClaimTrace& trace = queue[static_cast<std::size_t>(i)];
            make_trace(trace, program);
            progress.finished("trace " + trace.name(quick()));
        });
    }
}

void ClaimRuns::execute() {
    executed_ = true;
    if (entries_.empty() && traces_.empty()) return;
    start_directory(options_.directory + "/traces");
    start_directory(options_.directory + "/runs");
    make_traces();
    std::vector<PooledRun> runs;
    for (auto& [name, entry] : entries_) {
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
        runs.push_back({&record, name});
    }
    RunPool pool;
    pool.threads = options_.threads;
    pool.program = options_.program;
    pool.unwanted = {"image.exr", "image.png", "tiles.exr", "tiles.png"};
    run_all(runs, pool);
}

}  // namespace ropsim
