// One child process a run: SystemC elaborates once a process, and a run that crashes takes nothing with it.
#include "analysis/run_pool.h"

#include "analysis/child_process.h"
#include "analysis/progress.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "base/parallel.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

namespace ropsim {
namespace {

namespace fs = std::filesystem;

void run_one(RunRecord& run, const std::string& program, int threads) {
    std::vector<std::string> arguments = run.command;
    arguments[0] = program;
    arguments.insert(arguments.end(), {"--threads", std::to_string(threads)});
    try {
        const ChildResult result = run_child(arguments);
        run.failure = result.failure();
        if (!run.failure.empty()) return;
        const std::string file = (fs::path(run.directory) / "run.json").string();
        read_run_json(run, read_file(file), file);
    } catch (const UserError& error) {
        run.failure = fmt::format("{}: {}", error.where(), error.what());
    }
}

}  // namespace

void run_all(const std::vector<PooledRun>& runs, const RunPool& pool) {
    const int cores = default_threads();
    const int jobs =
        std::clamp(cores / std::max(1, pool.threads), 1, std::max(1, static_cast<int>(runs.size())));
    const int threads = pool.threads > 0 ? pool.threads : std::max(1, cores / jobs);
    const std::string program = pool.program.empty() ? own_program_path() : pool.program;
    Progress progress(runs.size());
    parallel_for(jobs, static_cast<int>(runs.size()), [&](int i) {
        RunRecord& run = *runs[static_cast<std::size_t>(i)].run;
        run_one(run, program, threads);
        for (const std::string& file : pool.unwanted) {
            std::error_code failure;
            fs::remove(fs::path(run.directory) / file, failure);
        }
        progress.finished(runs[static_cast<std::size_t>(i)].name, run.failure);
    });
}

}  // namespace ropsim
