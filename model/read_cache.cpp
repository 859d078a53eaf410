#include "model/read_cache.h"

#include "base/error.h"
#include "model/front_end.h"
#include "model/read_port.h"

#include <algorithm>

namespace ropsim {

ReadCache::ReadCache(EventWheel& wheel, const ReadCacheConfig& config, Picoseconds rop_period,
                     std::vector<ReadPort*> ports, std::uint64_t base, CompressedSurfaces* compressed,
                     FrontEnd& front_end, int unit)
    : wheel_(wheel),
      wheel_id_(wheel.add(*this)),
      config_(config),
      period_(rop_period),
      ports_(std::move(ports)),
      base_(base),
      compressed_(compressed),
      front_end_(front_end),
      unit_(unit),
      cache_(config.cache),
      misses_(config.mshrs) {}

void ReadCache::push(const ByteSource& source, Picoseconds arrival) {
    const std::size_t pushed = lines_.size() - lines_pushed_;
    lines_pushed_ = lines_.size();
    jobs_.push_back({source, edge(arrival), static_cast<std::uint32_t>(pushed), 0, 0, 0, kNever});
    if (next_job_ + 1 == first_job_ + jobs_.size())
        wheel_.arm(wheel_id_, std::max({edge(arrival), tags_free_, edge(wheel_.now())}));
}

void ReadCache::take() {
    CHECK(!jobs_.empty() && jobs_.front().known != kNever);
    jobs_.pop_front();
    ++first_job_;
    if (label_ == StageLabel::kSlotsFull) wheel_.arm(wheel_id_, edge(wheel_.now()));
}

// Looks up the next job whose time has come; stops where a miss register, a way or a place is wanting, and is
// woken by what frees it.
Picoseconds ReadCache::step(Picoseconds now) {
    if (now % period_ != 0) return edge(now);
    if (tags_free_ > now) return tags_free_;
    account_.charge(now / period_, label_);
    label_ = StageLabel::kIdle;
    if (next_job_ == first_job_ + jobs_.size()) return kNever;
    if (next_job_ - first_job_ == config_.jobs) {
        label_ = StageLabel::kSlotsFull;
        return kNever;
    }
    Job& next = job(next_job_);
    if (next.arrival > now) return next.arrival;
    for (; next.lines > 0; --next.lines, ++next.looked_up) {
        if (!look_up(next, next_job_, lines_.front())) return kNever;
        lines_.pop_front();
        --lines_pushed_;
    }
    const std::uint32_t cycles =
        std::max(1u, (next.looked_up + config_.lines_per_cycle - 1) / config_.lines_per_cycle);
    tags_free_ = now + cycles * period_;
    account_.charge(tags_free_ / period_, StageLabel::kBusy);
    next.answer = std::max(next.answer, tags_free_ - period_ + config_.latency * period_);
    ++next_job_;
    publish();
    return next_job_ == first_job_ + jobs_.size() ? kNever : tags_free_;
}

bool ReadCache::look_up(Job& job, std::uint64_t number, const LineRead& read) {
    int line = cache_.probe(read.address, read.surface);
    const bool misses = line == RopCache::kMiss || (read.sectors & ~cache_.valid_sectors(line)) != 0;
    auto miss = std::find_if(misses_.begin(), misses_.end(), [&](const Miss& m) {
        return m.sectors != 0 && m.address == read.address && m.surface == read.surface;
    });
    if (misses && miss == misses_.end() && misses_out_ == misses_.size()) {
        label_ = StageLabel::kMshrsFull;
        return false;
    }
    if (line == RopCache::kMiss) {
        Eviction clean;
        line = cache_.allocate(read.address, read.surface, &clean);
        if (line == RopCache::kMiss) {
            label_ = StageLabel::kCacheWays;
            return false;
        }
    }
    cache_.touch(line);
    if (!misses) {
        cache_.request_sectors(line, read.sectors);
        return true;
    }
    if (miss == misses_.end()) {
        miss = std::find_if(misses_.begin(), misses_.end(), [](const Miss& m) { return m.sectors == 0; });
        miss->address = read.address;
        miss->line = line;
        miss->surface = read.surface;
        miss->waiting.clear();
        ++misses_out_;
    }
    MemoryRequest request;
    request.cause = config_.cause;
    request.id = static_cast<std::uint32_t>(miss - misses_.begin());
    miss->sectors |= for_missing(cache_, line, read, request, compressed_,
                                 [&](const MemoryRequest& r) { send(r, job.source); });
    if (miss->waiting.empty() || miss->waiting.back() != number) {
        miss->waiting.push_back(number);
        ++job.missing;
    }
    return true;
}

void ReadCache::send(MemoryRequest request, const ByteSource& source) {
    ReadPort* port = ports_.front();
    if (ports_.size() > 1) {
        const std::uint64_t piece = request.address / kInterleave;
        port = ports_[piece % ports_.size()];
        request.address = base_ + piece / ports_.size() * kInterleave + request.address % kInterleave;
    } else {
        request.address += base_;
    }
    port->read(*this, request, source);
}

void ReadCache::fill(std::uint32_t id) {
    Miss& miss = misses_[id >> kFillRegisterShift];
    const std::uint32_t sectors = fill_sectors(id) & miss.sectors;
    cache_.fill(miss.line, sectors);
    miss.sectors &= ~sectors;
    if (miss.sectors != 0) return;
    --misses_out_;
    const Picoseconds answer = edge(wheel_.now()) + config_.latency * period_;
    for (const std::uint64_t number : miss.waiting) {
        Job& waiting = job(number);
        waiting.answer = std::max(waiting.answer, answer);
        --waiting.missing;
    }
    publish();
    if (label_ == StageLabel::kMshrsFull || label_ == StageLabel::kCacheWays)
        wheel_.arm(wheel_id_, edge(wheel_.now()));
}

void ReadCache::publish() {
    const bool first_was_known = published_ > first_job_;
    for (; published_ < next_job_ && job(published_).missing == 0; ++published_) {
        last_known_ = std::max(last_known_, job(published_).answer);
        job(published_).known = last_known_;
    }
    if (!first_was_known && published_ > first_job_) front_end_.reads_known(unit_, jobs_.front().known);
}

}  // namespace ropsim
