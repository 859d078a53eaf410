// The functional side of a sample: its partitions' quads go through their caches without a clock, all of
// them, and in stretches on to the timed machine.
#pragma once

#include "model/cached_partition.h"
#include "model/frame.h"
#include "model/front_end_caches.h"
#include "model/shader_cores.h"
#include "model/tile_sample_plan.h"
#include "model/tile_sample_squares.h"

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

namespace ropsim {

// What is counted by square and by stretch. Bytes by surface follow the fixed part.
enum SampleColumn : std::size_t {
    kQuads,
    kLines,
    kLaneCycles,
    kUnitCycles,
    kPixels,  // operated
    kResolved,
    kHits,
    kMisses,
    kAllocations,
    kEvictions,
    kSectorsWritten,
    kBytesWritten,
    kFillsAvoided,
    kPinReads,  // bytes, all surfaces
    kPinWrites,
    kBySurface  // four each: read and written on the pins, by operations read and written
};
using SampleRow = std::vector<double>;

// A piece of a stretch on its way through the timed machine.
struct SampleBatch : QuadBatch {
    enum class Part : std::uint8_t { kWarm, kMeasured, kTail, kGap };
    Part part = Part::kMeasured;
    bool last = false;  // of its part
};

// One sampled partition.
class SampleStream {
 public:
    SampleStream(int partition, const SamplePlan& plan, const MachineConfig& config, const Frame& frame,
                 const SampleSquares& squares, bool timed);

    void take(const QuadOperation& q, const QuadBatch& batch);
    void end();  // of the frame

    int partition() const { return partition_; }
    const CachedPartition& cached() const { return cached_; }
    // By square.
    const std::vector<SampleRow>& rows() const { return rows_; }
    SampleRow total() const;

    // A stretch: the cache as it begins, and what its measured quads add up to.
    struct Stretch {
        std::optional<RopCache> cache;
        SampleRow measured;
    };
    const std::vector<Stretch>& stretches() const { return stretches_; }
    // Gives away the state of the cache as stretch `number` begins.
    RopCache take_cache(std::size_t number);
    // Batches for the timed machine, in order; nullptr when there is none yet (or, ended(), none any more).
    SampleBatch* next();
    void release(SampleBatch* batch);
    bool ended() const { return ended_; }

 private:
    void count(SampleRow& row) const;
    void change_square(std::size_t square);
    void add_to_stretch(const QuadOperation& q, const QuadBatch& batch);
    void begin_stretch();
    void enter(SampleBatch::Part part);
    void finish_part();
    void copy(const QuadOperation& q, const QuadBatch& batch);
    void add_gap();
    SampleBatch* take_empty(SampleBatch::Part part, std::uint8_t pass);

    int partition_;
    const SamplePlan& plan_;
    const MachineConfig& config_;
    const SampleSquares& squares_;
    bool timed_;
    CachedPartition cached_;
    // Of the partition's share: what texels the others' quads fetch from it, its own fetch from them.
    MachineConfig share_;
    UntimedFrontEnd front_end_;
    // Of operations; the rest is read off the cache.
    SampleRow operated_;
    static constexpr std::size_t kNoSquare = ~std::size_t{0};
    std::size_t square_ = kNoSquare;  // of the quad before
    SampleRow counted_;               // up to where it began
    SampleRow now_;
    std::vector<SampleRow> rows_;

    std::uint64_t position_ = 0;  // quads so far
    std::uint64_t next_stretch_ = 0;
    bool in_stretch_ = false;
    SampleBatch::Part part_ = SampleBatch::Part::kWarm;
    std::uint64_t left_ = 0;  // quads of the part
    std::vector<Stretch> stretches_;
    std::vector<SampleBatch*> open_;  // of the stretch, until it is complete
    std::deque<SampleBatch*> ready_;
    std::vector<SampleBatch*> empty_;
    std::vector<std::unique_ptr<SampleBatch>> owned_;
    bool ended_ = false;
};

// Runs the frame for its streams, as far as any of them needs it.
class SampleFeeder {
 public:
    SampleFeeder(Frame& frame, std::vector<std::unique_ptr<SampleStream>>& streams);
    bool advance();  // false at the end of the frame

 private:
    Frame& frame_;
    std::vector<std::unique_ptr<SampleStream>>& streams_;
    std::vector<SampleStream*> of_partition_;  // nullptr: not in the sample
    QuadBatch batch_;
    bool ended_ = false;
};

}  // namespace ropsim
