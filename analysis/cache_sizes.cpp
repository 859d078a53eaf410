#include "analysis/cache_sizes.h"

#include "analysis/progress.h"
#include "analysis/standard_techniques.h"
#include "base/error.h"
#include "base/parallel.h"
#include "rop/registry.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr double kNear = 1.05;

template <class Surfaces>
ReadWriteBytes sum_of_surfaces(const Surfaces& surfaces) {
    ReadWriteBytes sum;
    for (const auto& one : surfaces) {
        sum.read += one.read;
        sum.write += one.write;
    }
    return sum;
}

// The machine with caches of this size.
MachineConfig config_of(const CacheSizesOptions& options, int kibibytes) {
    Parameters parameters = hardware_parameters(options.hardware);
    for (const std::string& setting : options.settings) set_from_text(parameters, setting, "--set");
    parameters.set("cache.kibibytes", std::to_string(kibibytes), "--kibibytes");
    try {
        MachineConfig config = machine_config(parameters, options.hardware);
        parameters.close();
        return config;
    } catch (const UserError& error) {
        if (error.where() != "rop_cache") throw;
        throw UserError("--kibibytes", fmt::format("{} does not fit the other keys of the cache: {}",
                                                   kibibytes, error.what()));
    }
}

// Ascending.
std::vector<int> sizes_of(const CacheSizesOptions& options) {
    for (const std::string& setting : options.settings)
        if (setting.starts_with("cache.kibibytes="))
            throw UserError("--set", "cache.kibibytes is what --kibibytes runs through; leave it out");
    std::vector<int> sizes = options.kibibytes;
    std::sort(sizes.begin(), sizes.end());
    if (sizes.empty()) throw UserError("--kibibytes", "give at least one size");
    const auto twice = std::adjacent_find(sizes.begin(), sizes.end());
    if (twice != sizes.end())
        throw UserError("--kibibytes", fmt::format("{} is given twice; leave one out", *twice));
    return sizes;
}

CacheSizesScene scene_of(const std::string& trace, TraceHeader& header) {
    const TraceReader reader(trace);
    header = reader.header();
    header.opaque.reset();
    if (reader.fragment_count() == 0) throw UserError(trace, "has no fragments; there is nothing to move");
    return {trace,
            std::filesystem::path(trace).stem().string(),
            header.scene,
            reader.hash(),
            header.width,
            header.height,
            header.samples,
            reader.fragment_count(),
            {}};
}

// The scenes with a run for each technique, those that a trace refuses with the reason.
CacheSizes prepared(const CacheSizesOptions& options) {
    CacheSizes study;
    study.options = options;
    study.options.kibibytes = sizes_of(options);
    MachineConfig config;
    for (const int kibibytes : study.options.kibibytes) config = config_of(options, kibibytes);
    study.partitions = config.partitions;
    study.partition_tiles = config.partition_tiles;
    study.ways = config.cache.ways;
    study.line_bytes = config.cache.line_bytes;
    study.sector_bytes = config.cache.sector_bytes;
    study.burst_bytes = config.dram.burst_bytes();
    std::vector<TraceHeader> headers(options.traces.size());
    for (std::size_t s = 0; s < options.traces.size(); ++s)
        study.scenes.push_back(scene_of(options.traces[s], headers[s]));
    std::set<std::string> seen;
    for (const std::string& technique : options.techniques) {
        if (!seen.insert(technique).second)
            throw UserError("--technique", fmt::format("'{}' is given twice; leave one out", technique));
        std::size_t refused = 0;
        for (std::size_t s = 0; s < headers.size(); ++s) {
            CacheSizesRun run;
            run.technique = technique;
            run.failure = refusal(technique, headers[s]);
            refused += run.failure.empty() ? 0 : 1;
            study.scenes[s].runs.push_back(std::move(run));
        }
        if (refused == headers.size())
            throw UserError("--technique", study.scenes.back().runs.back().failure);
    }
    return study;
}

void run_one(const CacheSizesOptions& options, const std::string& path, CacheSizesRun& run, int threads) {
    std::vector<MachineConfig> configs;
    for (const int kibibytes : options.kibibytes) configs.push_back(config_of(options, kibibytes));
    TraceReader trace(path);
    TechniqueSpec spec = parse_technique(run.technique, "--technique");
    const auto operation = make_operation(spec, screen_of(trace.header(), options.seed));
    Frame frame(trace, *operation, configs.front(), threads, true);
    run.sweep = sweep_cache_sizes(frame, configs, threads);
    run.uncached = sum_of_surfaces(run.sweep.uncached);
    for (const SurfaceTraffic& t : frame.traffic()) {
        run.worst_case.read += t.worst_read;
        run.worst_case.write += t.worst_write;
        run.touched.read += t.read;
        run.touched.write += t.write;
    }
    const SurfaceMap& map = frame.surfaces();
    for (int s = 0; s < map.surfaces(); ++s) {
        run.surfaces.push_back(map.name(s));
        if (map.layout(s) != Layout::kPool && run.sweep.uncached[static_cast<std::size_t>(s)].sum() > 0)
            run.tile_bytes += map.tile_bytes(s);
    }
}

}  // namespace

ReadWriteBytes CacheSizesRun::pins(std::size_t size) const {
    ReadWriteBytes sum;
    for (const auto& causes : sweep.caches[size].pins) {
        const ReadWriteBytes one = sum_of_surfaces(causes);
        sum.read += one.read;
        sum.write += one.write;
    }
    return sum;
}

ReadWriteBytes CacheSizesRun::ideal(std::size_t size) const {
    return sum_of_surfaces(sweep.ideal[size].surfaces);
}

ReadWriteBytes CacheSizesRun::ideal_of(std::uint64_t size_bytes) const {
    const auto found = std::find_if(sweep.ideal.begin(), sweep.ideal.end(),
                                    [&](const IdealCache& cache) { return cache.size_bytes == size_bytes; });
    CHECK(found != sweep.ideal.end(), "{} bytes", size_bytes);
    return sum_of_surfaces(found->surfaces);
}

std::optional<double> CacheSizesRun::saved_share(std::uint64_t size_bytes) const {
    const double most = static_cast<double>(uncached.sum()) - static_cast<double>(floor().sum());
    if (most <= 0) return {};
    double saved = 0;
    for (std::size_t i = 0; i < sweep.ideal.size(); ++i)
        if (sweep.ideal[i].size_bytes != 0 && sweep.ideal[i].size_bytes <= size_bytes)
            saved = static_cast<double>(uncached.sum()) - static_cast<double>(ideal(i).sum());
    return saved / most;
}

std::uint64_t CacheSizesRun::near_largest() const {
    const auto largest = static_cast<double>(pins(sweep.caches.size() - 1).sum());
    std::size_t size = 0;
    while (static_cast<double>(pins(size).sum()) > kNear * largest) ++size;
    return sweep.caches[size].size_bytes;
}

std::optional<std::uint64_t> CacheSizesRun::near_floor() const {
    const auto least = static_cast<double>(floor().sum());
    for (std::size_t i = 0; i + 1 < sweep.ideal.size(); ++i)
        if (static_cast<double>(ideal(i).sum()) <= kNear * least) return sweep.ideal[i].size_bytes;
    return {};
}

std::optional<std::uint64_t> CacheSizesRun::half_saved() const {
    for (const IdealCache& cache : sweep.ideal)
        if (cache.size_bytes != 0 && saved_share(cache.size_bytes).value_or(0) >= 0.5)
            return cache.size_bytes;
    return {};
}

void check_cache_sizes(const CacheSizesOptions& options) {
    prepared(options);
}

CacheSizes run_cache_sizes(const CacheSizesOptions& options) {
    CacheSizes study = prepared(options);
    struct Job {
        const CacheSizesScene* scene;
        CacheSizesRun* run;
    };
    std::vector<Job> queue;
    for (CacheSizesScene& scene : study.scenes)
        for (CacheSizesRun& run : scene.runs)
            if (run.failure.empty()) queue.push_back({&scene, &run});
    const int cores = default_threads();
    const int jobs =
        std::clamp(cores / std::max(1, options.threads), 1, std::max(1, static_cast<int>(queue.size())));
    const int threads = options.threads > 0 ? options.threads : std::max(1, cores / jobs);
    Progress progress(queue.size());
    parallel_for(jobs, static_cast<int>(queue.size()), [&](int i) {
        const Job& job = queue[static_cast<std::size_t>(i)];
        run_one(study.options, job.scene->trace, *job.run, threads);
        progress.finished(fmt::format("{} {}", job.scene->name, job.run->technique));
    });
    return study;
}

}  // namespace ropsim
