#include "model/compression_sweep.h"

#include "base/error.h"
#include "model/cached_partition.h"
#include "model/frame_pipeline.h"
#include "model/front_end_caches.h"

#include <memory>
#include <optional>

namespace ropsim {

namespace {

using Lines = std::vector<std::vector<LineAccess>>;  // by partition

// A line's address in one map from that in another of the same surfaces.
class Readdressing {
 public:
    Readdressing(const SurfaceMap& from, const SurfaceMap& to) {
        for (int s = 0; s < from.surfaces(); ++s) {
            const bool pool = from.layout(s) == Layout::kPool;  // one piece, whatever its nodes
            surfaces_.push_back({from.first_address(s), to.first_address(s), pool ? 0 : from.tile_bytes(s),
                                 pool ? 0 : to.tile_bytes(s)});
        }
    }
    std::uint64_t operator()(int surface, std::uint64_t address) const {
        const Places& p = surfaces_[static_cast<std::size_t>(surface)];
        const std::uint64_t offset = address - p.from;
        if (p.from_tile == p.to_tile) return p.to + offset;
        return p.to + offset / p.from_tile * p.to_tile + offset % p.from_tile;
    }

 private:
    struct Places {
        std::uint64_t from, to, from_tile, to_tile;
    };
    std::vector<Places> surfaces_;
};

class ConfiguredMachine {
 public:
    ConfiguredMachine(const MachineConfig& config, const Frame& frame)
        : config_(config),
          map_(frame.operation().declaration(), config, frame.initial_pixels().trace()),
          readdress_(frame.surfaces(), map_) {
        for (std::uint32_t p = 0; p < config.partitions; ++p)
            partitions_.push_back(std::make_unique<CachedPartition>(
                config_, map_,
                compressed_surfaces(config_, map_, frame.operation().declaration(), frame.initial_pixels(),
                                    static_cast<int>(p))));
        std::vector<CachedPartition*> owners;
        for (const auto& partition : partitions_) owners.push_back(partition.get());
        front_end_.emplace(config_, map_, owners);
    }

    // `lines`: the batch's, as the frame's map places them; those of the batch are overwritten.
    void operate(QuadBatch& batch, const Lines& lines) {
        for (std::size_t p = 0; p < lines.size(); ++p) {
            for (std::size_t l = 0; l < lines[p].size(); ++l) {
                LineAccess& here = batch.lines[p][l];
                here.line_address = readdress_(here.surface, lines[p][l].line_address);
                here.values = map_.needs_values(here.surface) ? lines[p][l].values : LineAccess::kNoValues;
            }
        }
        for (const QuadOperation& q : batch.quads) {
            front_end_->read(q, batch);
            if (reaches_partition(q)) partitions_[q.partition]->operate(q, batch);
        }
    }

    CompressionOutcome finish() {
        CompressionOutcome outcome;
        outcome.pins.resize(static_cast<std::size_t>(map_.surfaces()));
        for (const auto& partition : partitions_) {
            partition->flush();
            const BytesByCause& pins = partition->pins();
            for (std::size_t s = 0; s < pins.size(); ++s) {
                for (std::size_t c = 0; c < kMemoryCauses; ++c) {
                    outcome.pins[s][c].read += pins[s][c].read;
                    outcome.pins[s][c].write += pins[s][c].write;
                }
            }
            if (partition->compressed() != nullptr) outcome.report.add(*partition->compressed(), map_);
        }
        return outcome;
    }

 private:
    const MachineConfig& config_;
    SurfaceMap map_;
    Readdressing readdress_;
    std::vector<std::unique_ptr<CachedPartition>> partitions_;
    std::optional<UntimedFrontEnd> front_end_;
};

}  // namespace

std::vector<CompressionOutcome> sweep_compression(Frame& frame, const std::vector<MachineConfig>& configs,
                                                  int threads) {
    CHECK(!configs.empty());
    for (int s = 0; s < frame.surfaces().surfaces(); ++s)
        CHECK(frame.surfaces().needs_values(s) || s == frame.surfaces().textures(), "surface {}",
              frame.surfaces().name(s));
    std::vector<std::unique_ptr<ConfiguredMachine>> machines;
    for (const MachineConfig& config : configs) {
        CHECK(config.cache.line_bytes == configs[0].cache.line_bytes &&
              config.cache.sector_bytes == configs[0].cache.sector_bytes &&
              config.partitions == configs[0].partitions);
        machines.push_back(std::make_unique<ConfiguredMachine>(config, frame));
    }
    FramePipeline pipeline(frame, threads);
    Lines lines;
    while (QuadBatch* batch = pipeline.next()) {
        lines = batch->lines;
        for (const auto& machine : machines) machine->operate(*batch, lines);
        pipeline.release(batch);
    }
    std::vector<CompressionOutcome> outcomes;
    for (const auto& machine : machines) outcomes.push_back(machine->finish());
    return outcomes;
}

}  // namespace ropsim
