// The TLM side of a slice, its look-ups and its answers: see l2_slice.h.
#include "memory/l2_slice.h"

#include "base/error.h"

#include <algorithm>

namespace ropsim {

L2Slice::L2Slice(const sc_core::sc_module_name& name, EventWheel& wheel, const L2Config& config,
                 Picoseconds period)
    : sc_core::sc_module(name),
      socket("socket"),
      port("port", wheel, *this, static_cast<int>(2 * config.mshrs + config.request_queue)),
      config_(config),
      wheel_(wheel),
      period_(period),
      wheel_id_(wheel.add(*this)),
      worst_requests_((config.cache.line_bytes / config.cache.sector_bytes + 1) / 2),
      cache_(config.cache),
      mshrs_(static_cast<int>(config.mshrs)),
      input_(config.input_queue),
      reads_(kMaxReads),
      answers_(kMaxReads),
      requests_(config.request_queue) {
    CHECK(config.request_queue >= 2 * worst_requests_ && config.bytes_per_cycle > 0);
    socket.register_nb_transport_fw(this, &L2Slice::forward);
    socket.register_b_transport(this, &L2Slice::blocking);
    for (std::uint32_t i = kMaxReads; i > 0; --i) free_reads_.push_back(i - 1);
}

tlm::tlm_sync_enum L2Slice::forward(int initiator, tlm::tlm_generic_payload& payload, tlm::tlm_phase& phase,
                                    sc_core::sc_time& delay) {
    ++wheel_.inside_calls().forward;
    const Picoseconds moment = wheel_.local_moment(delay);
    if (phase == tlm::END_RESP) {
        gates_.end_response(initiator);
        wheel_.arm(wheel_id_, std::max(moment, wheel_.now()));
        return tlm::TLM_COMPLETED;
    }
    CHECK(phase == tlm::BEGIN_REQ, "phase {}", phase.get_name());
    CHECK(!held_.any([&](const Waiting& w) { return w.initiator == initiator; }),
          "a second request before END_REQ");
    if (refuse(payload)) return tlm::TLM_COMPLETED;
    if (moment > wheel_.now() || held_.due(moment) || !queue(payload, initiator)) {
        payload.acquire();
        held_.hold({&payload, initiator}, moment);
        if (moment > wheel_.now()) wheel_.arm(wheel_id_, moment);
        return tlm::TLM_ACCEPTED;
    }
    wheel_.arm(wheel_id_, wheel_.now());
    if (payload.is_write()) {
        payload.set_response_status(tlm::TLM_OK_RESPONSE);
        return tlm::TLM_COMPLETED;
    }
    phase = tlm::END_REQ;
    return tlm::TLM_UPDATED;
}

// Sets an error response on a request that cannot be served: not one range, or a write that leaves open which
// of its bytes it means.
bool L2Slice::refuse(tlm::tlm_generic_payload& payload) {
    const unsigned int bytes = payload.get_data_length();
    const RequestTag* tag = payload.get_extension<RequestTag>();
    if (payload.is_read() == payload.is_write())
        payload.set_response_status(tlm::TLM_COMMAND_ERROR_RESPONSE);
    else if (bytes == 0 || bytes > kMaxRequestBytes || payload.get_streaming_width() < bytes)
        payload.set_response_status(tlm::TLM_BURST_ERROR_RESPONSE);
    else if (tag != nullptr && tag->masked && !tag->has_enables && payload.get_byte_enable_ptr() == nullptr)
        payload.set_response_status(tlm::TLM_BYTE_ENABLE_ERROR_RESPONSE);
    else
        return false;
    return true;
}

bool L2Slice::queue(tlm::tlm_generic_payload& payload, int initiator) {
    if (input_count_ == input_.size()) return false;
    Request& r = input_[(input_head_ + input_count_) % input_.size()];
    r = Request{};
    r.address = payload.get_address();
    r.bytes = payload.get_data_length();
    r.write = payload.is_write();
    r.cause = r.write ? MemoryCause::kWriteBack : MemoryCause::kFill;
    if (const RequestTag* tag = payload.get_extension<RequestTag>()) {
        CHECK(tag->surface < kMaxSurfaces, "surface {}", tag->surface);
        r.surface = tag->surface;
        r.cause = tag->cause;
        r.masked = tag->masked;
        if (tag->has_enables) r.enables = tag->enables;
    }
    if (payload.get_byte_enable_ptr() != nullptr) {
        r.masked = true;
        for (std::uint32_t b = 0; b < r.bytes; ++b)
            if (payload.get_byte_enable_ptr()[b % payload.get_byte_enable_length()] != 0)
                r.enables.word[b / 64] |= std::uint64_t{1} << (b % 64);
    }
    if (!r.write) {
        payload.acquire();
        r.payload = &payload;
        r.initiator = initiator;
    }
    ++input_count_;
    ++(r.write ? statistics_.writes : statistics_.reads);
    PortBytes& bytes = statistics_.looked_up[r.surface][static_cast<std::size_t>(r.cause)];
    (r.write ? bytes.write : bytes.read) += r.bytes;
    return true;
}

tlm::tlm_sync_enum L2Slice::call(int initiator, tlm::tlm_generic_payload& payload, tlm::tlm_phase phase) {
    const std::uint64_t inside = wheel_.inside_calls().backward;
    sc_core::sc_time delay = wheel_.local_delay();
    const tlm::tlm_sync_enum answer = socket[initiator]->nb_transport_bw(payload, phase, delay);
    if (wheel_.inside_calls().backward == inside) wheel_.called_outside();
    return answer;
}

// Of a read in the slice, or of a write (kNoRead).
void L2Slice::respond(int initiator, tlm::tlm_generic_payload& payload, std::uint32_t read) {
    payload.set_response_status(tlm::TLM_OK_RESPONSE);
    gates_.respond(
        initiator, {&payload, read},
        [this](int to, tlm::tlm_generic_payload& p) { return call(to, p, tlm::BEGIN_RESP); },
        [this](const ResponseGates::Response& response) { responded(response); });
}

void L2Slice::send_waiting_responses() {
    gates_.send_waiting([this](int to, tlm::tlm_generic_payload& p) { return call(to, p, tlm::BEGIN_RESP); },
                        [this](const ResponseGates::Response& response) { responded(response); });
}

void L2Slice::responded(const ResponseGates::Response& response) {
    if (response.number != kNoRead) free_reads_.push_back(response.number);
    response.payload->release();
}

// A request that was held back is taken once there is room: a read gets its END_REQ, a write its answer.
void L2Slice::retry_held(Picoseconds now) {
    while (held_.due(now) && queue(*held_.front().request.payload, held_.front().request.initiator)) {
        const Waiting taken = held_.take().request;
        if (taken.payload->is_write()) {
            respond(taken.initiator, *taken.payload, kNoRead);
        } else {
            call(taken.initiator, *taken.payload, tlm::END_REQ);
            taken.payload->release();
        }
    }
}

Picoseconds L2Slice::step(Picoseconds now) {
    const std::uint64_t cycle = now / period_;
    if (now % period_ != 0) return (cycle + 1) * period_;
    send_waiting_responses();
    answer_reads(cycle);
    retry_held(now);
    std::uint64_t next = look_up(cycle);
    retry_held(now);
    if (input_count_ != 0 && next == kNever && label_ == L2Label::kIdle)
        next = std::max(look_up_free_, cycle + 1);
    flush_line(cycle);
    if (send_request(cycle) && label_ == L2Label::kRequestQueue) next = cycle + 1;
    if (answer_count_ != 0) next = std::min(next, answers_[answer_head_].cycle);
    if (request_count_ != 0 && port.can_issue()) next = std::min(next, cycle + 1);
    if (flushing() && request_room() >= worst_requests_) next = std::min(next, cycle + 1);
    if (!held_.empty() && held_.front().from > now) next = std::min(next, cycle_at(held_.front().from));
    return next == kNever ? kNever : next * period_;
}

void L2Slice::charge(std::uint64_t until, L2Label label) {
    if (until <= labelled_) return;
    statistics_.label_cycles[static_cast<std::size_t>(label)] += until - labelled_;
    labelled_ = until;
}

// In order, one line of the slice a cycle; a write takes as long as its data. Returns the cycle to try again,
// or kNever when something else must happen first.
std::uint64_t L2Slice::look_up(std::uint64_t cycle) {
    if (look_up_free_ > cycle) return input_count_ != 0 ? look_up_free_ : kNever;
    charge(cycle, label_);
    label_ = L2Label::kIdle;
    if (input_count_ == 0) return kNever;
    Request& r = input_[input_head_];
    if (!r.write && current_ < 0) {
        label_ = L2Label::kReadsFull;
        if (free_reads_.empty()) return kNever;
        current_ = static_cast<int>(free_reads_.back());
        free_reads_.pop_back();
        reads_[static_cast<std::size_t>(current_)] = {r.payload, r.initiator, r.bytes, 0};
    }
    if (!look_up_line(r, label_)) return kNever;
    label_ = L2Label::kIdle;
    look_up_free_ = cycle + 1;
    ++looked_up_lines_;
    if (r.looked_up == r.bytes) {
        if (r.write) {
            const std::uint32_t cycles = data_cycles(r.bytes);
            look_up_free_ += cycles > looked_up_lines_ ? cycles - looked_up_lines_ : 0;
        } else {
            const auto read = static_cast<std::uint32_t>(current_);
            current_ = -1;
            if (reads_[read].misses == 0) complete(read, cycle);
        }
        looked_up_lines_ = 0;
        input_head_ = (input_head_ + 1) % static_cast<std::uint32_t>(input_.size());
        --input_count_;
    }
    charge(look_up_free_, L2Label::kBusy);
    last_cycle_ = std::max(last_cycle_, look_up_free_);
    return input_count_ != 0 ? look_up_free_ : kNever;
}

// The request's next line. False, with the reason, when something it needs is taken.
bool L2Slice::look_up_line(Request& r, L2Label& reason) {
    const std::uint64_t address = r.address + r.looked_up;
    const auto offset = static_cast<std::uint32_t>(address & (config_.cache.line_bytes - 1));
    const std::uint64_t line_address = address - offset;
    const std::uint32_t here = std::min(r.bytes - r.looked_up, config_.cache.line_bytes - offset);
    int line = cache_.probe(line_address, r.surface);
    if (r.write) {
        if (line == RopCache::kMiss && !take_line(r, line_address, line, reason)) return false;
        cache_.touch(line);
        cache_.write(line, r.masked ? r.enables.part(r.looked_up, here).raised(offset)
                                    : LineMask::range(offset, here));
        r.looked_up += here;
        return true;
    }
    const std::uint32_t sectors = cache_.sectors_of(offset, here);
    int mshr = -1;
    if (line == RopCache::kMiss || (cache_.valid_sectors(line) & sectors) != sectors) {
        mshr = mshrs_.find(line_address);
        reason = L2Label::kMshrsFull;
        if (mshr < 0 && mshrs_.full()) return false;
        reason = L2Label::kRequestQueue;
        if (request_room() < 2 * worst_requests_) return false;
        if (line == RopCache::kMiss && !take_line(r, line_address, line, reason)) return false;
    }
    cache_.touch(line);
    const std::uint32_t missing = cache_.request_sectors(line, sectors);
    // What has been written over while its fill is on its way need not be waited for.
    const std::uint32_t waiting = cache_.pending_sectors(line, sectors) & ~cache_.valid_sectors(line);
    if ((missing | waiting) != 0) {
        if (mshr < 0) mshr = mshrs_.allocate(line_address, line);
        mshrs_.add(mshr, missing, current_);
        ++reads_[static_cast<std::size_t>(current_)].misses;
        MemoryRequest fill;
        fill.surface = r.surface;
        fill.cause = r.cause;
        fill.id = static_cast<std::uint32_t>(mshr);
        queue_requests(line_address, missing, fill);
    }
    r.looked_up += here;
    return true;
}

// A line of the set for this address; what it held is written back.
bool L2Slice::take_line(const Request& r, std::uint64_t line_address, int& line, L2Label& reason) {
    reason = L2Label::kRequestQueue;
    if (request_room() < worst_requests_) return false;
    reason = L2Label::kWays;
    Eviction eviction;
    line = cache_.allocate(line_address, r.surface, &eviction);
    if (line == RopCache::kMiss) return false;
    queue_write(eviction, MemoryCause::kWriteBack);
    return true;
}

// All of a read is here from `cycle` on.
void L2Slice::complete(std::uint32_t read, std::uint64_t cycle) {
    data_free_ = std::max(cycle + config_.latency, data_free_) + data_cycles(reads_[read].bytes);
    answers_[(answer_head_ + answer_count_) % answers_.size()] = {data_free_, read};
    ++answer_count_;
    last_cycle_ = std::max(last_cycle_, data_free_);
}

void L2Slice::answer_reads(std::uint64_t cycle) {
    while (answer_count_ != 0 && answers_[answer_head_].cycle <= cycle) {
        const std::uint32_t read = answers_[answer_head_].read;
        answer_head_ = (answer_head_ + 1) % static_cast<std::uint32_t>(answers_.size());
        --answer_count_;
        respond(reads_[read].initiator, *reads_[read].payload, read);
    }
}

void L2Slice::blocking(int, tlm::tlm_generic_payload& payload, sc_core::sc_time& delay) {
    delay += sc_core::sc_time::from_value(config_.latency * period_);
    port.socket->b_transport(payload, delay);
}

}  // namespace ropsim
