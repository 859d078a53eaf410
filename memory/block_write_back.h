// What leaves a ROP cache for memory when some of a compressed block does.
#pragma once

#include "memory/compressed_memory.h"
#include "memory/rop_cache.h"

#include <cstdint>

namespace ropsim {

// Traffic of one write-back: first the read, if any, then the write.
struct BlockWriteBack {
    std::uint32_t repack_bytes = 0;  // of the compressed block that is read, from its start; 0: none
    std::uint32_t write_bytes = 0;   // of the block, from its start; 0: the eviction's sectors as they are
    bool tried = false;              // the codec was at work on it
};

// Decides how the block of an evicted (or flushed) line is written, and brings cache and memory up to date:
// - all of the block is known on chip (here, in the block's other lines, or still clear): it is compressed;
// - some is not and memory has the block compressed: that is read (a repack), and the whole compressed anew;
// - some is not and memory has it raw: the dirty sectors are written as they are, and it stays raw.
// `sticky`: a raw block is never compressed again (ATTILA). A block that compresses is written whole, so the
// block's other lines become clean; one that does not is written whole only if memory had it compressed.
BlockWriteBack write_back_block(RopCache& cache, CompressedMemory& memory, const Eviction& eviction,
                                bool sticky);

}  // namespace ropsim
