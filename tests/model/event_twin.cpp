#include "tests/model/event_twin.h"

#include <algorithm>
#include <bit>

#include "base/error.h"

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
    for (int s = 0; s < map.surfaces(); ++s)
        if (map.starts_clear(s)) cache_.set_clear_range(map.first_address(s), map.address_bytes(s));
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
    write_stage(cycle);
    issue_stage(cycle);
    write_stage(cycle);  // a result that takes no time is written from the cycle of its issue on
    tag_stage(cycle);
    flush_stage(cycle);
    send_stage(cycle);
}

// Results leave in order, a cycle a line; all lines of a quad become visible after its last.
void TwinPartition::write_stage(std::uint64_t cycle) {
    while (!flight_.empty()) {
        TwinQuad& q = *flight_.front();
        if (!q.result || *q.result > cycle) return;
        if (!q.unwritten) {
            q.unwritten = 0;
            for (std::uint32_t l = 0; l < q.quad->line_count; ++l) *q.unwritten += access(q, l).write_bytes.any() ? 1 : 0;
        }
        if (*q.unwritten > 0) {
            if (cycle < write_next_) return;
            --*q.unwritten;
            write_next_ = cycle + 1;
            return;
        }
        if (cycle < write_next_) return;  // its last line is being written
        if (!commit(q, cycle)) return;
        end_ = std::max(end_, cycle + 1);
        quad_done_(q.batch);
        flight_.pop_front();
    }
}

bool TwinPartition::commit(TwinQuad& q, std::uint64_t cycle) {
    // A quad that gave up lines takes them one after the other again: none may stand in the way of the next.
    if (alone_) {
        for (const int line : q.pinned) cache_.unpin(line);
        q.pinned.clear();
    }
    for (; q.committed < q.quad->line_count; ++q.committed) {
        const LineAccess& a = access(q, q.committed);
        if (!a.write_bytes.any()) continue;
        int line = cache_.probe(a.line_address);
        if (line == RopCache::kMiss) {
            if (request_room() < worst_requests()) return false;
            Eviction eviction;
            line = cache_.allocate(a.line_address, a.surface, &eviction, cycle);
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
    if (older.quad->quad_id != younger.quad->quad_id) return false;
    if (config_.interlock_per_pixel) return (older.quad->pixels & younger.quad->pixels) != 0;
    return older.quad->pixels != 0 && younger.quad->pixels != 0;
}

// Operands are read as soon as they are here and nothing older writes the same pixels; operations start in order.
void TwinPartition::issue_stage(std::uint64_t cycle) {
    bool in_order = true;
    for (std::size_t i = 0; i < flight_.size(); ++i) {
        TwinQuad& q = *flight_[i];
        if (q.result) continue;
        if (!q.tagged) return;
        if (!q.read && q.missing == 0 && q.tagged_cycle < cycle) {
            bool free = true;
            for (std::size_t o = 0; o < i; ++o) free &= !conflicts(*flight_[o], q);
            if (free) q.read = cycle;
        }
        if (in_order && q.read && cycle >= *q.read + config_.cache_hit_latency && cycle >= units_free_) {
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
    if (q.lines_checked < q.quad->line_count) {
        if (!check_line(q, access(q, q.lines_checked))) return;
        ++q.lines_checked;
    }
    tag_next_ = cycle + 1;
    end_ = std::max(end_, cycle + 1);
    if (q.lines_checked == q.quad->line_count) {
        q.tagged = true;
        q.tagged_cycle = cycle;
    }
}

bool TwinPartition::check_line(TwinQuad& q, const LineAccess& a) {
    int line = cache_.probe(a.line_address);
    auto miss = std::find_if(misses_.begin(), misses_.end(), [&](const Miss& m) { return m.line_address == a.line_address; });
    const bool here = line != RopCache::kMiss && (a.read_sectors & ~cache_.valid_sectors(line)) == 0;
    if (!here) {
        // Room for the worst is made sure of before anything is changed, whether it turns out to be needed or not.
        if (a.read_sectors != 0 && miss == misses_.end() && misses_.size() == config_.mshrs) return false;
        if (request_room() < 2 * worst_requests()) return false;
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
    const MemoryCause cause = q.quad->kind == QuadKind::kCopy ? MemoryCause::kCopy : MemoryCause::kFill;
    request(a.line_address, fetch, false, false, a.surface, cause);
    return true;
}

// One request for each run of neighbouring sectors.
void TwinPartition::request(std::uint64_t line_address, std::uint32_t sectors, bool write, bool masked,
                            std::uint8_t surface, MemoryCause cause) {
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
            auto place = std::find_if(outstanding_.begin(), outstanding_.end(), [](const Outstanding& o) { return !o.used; });
            if (place == outstanding_.end()) place = outstanding_.insert(place, Outstanding{});
            *place = {line_address, run, true};
            r.id = static_cast<std::uint32_t>(place - outstanding_.begin());
        }
        requests_.push_back(r);
    }
    CHECK(requests_.size() <= config_.cache_request_queue);
}

void TwinPartition::write_back(const Eviction& eviction, MemoryCause cause) {
    const auto whole = static_cast<std::uint32_t>(std::popcount(eviction.sectors)) * config_.cache.sector_bytes;
    request(eviction.line_address, eviction.sectors, true, eviction.dirty_bytes < whole, eviction.surface, cause);
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
    const MemoryRequest r = requests_.front();
    requests_.pop_front();
    send_next_ = cycle + 1;
    end_ = std::max(end_, cycle + 1);
    port.issue(r);
}

void TwinPartition::memory_done(std::uint32_t id, bool write) {
    end_ = std::max(end_, now_cycle());
    if (write) return;
    wake_();
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

namespace {

// Shader cores: a window of quads; raster and ALUs work them off one after the other; each leaves for its partition
// in raster order of that partition.
class TwinFrontEnd {
   public:
    TwinFrontEnd(const MachineConfig& config, Frame& frame) : config_(config), frame_(frame), lanes_(config.partitions) {}

    void tick(std::uint64_t cycle, std::vector<std::unique_ptr<TwinPartition>>& partitions) {
        const Picoseconds now = cycle * config_.rop_period_ps;
        while (window_ < config_.shader_quads_in_flight && fetch()) launch(now);
        std::uint32_t exported = 0;
        for (std::uint32_t i = 0; i < config_.partitions && exported < config_.export_quads_per_cycle; ++i) {
            const std::uint32_t p = (turn_ + i) % config_.partitions;
            if (lanes_[p].empty() || lanes_[p].front().ready > now || !partitions[p]->has_room()) continue;
            partitions[p]->push(lanes_[p].front().batch, lanes_[p].front().quad, cycle);
            lanes_[p].pop_front();
            ++exported;
        }
        window_ -= exported;
        // Whoever had the first turn in a cycle that exported goes last in the next.
        if (exported > 0) {
            turn_ = (turn_ + 1) % config_.partitions;
            end_ = cycle + 1;
        }
        if (ended_ && window_ == 0)
            for (auto& p : partitions) p->upstream_finished();
    }
    void quad_done(QuadBatch* batch) {
        if (--batch->unfinished > 0) return;
        std::erase_if(batches_, [&](const std::unique_ptr<QuadBatch>& b) { return b.get() == batch && b.get() != current_; });
    }
    std::uint64_t end() const { return end_; }

   private:
    struct Shading {
        QuadBatch* batch;
        std::uint32_t quad;
        Picoseconds ready;
    };
    bool fetch() {
        while (!ended_ && (current_ == nullptr || next_ == current_->quads.size())) {
            batches_.push_back(std::make_unique<QuadBatch>());
            current_ = batches_.back().get();
            ended_ = !frame_.advance(*current_);
            current_->unfinished = current_->quads.size();
            next_ = 0;
        }
        return !ended_;
    }
    void launch(Picoseconds now) {
        const QuadOperation& q = current_->quads[next_];
        Picoseconds ready = now;
        if (q.kind == QuadKind::kDraw || q.kind == QuadKind::kCulled) {
            const auto period = static_cast<long double>(config_.shader_period_ps);
            rastered_ = std::max<long double>(rastered_, static_cast<long double>(now)) + period / config_.raster_quads_per_cycle;
            ready = static_cast<Picoseconds>(rastered_);
            if (q.kind == QuadKind::kDraw) {
                shaded_ = std::max(shaded_, rastered_) + period * q.shader_lane_cycles / config_.shader_alu_lanes;
                ready = static_cast<Picoseconds>(shaded_) + config_.shader_latency * config_.shader_period_ps;
            }
        }
        lanes_[q.partition].push_back({current_, static_cast<std::uint32_t>(next_), ready});
        ++next_;
        ++window_;
    }

    const MachineConfig& config_;
    Frame& frame_;
    std::vector<std::deque<Shading>> lanes_;  // by partition
    std::vector<std::unique_ptr<QuadBatch>> batches_;
    QuadBatch* current_ = nullptr;
    std::size_t next_ = 0;
    bool ended_ = false;
    std::uint32_t window_ = 0;
    std::uint32_t turn_ = 0;
    long double rastered_ = 0;
    long double shaded_ = 0;
    std::uint64_t end_ = 0;
};

class TwinMachine : public sc_core::sc_module, public WheelUnit {
   public:
    TwinMachine(const sc_core::sc_module_name& name, Frame& frame, const MachineConfig& config)
        : sc_core::sc_module(name), wheel("wheel"), config_(config), front_end_(config, frame) {
        id_ = wheel.add(*this);
        for (std::uint32_t p = 0; p < config.partitions; ++p) {
            woken_.push_back(false);
            const auto wake = [this, p] {
                woken_[p] = true;
                wheel.arm(id_, wheel.now());
            };
            partitions.push_back(std::make_unique<TwinPartition>(fmt::format("port_{}", p), wheel, config, frame.surfaces(), wake,
                                                                 [this](QuadBatch* b) { front_end_.quad_done(b); }));
            channels.push_back(std::make_unique<DramChannel>(fmt::format("channel_{}", p).c_str(), wheel, config.dram));
            partitions.back()->port.socket.bind(channels.back()->socket);
        }
        wheel.arm(id_, 0);
    }

    Picoseconds step(Picoseconds now) override {
        const std::uint64_t cycle = now / config_.rop_period_ps;
        const Picoseconds following = (cycle + 1) * config_.rop_period_ps;
        if (now % config_.rop_period_ps != 0) return following;
        // Memory that speaks at the very edge of a cycle is heard in it, by the partition it spoke to.
        const bool again = cycle < next_cycle_;
        if (!again) front_end_.tick(cycle, partitions);
        next_cycle_ = cycle + 1;
        bool done = true;
        for (std::size_t p = 0; p < partitions.size(); ++p) {
            if (!again || woken_[p]) partitions[p]->tick(cycle);
            woken_[p] = false;
            done = done && partitions[p]->drained();
        }
        return done ? kNever : following;
    }
    std::uint64_t cycles() const {
        std::uint64_t end = std::max(front_end_.end(), (dram_end() + config_.rop_period_ps - 1) / config_.rop_period_ps);
        for (const auto& p : partitions) end = std::max(end, p->end());
        return end;
    }
    // The last data on any channel's pins.
    Picoseconds dram_end() const { return last_data_; }
    void note_last_data(Picoseconds time) { last_data_ = std::max(last_data_, time); }

    EventWheel wheel;
    std::vector<std::unique_ptr<TwinPartition>> partitions;
    std::vector<std::unique_ptr<DramChannel>> channels;

   private:
    const MachineConfig& config_;
    TwinFrontEnd front_end_;
    int id_;
    std::uint64_t next_cycle_ = 0;
    std::vector<bool> woken_;  // by partition: memory has spoken since its last tick
    Picoseconds last_data_ = 0;
};

// When data last moved on a channel: column commands tell, as they are issued.
class LastData : public DramCommandTrace {
   public:
    LastData(TwinMachine& machine, const DramConfig& dram) : machine_(machine), dram_(dram) {}
    void command(DramCycle cycle, DramCommand command, std::uint32_t, std::uint32_t, std::uint32_t) override {
        if (command == DramCommand::kRead) machine_.note_last_data((cycle + dram_.cl + dram_.burst) * dram_.tck_ps);
        if (command == DramCommand::kWrite) machine_.note_last_data((cycle + dram_.cwl + dram_.burst) * dram_.tck_ps);
    }

   private:
    TwinMachine& machine_;
    const DramConfig& dram_;
};

}  // namespace

MachineResult run_event_twin(Frame& frame, const MachineConfig& config) {
    use_picosecond_resolution();
    TwinMachine machine("twin", frame, config);
    LastData last_data(machine, config.dram);
    for (auto& channel : machine.channels) channel->set_trace(&last_data);
    sc_core::sc_start();
    MachineResult result;
    result.timed = true;
    result.rop_cycles = machine.cycles();
    result.miss_port.resize(static_cast<std::size_t>(frame.surfaces().surfaces()));
    for (const auto& p : machine.partitions) {
        CHECK(p->drained(), "the twin stopped early");
        result.cache.add(p->cache_statistics());
        for (std::size_t s = 0; s < result.miss_port.size(); ++s)
            for (std::size_t c = 0; c < kMemoryCauses; ++c) {
                result.miss_port[s][c].read += p->miss_port()[s][c].read;
                result.miss_port[s][c].write += p->miss_port()[s][c].write;
            }
    }
    return result;
}

}  // namespace ropsim
