// A trace file taken apart and put together again with sizes and checksums that are right, so that mutations
// reach what lies behind the checksums.
#pragma once

#include "traces/trace_layout.h"

#include <optional>
#include <vector>

namespace ropsim::fuzz {

struct TraceParts {
    Bytes header;                     // JSON
    Bytes opaque;                     // section
    std::vector<ChunkRecord> chunks;  // of the index
    std::vector<BlockRecord> blocks;  // sizes and checksums are made anew by assemble()
    std::vector<Bytes> contents;      // of the blocks
    IndexRecord totals;               // numbers of chunks and blocks are made anew by assemble()
    Bytes tiles;                      // fragment counts, 8 bytes each
};

// Nothing where `data` is no trace file whose sections can be found.
std::optional<TraceParts> take_apart(const std::uint8_t* data, std::size_t size);
Bytes assemble(const TraceParts& parts);

}  // namespace ropsim::fuzz
