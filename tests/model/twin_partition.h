// The twin's ROP partition: see event_twin.h.
#pragma once

#include "memory/dram_channel.h"
#include "memory/event_wheel.h"
#include "memory/rop_cache.h"
#include "memory/tlm_memory_port.h"
#include "model/frame.h"
#include "model/machine_config.h"
#include "model/machine_result.h"

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace ropsim {

// A line in the write queue.
struct TwinWrite {
    std::uint64_t line_address = 0;
    std::uint8_t surface = 0;
    const void* quad = nullptr;          // that it was queued for
    std::optional<std::uint64_t> cycle;  // of the write
};

// A quad's way through a partition, one state after the other.
struct TwinQuad {
    const QuadOperation* quad = nullptr;
    QuadBatch* batch = nullptr;
    std::uint64_t arrival = 0;  // cycle at the partition
    std::uint32_t lines_checked = 0;
    bool tagged = false;                     // every line checked ...
    std::uint64_t tagged_cycle = 0;          // ... in this cycle
    int missing = 0;                         // lines with sectors on their way
    std::uint64_t last_fill = 0;             // cycle
    std::optional<std::uint64_t> read;       // cycle at which its operands began to be read from the cache
    std::optional<std::uint64_t> result;     // issued: cycle at which its result is there
    std::optional<std::uint32_t> unwritten;  // lines still to be written, once writing has begun
    std::uint32_t committed = 0;             // lines whose bytes are in the cache
    std::vector<int> pinned;
    std::vector<const TwinQuad*> sources;            // whose results it takes, while they are in flight
    bool from_cache = true;                          // some operands are read there
    bool entered = false;                            // in the write queue (with coalescing)
    std::vector<std::shared_ptr<TwinWrite>> writes;  // its own, and those that it joined
};

class TwinPartition : public MemoryPortClient {
 public:
    TwinPartition(const std::string& name, EventWheel& wheel, const MachineConfig& config,
                  const SurfaceMap& map, std::function<void()> wake,
                  std::function<void(QuadBatch*)> quad_done);

    TlmMemoryPort port;
    void push(QuadBatch* batch, std::uint32_t quad, std::uint64_t cycle);
    // The crossbar is a pipeline: it holds a quad for each of its cycles.
    bool has_room() const { return input_.size() < config_.input_queue + config_.crossbar_latency; }
    void upstream_finished() { upstream_finished_ = true; }
    // Everything this cycle does; called again in the same cycle when memory spoke meanwhile.
    void tick(std::uint64_t cycle);
    bool drained() const;
    std::uint64_t end() const { return end_; }
    const BytesByCause& miss_port() const { return miss_port_; }
    const RopCacheStatistics& cache_statistics() const { return cache_.statistics(); }

    void memory_done(std::uint32_t id, bool write) override;
    void memory_port_free() override { wake_(); }

 private:
    // A line with sectors on their way.
    struct Miss {
        std::uint64_t line_address = 0;
        int line = 0;
        std::uint32_t sectors = 0;
        std::vector<TwinQuad*> waiting;
    };
    struct Outstanding {
        std::uint64_t line_address = 0;
        std::uint32_t sectors = 0;
        bool used = false;
    };
    void write_stage(std::uint64_t cycle);
    bool commit(TwinQuad& q);
    void coalescing_write_stage(std::uint64_t cycle);
    void enter_write_queue(TwinQuad& q, std::uint64_t cycle);
    bool free_to_read(std::size_t place) const;
    void find_sources(std::size_t place);
    bool covers(const TwinQuad& older, const TwinQuad& younger, const LineAccess& wanted) const;
    void issue_stage(std::uint64_t cycle);
    void tag_stage(std::uint64_t cycle);
    bool check_line(TwinQuad& q, const LineAccess& access, std::uint64_t cycle);
    void flush_stage(std::uint64_t cycle);
    void send_stage(std::uint64_t cycle);
    void request(std::uint64_t line_address, std::uint32_t sectors, bool write, bool masked,
                 std::uint8_t surface, MemoryCause cause, const LineMask* dirty = nullptr);
    void write_back(const Eviction& eviction, MemoryCause cause);
    void fill(std::uint32_t id);
    bool conflicts(const TwinQuad& older, const TwinQuad& younger) const;
    const LineAccess& access(const TwinQuad& q, std::uint32_t line) const;
    // Requests that one line can need at worst: every other sector.
    std::size_t worst_requests() const {
        return (config_.cache.line_bytes / config_.cache.sector_bytes + 1) / 2;
    }
    std::size_t request_room() const { return config_.cache_request_queue - requests_.size(); }
    std::uint64_t now_cycle() const {
        return (wheel_.now() + config_.rop_period_ps - 1) / config_.rop_period_ps;
    }

    EventWheel& wheel_;
    const MachineConfig& config_;
    std::function<void()> wake_;
    std::function<void(QuadBatch*)> quad_done_;
    RopCache cache_;
    std::deque<TwinQuad> input_;
    std::deque<std::unique_ptr<TwinQuad>> flight_;  // oldest first: being written, waiting, being tagged
    std::vector<Miss> misses_;
    std::vector<Outstanding> outstanding_;  // reads sent or queued; a request's id is its place
    std::deque<MemoryRequest> requests_;
    std::deque<LineMask> masks_;                                    // theirs
    std::deque<std::pair<std::uint64_t, std::uint32_t>> arriving_;  // cycle and id, where the port is narrow
    std::uint64_t port_in_free_ = 0;
    bool alone_ = false;  // the youngest quad gave up its lines: none follows before it is written
    bool upstream_finished_ = false;
    bool flushed_ = false;
    int flush_from_ = 0;
    std::uint64_t units_free_ = 0;
    std::deque<std::shared_ptr<TwinWrite>> write_queue_;  // not yet written
    std::deque<std::shared_ptr<TwinWrite>> recent_;       // the last queued, which may be joined
    // First cycle in which a stage may work again: one line, one request a cycle.
    std::uint64_t write_next_ = 0, tag_next_ = 0, flush_next_ = 0, send_next_ = 0;
    std::uint64_t sent_ = kNever;  // cycle of the last request
    std::uint64_t end_ = 0;
    BytesByCause miss_port_;
};

}  // namespace ropsim
