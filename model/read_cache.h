// A cache that only reads, before the shader cores: of a depth unit, or of a core's textures.
#pragma once

#include "memory/event_wheel.h"
#include "memory/rop_cache.h"
#include "memory/sector_runs.h"
#include "model/compressed_surfaces.h"
#include "model/line_read.h"
#include "model/quad_operation.h"
#include "model/stage_account.h"

#include <cstdint>
#include <deque>
#include <vector>

namespace ropsim {

class FrontEnd;
class ReadPort;

struct ReadCacheConfig {
    RopCacheConfig cache;
    std::uint32_t jobs = 64;            // between look-up and take()
    std::uint32_t mshrs = 8;            // lines on their way before another is asked for
    std::uint32_t latency = 8;          // cycles from the look-up, or the last fill, to the answer
    std::uint32_t lines_per_cycle = 1;  // looked up
    MemoryCause cause = MemoryCause::kFill;
};

// What a look-up asks memory for, as timed and untimed caches do alike: the sectors that are missing, a
// request for each run of them; of a compressed block what is stored of it, which brings the line whole.
// Returns the sectors that come.
template <class Visit>
std::uint32_t for_missing(RopCache& cache, int line, const LineRead& read, MemoryRequest request,
                          CompressedSurfaces* compressed, Visit&& visit) {
    std::uint32_t missing = cache.request_sectors(line, read.sectors);
    if (missing == 0) return 0;
    request.surface = read.surface;
    if (compressed != nullptr && compressed->memory.holds(read.surface) &&
        compressed->memory.state(read.surface, read.address) == CompressedMemory::State::kCompressed) {
        missing |= cache.request_rest(line);
        request.address = compressed->memory.block_of(read.address);
        request.bytes = compressed->memory.stored_bytes(read.surface, read.address);
        const auto first = static_cast<std::uint32_t>(std::countr_zero(missing));
        const auto length = static_cast<std::uint32_t>(std::bit_width(missing)) - first;
        request.id = request.id << kFillRegisterShift | first << kFillSectorShift | (length - 1);
        visit(request);
        return missing;
    }
    for_each_run(read.address, missing, cache.config().sector_bytes, request, nullptr, visit);
    return missing;
}

// Jobs (a quad's depths, a warp's texels) are looked up in order and answered in order. The lines of a job
// are looked up in one go and keep the tags busy for as many cycles as they take. A line may be replaced as
// soon as it is here: its data go to whoever waits.
class ReadCache {
 public:
    // `ports`: by partition; lines go to them in turn, `interleave` bytes each, or, with one port, all to it.
    // `unit`: how the front end knows it.
    ReadCache(EventWheel& wheel, const ReadCacheConfig& config, Picoseconds rop_period,
              std::vector<ReadPort*> ports, std::uint64_t base, CompressedSurfaces* compressed,
              FrontEnd& front_end, int unit);

    // A job's lines, then the job: it may be looked up from `arrival` on.
    void add_line(const LineRead& read) { lines_.push_back(read); }
    void push(const ByteSource& source, Picoseconds arrival);
    // When the first job's answer is there; kNever: not yet known, or there is no job.
    Picoseconds first_known() const { return jobs_.empty() ? kNever : jobs_.front().known; }
    // The first job is done with.
    void take();
    // Sectors have arrived (of a request's id).
    void fill(std::uint32_t id);

    Picoseconds step(Picoseconds now);
    const RopCacheStatistics& statistics() const { return cache_.statistics(); }
    StageAccount& account() { return account_; }
    std::uint32_t jobs() const { return static_cast<std::uint32_t>(jobs_.size()); }

    static constexpr std::uint64_t kInterleave = 256;  // bytes

 private:
    struct Job {
        ByteSource source;
        Picoseconds arrival = 0;
        std::uint32_t lines = 0;  // not yet looked up
        std::uint32_t looked_up = 0;
        std::uint32_t missing = 0;  // lines on their way
        Picoseconds answer = 0;     // its own
        Picoseconds known = kNever;
    };
    struct Miss {
        std::uint64_t address = 0;
        int line = 0;
        std::uint32_t sectors = 0;  // 0: free
        std::uint8_t surface = 0;
        std::vector<std::uint64_t> waiting;  // jobs, by number
    };
    bool look_up(Job& job, std::uint64_t number, const LineRead& read);
    void send(MemoryRequest request, const ByteSource& source);
    void publish();
    Job& job(std::uint64_t number) { return jobs_[number - first_job_]; }
    Picoseconds edge(Picoseconds time) const { return (time + period_ - 1) / period_ * period_; }

    EventWheel& wheel_;
    int wheel_id_;
    ReadCacheConfig config_;
    Picoseconds period_;
    std::vector<ReadPort*> ports_;
    std::uint64_t base_;
    CompressedSurfaces* compressed_;
    FrontEnd& front_end_;
    int unit_;
    RopCache cache_;
    std::deque<LineRead> lines_;  // of the jobs not yet looked up, and of one being put together
    std::size_t lines_pushed_ = 0;
    std::deque<Job> jobs_;
    std::uint64_t first_job_ = 0;  // number of jobs_.front()
    std::uint64_t next_job_ = 0;   // to be looked up
    std::uint64_t published_ = 0;  // jobs whose answers are known, in order
    Picoseconds last_known_ = 0;
    Picoseconds tags_free_ = 0;
    std::vector<Miss> misses_;
    std::uint32_t misses_out_ = 0;
    StageLabel label_ = StageLabel::kIdle;
    StageAccount account_;
};

}  // namespace ropsim
