// What a port asks a memory for, and how the two speak when both are stepped by one wheel: plain calls at the
// wheel's time. They say what the phases of TLM's base protocol say (tlm_memory_port.h), at a fraction of the
// cost.
#pragma once

#include "memory/memory_cause.h"
#include "memory/rop_cache.h"

#include <cstdint>

namespace ropsim {

// What a request is for.
struct MemoryRequest {
    std::uint64_t address = 0;  // bytes, in the channel's own address space
    std::uint32_t bytes = 0;    // 1..kMaxRequestBytes, within one line
    bool write = false;
    bool masked = false;  // write: some of the bytes are not enabled
    // Of a masked write: bit b is the byte at address + b; null: not told. Read by issue(), not kept.
    const LineMask* enables = nullptr;
    std::uint8_t surface = 0;
    MemoryCause cause = MemoryCause::kFill;
    std::uint32_t id = 0;  // handed back on completion
};

// Who has asked. Neither call comes from inside request().
class LinkedPort {
 public:
    virtual ~LinkedPort() = default;
    // The request that was held is queued (END_REQ).
    virtual void request_taken() = 0;
    // A read's data are here, or a write that was held is done (BEGIN_RESP). `id`: the request's.
    virtual void request_done(std::uint32_t id, bool write) = 0;
};

class LinkedMemory {
 public:
    enum class Answer {
        kDone,    // a posted write
        kQueued,  // a read: request_done() follows
        kHeld,    // there is no room: request_taken() follows, then request_done(); no other request before
    };
    virtual ~LinkedMemory() = default;
    // At the wheel's time.
    virtual Answer request(LinkedPort& from, const MemoryRequest& request) = 0;
};

}  // namespace ropsim
