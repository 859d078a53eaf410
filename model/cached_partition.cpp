#include "model/cached_partition.h"

#include "base/error.h"

#include <algorithm>
#include <bit>

namespace ropsim {

CachedPartition::CachedPartition(const MachineConfig& config, const SurfaceMap& map)
    : config_(config),
      cache_(config.cache),
      port_(static_cast<std::size_t>(map.surfaces())),
      pins_(static_cast<std::size_t>(map.surfaces())) {
    for (int s = 0; s < map.surfaces(); ++s)
        if (map.starts_clear(s)) cache_.set_clear_range(map.first_address(s), map.address_bytes(s));
}

void CachedPartition::operate(const QuadOperation& q, const std::vector<LineAccess>& lines) {
    tag_cycles_ += std::max(1u, q.line_count);
    operation_cycles_ += q.interval;
    const MemoryCause cause = cause_of(q.kind);
    for (std::uint32_t l = 0; l < q.line_count; ++l) {
        const LineAccess& access = lines[q.first_line + l];
        const int line = present(access);
        const std::uint32_t missing = cache_.request_sectors(line, access.read_sectors);
        if (missing != 0) {
            move(access.line_address, missing, false, access.surface, cause);
            cache_.fill(line, missing);
        }
        if (access.write_bytes.any()) cache_.write(line, access.write_bytes);
    }
}

void CachedPartition::flush() {
    cache_.flush(
        [this](const Eviction& e) { move(e.line_address, e.sectors, true, e.surface, MemoryCause::kFlush); });
}

int CachedPartition::present(const LineAccess& access) {
    int line = cache_.probe(access.line_address);
    if (line == RopCache::kMiss) {
        Eviction e;
        line = cache_.allocate(access.line_address, access.surface, &e);
        CHECK(line != RopCache::kMiss);
        if (e.sectors != 0) move(e.line_address, e.sectors, true, e.surface, MemoryCause::kWriteBack);
    }
    cache_.touch(line);
    return line;
}

// Sectors over the miss port, and the whole bursts they take on the pins.
void CachedPartition::move(std::uint64_t line_address, std::uint32_t sectors, bool write,
                           std::uint8_t surface, MemoryCause cause) {
    const std::uint32_t sector_bytes = config_.cache.sector_bytes;
    const std::uint64_t burst_bytes = config_.dram.burst_bytes();
    while (sectors != 0) {
        const auto first = static_cast<std::uint32_t>(std::countr_zero(sectors));
        const auto length = static_cast<std::uint32_t>(std::countr_one(sectors >> first));
        const std::uint64_t begin = line_address + std::uint64_t{first} * sector_bytes;
        const std::uint64_t bytes = std::uint64_t{length} * sector_bytes;
        const std::uint64_t bursts = (begin + bytes + burst_bytes - 1) / burst_bytes - begin / burst_bytes;
        bursts_ += bursts;
        CauseBytes& port = port_[surface][static_cast<std::size_t>(cause)];
        CauseBytes& pins = pins_[surface][static_cast<std::size_t>(cause)];
        (write ? port.write : port.read) += bytes;
        (write ? pins.write : pins.read) += bursts * burst_bytes;
        sectors &= ~(~0u >> (32 - length) << first);
    }
}

}  // namespace ropsim
