#include "memory/metadata_cache.h"

#include "base/error.h"

#include <bit>

namespace ropsim {

MetadataCache::MetadataCache(const MetadataConfig& config, std::uint64_t base, std::uint32_t block_bytes)
    : cache_({config.size_bytes, config.ways, kLineBytes, kSectorBytes}),
      base_(base),
      block_bytes_(block_bytes),
      bits_(config.bits) {
    CHECK(base % kLineBytes == 0, "{:#x}", base);
}

std::uint64_t MetadataCache::bytes_for(const MetadataConfig& config, std::uint64_t memory_bytes,
                                       std::uint32_t block_bytes) {
    if (config.size_bytes == 0) return 0;
    const std::uint64_t bytes = (memory_bytes + block_bytes - 1) / block_bytes * config.bits / 8 + 1;
    return (bytes + kLineBytes - 1) / kLineBytes * kLineBytes;
}

void MetadataCache::set_clear(std::uint64_t first, std::uint64_t bytes) {
    cache_.set_clear_range(state_address(first), state_address(first + bytes) - state_address(first));
}

bool MetadataCache::holds(std::uint64_t address) const {
    const std::uint64_t at = state_address(address);
    const std::uint32_t sector = 1u << (at % kLineBytes / kSectorBytes);
    return (cache_.known_sectors(at / kLineBytes * kLineBytes, 0) & sector) != 0;
}

// Of a line at most two sectors are dirty, and they are neighbours: one write.
MetadataCache::Traffic MetadataCache::written(const Eviction& eviction) {
    Traffic out;
    if (eviction.sectors == 0) return out;
    out.write_address =
        eviction.line_address + static_cast<std::uint64_t>(std::countr_zero(eviction.sectors)) * kSectorBytes;
    out.write_bytes = static_cast<std::uint32_t>(std::popcount(eviction.sectors)) * kSectorBytes;
    return out;
}

MetadataCache::Traffic MetadataCache::look_up(std::uint64_t address, bool changes) {
    const std::uint64_t at = state_address(address);
    const std::uint64_t line_address = at / kLineBytes * kLineBytes;
    const auto sector = static_cast<std::uint32_t>(at % kLineBytes / kSectorBytes);
    Traffic out;
    int line = cache_.probe(line_address, 0);
    if (line == RopCache::kMiss) {
        Eviction eviction;
        line = cache_.allocate(line_address, 0, &eviction);
        CHECK(line != RopCache::kMiss);
        out = written(eviction);
    }
    cache_.touch(line);
    const std::uint32_t missing = cache_.request_sectors(line, 1u << sector);
    if (missing != 0) {
        out.read_address = line_address + std::uint64_t{sector} * kSectorBytes;
        out.read_bytes = kSectorBytes;
        cache_.fill(line, missing);
    }
    if (changes) cache_.write(line, sector * kSectorBytes, kSectorBytes);
    return out;
}

MetadataCache::Traffic MetadataCache::write_back() {
    return written(cache_.clean(cache_.next_dirty(0)));
}

}  // namespace ropsim
