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
        : source_(source), wheel_(wheel), names_(std::move(pass_names)), reuse_(cache, map) {}
    QuadBatch* next() override;
    void release(QuadBatch* batch) override;

    const std::vector<PassSpan>& passes() const { return passes_; }
    const ReuseSample& reuse() const { return reuse_; }
    // Quads that were rasterised: all but those of copies and resolves.
    std::uint64_t rastered() const { return rastered_; }

 private:
    BatchSource& source_;
    const EventWheel& wheel_;
    std::vector<std::string> names_;
    ReuseSample reuse_;
    std::vector<PassSpan> passes_;
    std::uint8_t pass_ = 0;                                   // number of the last of them
    std::vector<std::pair<QuadBatch*, std::size_t>> inside_;  // batches, with the place of their pass
    std::uint64_t rastered_ = 0;
};

}  // namespace ropsim
