#include "model/cached_partition.h"

#include "base/error.h"
#include "memory/block_write_back.h"
#include "memory/sector_runs.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace ropsim {

CachedPartition::CachedPartition(const MachineConfig& config, const SurfaceMap& map,
                                 std::unique_ptr<CompressedSurfaces> compressed, TrafficBreakdown* breakdown)
    : config_(config),
      cache_(config.cache),
      compressed_(std::move(compressed)),
      breakdown_(breakdown),
      port_(static_cast<std::size_t>(map.surfaces())),
      pins_(static_cast<std::size_t>(map.surfaces())),
      burst_shift_(static_cast<std::uint32_t>(std::countr_zero(config.dram.burst_bytes()))) {
    map.prepare(cache_);
    for (std::uint32_t sectors = 1; sectors < run_port_cycles_.size(); ++sectors)
        run_port_cycles_[sectors] = config.port_cycles(sectors * config.cache.sector_bytes);
    if (config.l2.present()) l2_.emplace(config.l2);
}

void CachedPartition::operate(const QuadOperation& q, const QuadBatch& batch) {
    tag_cycles_ += std::max(1u, config_.line_cycles(q.line_count));
    operation_cycles_ += q.interval;
    const MemoryCause cause = cause_of(q.kind);
    const ByteSource source = batch.source(q);
    const LineAccess* lines = batch.lines[q.partition].data() + q.first_line;
    for (std::uint32_t l = 0; l < q.line_count; ++l) {
        const LineAccess& access = lines[l];
        int line = cache_.probe(access.line_address, access.surface);
        if (line == RopCache::kMiss) line = allocate(access);
        cache_.touch(line);
        if (access.read_sectors != 0) fetch(access, line, cause, source);
        if (access.write_sectors == 0) continue;
        cache_.write(line, access.write_bytes, access.write_sectors, std::bit_cast<std::uint64_t>(source));
        if (access.values != LineAccess::kNoValues)
            compressed_->memory.write(access.surface, access.line_address, access.write_bytes,
                                      &batch.values[q.partition][access.values]);
    }
}

// The sectors that are missing; of a compressed block the line whole, since that comes out of the
// decompressor.
void CachedPartition::fetch(const LineAccess& access, int line, MemoryCause cause, const ByteSource& source) {
    if (compressed_ != nullptr && (access.read_sectors & ~cache_.valid_sectors(line)) != 0) {
        moved_for_ = source;
        look_up_state(access.surface, access.line_address, false);
    }
    std::uint32_t missing = cache_.request_sectors(line, access.read_sectors);
    if (missing == 0) return;
    moved_for_ = source;
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
    moved_for_ = std::bit_cast<ByteSource>(e.writer);
    if (compressed_ == nullptr) return move(e.line_address, e.sectors, true, e.surface, cause, &e);
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
        move(e.line_address, e.sectors, true, e.surface, cause, &e);
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
    // Sectors hold the states of several surfaces: they go to the first, and to no tile.
    moved_for_ = breakdown_ != nullptr ? breakdown_->end_of_frame() : ByteSource{};
    if (compressed_ != nullptr && compressed_->metadata)
        while (compressed_->metadata->dirty()) move_metadata(compressed_->metadata->write_back(), 0);
    if (l2_)
        for (const MemoryRequest& request : l2_->flush()) to_memory(request);
}

int CachedPartition::allocate(const LineAccess& access) {
    Eviction e;
    const int line = cache_.allocate(access.line_address, access.surface, &e);
    CHECK(line != RopCache::kMiss);
    write_back(e, MemoryCause::kWriteBack);
    return line;
}

// Sectors over the miss port, a request for each run of them; from there on to the slice or the pins.
void CachedPartition::move(std::uint64_t line_address, std::uint32_t sectors, bool write,
                           std::uint8_t surface, MemoryCause cause, const Eviction* eviction) {
    const auto c = static_cast<std::size_t>(cause);
    if (!l2_) return move_runs(line_address, sectors, write, port_[surface][c], pins_[surface][c]);
    MemoryRequest common;
    if (eviction != nullptr) common = write_back_request(*eviction, config_.cache.sector_bytes, cause);
    common.write = write;
    common.surface = surface;
    common.cause = cause;
    for_each_run(line_address, sectors, config_.cache.sector_bytes, common,
                 eviction != nullptr ? &eviction->bytes : nullptr,
                 [this](const MemoryRequest& request) { move(request); });
}

// The same straight to the pins, where nobody asks which bytes of a sector are written.
void CachedPartition::move_runs(std::uint64_t line_address, std::uint32_t sectors, bool write,
                                CauseBytes& port, CauseBytes& pins) {
    std::uint32_t useful = 0;
    std::uint64_t bursts = 0;
    while (sectors != 0) {
        const SectorRun run = take_run(sectors);
        const std::uint64_t address = line_address + std::uint64_t{run.first} * config_.cache.sector_bytes;
        const std::uint32_t bytes = run.length * config_.cache.sector_bytes;
        useful += bytes;
        bursts += ((address + bytes - 1) >> burst_shift_) - (address >> burst_shift_) + 1;
        port_cycles_[write ? 1 : 0] += run_port_cycles_[run.length];
    }
    (write ? port.write : port.read) += useful;
    (write ? pins.write : pins.read) += bursts << burst_shift_;
    bursts_ += bursts;
    if (breakdown_ != nullptr) breakdown_->add(moved_for_, useful, write);
}

void CachedPartition::move_bytes(std::uint64_t address, std::uint32_t bytes, bool write, std::uint8_t surface,
                                 MemoryCause cause) {
    move({.address = address, .bytes = bytes, .write = write, .surface = surface, .cause = cause});
}

void CachedPartition::move(const MemoryRequest& request) {
    port_cycles_[request.write ? 1 : 0] += config_.port_cycles(request.bytes);
    pass_on(request);
}

void CachedPartition::pass_on(const MemoryRequest& request) {
    CauseBytes& port = port_[request.surface][static_cast<std::size_t>(request.cause)];
    (request.write ? port.write : port.read) += request.bytes;
    if (breakdown_ != nullptr) breakdown_->add(moved_for_, request.bytes, request.write);
    if (!l2_) return to_memory(request);
    for (const MemoryRequest& below : l2_->access(request)) to_memory(below);
}

// The whole bursts that a request takes on the pins.
void CachedPartition::to_memory(const MemoryRequest& request) {
    const std::uint64_t bursts =
        ((request.address + request.bytes - 1) >> burst_shift_) - (request.address >> burst_shift_) + 1;
    bursts_ += bursts;
    CauseBytes& pins = pins_[request.surface][static_cast<std::size_t>(request.cause)];
    (request.write ? pins.write : pins.read) += bursts << burst_shift_;
}

}  // namespace ropsim
