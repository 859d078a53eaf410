// Prints a hash of what every technique makes of a made trace (image, files, numbers), a line each: builds
// and machines that agree print the same. determinism_probe FOLDER [THREADS [FIDELITY]]; FOLDER keeps the
// outputs of every run and the references, so a second call finds the directories used. Exit code 1 where a
// run failed that must not.
#include "base/error.h"
#include "model/run.h"
#include "model/run_json.h"
#include "traces/generators.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
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
    std::string path = fmt::format("{}/{}.trace", folder, rich ? "rich" : "plain");
    TraceWriter writer(path, header);
    writer.append(random_chunk(options));
    writer.finish();
    return path;
}

// Long enough to be sampled, and as coherent as a renderer's.
std::string write_layered_trace(const std::string& folder) {
    LayeredScene scene;
    scene.width = 384;
    scene.height = 256;
    scene.layers = 6;
    std::string path = folder + "/layered.trace";
    TraceWriter writer(path, layered_header(scene));
    append_layered(scene, writer);
    writer.finish();
    return path;
}

std::uint64_t hash_of(const std::string& bytes) {
    return XXH3_64bits(bytes.data(), bytes.size());
}

std::string content_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream bytes;
    bytes << file.rdbuf();
    return bytes.str();
}

// What may differ between machines is left out: the host's own times, threads, paths.
std::string numbers(const RunResult& result) {
    nlohmann::ordered_json json = nlohmann::ordered_json::parse(run_json(result));
    json.erase("host");
    json.erase("threads");
    json["trace"].erase("file");
    return json.dump();
}

struct ProbeRun {
    std::string name;
    RunOptions options;
    bool may_refuse = false;  // several samples a pixel, which not every technique takes
};

// The exit code: 1 for what must not be refused.
int print_run(const ProbeRun& run, const std::string& folder) {
    try {
        const RunResult result = run_simulation(run.options);
        const std::string directory = folder + "/" + run.name;
        write_run(result, directory);
        std::string files;
        for (const char* name : {"image.exr", "image.png", "tiles.exr", "tiles.png"})
            files += fmt::format("{:016x}", hash_of(content_of(directory + "/" + name)));
        const auto* values = reinterpret_cast<const char*>(result.image.values.data());
        fmt::print("{} image {:016x} numbers {:016x} files {:016x}\n", run.name,
                   XXH3_64bits(values, result.image.values.size() * sizeof(float)), hash_of(numbers(result)),
                   hash_of(files));
        return 0;
    } catch (const UserError& error) {
        fmt::print("{} refused: {}\n", run.name, error.what());
        return run.may_refuse && std::string(error.what()).starts_with("works on traces of one sample") ? 0
                                                                                                        : 1;
    }
}

// SystemC elaborates once a process, so every run has one of its own.
bool run_in_child(const ProbeRun& run, const std::string& folder) {
    std::fflush(stdout);
    const pid_t child = ::fork();
    CHECK(child >= 0);
    if (child == 0) {
        int status = 2;
        try {
            status = print_run(run, folder);
        } catch (const std::exception& error) {
            fmt::print("{} failed: {}\n", run.name, error.what());
        }
        std::fflush(stdout);
        ::_exit(status);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    if (status != 0) fmt::print(stderr, "determinism_probe: {} ended with status {:#x}\n", run.name, status);
    return status == 0;
}

constexpr const char* kFidelities[] = {"count", "cached", "timed"};

std::vector<ProbeRun> every_technique(const RunOptions& common, const std::string& trace, bool rich) {
    std::vector<ProbeRun> runs;
    for (const TechniqueInfo& technique : technique_list()) {
        for (int f = 0; f < 3; ++f) {
            ProbeRun run{fmt::format("{}-{}-{}", rich ? "rich" : "plain", technique.name, kFidelities[f]),
                         common, rich};
            run.options.trace = trace;
            run.options.technique = technique.name;
            run.options.fidelity = static_cast<Fidelity>(f);
            runs.push_back(run);
        }
    }
    return runs;
}

// Parts of the machine, and of the analysis of a run, that the defaults do not enter.
std::vector<ProbeRun> other_machines(const RunOptions& common, const std::string& plain,
                                     const std::string& layered) {
    std::vector<ProbeRun> runs;
    const auto add = [&](const std::string& name, const std::string& trace, const std::string& technique,
                         auto change) {
        ProbeRun run{name, common};
        run.options.trace = trace;
        run.options.technique = technique;
        change(run.options);
        runs.push_back(run);
    };
    for (const HardwarePreset& preset : hardware_presets())
        add(fmt::format("preset-{}", preset.name), plain, "stochastic:samples=4",
            [&](RunOptions& o) { o.hardware = preset.name; });
    for (const char* technique :
         {"a_buffer", "mlab:layers=4", "adaptive:nodes=4", "moment_based:moments=4"}) {
        const std::string name = std::string(technique).substr(0, std::string(technique).find(':'));
        add("shader-" + name, plain, technique, [](RunOptions& o) { o.engine = Engine::kShader; });
        add("tiled-" + name, plain, technique, [](RunOptions& o) { o.engine = Engine::kTiled; });
        add("float32-" + name, plain,
            fmt::format("{}{}format=float32", technique, technique == name ? ":" : ","), [](RunOptions&) {});
        add("compressed-" + name, layered, technique, [](RunOptions& o) {
            o.settings = {"compression.depth=best", "compression.color=delta",
                          "compression.nodes=used_delta"};
        });
    }
    add("spin-mlab", plain, "mlab:layers=4", [](RunOptions& o) {
        o.engine = Engine::kShader;
        o.order = Order::kMachine;
        o.settings = {"interlock.mode=spin"};
    });
    for (const auto fidelity : {Fidelity::kCount, Fidelity::kCached, Fidelity::kTimed})
        add(fmt::format("sampled-{}", kFidelities[static_cast<int>(fidelity)]), layered, "adaptive:nodes=4",
            [&](RunOptions& o) {
                o.fidelity = fidelity;
                o.sample_percent = 30;
            });
    return runs;
}

bool print_all(const std::string& folder, int threads, const std::string& fidelity) {
    RunOptions common;
    common.threads = threads;
    common.seed = 7;
    const std::string plain = write_made_trace(folder, false);
    const std::string rich = write_made_trace(folder, true);
    const std::string layered = write_layered_trace(folder);
    for (const std::string& trace : {plain, rich, layered})
        fmt::print("{} file {:016x}\n", std::filesystem::path(trace).stem().string(),
                   hash_of(content_of(trace)));
    std::vector<ProbeRun> runs = every_technique(common, plain, false);
    for (auto more : {every_technique(common, rich, true), other_machines(common, plain, layered)})
        runs.insert(runs.end(), more.begin(), more.end());
    bool good = true;
    for (const ProbeRun& run : runs)
        if (fidelity.empty() || kFidelities[static_cast<int>(run.options.fidelity)] == fidelity)
            good &= run_in_child(run, folder);
    return good;
}

}  // namespace
}  // namespace ropsim

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: determinism_probe FOLDER [THREADS [count|cached|timed]]\n");
        return 2;
    }
    std::filesystem::create_directories(argv[1]);
    // References must be computed by this build, not found in the user's cache.
    ::setenv("XDG_CACHE_HOME", fmt::format("{}/cache", argv[1]).c_str(), 1);
    return ropsim::print_all(argv[1], argc > 2 ? std::atoi(argv[2]) : 1, argc > 3 ? argv[3] : "") ? 0 : 1;
}
