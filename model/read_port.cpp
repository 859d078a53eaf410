#include "model/read_port.h"

#include "model/read_cache.h"

namespace ropsim {

ReadPort::ReadPort(const sc_core::sc_module_name& name, EventWheel& wheel, Picoseconds rop_period,
                   int surfaces, int requests, TrafficBreakdown& breakdown)
    : port(name, wheel, *this, requests),
      wheel_(wheel),
      wheel_id_(wheel.add(*this)),
      period_(rop_period),
      bytes_(static_cast<std::size_t>(surfaces)),
      breakdown_(breakdown) {}

void ReadPort::read(ReadCache& cache, const MemoryRequest& request, const ByteSource& source) {
    if (free_.empty()) {
        free_.push_back(static_cast<std::uint32_t>(readers_.size()));
        readers_.emplace_back();
    }
    requests_.push_back(request);
    requests_.back().id = free_.back();
    readers_[free_.back()] = {&cache, request.id};
    free_.pop_back();
    bytes_[request.surface][static_cast<std::size_t>(request.cause)].read += request.bytes;
    breakdown_.add(source, request.bytes, false);
    wheel_.arm(wheel_id_, wheel_.now());
}

Picoseconds ReadPort::step(Picoseconds now) {
    if (requests_.empty() || !port.can_issue()) return kNever;
    const Picoseconds edge = (now + period_ - 1) / period_ * period_;
    if (std::max(edge, next_) > now) return std::max(edge, next_);
    const MemoryRequest request = requests_.front();
    requests_.pop_front();
    next_ = now + period_;
    port.issue(request);
    return requests_.empty() ? kNever : next_;
}

void ReadPort::memory_done(std::uint32_t id, bool /*write*/) {
    const Reader reader = readers_[id];
    free_.push_back(id);
    reader.cache->fill(reader.id);
}

}  // namespace ropsim
