// One partition of the twin, stage by stage.
#include "tests/model/twin_partition.h"

#include "base/error.h"

#include <algorithm>
#include <bit>

namespace ropsim {

TwinPartition::TwinPartition(const std::string& name, EventWheel& wheel, const MachineConfig& config,
                             const SurfaceMap& map, std::function<void()> wake,
                             std::function<void(QuadBatch*)> quad_done)
    : port(name.c_str(), wheel, *this, static_cast<int>(2 * config.mshrs + config.cache_request_queue)),
      wheel_(wheel),
      config_(config),
      wake_(std::move(wake)),
      quad_done_(std::move(quad_done)),
      cache_(config.cache),
      miss_port_(static_cast<std::size_t>(map.surfaces())) {
    map.prepare(cache_);
}

void TwinPartition::push(QuadBatch* batch, std::uint32_t quad, std::uint64_t cycle) {
    TwinQuad q;
    q.batch = batch;
    q.quad = &batch->quads[quad];
    q.arrival = cycle + config_.crossbar_latency;
    input_.push_back(q);
}

const LineAccess& TwinPartition::access(const TwinQuad& q, std::uint32_t line) const {
    return q.batch->lines[q.quad->partition][q.quad->first_line + line];
}

// Later stages first, so that a place freed in a cycle can be taken in it.
void TwinPartition::tick(std::uint64_t cycle) {
    for (; !arriving_.empty() && arriving_.front().first <= cycle; arriving_.pop_front())
        fill(arriving_.front().second);
    write_stage(cycle);
    issue_stage(cycle);
    write_stage(cycle);  // a result that takes no time is written from the cycle of its issue on
    tag_stage(cycle);
    flush_stage(cycle);
    send_stage(cycle);
}

// Results leave in order, a cycle a line; all lines of a quad become visible after its last.
void TwinPartition::write_stage(std::uint64_t cycle) {
    if (config_.hazards.write_coalescing != 0) return coalescing_write_stage(cycle);
    while (!flight_.empty()) {
        TwinQuad& q = *flight_.front();
        if (!q.result || *q.result > cycle) return;
        if (!q.unwritten) {
            q.unwritten = 0;
            for (std::uint32_t l = 0; l < q.quad->line_count; ++l)
                *q.unwritten += access(q, l).write_bytes.any() ? 1 : 0;
        }
        if (*q.unwritten > 0) {
            if (cycle < write_next_) return;
            *q.unwritten -= std::min(*q.unwritten, config_.cache_ports);
            write_next_ = cycle + 1;
            return;
        }
        if (cycle < write_next_) return;  // its last line is being written
        if (!commit(q)) return;
        end_ = std::max(end_, cycle + 1);
        quad_done_(q.batch);
        flight_.pop_front();
    }
}

// The same with a queue of lines, in which a result finds those that are still to be written.
void TwinPartition::coalescing_write_stage(std::uint64_t cycle) {
    for (const auto& q : flight_) {
        if (q->entered) continue;
        if (!q->result || *q->result > cycle) break;
        enter_write_queue(*q, cycle);
    }
    if (cycle >= write_next_ && !write_queue_.empty()) {
        const void* quad = write_queue_.front()->quad;
        for (std::uint32_t p = 0; p < config_.cache_ports && !write_queue_.empty(); ++p) {
            if (write_queue_.front()->quad != quad) break;
            write_queue_.front()->cycle = cycle;
            write_queue_.pop_front();
        }
        write_next_ = cycle + 1;
    }
    while (!flight_.empty() && flight_.front()->entered) {
        TwinQuad& q = *flight_.front();
        for (const auto& w : q.writes)
            if (!w->cycle || *w->cycle >= cycle) return;
        if (!commit(q)) return;
        end_ = std::max(end_, cycle + 1);
        quad_done_(q.batch);
        flight_.pop_front();
    }
}

void TwinPartition::enter_write_queue(TwinQuad& q, std::uint64_t cycle) {
    q.entered = true;
    for (std::uint32_t l = 0; l < q.quad->line_count; ++l) {
        const LineAccess& a = access(q, l);
        if (!a.write_bytes.any()) continue;
        auto write = std::find_if(recent_.begin(), recent_.end(), [&](const auto& w) {
            return w->line_address == a.line_address && w->surface == a.surface &&
                   (!w->cycle || *w->cycle >= cycle);
        });
        if (write != recent_.end()) {
            q.writes.push_back(*write);
            continue;
        }
        q.writes.push_back(std::make_shared<TwinWrite>(TwinWrite{a.line_address, a.surface, &q, {}}));
        write_queue_.push_back(q.writes.back());
        recent_.push_back(q.writes.back());
        if (recent_.size() > config_.hazards.write_coalescing) recent_.pop_front();
    }
}

bool TwinPartition::commit(TwinQuad& q) {
    // A quad that gave up lines takes them one after the other again: none may stand in the way of the next.
    if (alone_) {
        for (const int line : q.pinned) cache_.unpin(line);
        q.pinned.clear();
    }
    for (; q.committed < q.quad->line_count; ++q.committed) {
        const LineAccess& a = access(q, q.committed);
        if (!a.write_bytes.any()) continue;
        int line = cache_.probe(a.line_address, a.surface);
        if (line == RopCache::kMiss) {
            if (request_room() < worst_requests()) return false;
            Eviction eviction;
            line = cache_.allocate(a.line_address, a.surface, &eviction);
            CHECK(line != RopCache::kMiss);
            write_back(eviction, MemoryCause::kWriteBack);
        }
        cache_.touch(line);
        cache_.write(line, a.write_bytes);
    }
    for (const int line : q.pinned) cache_.unpin(line);
    alone_ = false;
    return true;
}

bool TwinPartition::conflicts(const TwinQuad& older, const TwinQuad& younger) const {
    if (older.quad->kind == QuadKind::kCopy || younger.quad->kind == QuadKind::kCopy) return false;
    const std::uint32_t unit = config_.hazards.interlock == HazardConfig::Interlock::kTile ? 16 : 1;
    if (older.quad->quad_id / unit != younger.quad->quad_id / unit) return false;
    if (config_.hazards.interlock == HazardConfig::Interlock::kPixel)
        return (older.quad->pixels & younger.quad->pixels) != 0;
    return older.quad->pixels != 0 && younger.quad->pixels != 0;
}

// Nothing older must be written before operands can be read; results of the same quad are forwarded, if they
// are at all.
bool TwinPartition::free_to_read(std::size_t place) const {
    const TwinQuad& q = *flight_[place];
    for (std::size_t o = 0; o < place; ++o) {
        const bool same = flight_[o]->quad->quad_id == q.quad->quad_id;
        if (conflicts(*flight_[o], q) && !(config_.hazards.forward_results && same)) return false;
    }
    return true;
}

void TwinPartition::find_sources(std::size_t place) {
    TwinQuad& q = *flight_[place];
    for (std::size_t o = 0; o < place; ++o)
        if (conflicts(*flight_[o], q)) q.sources.push_back(flight_[o].get());
    if (q.sources.empty()) return;
    q.from_cache = false;
    for (std::uint32_t l = 0; l < q.quad->line_count; ++l) {
        const LineAccess& wanted = access(q, l);
        bool covered = wanted.read_sectors == 0;
        for (std::size_t o = 0; o < place; ++o) covered |= covers(*flight_[o], q, wanted);
        q.from_cache |= !covered;
    }
}

// Every pixel, and every sector either read or written by an operation that writes the line.
bool TwinPartition::covers(const TwinQuad& older, const TwinQuad& younger, const LineAccess& wanted) const {
    if (older.quad->kind == QuadKind::kCopy || older.quad->quad_id != younger.quad->quad_id) return false;
    if ((older.quad->pixels & younger.quad->pixels) != younger.quad->pixels) return false;
    for (std::uint32_t l = 0; l < older.quad->line_count; ++l) {
        const LineAccess& has = access(older, l);
        if (has.line_address != wanted.line_address || has.surface != wanted.surface) continue;
        if (!has.write_bytes.any()) continue;
        std::uint32_t known = has.read_sectors;
        for (std::uint32_t b = 0; b < config_.cache.line_bytes; ++b)
            if ((has.write_bytes.word[b / 64] >> (b % 64) & 1) != 0)
                known |= 1u << (b / config_.cache.sector_bytes);
        if ((wanted.read_sectors & ~known) == 0) return true;
    }
    return false;
}

// Operands are read as soon as they are here and nothing older writes the same pixels; operations start in
// order.
void TwinPartition::issue_stage(std::uint64_t cycle) {
    bool in_order = true;
    for (std::size_t i = 0; i < flight_.size(); ++i) {
        TwinQuad& q = *flight_[i];
        if (q.result) continue;
        if (!q.tagged) return;
        if (!q.read && q.missing == 0 && q.tagged_cycle < cycle) {
            if (free_to_read(i)) {
                q.read = cycle;
                find_sources(i);
            }
        }
        bool here = q.read && cycle >= *q.read + (q.from_cache ? config_.cache_hit_latency : 0);
        for (std::size_t o = 0; o < i; ++o)
            if (std::ranges::count(q.sources, flight_[o].get()) != 0)
                here &= flight_[o]->result && *flight_[o]->result <= cycle;
        if (in_order && here && cycle >= units_free_) {
            q.result = cycle + q.quad->latency;
            units_free_ = cycle + q.quad->interval;
            end_ = std::max(end_, units_free_);
        } else {
            in_order = false;
        }
    }
}

// In order, one line a cycle.
void TwinPartition::tag_stage(std::uint64_t cycle) {
    if (cycle < tag_next_) return;
    if (flight_.empty() || flight_.back()->tagged) {
        if (input_.empty() || input_.front().arrival > cycle) return;
        if (flight_.size() == config_.quads_in_flight || alone_) return;
        flight_.push_back(std::make_unique<TwinQuad>(input_.front()));
        input_.pop_front();
    }
    TwinQuad& q = *flight_.back();
    for (std::uint32_t p = 0; p < config_.cache_ports && q.lines_checked < q.quad->line_count; ++p) {
        if (!check_line(q, access(q, q.lines_checked), cycle)) {
            if (p == 0) return;
            break;
        }
        ++q.lines_checked;
    }
    tag_next_ = cycle + 1;
    end_ = std::max(end_, cycle + 1);
    if (q.lines_checked == q.quad->line_count) {
        q.tagged = true;
        q.tagged_cycle = cycle;
    }
}

bool TwinPartition::check_line(TwinQuad& q, const LineAccess& a, std::uint64_t cycle) {
    int line = cache_.probe(a.line_address, a.surface);
    auto miss = std::find_if(misses_.begin(), misses_.end(),
                             [&](const Miss& m) { return m.line_address == a.line_address; });
    const bool here = line != RopCache::kMiss && (a.read_sectors & ~cache_.valid_sectors(line)) == 0;
    if (!here) {
        // Room for the worst is made sure of before anything is changed, whether it turns out to be needed or
        // not.
        if (a.read_sectors != 0 && miss == misses_.end() && misses_.size() == config_.mshrs) return false;
        // What is sent in a cycle makes room in the next.
        if (request_room() < 2 * worst_requests() + (sent_ == cycle ? 1 : 0)) return false;
    }
    if (line == RopCache::kMiss) {
        Eviction eviction;
        line = cache_.allocate(a.line_address, a.surface, &eviction);
        if (line == RopCache::kMiss && flight_.size() == 1 && q.missing == 0) {
            // Its own lines hold the whole set and nobody else will make room.
            for (const int held : q.pinned) cache_.unpin(held);
            q.pinned.clear();
            alone_ = true;
            line = cache_.allocate(a.line_address, a.surface, &eviction);
        }
        if (line == RopCache::kMiss) return false;
        write_back(eviction, MemoryCause::kWriteBack);
    }
    cache_.touch(line);
    cache_.pin(line);
    q.pinned.push_back(line);
    const std::uint32_t fetch = cache_.request_sectors(line, a.read_sectors);
    if ((fetch | cache_.pending_sectors(line, a.read_sectors)) == 0) return true;
    if (miss == misses_.end()) miss = misses_.insert(misses_.end(), Miss{a.line_address, line, 0, {}});
    miss->sectors |= fetch;
    if (std::find(miss->waiting.begin(), miss->waiting.end(), &q) == miss->waiting.end()) {
        miss->waiting.push_back(&q);
        ++q.missing;
    }
    const MemoryCause cause = cause_of(q.quad->kind);
    request(a.line_address, fetch, false, false, a.surface, cause);
    return true;
}

// One request for each run of neighbouring sectors.
void TwinPartition::request(std::uint64_t line_address, std::uint32_t sectors, bool write, bool masked,
                            std::uint8_t surface, MemoryCause cause, const LineMask* dirty) {
    const std::uint32_t count = config_.cache.line_bytes / config_.cache.sector_bytes;
    for (std::uint32_t s = 0; s < count; ++s) {
        if ((sectors >> s & 1) == 0) continue;
        MemoryRequest r;
        r.address = line_address + std::uint64_t{s} * config_.cache.sector_bytes;
        r.write = write;
        r.masked = masked;
        r.surface = surface;
        r.cause = cause;
        std::uint32_t run = 0;
        for (; s < count && (sectors >> s & 1) != 0; ++s) {
            run |= 1u << s;
            r.bytes += config_.cache.sector_bytes;
        }
        CauseBytes& bytes = miss_port_[surface][static_cast<std::size_t>(cause)];
        (write ? bytes.write : bytes.read) += r.bytes;
        if (!write) {
            auto place = std::find_if(outstanding_.begin(), outstanding_.end(),
                                      [](const Outstanding& o) { return !o.used; });
            if (place == outstanding_.end()) place = outstanding_.insert(place, Outstanding{});
            *place = {line_address, run, true};
            r.id = static_cast<std::uint32_t>(place - outstanding_.begin());
        }
        LineMask mask;
        for (std::uint32_t b = 0; masked && b < r.bytes; ++b) {
            const std::uint64_t at = r.address - line_address + b;
            if ((dirty->word[at / 64] >> (at % 64) & 1) != 0)
                mask.word[b / 64] |= std::uint64_t{1} << (b % 64);
        }
        masks_.push_back(mask);
        requests_.push_back(r);
    }
    CHECK(requests_.size() <= config_.cache_request_queue);
}

void TwinPartition::write_back(const Eviction& eviction, MemoryCause cause) {
    const auto whole =
        static_cast<std::uint32_t>(std::popcount(eviction.sectors)) * config_.cache.sector_bytes;
    request(eviction.line_address, eviction.sectors, true, eviction.dirty_bytes < whole, eviction.surface,
            cause, &eviction.bytes);
}

// The end of the frame: one dirty line a cycle, set by set.
void TwinPartition::flush_stage(std::uint64_t cycle) {
    if (flushed_ || !upstream_finished_ || !input_.empty() || !flight_.empty()) return;
    if (cycle < flush_next_ || request_room() < worst_requests()) return;
    const int line = cache_.next_dirty(flush_from_);
    flushed_ = line == RopCache::kMiss;
    if (flushed_) return;
    write_back(cache_.clean(line), MemoryCause::kFlush);
    flush_from_ = line + 1;
    flush_next_ = cycle + 1;
    end_ = std::max(end_, cycle + 1);
    flushed_ = flush_from_ == cache_.line_count();
}

void TwinPartition::send_stage(std::uint64_t cycle) {
    if (requests_.empty() || cycle < send_next_ || !port.can_issue()) return;
    MemoryRequest r = requests_.front();
    const LineMask mask = masks_.front();
    if (r.masked) r.enables = &mask;
    requests_.pop_front();
    masks_.pop_front();
    const std::uint32_t width = config_.cache_port_bytes;
    sent_ = cycle;
    send_next_ = cycle + (r.write && width != 0 ? (r.bytes + width - 1) / width : 1);
    end_ = std::max(end_, send_next_);
    port.issue(r);
}

void TwinPartition::memory_done(std::uint32_t id, bool write) {
    end_ = std::max(end_, now_cycle());
    if (write) return;
    wake_();
    std::uint32_t cycles = 0;
    if (config_.cache_port_bytes != 0)
        for (std::uint32_t sectors = outstanding_[id].sectors, bytes = 0; sectors != 0;
             sectors &= sectors - 1) {
            bytes += config_.cache.sector_bytes;
            cycles = (bytes + config_.cache_port_bytes - 1) / config_.cache_port_bytes;
        }
    // The data went through the port as they came, unless it was still busy with others.
    port_in_free_ = std::max(now_cycle(), port_in_free_ + cycles);
    end_ = std::max(end_, port_in_free_);
    if (cycles == 0 || port_in_free_ == now_cycle())
        fill(id);
    else
        arriving_.emplace_back(port_in_free_, id);
}

void TwinPartition::fill(std::uint32_t id) {
    const Outstanding arrived = outstanding_[id];
    outstanding_[id].used = false;
    const auto miss = std::find_if(misses_.begin(), misses_.end(),
                                   [&](const Miss& m) { return m.line_address == arrived.line_address; });
    CHECK(miss != misses_.end());
    cache_.fill(miss->line, arrived.sectors);
    miss->sectors &= ~arrived.sectors;
    if (miss->sectors != 0) return;
    for (TwinQuad* q : miss->waiting) --q->missing;
    misses_.erase(miss);
}

bool TwinPartition::drained() const {
    return upstream_finished_ && input_.empty() && flight_.empty() && flushed_ && requests_.empty() &&
           port.in_flight() == 0;
}

}  // namespace ropsim
