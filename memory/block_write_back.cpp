#include "memory/block_write_back.h"

namespace ropsim {

BlockWriteBack write_back_block(RopCache& cache, CompressedMemory& memory, const Eviction& eviction,
                                bool sticky) {
    const std::uint32_t line_bytes = cache.config().line_bytes;
    const std::uint64_t block = memory.block_of(eviction.line_address);
    const std::uint64_t end = block + memory.block_bytes();
    const auto padding = [&](std::uint64_t line) {
        return memory.padding(eviction.surface, line, line_bytes, cache.config().sector_bytes);
    };
    bool known = (eviction.resident_sectors | padding(eviction.line_address)) == cache.all_sectors();
    for (std::uint64_t line = block; line < end; line += line_bytes)
        if (line != eviction.line_address)
            known &= (cache.known_sectors(line, eviction.surface) | padding(line)) == cache.all_sectors();

    using State = CompressedMemory::State;
    const State before = memory.state(eviction.surface, block);
    BlockWriteBack out;
    if (before == State::kRaw && (sticky || !known)) {
        memory.keep_raw(eviction.surface, block);
        return out;
    }
    if (!known && before == State::kCompressed) {
        out.repack_bytes = memory.stored_bytes(eviction.surface, block);
        memory.count_repack(eviction.surface);
    }
    out.tried = true;
    const std::uint32_t stored = memory.pack(eviction.surface, block);
    const bool compressed = stored < memory.block_bytes();
    if (!compressed && before != State::kCompressed) return out;
    out.write_bytes = stored;
    for (std::uint64_t line = block; line < end; line += line_bytes) {
        cache.forget_clear(line, eviction.surface);
        if (const int sibling = cache.probe(line, eviction.surface);
            sibling != RopCache::kMiss && line != eviction.line_address)
            cache.clean(sibling);
    }
    return out;
}

}  // namespace ropsim
