// A slice of the second-level cache without a clock: see untimed_l2.h.
#include "memory/untimed_l2.h"

#include "base/error.h"
#include "memory/sector_runs.h"

namespace ropsim {

const std::vector<MemoryRequest>& UntimedL2::access(const MemoryRequest& request) {
    below_.clear();
    ++(request.write ? statistics_.writes : statistics_.reads);
    PortBytes& counted = statistics_.looked_up[request.surface][static_cast<std::size_t>(request.cause)];
    (request.write ? counted.write : counted.read) += request.bytes;
    std::uint64_t lines = 0;
    for (std::uint32_t from = 0; from < request.bytes; ++lines) {
        const auto offset =
            static_cast<std::uint32_t>((request.address + from) & (config_.cache.line_bytes - 1));
        const std::uint32_t here = std::min(request.bytes - from, config_.cache.line_bytes - offset);
        look_up(request, from, here);
        from += here;
    }
    const std::uint64_t data = (request.bytes + config_.bytes_per_cycle - 1) / config_.bytes_per_cycle;
    look_up_cycles_ += request.write ? std::max(lines, data) : lines;
    if (!request.write) data_cycles_ += data;
    return below_;
}

// `bytes` of the request, from its byte `from` on, all in one line.
void UntimedL2::look_up(const MemoryRequest& request, std::uint32_t from, std::uint32_t bytes) {
    const std::uint64_t address = request.address + from;
    const auto offset = static_cast<std::uint32_t>(address & (config_.cache.line_bytes - 1));
    const std::uint64_t line_address = address - offset;
    int line = cache_.probe(line_address, request.surface);
    if (line == RopCache::kMiss) {
        Eviction eviction;
        line = cache_.allocate(line_address, request.surface, &eviction);
        CHECK(line != RopCache::kMiss);
        to_memory(eviction.line_address, eviction.sectors,
                  write_back_request(eviction, config_.cache.sector_bytes, MemoryCause::kWriteBack));
    }
    cache_.touch(line);
    if (request.write) {
        cache_.write(line, request.masked ? request.enables->part(from, bytes).raised(offset)
                                          : LineMask::range(offset, bytes));
        return;
    }
    const std::uint32_t missing = cache_.request_sectors(line, cache_.sectors_of(offset, bytes));
    MemoryRequest fill;
    fill.surface = request.surface;
    fill.cause = request.cause;
    to_memory(line_address, missing, fill);
    cache_.fill(line, missing);
}

void UntimedL2::to_memory(std::uint64_t line_address, std::uint32_t sectors, const MemoryRequest& common) {
    for_each_run(line_address, sectors, config_.cache.sector_bytes, common, nullptr,
                 [this](const MemoryRequest& request) {
                     PortBytes& bytes =
                         statistics_.memory[request.surface][static_cast<std::size_t>(request.cause)];
                     (request.write ? bytes.write : bytes.read) += request.bytes;
                     below_.push_back(request);
                 });
}

const std::vector<MemoryRequest>& UntimedL2::flush() {
    below_.clear();
    if (!config_.flush) return below_;
    cache_.flush([this](const Eviction& e) {
        to_memory(e.line_address, e.sectors,
                  write_back_request(e, config_.cache.sector_bytes, MemoryCause::kFlush));
    });
    return below_;
}

L2Statistics UntimedL2::statistics() const {
    L2Statistics s = statistics_;
    s.cache = cache_.statistics();
    return s;
}

}  // namespace ropsim
