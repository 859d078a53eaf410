// What a memory request is for: a TLM extension that travels with the payload and never changes its timing.
#pragma once

#include "memory/memory_cause.h"
#include "memory/rop_cache.h"

#include <cstdint>
#include <tlm>

namespace ropsim {

// Ignorable: a target that does not know it treats the request as surface 0, fill or write-back, unmasked.
struct RequestTag : tlm::tlm_extension<RequestTag> {
    std::uint32_t id = 0;      // the initiator's name for the request (slot, MSHR, ...)
    std::uint8_t surface = 0;  // < kMaxSurfaces
    bool masked = false;       // a write whose byte enables leave bytes of it untouched
    MemoryCause cause = MemoryCause::kFill;
    bool has_enables = false;
    LineMask enables;  // of a masked write: bit b is the byte at address + b

    tlm::tlm_extension_base* clone() const override { return new RequestTag(*this); }
    void copy_from(const tlm::tlm_extension_base& other) override {
        *this = static_cast<const RequestTag&>(other);
    }
};

}  // namespace ropsim
