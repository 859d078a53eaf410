// What the tests of model/ share: configurations, small traces, frames run to their end, runs of the program.
#pragma once

#include "base/atomic_file.h"
#include "model/frame.h"
#include "model/machine_config.h"
#include "rop/registry.h"
#include "tests/cli/program.h"
#include "tests/traces/scratch.h"
#include "traces/generators.h"

#include <memory>
#include <string>
#include <vector>

#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace ropsim {

using Settings = std::vector<std::string>;  // key=value

inline MachineConfig configured(const Settings& settings = {}) {
    Parameters parameters = hardware_parameters("desktop");
    for (const std::string& s : settings) set_from_text(parameters, s, "--set");
    MachineConfig config = machine_config(parameters, "desktop");
    parameters.close();
    return config;
}

// Picoseconds from the start to the export of a lone quad of `instructions`: the rasteriser goes to its tile
// and finds it, its warp is closed at once because nothing follows, takes the ALU as long as a full one would
// on its core's share of the lanes, and then its latency.
inline std::uint64_t lone_quad_shaded(const MachineConfig& c, double instructions) {
    const auto period = static_cast<double>(c.shader_period_ps);
    const double lanes = static_cast<double>(c.shader_alu_lanes) / c.front.shader.cores;
    const double rastered =
        std::max(period / c.raster_quads_per_cycle, period / c.front.raster_tiles_per_cycle);
    const double worked = period * instructions * 4 * c.front.shader.warp_quads / lanes;
    return static_cast<std::uint64_t>(rastered + worked) + c.shader_latency * c.shader_period_ps;
}

inline std::unique_ptr<FramebufferOperation> operation_for(const std::string& technique,
                                                           const TraceHeader& header,
                                                           std::uint64_t seed = 0) {
    TechniqueSpec spec = parse_technique(technique, "technique");
    return make_operation(spec, {header.width, header.height, header.samples, seed});
}

inline std::vector<std::string> technique_names() {
    std::vector<std::string> names;
    for (const TechniqueInfo& t : technique_list()) names.emplace_back(t.name);
    return names;
}

// A header without opaque layer, `draws` draws.
inline TraceHeader plain_header(int width, int height, int draws = 1) {
    TraceHeader header;
    header.width = width;
    header.height = height;
    header.background = {0.25f, 0.5f, 0.75f};
    header.draws.resize(static_cast<std::size_t>(draws));
    return header;
}

// A fragment of one sample; each its own primitive, so that no two share a quad operation.
inline Fragment fragment_at(int x, int y, float z, std::uint32_t primitive, float alpha = 0.5f) {
    return {z,
            0.5f * alpha,
            0.25f * alpha,
            alpha,
            alpha,
            static_cast<std::uint16_t>(x),
            static_cast<std::uint16_t>(y),
            primitive,
            1,
            0};
}

class ModelTest : public ScratchTest {
 protected:
    std::string write(const TraceHeader& header, const std::vector<Fragment>& fragments,
                      const std::string& name = "trace") const {
        write_trace(path(name), header, fragments);
        return path(name);
    }
    // Coherent layers of the usual kind.
    std::string write_layers(const LayeredScene& scene, const std::string& name = "trace") const {
        TraceWriter writer(path(name), layered_header(scene));
        append_layered(scene, writer);
        writer.finish();
        return path(name);
    }
    // `ropsim run`; its run.json. The run must succeed.
    nlohmann::json run(const std::string& trace, const std::string& technique, const Settings& settings,
                       const std::vector<std::string>& more = {}, const std::string& out = "run") const {
        std::vector<std::string> arguments = {"run", trace, "--technique", technique, "-o", path(out)};
        for (const std::string& s : settings) arguments.insert(arguments.end(), {"--set", s});
        arguments.insert(arguments.end(), more.begin(), more.end());
        const ProgramResult result = run_program(arguments);
        EXPECT_EQ(result.status, 0) << spelled(arguments) << "\n" << result.err << "signal " << result.signal;
        if (result.status != 0) return nullptr;
        return nlohmann::json::parse(read_file(path(out) + "/run.json"));
    }
};

// Everything a frame says, after its last batch.
struct FrameResult {
    Image image;
    FragmentCounts counts;
    SkipCounts skipped;
    std::vector<SurfaceTraffic> traffic;
    std::vector<std::string> surfaces;
    std::vector<std::uint64_t> paths;
    std::uint64_t touched_tiles = 0;
    std::uint64_t pool_used = 0, pool_overflowed = 0;
    std::vector<QuadOperation> quads;  // first_line made to count from the frame's first of the partition
    std::vector<std::vector<LineAccess>> lines;

    const SurfaceTraffic& surface(const std::string& name) const {
        for (std::size_t s = 0; s < surfaces.size(); ++s)
            if (surfaces[s] == name) return traffic[s];
        ADD_FAILURE() << "no surface " << name;
        return traffic.front();
    }
};

inline FrameResult run_frame(const std::string& trace_path, const std::string& technique,
                             const MachineConfig& config, int threads, bool quads, std::uint64_t seed = 0) {
    TraceReader trace(trace_path);
    const auto operation = operation_for(technique, trace.header(), seed);
    Frame frame(trace, *operation, config, threads, quads);
    FrameResult result;
    result.lines.resize(config.partitions);
    QuadBatch batch;
    while (frame.advance(batch)) {
        for (QuadOperation q : batch.quads) {
            q.first_line += static_cast<std::uint32_t>(result.lines[q.partition].size());
            result.quads.push_back(q);
        }
        for (std::size_t p = 0; p < config.partitions; ++p)
            result.lines[p].insert(result.lines[p].end(), batch.lines[p].begin(), batch.lines[p].end());
    }
    result.image = frame.image();
    result.counts = frame.fragments();
    result.skipped = frame.skipped();
    result.traffic = frame.traffic();
    for (int s = 0; s < frame.surfaces().surfaces(); ++s) result.surfaces.push_back(frame.surfaces().name(s));
    for (std::size_t p = 0; p < frame.cost().size(); ++p) result.paths.push_back(frame.path_count(p));
    result.touched_tiles = frame.touched_tiles();
    result.pool_used = frame.pool_used();
    result.pool_overflowed = frame.pool_overflowed();
    return result;
}

}  // namespace ropsim
