// A partition's second port to memory: what the front end's caches read of its channel.
#pragma once

#include "memory/event_wheel.h"
#include "memory/tlm_memory_port.h"
#include "model/byte_counts.h"
#include "model/traffic_breakdown.h"

#include <cstdint>
#include <deque>
#include <vector>

namespace ropsim {

class ReadCache;

// Requests of depth unit and texture caches leave one a ROP cycle, in order of arrival. The caches' miss
// registers bound how many wait.
class ReadPort : public MemoryPortClient {
 public:
    // `surfaces`: of the map. `requests`: how many may be in memory at once.
    ReadPort(const sc_core::sc_module_name& name, EventWheel& wheel, Picoseconds rop_period, int surfaces,
             int requests, TrafficBreakdown& breakdown);

    TlmMemoryPort port;
    // Asks for the request's bytes; its id is the cache's.
    void read(ReadCache& cache, const MemoryRequest& request, const ByteSource& source);
    const BytesByCause& bytes() const { return bytes_; }

    Picoseconds step(Picoseconds now);
    void memory_done(std::uint32_t id, bool write) override;
    void memory_port_free() override { wheel_.arm(wheel_id_, wheel_.now()); }

 private:
    struct Reader {
        ReadCache* cache;
        std::uint32_t id;
    };
    EventWheel& wheel_;
    int wheel_id_;
    Picoseconds period_;
    Picoseconds next_ = 0;                // when another may leave
    std::deque<MemoryRequest> requests_;  // ids are places in readers_
    std::vector<Reader> readers_;
    std::vector<std::uint32_t> free_;
    BytesByCause bytes_;
    TrafficBreakdown& breakdown_;
};

}  // namespace ropsim
