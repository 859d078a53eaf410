#include "model/cached_partition.h"

#include "base/error.h"
#include "memory/block_write_back.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace ropsim {

CachedPartition::CachedPartition(const MachineConfig& config, const SurfaceMap& map,
                                 std::unique_ptr<CompressedSurfaces> compressed)
    : config_(config),
      cache_(config.cache),
      compressed_(std::move(compressed)),
      port_(static_cast<std::size_t>(map.surfaces())),
      pins_(static_cast<std::size_t>(map.surfaces())) {
    map.prepare(cache_);
}

void CachedPartition::operate(const QuadOperation& q, const QuadBatch& batch) {
    tag_cycles_ += std::max(1u, q.line_count);
    operation_cycles_ += q.interval;
    const MemoryCause cause = cause_of(q.kind);
    const LineAccess* lines = batch.lines[q.partition].data() + q.first_line;
    for (std::uint32_t l = 0; l < q.line_count; ++l) {
        const LineAccess& access = lines[l];
        const int line = present(access);
        fetch(access, line, cause);
        if (!access.write_bytes.any()) continue;
        cache_.write(line, access.write_bytes);
        if (access.values != LineAccess::kNoValues)
            compressed_->memory.write(access.surface, access.line_address, access.write_bytes,
                                      &batch.values[q.partition][access.values]);
    }
}

// The sectors that are missing; of a compressed block the line whole, since that comes out of the
// decompressor.
void CachedPartition::fetch(const LineAccess& access, int line, MemoryCause cause) {
    if (compressed_ != nullptr && (access.read_sectors & ~cache_.valid_sectors(line)) != 0)
        look_up_state(access.surface, access.line_address, false);
    std::uint32_t missing = cache_.request_sectors(line, access.read_sectors);
    if (missing == 0) return;
    if (compressed_ != nullptr && compressed_->memory.holds(access.surface) &&
        compressed_->memory.state(access.surface, access.line_address) ==
            CompressedMemory::State::kCompressed) {
        CompressedMemory& memory = compressed_->memory;
        missing |= cache_.request_rest(line);
        move_bytes(memory.block_of(access.line_address),
                   memory.stored_bytes(access.surface, access.line_address), false, access.surface, cause);
    } else {
        move(access.line_address, missing, false, access.surface, cause);
    }
    cache_.fill(line, missing);
}

void CachedPartition::write_back(const Eviction& e, MemoryCause cause) {
    if (e.sectors == 0) return;
    if (compressed_ == nullptr) return move(e.line_address, e.sectors, true, e.surface, cause);
    CompressedMemory& memory = compressed_->memory;
    BlockWriteBack block;
    if (memory.holds(e.surface)) block = write_back_block(cache_, memory, e, config_.compression.sticky);
    look_up_state(e.surface, e.line_address, true);
    const std::uint64_t address = memory.block_of(e.line_address);
    if (block.repack_bytes != 0)
        move_bytes(address, block.repack_bytes, false, e.surface, MemoryCause::kRepack);
    if (block.write_bytes != 0)
        move_bytes(address, block.write_bytes, true, e.surface, cause);
    else
        move(e.line_address, e.sectors, true, e.surface, cause);
}

void CachedPartition::look_up_state(int surface, std::uint64_t address, bool changes) {
    if (compressed_->has_states(surface))
        move_metadata(compressed_->metadata->look_up(address, changes), static_cast<std::uint8_t>(surface));
}

void CachedPartition::move_metadata(const MetadataCache::Traffic& traffic, std::uint8_t surface) {
    if (traffic.write_bytes != 0)
        move_bytes(traffic.write_address, traffic.write_bytes, true, surface, MemoryCause::kMetadata);
    if (traffic.read_bytes != 0)
        move_bytes(traffic.read_address, traffic.read_bytes, false, surface, MemoryCause::kMetadata);
}

void CachedPartition::flush() {
    cache_.flush([this](const Eviction& e) { write_back(e, MemoryCause::kFlush); });
    if (compressed_ == nullptr || !compressed_->metadata) return;
    // Sectors hold the states of several surfaces: they go to the first.
    while (compressed_->metadata->dirty()) move_metadata(compressed_->metadata->write_back(), 0);
}

int CachedPartition::present(const LineAccess& access) {
    int line = cache_.probe(access.line_address, access.surface);
    if (line == RopCache::kMiss) {
        Eviction e;
        line = cache_.allocate(access.line_address, access.surface, &e);
        CHECK(line != RopCache::kMiss);
        write_back(e, MemoryCause::kWriteBack);
    }
    cache_.touch(line);
    return line;
}

// Sectors over the miss port, and the whole bursts they take on the pins.
void CachedPartition::move(std::uint64_t line_address, std::uint32_t sectors, bool write,
                           std::uint8_t surface, MemoryCause cause) {
    const std::uint32_t sector_bytes = config_.cache.sector_bytes;
    while (sectors != 0) {
        const auto first = static_cast<std::uint32_t>(std::countr_zero(sectors));
        const auto length = static_cast<std::uint32_t>(std::countr_one(sectors >> first));
        move_bytes(line_address + std::uint64_t{first} * sector_bytes, std::uint64_t{length} * sector_bytes,
                   write, surface, cause);
        sectors &= ~(~0u >> (32 - length) << first);
    }
}

void CachedPartition::move_bytes(std::uint64_t address, std::uint64_t bytes, bool write, std::uint8_t surface,
                                 MemoryCause cause) {
    const std::uint64_t burst_bytes = config_.dram.burst_bytes();
    const std::uint64_t bursts = (address + bytes + burst_bytes - 1) / burst_bytes - address / burst_bytes;
    bursts_ += bursts;
    CauseBytes& port = port_[surface][static_cast<std::size_t>(cause)];
    CauseBytes& pins = pins_[surface][static_cast<std::size_t>(cause)];
    (write ? port.write : port.read) += bytes;
    (write ? pins.write : pins.read) += bursts * burst_bytes;
}

}  // namespace ropsim
