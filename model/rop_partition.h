// One ROP partition: input queue, tag stage with same-pixel interlock, ROP cache with misses in flight,
// operation pipeline, write stage, and its port to a memory channel.
#pragma once

#include "memory/clock_period.h"
#include "memory/event_wheel.h"
#include "memory/l2_slice.h"
#include "memory/latency_histogram.h"
#include "memory/mshr_table.h"
#include "memory/rop_cache.h"
#include "memory/sector_runs.h"
#include "memory/tlm_memory_port.h"
#include "model/compressed_surfaces.h"
#include "model/machine_config.h"
#include "model/partition_input.h"
#include "model/quad_operation.h"
#include "model/stage_account.h"
#include "model/surface_map.h"
#include "model/traffic_breakdown.h"

#include <array>
#include <bit>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace ropsim {

// Bytes that crossed the miss port, by surface and cause: what the channel must account for.
struct MissPortBytes {
    std::uint64_t read = 0;
    std::uint64_t write = 0;
};

// A quad's life: push() puts it on the way to the input queue; the tag stage takes it in order, one cache
// line a cycle, asks for what is missing and holds its lines; it issues, in order, when all its sectors are
// here, the operation units are free and no earlier quad on its pixels is still to be written; `latency`
// cycles later its lines are written, one a cycle, in order. So fetches run ahead of a hazard and only the
// operation waits for it.
class RopPartition : public sc_core::sc_module, public MemoryPortClient {
 public:
    // `breakdown` counts for whom bytes move.
    RopPartition(const sc_core::sc_module_name& name, int number, EventWheel& wheel,
                 const MachineConfig& config, const SurfaceMap& map, BatchSource& source,
                 TrafficBreakdown& breakdown, std::unique_ptr<CompressedSurfaces> compressed = nullptr);

    TlmMemoryPort port;
    PartitionInput& input() { return input_; }
    // A slice that the port is bound to: told when the cache has been flushed into it.
    void connect(L2Slice& slice) {
        slice_ = &slice;
        enables_.resize(requests_.size());
    }

    Picoseconds step(Picoseconds now);
    void memory_done(std::uint32_t id, bool write) override;
    void memory_port_free() override;

    bool drained() const;
    // Cycle after the last thing this partition did.
    std::uint64_t last_cycle() const { return last_cycle_; }
    void finish(std::uint64_t total_cycles);

    const RopCache& cache() const { return cache_; }
    // Puts another state into the cache. No quad that has lines may be in flight, nothing may be compressed.
    void replace_cache(RopCache cache);
    const CompressedSurfaces* compressed() const { return compressed_.get(); }
    CompressedSurfaces* compressed() { return compressed_.get(); }
    const StageAccount& tag_account() const { return tags_; }
    const StageAccount& operation_account() const { return operations_; }
    // The cache's memory port, each way. Out: busy with requests and data, or the next one waits for memory
    // to take it. In: busy with data; a request of read data takes at least a cycle.
    const StageAccount& port_out_account() const { return out_; }
    const StageAccount& port_in_account() const { return in_; }
    // [surface][cause]
    const std::vector<std::array<MissPortBytes, kMemoryCauses>>& miss_port() const { return miss_port_; }
    // By surface: picoseconds from a miss to the arrival of its sectors or block.
    const std::vector<LatencyHistogram>& read_latency() const { return read_latency_; }
    std::uint64_t quads() const { return quads_done_; }
    // Cycles of the operation stage labelled `fill`, by the surface whose data came last; and of those
    // labelled `cache_read` the ones after such a fill, and after a wait for the interlock.
    const std::vector<std::uint64_t>& fill_cycles() const { return fill_cycles_; }
    const std::vector<std::uint64_t>& fill_reads() const { return fill_reads_; }
    std::uint64_t interlock_reads() const { return interlock_reads_; }
    // How things stand after a step, for who looks on at `cycle`: whether the operation stage does not
    // operate and has no quad to issue, or the next one waits for a fill; and the tag stage's label.
    struct Waits {
        std::uint64_t issued = 0;  // quads, so far
        bool starved = false;
        bool fill = false;
        StageLabel tags = StageLabel::kIdle;
    };
    Waits waits(std::uint64_t cycle) const {
        const bool next = issue_head_ < tag_tail_;
        const bool operates = units_taken_ <= cycle && cycle < units_free_;
        return {issue_head_, !next && !operates,
                next && operations_.labelled() <= cycle && slots_[issue_head_ % kMaxSlots].fills > 0,
                tag_free_ > cycle ? StageLabel::kBusy : tag_label_};
    }
    // The stages, to log their labels.
    std::array<StageAccount*, 4> accounts() { return {&tags_, &operations_, &out_, &in_}; }
    // Lines whose write a later result joined: cycles of the write port saved, at one line a cycle.
    std::uint64_t writes_saved() const { return writes_saved_; }
    // What is occupied now: quads between tag check and write (the one being checked included), miss
    // registers, requests not yet taken by memory, compressed blocks on their way to memory.
    const PartitionInput& input() const { return input_; }
    std::uint32_t slots_in_use() const;
    std::uint32_t mshrs_in_use() const { return static_cast<std::uint32_t>(mshrs_.used()); }
    std::uint32_t requests_queued() const { return request_count_; }
    std::uint32_t blocks_leaving() const { return leaving_count_; }

 private:
    static constexpr std::uint32_t kMaxSlots = 32;
    // A fill's id: miss register, first sector and one less than their number, from high to low; or, flagged,
    // what else was read.
    static constexpr int kMshrShift = kFillRegisterShift;
    static constexpr int kSectorShift = kFillSectorShift;
    static constexpr std::uint32_t kField = kFillField;
    static constexpr std::uint32_t kBlockFill = 1u << 31;  // the whole line of the miss register; below it,
    static constexpr std::uint32_t kBlockBytes = (1u << kMshrShift) - 1u;  // its bytes
    static constexpr std::uint32_t kBlockUnit = 8;                         // in so many
    static constexpr std::uint32_t kLeavingRead = 1u << 30;  // for the leaving block of this number
    static constexpr std::uint32_t kStateRead = 1u << 29;    // a block's state, for the tag stage
    struct Slot {
        QuadBatch* batch = nullptr;
        const QuadOperation* quad = nullptr;
        const LineAccess* lines = nullptr;
        std::uint32_t fills = 0;           // miss registers it waits for
        std::uint32_t written_lines = 0;   // of those looked up, how many it writes
        std::uint64_t tags_done = 0;       // cycle after its last tag check
        std::uint64_t operands_ready = 0;  // cycle, once fills is 0
        std::uint64_t result = 0;          // cycle it leaves the pipeline, once issued
        std::uint64_t written = 0;         // cycle its last line is written, once issued
        std::uint8_t awaited = 0;          // surface whose data came last
        std::vector<int> held;             // the cache line of each of its lines, unless it gave them up

        ByteSource source() const { return batch->source(*quad); }
        // As the cache keeps it.
        std::uint64_t writer() const { return std::bit_cast<std::uint64_t>(source()); }
        void start(QuadBatch* of, std::uint32_t number) {
            batch = of;
            quad = &of->quads[number];
            lines = of->lines[quad->partition].data() + quad->first_line;
            fills = written_lines = 0;
            tags_done = operands_ready = result = written = 0;
        }
    };
    Slot& slot(std::uint64_t number) { return slots_[number % kMaxSlots]; }
    const Slot& slot(std::uint64_t number) const { return slots_[number % kMaxSlots]; }

    std::uint64_t next_cycle(std::uint64_t cycle) const;
    void end_of_frame(std::uint64_t cycle);
    void write_results(std::uint64_t cycle);
    void write_held_lines(Slot& s);
    bool write_lines_anew(Slot& s);
    void write(const Slot& s, const LineAccess& access, int line, std::uint64_t writer);
    // Whether anybody can tell when a result is written. Others are written with the next step, in their
    // order and with their time.
    bool watches_writes() const {
        return input_.finished() || exclusive_ ||
               (tag_waits_ && (tag_label_ == StageLabel::kSlotsFull || tag_label_ == StageLabel::kCacheWays));
    }
    // Operations issue in order as soon as their operands are known to be here: the time follows by
    // reservation.
    void issue_operations() {
        for (; issue_head_ < tag_tail_ && slot(issue_head_).fills == 0; ++issue_head_)
            issue(slot(issue_head_));
    }
    void issue(Slot& s);
    // Returns the cycle to try again, or kNever when something else must happen first.
    std::uint64_t tag_stage(std::uint64_t cycle);
    std::uint64_t look_up_lines(std::uint64_t cycle);
    bool still_blocked(std::uint64_t cycle) const;
    // Room in the queue for the worst that a missing line can ask for. A request that was sent in this cycle
    // makes room in the next, however often the partition is stepped meanwhile.
    bool room_to_miss(std::uint64_t cycle) const {
        const std::uint32_t wanted = 2 * worst_requests_ + (compressed_ != nullptr ? kBlockRequests : 0);
        return request_room() >= wanted + (sent_ == cycle ? 1 : 0);
    }
    bool admit(std::uint64_t cycle, StageLabel& reason);
    void hold(Slot& s, int line, const LineAccess& access);
    std::uint64_t cycles_without_write(std::uint64_t cycle) const;
    // When the first result that was issued is written; kNever: none was.
    void expect_write() { next_write_ = write_head_ < issue_head_ ? slot(write_head_).written : kNever; }
    bool check_lines(Slot& s, int line, std::uint64_t cycle);
    // Where the line is, and whether all that is read of it is there.
    struct Found {
        int line;  // or RopCache::kMiss
        bool whole;
    };
    Found find(const LineAccess& access) const {
        const int line = cache_.probe(access.line_address, access.surface);
        return {line, line != RopCache::kMiss && (access.read_sectors & ~cache_.valid_sectors(line)) == 0};
    }
    // Whether it would take a free miss register to look the line up.
    bool needs_register(const LineAccess& access) const {
        const Found found = find(access);
        return access.read_sectors != 0 && !found.whole &&
               (found.line == RopCache::kMiss || cache_.pending_sectors(found.line, ~0u) == 0);
    }
    void hold_present_line(Slot& s, const LineAccess& access, int line);
    std::uint64_t hold_present_lines(Slot& s, Found& found, std::uint64_t cycle);
    bool access_missing_line(Slot& s, const LineAccess& access, int line, std::uint64_t cycle,
                             StageLabel& reason);
    void ask_for(Slot& s, const LineAccess& access, int line, std::uint32_t missing);
    bool take_line(Slot& s, const LineAccess& access, int& line);
    // of operations on the same pixels and results for the same line (rop_partition_hazards.cpp)
    struct Operands {
        std::uint64_t read = 0;       // cycle from which they may be read
        std::uint64_t forwarded = 0;  // cycle of the last result that they are taken from; 0: of none
        bool from_cache = true;       // some of them at least
    };
    std::uint32_t crowd_of(std::uint32_t quad_id) const {
        return (config_.hazards.interlock == HazardConfig::Interlock::kTile ? quad_id / 16 : quad_id) %
               kCrowd;
    }
    bool conflict(std::size_t older, std::size_t younger) const;
    Operands operands(std::uint64_t number, std::uint64_t present) const;
    void take_results(std::uint64_t number, Operands& o) const;
    bool forwarded(const Slot& s, const LineAccess& wanted, std::uint64_t from, std::uint64_t to,
                   std::uint64_t read) const;
    std::uint64_t book_writes(const Slot& s);
    void release_pins(Slot& s);
    void queue_request(const MemoryRequest& request);
    void queue_requests(std::uint64_t line_address, std::uint32_t sectors, const MemoryRequest& common,
                        const LineMask* enables = nullptr);
    void queue_write(const Eviction& eviction, MemoryCause cause);
    void queue_sectors(const Eviction& eviction, MemoryCause cause);
    // Room for the requests of one line that leaves.
    bool can_write_back() const {
        if (compressed_ == nullptr) return request_room() >= worst_requests_;
        return request_room() >= worst_requests_ + kBlockRequests && leaving_count_ < leaving_.size();
    }

    // of compressed surfaces (rop_partition_blocks.cpp)
    bool compressed_in_memory(const LineAccess& access);
    void queue_block_fill(std::uint64_t line_address, MemoryRequest request);
    bool look_up_state(const LineAccess& access, StageLabel& reason);
    void queue_metadata(const MetadataCache::Traffic& traffic, std::uint8_t surface, std::uint32_t id);
    void queue_block(const Eviction& eviction, MemoryCause cause);
    bool leaving(std::uint64_t line_address) const;
    void write_leaving_blocks(std::uint64_t cycle);
    std::uint64_t next_leaving_block() const;
    void leaving_read_done(std::uint32_t id, std::uint64_t cycle);
    std::uint32_t decompress_latency(std::uint8_t surface) const;
    void flush_metadata();
    void send_request(std::uint64_t cycle);
    bool through_port(std::uint32_t id, std::uint64_t cycle);
    void take_fills(std::uint64_t cycle);
    bool fill(std::uint32_t id, std::uint64_t cycle);
    bool flushing() const;
    bool flushing_metadata() const;
    void flush_line(std::uint64_t cycle);
    std::uint32_t request_room() const { return config_.cache_request_queue - request_count_; }
    // The place after this one in the ring of requests.
    std::uint32_t next_place(std::uint32_t place) const {
        return place + 1 == config_.cache_request_queue ? 0 : place + 1;
    }

    const MachineConfig& config_;
    ClockPeriod clock_;
    EventWheel& wheel_;
    BatchSource& source_;
    int number_;
    int wheel_id_;
    PartitionInput input_;  // at its end the cache is flushed
    L2Slice* slice_ = nullptr;
    bool told_slice_ = false;
    std::uint32_t worst_requests_;  // separate runs of sectors that one line can fall into
    // Requests that the write-back of a line may take beside its own: rest of the block, state there and
    // back.
    static constexpr std::uint32_t kBlockRequests = 3;
    // A compressed block between cache and memory.
    struct LeavingBlock {
        std::uint64_t block = 0;
        Eviction eviction;
        MemoryCause cause = MemoryCause::kWriteBack;
        std::uint32_t write_bytes = 0;  // 0: the eviction's sectors
        std::uint32_t reads = 0;        // outstanding
        std::uint64_t ready = 0;        // cycle it may be written, once reads is 0
        std::uint32_t latency = 0;      // from the last read on
        bool used = false;
    };
    RopCache cache_;
    std::unique_ptr<CompressedSurfaces> compressed_;
    std::vector<LeavingBlock> leaving_;
    std::uint32_t leaving_count_ = 0;
    bool state_pending_ = false;  // the tag stage waits for a block's state
    static constexpr std::uint64_t kNoLine = ~std::uint64_t{0};
    std::uint64_t state_known_ = kNoLine;  // the line whose state it waited for
    MshrTable mshrs_;
    std::vector<std::uint16_t> mshr_of_;  // by cache line, while sectors of it are on their way

    std::array<Slot, kMaxSlots>
        slots_{};  // ring: [write_head_, issue_head_) issued, [issue_head_, tag_tail_) waiting
    std::array<std::uint32_t, kMaxSlots> slot_quad_id_{};
    std::array<std::uint8_t, kMaxSlots> slot_pixels_{};
    // Slots in use by the low bits of their quad's number: most quads have no other of theirs in flight.
    static constexpr std::uint32_t kCrowd = 256;
    std::array<std::uint8_t, kCrowd> crowd_{};
    std::uint64_t write_head_ = 0;
    std::uint64_t issue_head_ = 0;
    std::uint64_t tag_tail_ = 0;
    std::uint64_t next_write_ = kNever;  // cycle: see expect_write()
    bool tagging_ = false;               // slot tag_tail_ is having its lines checked
    std::uint32_t next_line_ = 0;        // of it
    std::uint32_t ports_used_ = 0;       // look-ups already made for the cycle tag_free_
    bool exclusive_ = false;  // the last quad had to give up its lines: none follows before it is written

    std::uint64_t tag_free_ = 0;
    std::uint64_t units_taken_ = 0;  // by the last quad, from then on
    std::uint64_t units_free_ = 0;
    std::uint64_t write_free_ = 0;
    // Lines last booked at the cache's write port, with the cycle of each: results may join them.
    struct BookedWrite {
        std::uint64_t line_address = 0;
        std::uint64_t cycle = 0;
        std::uint8_t surface = 0;
    };
    std::vector<BookedWrite> booked_;  // ring
    std::uint64_t writes_booked_ = 0;
    std::uint64_t results_entered_ = 0;  // cycle of the last result in the write queue
    std::uint64_t writes_saved_ = 0;
    std::uint32_t written_lines_ = 0;  // of slot write_head_, where it takes them anew
    StageLabel tag_label_ = StageLabel::kIdle;
    bool tag_waits_ = false;     // for what tag_label_ says
    bool ways_changed_ = false;  // a line was let go since the tag stage last found every way taken

    std::vector<MemoryRequest> requests_;  // ring
    std::vector<LineMask> enables_;        // of the masked writes among them, where there is a slice
    std::uint32_t request_head_ = 0;
    std::uint32_t request_tail_ = 0;  // the place of the next one
    std::uint32_t request_count_ = 0;
    std::uint64_t sent_ = kNever;     // cycle of the last
    std::uint64_t request_free_ = 0;  // one a cycle, or as long as its data take
    // Fills on their way through a port of limited width, in order of time; empty without a limit.
    struct Fill {
        std::uint64_t cycle;
        std::uint32_t id;
    };
    std::vector<Fill> fills_;  // ring, as many as the port has requests in flight
    std::uint32_t fill_head_ = 0;
    std::uint32_t fill_count_ = 0;
    std::uint64_t fill_free_ = 0;

    int flush_line_ = 0;  // next line to look at; past the end when flushed
    std::uint64_t flush_free_ = 0;
    std::uint64_t last_cycle_ = 0;
    std::uint64_t quads_done_ = 0;
    StageAccount tags_;
    StageAccount operations_;
    StageAccount out_;  // the port to memory: requests and data written
    StageAccount in_;   // the port from memory: data read
    std::vector<std::array<MissPortBytes, kMemoryCauses>> miss_port_;
    TrafficBreakdown& breakdown_;
    ByteSource moved_for_;  // whose bytes are asked for next
    std::vector<LatencyHistogram> read_latency_;
    std::vector<std::uint64_t> fill_cycles_;  // by surface
    std::vector<std::uint64_t> fill_reads_;   // by surface
    std::uint64_t interlock_reads_ = 0;
    std::vector<Picoseconds> asked_;  // by miss register and first sector: when
};

}  // namespace ropsim
