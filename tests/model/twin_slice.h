// The twin's L2 slice: one cycle's work at every ROP cycle. Shares only the tag store and the memory port.
#pragma once

#include "memory/l2_slice.h"
#include "memory/rop_cache.h"
#include "memory/tlm_memory_port.h"

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <tlm_utils/simple_target_socket.h>

namespace ropsim {

class TwinSlice : public sc_core::sc_module, public MemoryPortClient {
 public:
    TwinSlice(const sc_core::sc_module_name& name, EventWheel& wheel, const L2Config& config,
              Picoseconds period, std::function<void()> wake);

    tlm_utils::simple_target_socket<TwinSlice> socket;
    TlmMemoryPort port;
    // Everything this cycle does; harmless when called again in the same cycle.
    void tick(std::uint64_t cycle, bool frame_ended);
    bool drained() const;
    std::uint64_t end() const { return end_; }
    const RopCacheStatistics& cache_statistics() const { return cache_.statistics(); }
    std::uint64_t memory_bytes() const { return memory_bytes_; }

    void memory_done(std::uint32_t id, bool write) override;
    void memory_port_free() override { wake_(); }

 private:
    // A request cut into its lines.
    struct Piece {
        std::uint64_t line_address = 0;
        LineMask bytes;
    };
    struct Request {
        tlm::tlm_generic_payload* payload = nullptr;  // of a read
        std::deque<Piece> pieces;
        std::uint32_t bytes = 0;
        std::uint64_t busy_until = 0;  // a write: until its data are in
        bool started = false;
        bool write = false;
        std::uint8_t surface = 0;
        MemoryCause cause = MemoryCause::kFill;
        int missing = 0;
        bool looked_up = false;
    };
    struct Miss {
        std::uint64_t line_address = 0;
        int line = 0;
        std::uint32_t sectors = 0;
        std::vector<std::shared_ptr<Request>> waiting;
    };
    struct Answer {
        std::uint64_t cycle;
        std::shared_ptr<Request> read;
    };
    tlm::tlm_sync_enum forward(tlm::tlm_generic_payload& payload, tlm::tlm_phase& phase, sc_core::sc_time&);
    void take(tlm::tlm_generic_payload& payload);
    void admit_waiting();
    void look_up(std::uint64_t cycle);
    bool look_up_piece(const std::shared_ptr<Request>& request, const Piece& piece);
    void done(const std::shared_ptr<Request>& read, std::uint64_t cycle);
    void request(std::uint64_t line_address, std::uint32_t sectors, MemoryRequest common);
    void write_back(const Eviction& eviction, MemoryCause cause);
    std::size_t worst() const { return (c_.cache.line_bytes / c_.cache.sector_bytes + 1) / 2; }
    std::size_t room() const { return c_.request_queue - requests_.size(); }
    std::uint64_t transfer(std::uint32_t bytes) const {
        return (bytes + c_.bytes_per_cycle - 1) / c_.bytes_per_cycle;
    }

    EventWheel& wheel_;
    L2Config c_;
    Picoseconds period_;
    std::function<void()> wake_;
    RopCache cache_;
    std::deque<std::shared_ptr<Request>> input_;
    tlm::tlm_generic_payload* held_back_ = nullptr;
    std::vector<Miss> misses_;
    std::vector<std::pair<std::uint64_t, std::uint32_t>> outstanding_;  // by id: line address and sectors
    std::deque<Answer> answers_;
    std::deque<MemoryRequest> requests_;
    int reads_ = 0;  // between look-up and answer
    bool flushed_ = false;
    int flush_from_ = 0;
    std::uint64_t look_up_next_ = 0, data_next_ = 0, flush_next_ = 0, send_next_ = 0;
    std::uint64_t end_ = 0;
    std::uint64_t memory_bytes_ = 0;
};

}  // namespace ropsim
