// What caches before the shader cores read from, without a clock.
#pragma once

#include "memory/tlm_memory_port.h"
#include "model/compressed_surfaces.h"
#include "model/quad_operation.h"

namespace ropsim {

// A partition's memory for another unit of the machine: through the slice, if there is one, from its channel.
class UntimedMemory {
 public:
    virtual void read_for(const ByteSource& source, const MemoryRequest& request) = 0;
    // Of this partition, if anything is.
    virtual CompressedSurfaces* compressed() const { return nullptr; }

 protected:
    ~UntimedMemory() = default;
};

}  // namespace ropsim
