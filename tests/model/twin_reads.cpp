#include "tests/model/twin_reads.h"

#include "base/error.h"

#include <algorithm>

namespace ropsim {

void TwinReadPort::read(TwinReadCache& cache, std::uint64_t line, const MemoryRequest& request) {
    const auto offset = static_cast<std::uint32_t>(request.id);  // in the line
    requests_.push_back(request);
    requests_.back().id = static_cast<std::uint32_t>(asked_.size());
    asked_.push_back({&cache, line, offset / cache.sector_bytes(), request.bytes});
    bytes_[request.surface][static_cast<std::size_t>(request.cause)].read += request.bytes;
}

void TwinReadPort::tick(std::uint64_t cycle) {
    if (requests_.empty() || cycle < next_ || !port.can_issue()) return;
    const MemoryRequest request = requests_.front();
    requests_.pop_front();
    next_ = cycle + 1;
    port.issue(request);
}

void TwinReadPort::memory_done(std::uint32_t id, bool /*write*/) {
    const Asked& a = asked_[id];
    a.cache->fill(a.line, a.first_sector, a.bytes / a.cache->sector_bytes());
    wake_();
}

void TwinReadCache::push(std::vector<LineRead> lines, Picoseconds arrival) {
    Job job;
    job.lines = std::move(lines);
    job.arrival = arrival;
    jobs_.push_back(std::move(job));
}

// Answers leave in order, so what comes before does not matter to the first.
bool TwinReadCache::answered(Picoseconds now) const {
    return !jobs_.empty() && jobs_.front().done && jobs_.front().waiting.empty() &&
           jobs_.front().answer * period_ <= now;
}

// One job a cycle starts; one with more lines than a cycle takes keeps the tags busy.
void TwinReadCache::tick(std::uint64_t cycle) {
    if (cycle < tags_free_) return;
    std::size_t place = 0;
    while (place < jobs_.size() && jobs_[place].done) ++place;
    if (place == jobs_.size() || place == config_.jobs) return;
    Job& job = jobs_[place];
    if (job.arrival > cycle * period_) return;
    for (; job.looked_up < job.lines.size(); ++job.looked_up)
        if (!look_up(job, job.lines[job.looked_up])) return;
    const std::size_t cycles =
        std::max<std::size_t>(1, (job.lines.size() + config_.lines_per_cycle - 1) / config_.lines_per_cycle);
    tags_free_ = cycle + cycles;
    job.answer = std::max(job.answer, tags_free_ - 1 + config_.latency);
    job.done = true;
}

bool TwinReadCache::look_up(Job& job, const LineRead& read) {
    int line = cache_.probe(read.address, read.surface);
    const bool here = line != RopCache::kMiss && (read.sectors & ~cache_.valid_sectors(line)) == 0;
    if (!here && !misses_.contains(read.address) && misses_.size() == config_.mshrs) return false;
    if (line == RopCache::kMiss) {
        Eviction nothing;
        line = cache_.allocate(read.address, read.surface, &nothing);
        if (line == RopCache::kMiss) return false;
    }
    cache_.touch(line);
    const std::uint32_t fetch = cache_.request_sectors(line, read.sectors);
    if (here) return true;
    misses_.insert(read.address);
    job.waiting.insert(read.address);
    const std::uint32_t bytes = config_.cache.sector_bytes;
    for (std::uint32_t s = 0; s < config_.cache.line_bytes / bytes; ++s) {
        if ((fetch >> s & 1) == 0) continue;
        const std::uint32_t first = s;
        while (s + 1 < config_.cache.line_bytes / bytes && (fetch >> (s + 1) & 1) != 0) ++s;
        const auto [port, address] = locate_(read.address + std::uint64_t{first} * bytes);
        MemoryRequest request;
        request.address = address;
        request.bytes = (s - first + 1) * bytes;
        request.surface = read.surface;
        request.cause = config_.cause;
        request.id = first * bytes;
        port->read(*this, read.address, request);
    }
    return true;
}

void TwinReadCache::fill(std::uint64_t line, std::uint32_t first_sector, std::uint32_t sectors) {
    const int at = cache_.probe(line, jobs_.front().lines.front().surface);
    CHECK(at != RopCache::kMiss);
    cache_.fill(at, ((2u << (sectors - 1)) - 1u) << first_sector);
    if (cache_.pending_sectors(at, cache_.all_sectors()) != 0) return;
    misses_.erase(line);
    const std::uint64_t answer = (wheel_.now() + period_ - 1) / period_ + config_.latency;
    for (Job& job : jobs_)
        if (job.waiting.erase(line) > 0) job.answer = std::max(job.answer, answer);
}

}  // namespace ropsim
