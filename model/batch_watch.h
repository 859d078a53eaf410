// Watches the batches on their way into the machine and out of it: when passes run, and what their quads use.
#pragma once

#include "memory/event_wheel.h"
#include "model/quad_operation.h"
#include "model/reuse_sample.h"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace ropsim {

class BatchWatch : public BatchSource {
 public:
    BatchWatch(BatchSource& source, const EventWheel& wheel, std::vector<std::string> pass_names,
               const RopCacheConfig& cache, const SurfaceMap& map)
        : source_(source),
          wheel_(wheel),
          names_(std::move(pass_names)),
          added_time_(names_.size(), 0),
          reuse_(cache, map) {}
    QuadBatch* next() override;
    void release(QuadBatch* batch) override;

    const std::vector<PassSpan>& passes() const { return passes_; }
    // By pass of Frame::pass_names(), picoseconds that it adds: a batch ends when its last quad is written,
    // and the time since the end of the one before it belongs to its pass. Passes overlap in the machine, and
    // these sum to `end`: what follows the last batch belongs to the last pass, the end of the frame.
    std::vector<Picoseconds> added_times(Picoseconds end) const;
    const ReuseSample& reuse() const { return reuse_; }
    // Quads that were rasterised: all but those of copies and resolves.
    std::uint64_t rastered() const { return rastered_; }

 private:
    BatchSource& source_;
    const EventWheel& wheel_;
    std::vector<std::string> names_;
    std::vector<Picoseconds> added_time_;  // by pass
    Picoseconds last_end_ = 0;             // of a batch
    ReuseSample reuse_;
    std::vector<PassSpan> passes_;
    std::uint8_t pass_ = 0;                                   // number of the last of them
    std::vector<std::pair<QuadBatch*, std::size_t>> inside_;  // batches, with the place of their pass
    std::uint64_t rastered_ = 0;
};

}  // namespace ropsim
