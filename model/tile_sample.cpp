#include "model/tile_sample.h"

#include "base/error.h"
#include "model/tile_sample_machine.h"
#include "model/tile_sample_report.h"
#include "model/tile_sample_stream.h"

#include <algorithm>
#include <charconv>
#include <memory>

namespace ropsim {

namespace {

// Whether what a tile's pixels read lies in tiles of other partitions: the function then runs over all tiles.
bool reads_elsewhere(const Declaration& declared) {
    bool elsewhere = declared.footprint > 0 || declared.gathers;
    for (const Pass& pass : declared.passes) elsewhere = elsewhere || pass.gathers || pass.scale > 1;
    return elsewhere;
}

std::vector<std::uint8_t> tiles_of(const SurfaceMap& map, std::size_t tiles,
                                   const std::vector<int>& partitions) {
    std::vector<std::uint8_t> selected(tiles);
    for (std::size_t tile = 0; tile < tiles; ++tile)
        selected[tile] = std::ranges::find(partitions, map.partition_of(tile)) != partitions.end() ? 1 : 0;
    return selected;
}

}  // namespace

double sample_percent(const std::string& text, const std::string& where) {
    double percent = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, percent);
    const bool all = stop == end || (stop + 1 == end && *stop == '%');
    if (error != std::errc{} || !all || !(percent > 0) || percent > 100)
        throw UserError(where, fmt::format("'{}' is no percentage above 0 and up to 100; write 5%", text));
    return percent;
}

const Estimate* TileSample::find(const std::string& place) const {
    for (const auto& [at, estimate] : estimates)
        if (at == place) return &estimate;
    return nullptr;
}

TileSample sample_frame(Frame& frame, const TraceReader& trace, const MachineConfig& config, double percent,
                        std::uint64_t seed, SampledFidelity fidelity) {
    TileSample sample;
    sample.percent = percent;
    sample.seed = seed;
    const SurfaceMap& map = frame.surfaces();
    sample.plan = plan_sample(map, trace.tile_fragments(), config, percent, seed);
    sample.function_complete = reads_elsewhere(frame.operation().declaration());
    if (!sample.function_complete)
        frame.select_tiles(tiles_of(map, trace.tile_fragments().size(), sample.plan.partitions));
    const SampleSquares squares(map, trace, config.partition_tiles, sample.plan.partitions);
    const bool timed = fidelity == SampledFidelity::kTimed;
    std::vector<std::unique_ptr<SampleStream>> streams;
    for (const int p : sample.plan.partitions)
        streams.push_back(std::make_unique<SampleStream>(p, sample.plan, config, frame, squares, timed));
    SampleFeeder feeder(frame, streams);
    SampledTiming timing;
    if (timed) timing = run_sample_machine(frame, config, sample.plan, feeder, streams);
    while (feeder.advance()) {
    }
    SampleReport report(frame, squares, streams, sample);
    if (squares.all_fragments() > 0)
        sample.fragment_share = squares.sample_fragments() / squares.all_fragments();
    if (!sample.function_complete) {
        report.add_counts();
        report.add_touched();
    }
    if (fidelity != SampledFidelity::kCount) report.add_pins();
    if (!timed) return sample;
    const double quads = report.column(kQuads).value;
    double timed_quads = 0;
    for (std::size_t i = 0; i < streams.size(); ++i) {
        sample.stretches += timing.stretches[i].size();
        timed_quads += sample.plan.whole()
                           ? streams[i]->total()[kQuads]
                           : static_cast<double>(timing.stretches[i].size() * SamplePlan::kStretch);
    }
    if (quads > 0) sample.timed_share = timed_quads / quads;
    const double rop_a_shader_cycle =
        static_cast<double>(config.shader_period_ps) / static_cast<double>(config.rop_period_ps);
    const double front_end =
        std::max(quads / config.export_quads_per_cycle,
                 report.column(kLaneCycles).value / config.shader_alu_lanes * rop_a_shader_cycle);
    report.add_timing(timing, config, front_end);
    return sample;
}

Estimate TileSample::cycles() const {
    const Estimate* e = find("/cycles");
    return e != nullptr ? *e : Estimate{};
}

Estimate TileSample::pin_bytes() const {
    const Estimate* read = find("/traffic/total/pin_read_bytes");
    const Estimate* write = find("/traffic/total/pin_write_bytes");
    if (read == nullptr || write == nullptr) return {};
    return {read->value + write->value, read->low + write->low, read->high + write->high};
}

}  // namespace ropsim
