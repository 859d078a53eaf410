// The twin's L2 slice, stage by stage.
#include "tests/model/twin_slice.h"

#include "base/error.h"

#include <algorithm>
#include <bit>

namespace ropsim {

TwinSlice::TwinSlice(const sc_core::sc_module_name& name, EventWheel& wheel, const L2Config& config,
                     Picoseconds period, std::function<void()> wake)
    : sc_core::sc_module(name),
      socket("socket"),
      port("port", wheel, *this, static_cast<int>(2 * config.mshrs + config.request_queue)),
      wheel_(wheel),
      c_(config),
      period_(period),
      wake_(std::move(wake)),
      cache_(config.cache) {
    socket.register_nb_transport_fw(this, &TwinSlice::forward);
}

tlm::tlm_sync_enum TwinSlice::forward(tlm::tlm_generic_payload& payload, tlm::tlm_phase& phase,
                                      sc_core::sc_time&) {
    ++wheel_.inside_calls().forward;
    wake_();
    if (phase == tlm::END_RESP) return tlm::TLM_COMPLETED;
    payload.acquire();
    if (input_.size() == c_.input_queue) {
        held_back_ = &payload;
        return tlm::TLM_ACCEPTED;
    }
    take(payload);
    if (payload.is_write()) {
        payload.set_response_status(tlm::TLM_OK_RESPONSE);
        payload.release();
        return tlm::TLM_COMPLETED;
    }
    phase = tlm::END_REQ;
    return tlm::TLM_UPDATED;
}

// Byte by byte: which line it is in, and whether the write means it.
void TwinSlice::take(tlm::tlm_generic_payload& payload) {
    const RequestTag& tag = *payload.get_extension<RequestTag>();
    auto r = std::make_shared<Request>();
    r->write = payload.is_write();
    r->surface = tag.surface;
    r->cause = tag.cause;
    r->bytes = payload.get_data_length();
    if (!r->write) r->payload = &payload;
    for (std::uint32_t b = 0; b < r->bytes; ++b) {
        const std::uint64_t address = payload.get_address() + b;
        const std::uint64_t line = address / c_.cache.line_bytes * c_.cache.line_bytes;
        if (r->pieces.empty() || r->pieces.back().line_address != line) r->pieces.push_back({line, {}});
        if (r->write && tag.masked && (tag.enables.word[b / 64] >> (b % 64) & 1) == 0) continue;
        const std::uint64_t at = address - line;
        r->pieces.back().bytes.word[at / 64] |= std::uint64_t{1} << (at % 64);
    }
    input_.push_back(r);
}

void TwinSlice::admit_waiting() {
    if (held_back_ == nullptr || input_.size() == c_.input_queue) return;
    tlm::tlm_generic_payload& payload = *held_back_;
    held_back_ = nullptr;
    take(payload);
    payload.set_response_status(tlm::TLM_OK_RESPONSE);
    tlm::tlm_phase phase = payload.is_write() ? tlm::BEGIN_RESP : tlm::END_REQ;
    sc_core::sc_time delay = wheel_.local_delay();
    const bool write = payload.is_write();
    socket->nb_transport_bw(payload, phase, delay);
    if (write) payload.release();
}

void TwinSlice::tick(std::uint64_t cycle, bool frame_ended) {
    for (; !answers_.empty() && answers_.front().cycle <= cycle; answers_.pop_front()) {
        --reads_;
        tlm::tlm_generic_payload& payload = *answers_.front().read->payload;
        payload.set_response_status(tlm::TLM_OK_RESPONSE);
        tlm::tlm_phase phase = tlm::BEGIN_RESP;
        sc_core::sc_time delay = wheel_.local_delay();
        socket->nb_transport_bw(payload, phase, delay);
        payload.release();
    }
    admit_waiting();
    look_up(cycle);
    admit_waiting();
    if (c_.flush && frame_ended && !flushed_ && input_.empty() && held_back_ == nullptr && reads_ == 0 &&
        cycle >= flush_next_ && room() >= worst()) {
        const int line = cache_.next_dirty(flush_from_);
        flushed_ = line == RopCache::kMiss;
        if (!flushed_) {
            write_back(cache_.clean(line), MemoryCause::kFlush);
            flush_from_ = line + 1;
            flushed_ = flush_from_ == cache_.line_count();
            flush_next_ = cycle + 1;
            end_ = std::max(end_, cycle + 1);
        }
    }
    if (!requests_.empty() && cycle >= send_next_ && port.can_issue()) {
        const MemoryRequest r = requests_.front();
        requests_.pop_front();
        send_next_ = cycle + 1;
        end_ = std::max(end_, cycle + 1);
        port.issue(r);
    }
}

void TwinSlice::look_up(std::uint64_t cycle) {
    if (input_.empty() || cycle < look_up_next_) return;
    const std::shared_ptr<Request> r = input_.front();
    if (!r->started) {
        if (!r->write && reads_ == 64) return;
        r->started = true;
        reads_ += r->write ? 0 : 1;
        // As many cycles as its lines, or its data if those take longer.
        const std::uint64_t data = r->write ? transfer(r->bytes) : 0;
        r->busy_until = data > r->pieces.size() ? data - r->pieces.size() : 0;
    }
    if (!look_up_piece(r, r->pieces.front())) return;
    r->pieces.pop_front();
    look_up_next_ = cycle + 1;
    if (r->pieces.empty()) {
        look_up_next_ += r->busy_until;
        r->looked_up = true;
        input_.pop_front();
        if (!r->write && r->missing == 0) done(r, cycle);
    }
    end_ = std::max(end_, look_up_next_);
}

bool TwinSlice::look_up_piece(const std::shared_ptr<Request>& r, const Piece& piece) {
    int line = cache_.probe(piece.line_address, r->surface);
    std::uint32_t sectors = 0;
    for (std::uint32_t b = 0; b < c_.cache.line_bytes; ++b)
        if ((piece.bytes.word[b / 64] >> (b % 64) & 1) != 0) sectors |= 1u << (b / c_.cache.sector_bytes);
    auto miss = std::find_if(misses_.begin(), misses_.end(),
                             [&](const Miss& m) { return m.line_address == piece.line_address; });
    const bool here = line != RopCache::kMiss && (sectors & ~cache_.valid_sectors(line)) == 0;
    if (!r->write && !here) {
        if (miss == misses_.end() && misses_.size() == c_.mshrs) return false;
        if (room() < 2 * worst()) return false;
    }
    if (line == RopCache::kMiss) {
        if (room() < worst()) return false;
        Eviction eviction;
        line = cache_.allocate(piece.line_address, r->surface, &eviction);
        if (line == RopCache::kMiss) return false;
        write_back(eviction, MemoryCause::kWriteBack);
    }
    cache_.touch(line);
    if (r->write) {
        cache_.write(line, piece.bytes);
        return true;
    }
    const std::uint32_t fetch = cache_.request_sectors(line, sectors);
    if ((fetch | cache_.pending_sectors(line, sectors)) == 0) return true;
    if (miss == misses_.end()) miss = misses_.insert(miss, Miss{piece.line_address, line, 0, {}});
    miss->sectors |= fetch;
    miss->waiting.push_back(r);
    ++r->missing;
    MemoryRequest fill;
    fill.surface = r->surface;
    fill.cause = r->cause;
    request(piece.line_address, fetch, fill);
    return true;
}

// A read's data leave one read after the other.
void TwinSlice::done(const std::shared_ptr<Request>& read, std::uint64_t cycle) {
    data_next_ = std::max(cycle + c_.latency, data_next_) + transfer(read->bytes);
    answers_.push_back({data_next_, read});
    end_ = std::max(end_, data_next_);
}

void TwinSlice::request(std::uint64_t line_address, std::uint32_t sectors, MemoryRequest common) {
    const std::uint32_t size = c_.cache.sector_bytes;
    for (std::uint32_t s = 0; s < c_.cache.line_bytes / size; ++s) {
        if ((sectors >> s & 1) == 0) continue;
        MemoryRequest r = common;
        r.address = line_address + std::uint64_t{s} * size;
        std::uint32_t run = 0;
        for (; s < c_.cache.line_bytes / size && (sectors >> s & 1) != 0; ++s) {
            run |= 1u << s;
            r.bytes += size;
        }
        if (!r.write) {
            r.id = static_cast<std::uint32_t>(outstanding_.size());
            outstanding_.emplace_back(line_address, run);
        }
        memory_bytes_ += r.bytes;
        requests_.push_back(r);
    }
    CHECK(requests_.size() <= c_.request_queue);
}

void TwinSlice::write_back(const Eviction& eviction, MemoryCause cause) {
    MemoryRequest r;
    r.write = true;
    // What the channel can forward from a queued write depends on whether it has every byte.
    r.masked = eviction.dirty_bytes <
               static_cast<std::uint32_t>(std::popcount(eviction.sectors)) * c_.cache.sector_bytes;
    r.surface = eviction.surface;
    r.cause = cause;
    request(eviction.line_address, eviction.sectors, r);
}

void TwinSlice::memory_done(std::uint32_t id, bool write) {
    const std::uint64_t cycle = (wheel_.now() + period_ - 1) / period_;
    end_ = std::max(end_, cycle);
    if (write) return;
    wake_();
    const auto [address, sectors] = outstanding_[id];
    const auto miss = std::find_if(misses_.begin(), misses_.end(),
                                   [at = address](const Miss& m) { return m.line_address == at; });
    CHECK(miss != misses_.end());
    cache_.fill(miss->line, sectors);
    miss->sectors &= ~sectors;
    if (miss->sectors != 0) return;
    const std::vector<std::shared_ptr<Request>> waiting = miss->waiting;
    misses_.erase(miss);
    for (const auto& read : waiting)
        if (--read->missing == 0 && read->looked_up) done(read, cycle);
}

bool TwinSlice::drained() const {
    return input_.empty() && held_back_ == nullptr && reads_ == 0 && requests_.empty() &&
           port.in_flight() == 0 && (flushed_ || !c_.flush);
}

}  // namespace ropsim
