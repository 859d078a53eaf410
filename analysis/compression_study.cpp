#include "analysis/compression_study.h"

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

constexpr std::array kSweptKeys = {"compression.depth", "compression.color", "compression.nodes",
                                   "metadata.kibibytes"};

MachineConfig config_of(const CompressionStudyOptions& options, const CompressionSetup& setup) {
    Parameters parameters = hardware_parameters(options.hardware);
    for (const std::string& setting : options.settings) set_from_text(parameters, setting, "--set");
    for (const std::string& setting : setup.settings()) set_from_text(parameters, setting, "--metadata");
    try {
        MachineConfig config = machine_config(parameters, options.hardware);
        parameters.close();
        return config;
    } catch (const UserError& error) {
        // The ROP cache itself was taken by the setups before.
        if (error.where() != "rop_cache" || setup.metadata_kibibytes == 0) throw;
        throw UserError("--metadata", fmt::format("{} does not fit metadata.ways: {}",
                                                  setup.metadata_kibibytes, error.what()));
    }
}

void check_settings(const CompressionStudyOptions& options) {
    for (const std::string& setting : options.settings)
        for (const char* key : kSweptKeys)
            if (setting.starts_with(std::string(key) + "="))
                throw UserError("--set", fmt::format("{} is what the study runs through; leave it out", key));
}

CompressionScene scene_of(const std::string& trace, TraceHeader& header) {
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
CompressionStudy prepared(const CompressionStudyOptions& options) {
    check_settings(options);
    CompressionStudy study;
    study.options = options;
    study.setups = compression_setups(options.metadata_kibibytes);
    for (const CompressionSetup& setup : study.setups) study.machine = config_of(options, setup);
    std::vector<TraceHeader> headers(options.traces.size());
    for (std::size_t s = 0; s < options.traces.size(); ++s)
        study.scenes.push_back(scene_of(options.traces[s], headers[s]));
    std::set<std::string> seen;
    for (const std::string& technique : options.techniques) {
        if (!seen.insert(technique).second)
            throw UserError("--technique", fmt::format("'{}' is given twice; leave one out", technique));
        std::size_t refused = 0;
        for (std::size_t s = 0; s < headers.size(); ++s) {
            CompressionRun run;
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

PinGroups groups_of(const std::array<CauseBytes, kMemoryCauses>& causes) {
    PinGroups groups;
    for (std::size_t c = 0; c < kMemoryCauses; ++c) {
        const auto cause = static_cast<MemoryCause>(c);
        if (cause == MemoryCause::kMetadata) {
            groups.metadata += causes[c].read + causes[c].write;
        } else if (cause == MemoryCause::kRepack) {
            groups.repack += causes[c].read + causes[c].write;
        } else {
            groups.fill += causes[c].read;
            groups.write += causes[c].write;
        }
    }
    return groups;
}

void run_one(const CompressionStudy& study, const std::string& path, CompressionRun& run, int threads) {
    std::vector<MachineConfig> configs;
    for (const CompressionSetup& setup : study.setups) configs.push_back(config_of(study.options, setup));
    TraceReader trace(path);
    TechniqueSpec spec = parse_technique(run.technique, "--technique");
    const auto operation = make_operation(spec, screen_of(trace.header(), study.options.seed));
    Frame frame(trace, *operation, configs.back(), threads, true);
    const std::vector<CompressionOutcome> outcomes = sweep_compression(frame, configs, threads);
    const SurfaceMap& map = frame.surfaces();
    for (int s = 0; s < map.surfaces(); ++s) {
        const auto number = static_cast<std::size_t>(s);
        StudiedSurface surface{map.name(s),
                               map.surface_class(s),
                               map.element_bytes(s),
                               static_cast<int>(map.format(s).elements),
                               {}};
        std::uint64_t moved = 0;
        for (const CompressionOutcome& outcome : outcomes) {
            const auto& blocks = outcome.report.surfaces;
            surface.outcomes.push_back({number < blocks.size() ? blocks[number] : CompressionCounts{},
                                        groups_of(outcome.pins[number])});
            moved += surface.outcomes.back().pins.sum();
        }
        if (moved > 0) run.surfaces.push_back(std::move(surface));
    }
}

}  // namespace

std::vector<std::string> CompressionSetup::settings() const {
    std::vector<std::string> all;
    for (std::size_t c = 0; c < codecs.size(); ++c)
        all.push_back(fmt::format("{}={}", kSweptKeys[c], codecs[c]));
    all.push_back(fmt::format("{}={}", kSweptKeys.back(), metadata_kibibytes));
    return all;
}

std::string CompressionSetup::name() const {
    if (off()) return "off";
    return fmt::format("{}/{}/{}{}", codecs[0], codecs[1], codecs[2],
                       metadata_kibibytes > 0 ? fmt::format(" + {} KiB", metadata_kibibytes) : "");
}

std::vector<CompressionSetup> compression_setups(int metadata_kibibytes) {
    return {{{"none", "none", "none"}, 0},
            {{"planes", "delta", "delta"}, 0},
            {{"delta", "delta", "used"}, 0},
            {{"best", "delta", "used_delta"}, 0},
            {{"best", "delta", "used_delta"}, metadata_kibibytes}};
}

void PinGroups::add(const PinGroups& other) {
    fill += other.fill;
    write += other.write;
    repack += other.repack;
    metadata += other.metadata;
}

double saved_share(const PinGroups& off, const PinGroups& on) {
    if (off.sum() == 0) return 0;
    return 1 - static_cast<double>(on.sum()) / static_cast<double>(off.sum());
}

double storage_ratio(const CompressionCounts& blocks) {
    if (blocks.stored_bytes == 0) return 0;
    return static_cast<double>(blocks.block_bytes) / static_cast<double>(blocks.stored_bytes);
}

PinGroups CompressionRun::pins(std::size_t setup) const {
    PinGroups sum;
    for (const StudiedSurface& surface : surfaces) sum.add(surface.outcomes[setup].pins);
    return sum;
}

const char* class_name(SurfaceClass surface_class) {
    constexpr std::array kNames = {"depth", "color", "nodes"};
    return kNames[static_cast<std::size_t>(surface_class)];
}

void check_compression_study(const CompressionStudyOptions& options) {
    prepared(options);
}

CompressionStudy run_compression_study(const CompressionStudyOptions& options) {
    CompressionStudy study = prepared(options);
    struct Job {
        const CompressionScene* scene;
        CompressionRun* run;
    };
    std::vector<Job> queue;
    for (CompressionScene& scene : study.scenes)
        for (CompressionRun& run : scene.runs)
            if (run.failure.empty()) queue.push_back({&scene, &run});
    const int cores = default_threads();
    const int jobs =
        std::clamp(cores / std::max(1, options.threads), 1, std::max(1, static_cast<int>(queue.size())));
    const int threads = options.threads > 0 ? options.threads : std::max(1, cores / jobs);
    Progress progress(queue.size());
    parallel_for(jobs, static_cast<int>(queue.size()), [&](int i) {
        const Job& job = queue[static_cast<std::size_t>(i)];
        run_one(study, job.scene->trace, *job.run, threads);
        progress.finished(fmt::format("{} {}", job.scene->name, job.run->technique));
    });
    return study;
}

}  // namespace ropsim
