// A slice of the second-level cache: the piece of it between one ROP partition's cache and its memory
// channel.
#pragma once

#include "memory/event_wheel.h"
#include "memory/initiators.h"
#include "memory/l2_statistics.h"
#include "memory/mshr_table.h"
#include "memory/rop_cache.h"
#include "memory/tlm_memory_port.h"

#include <cstdint>
#include <tlm>
#include <vector>

#include <tlm_utils/multi_passthrough_target_socket.h>

namespace ropsim {

struct L2Config {
    RopCacheConfig cache;                // size_bytes 0: there is no slice
    std::uint32_t latency = 0;           // cycles from the look-up to the first data of a hit
    std::uint32_t bytes_per_cycle = 64;  // between the slice and whoever asks it, each way
    std::uint32_t mshrs = 32;            // lines with misses outstanding
    std::uint32_t input_queue = 16;      // requests that wait for their look-up
    std::uint32_t request_queue = 16;    // requests between slice and memory port
    bool flush = true;                   // dirty bytes go to memory at the end of the frame

    bool present() const { return cache.size_bytes != 0; }
};

// Target of any number of initiators, initiator to memory; AT base protocol on both sides, as DramChannel and
// TlmMemoryPort speak it. A request is any byte range of up to kMaxRequestBytes; it is looked up in order, a
// line of the slice a cycle, and waits at the head of the queue while something that a miss needs is taken.
// A read is answered `latency` cycles after its last look-up or its last fill, whichever is later, plus the
// cycles its bytes take; answers may overtake one another. A write is done when it is queued, allocates
// without a fetch, and keeps its byte enables (RequestTag's): bytes it does not enable stay unknown, and a
// read of them fetches and merges. Fills have the cause of the request that missed; dirty lines leave as
// write-backs, or as flush at the end of the frame, with the surface that allocated them.
//
// b_transport passes through to memory, `latency` later: it neither sees nor changes what the slice holds.
class L2Slice : public sc_core::sc_module, public MemoryPortClient {
 public:
    // `period`: a cycle, in ps.
    L2Slice(const sc_core::sc_module_name& name, EventWheel& wheel, const L2Config& config,
            Picoseconds period);

    tlm_utils::multi_passthrough_target_socket<L2Slice> socket;
    TlmMemoryPort port;

    // Nothing more comes: once everything is answered the slice flushes. Call once, during simulation.
    void end_of_frame();

    Picoseconds step(Picoseconds now);
    void memory_done(std::uint32_t id, bool write) override;
    void memory_port_free() override;

    // Nothing queued, in flight or, after end_of_frame(), left to flush.
    bool drained() const;
    // Cycle after the last thing the slice did.
    std::uint64_t last_cycle() const { return last_cycle_; }
    // Labels the cycles up to `total_cycles` and checks the sums. Call once, after the simulation.
    void finish(std::uint64_t total_cycles);
    const L2Statistics& statistics() const { return statistics_; }

 private:
    static constexpr int kMaxReads = 64;  // between look-up and answer
    struct Request {
        tlm::tlm_generic_payload* payload = nullptr;  // of a read
        int initiator = 0;
        std::uint64_t address = 0;
        std::uint32_t bytes = 0;
        std::uint32_t looked_up = 0;  // bytes of it
        bool write = false;
        bool masked = false;
        std::uint8_t surface = 0;
        MemoryCause cause = MemoryCause::kFill;
        LineMask enables;
    };
    struct Read {
        tlm::tlm_generic_payload* payload = nullptr;
        int initiator = 0;
        std::uint32_t bytes = 0;
        std::uint32_t misses = 0;  // miss registers it waits for
    };
    struct Answer {
        std::uint64_t cycle;
        std::uint32_t read;
    };

    static constexpr std::uint32_t kNoRead = ~0u;
    void end_of_elaboration() override { gates_.resize(socket.size()); }
    tlm::tlm_sync_enum forward(int initiator, tlm::tlm_generic_payload& payload, tlm::tlm_phase& phase,
                               sc_core::sc_time& delay);
    void blocking(int initiator, tlm::tlm_generic_payload& payload, sc_core::sc_time& delay);
    static bool refuse(tlm::tlm_generic_payload& payload);
    bool queue(tlm::tlm_generic_payload& payload, int initiator);
    void retry_held(Picoseconds now);
    tlm::tlm_sync_enum call(int initiator, tlm::tlm_generic_payload& payload, tlm::tlm_phase phase);
    void respond(int initiator, tlm::tlm_generic_payload& payload, std::uint32_t read);
    void send_waiting_responses();
    void responded(const ResponseGates::Response& response);
    std::uint64_t look_up(std::uint64_t cycle);
    bool look_up_line(Request& request, L2Label& reason);
    bool take_line(const Request& request, std::uint64_t line_address, int& line, L2Label& reason);
    std::uint32_t data_cycles(std::uint32_t bytes) const {
        return (bytes + config_.bytes_per_cycle - 1) / config_.bytes_per_cycle;
    }
    void charge(std::uint64_t until, L2Label label);
    void complete(std::uint32_t read, std::uint64_t cycle);
    void answer_reads(std::uint64_t cycle);
    void queue_requests(std::uint64_t line_address, std::uint32_t sectors, const MemoryRequest& common);
    void queue_write(const Eviction& eviction, MemoryCause cause);
    bool send_request(std::uint64_t cycle);
    void flush_line(std::uint64_t cycle);
    bool flushing() const;
    std::uint32_t request_room() const {
        return static_cast<std::uint32_t>(requests_.size()) - request_count_;
    }
    std::uint64_t cycle_at(Picoseconds time) const { return (time + period_ - 1) / period_; }

    L2Config config_;
    EventWheel& wheel_;
    Picoseconds period_;
    int wheel_id_;
    std::uint32_t worst_requests_;
    RopCache cache_;
    BasicMshrTable<std::uint64_t> mshrs_;

    std::vector<Request> input_;  // ring
    std::uint32_t input_head_ = 0;
    std::uint32_t input_count_ = 0;
    // Of a request that is held back; the payload is acquired.
    struct Waiting {
        tlm::tlm_generic_payload* payload;
        int initiator;
    };
    HeldRequests<Waiting> held_;
    std::uint64_t look_up_free_ = 0;
    std::uint32_t looked_up_lines_ = 0;  // of the request at the head
    L2Label label_ = L2Label::kIdle;

    std::vector<Read> reads_;
    std::vector<std::uint32_t> free_reads_;
    int current_ = -1;             // of the request that is being looked up
    std::vector<Answer> answers_;  // ring, in order of time
    std::uint32_t answer_head_ = 0;
    std::uint32_t answer_count_ = 0;
    std::uint64_t data_free_ = 0;
    ResponseGates gates_;

    std::vector<MemoryRequest> requests_;  // ring
    std::uint32_t request_head_ = 0;
    std::uint32_t request_count_ = 0;
    std::uint64_t request_free_ = 0;

    bool frame_ended_ = false;
    int flush_line_ = 0;
    std::uint64_t flush_free_ = 0;
    std::uint64_t last_cycle_ = 0;
    std::uint64_t labelled_ = 0;
    L2Statistics statistics_;
};

}  // namespace ropsim
