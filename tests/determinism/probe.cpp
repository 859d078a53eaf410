// Prints a hash of every technique's image and numbers on a made trace, a line each: builds that agree print
// the same. determinism_probe SCRATCH_FOLDER [THREADS]
#include "base/error.h"
#include "model/run.h"
#include "model/run_json.h"
#include "traces/generators.h"

#include <cstdio>
#include <cstdlib>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>
#include <xxhash.h>

namespace ropsim {
namespace {

std::string write_made_trace(const std::string& folder, bool rich) {
    RandomFragments options;
    options.width = 44;
    options.height = 28;
    options.count = 6000;
    options.samples = rich ? 4 : 1;
    options.opaque = options.materials = true;
    options.partial_coverage = options.slopes = rich;
    options.draws = 3;
    TraceHeader header = random_header(options);
    header.camera.emplace();
    header.camera->projection = glm::mat4(1, 0, 0, 0, 0, 1.5f, 0, 0, 0, 0, -1.02f, -1, 0, 0, -0.202f, 0);
    header.camera->near_plane = 0.1f;
    header.camera->far_plane = 10;
    header.camera->fovy_degrees = 67;
    const std::string path = fmt::format("{}/{}.trace", folder, rich ? "rich" : "plain");
    TraceWriter writer(path, header);
    writer.append(random_chunk(options));
    writer.finish();
    return path;
}

std::uint64_t hash_of(const void* data, std::size_t bytes) {
    return XXH3_64bits(data, bytes);
}

// What may differ between machines is left out: the host's own times, threads, paths.
std::string numbers(const RunResult& result) {
    nlohmann::ordered_json json = nlohmann::ordered_json::parse(run_json(result));
    json.erase("host");
    json.erase("threads");
    json["trace"].erase("file");
    return json.dump();
}

std::string line_of(const RunOptions& options) {
    try {
        const RunResult result = run_simulation(options);
        const std::string text = numbers(result);
        return fmt::format("{:016x} {:016x}",
                           hash_of(result.image.values.data(), result.image.values.size() * sizeof(float)),
                           hash_of(text.data(), text.size()));
    } catch (const UserError& error) {
        return fmt::format("refused: {}", error.what());
    }
}

// SystemC elaborates once a process, so every run has one of its own.
void print_in_child(const std::string& name, const RunOptions& options) {
    std::fflush(stdout);
    const pid_t child = ::fork();
    CHECK(child >= 0);
    if (child == 0) {
        fmt::print("{} {}\n", name, line_of(options));
        std::fflush(stdout);
        ::_exit(0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    if (status != 0) fmt::print("{} ended with status {:#x}\n", name, status);
}

void print_all(const std::string& folder, int threads) {
    constexpr const char* kFidelities[] = {"count", "cached", "timed"};
    for (const bool rich : {false, true}) {
        RunOptions options;
        options.trace = write_made_trace(folder, rich);
        options.threads = threads;
        options.seed = 7;
        for (const TechniqueInfo& technique : technique_list()) {
            options.technique = technique.name;
            for (int f = 0; f < 3; ++f) {
                options.fidelity = static_cast<Fidelity>(f);
                print_in_child(
                    fmt::format("{} {} {}", rich ? "rich" : "plain", technique.name, kFidelities[f]),
                    options);
            }
        }
    }
}

}  // namespace
}  // namespace ropsim

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: determinism_probe SCRATCH_FOLDER [THREADS]\n");
        return 2;
    }
    // References must be computed by this build, not found in the user's cache.
    ::setenv("XDG_CACHE_HOME", fmt::format("{}/cache-{}", argv[1], ::getpid()).c_str(), 1);
    ropsim::print_all(argv[1], argc > 2 ? std::atoi(argv[2]) : 1);
    return 0;
}
