// Feeding a stream of requests to the channels of a memory.
#include "memory/memory_system.h"

#include "base/error.h"

#include <algorithm>
#include <bit>

namespace ropsim {
namespace {

int address_bits(const MemoryConfig& config) {
    return std::countr_zero(config.channels) + std::countr_zero(config.dram.capacity_bytes());
}

}  // namespace

MemorySystem::Channel::Channel(const DramConfig& config) : scheduler(config), request_of(config.max_reads()) {
    for (std::uint32_t i = config.max_reads(); i > 0; --i) free_numbers.push_back(i - 1);
}

MemorySystem::MemorySystem(const MemoryConfig& config, std::uint32_t needs, std::uint32_t outstanding)
    : config_(config),
      map_(config.channel_bits, address_bits(config), config.channel_place),
      outstanding_(outstanding) {
    if (map_.granule() < config.dram.burst_bytes())
        throw UserError(config.channel_place,
                        fmt::format("channels change within a burst of {} bytes", config.dram.burst_bytes()));
    for (std::uint32_t c = 0; c < config.channels; ++c)
        channels_.push_back(std::make_unique<Channel>(config.dram));
    const std::size_t tracked = std::max(needs, outstanding);
    if (tracked != 0) recent_.resize(std::bit_ceil(tracked + 1));
}

DramCycle MemorySystem::offer(const AddressRequest& request) {
    now_ = std::max(now_, request.cycle);
    if (request.needs != 0) wait_for(offered_ - request.needs);
    if (outstanding_ != 0 && offered_ >= outstanding_) wait_for(offered_ - outstanding_);
    if (!recent_.empty()) recent(offered_) = {};
    const DramCycle first_offered = now_;
    std::uint64_t address = request.address & (capacity() - 1);
    if (address != request.address) ++wrapped_;
    std::uint64_t left = config_.request_bytes;
    while (left != 0) {
        const std::uint64_t block_left = map_.granule() - (address & (map_.granule() - 1));
        const auto part = static_cast<std::uint32_t>(std::min(left, block_left));
        const std::uint32_t channel = map_.channel(address);
        if (!recent_.empty()) recent(offered_).channels |= std::uint64_t{1} << channel;
        offer_part(*channels_[channel], map_.local(address), part, request.write);
        left -= part;
        address = (address + part) & (capacity() - 1);
    }
    ++offered_;
    return first_offered;
}

void MemorySystem::offer_part(Channel& channel, std::uint64_t address, std::uint32_t bytes, bool write) {
    while (channel.scheduler.next() < now_) step(channel);
    channel.now = std::max(channel.now, now_);
    DramRequest request;
    request.address = address;
    request.bytes = bytes;
    request.write = write;
    request.cause = write ? MemoryCause::kWriteBack : MemoryCause::kFill;
    const DramCycle arrival = now_;
    while (!try_push(channel, request, arrival)) {
        const std::uint64_t chances = channel.scheduler.chances();
        while (channel.scheduler.chances() == chances) step(channel);
    }
    channel.scheduler.count_blocked(channel.now - arrival);
    now_ = channel.now;
}

bool MemorySystem::try_push(Channel& channel, DramRequest& request, DramCycle arrival) {
    if (!request.write) {
        if (channel.free_numbers.empty()) {
            channel.scheduler.expect_any_chance();
            return false;
        }
        request.number = channel.free_numbers.back();
    }
    if (!channel.scheduler.push(request, arrival, channel.now)) return false;
    if (request.write) return true;
    channel.free_numbers.pop_back();
    if (!recent_.empty()) {
        channel.request_of[request.number] = offered_;
        ++recent(offered_).pending;
    }
    collect(channel);
    return true;
}

void MemorySystem::step(Channel& channel) {
    CHECK(channel.scheduler.next() != kNoCycle, "a request waits and the channel has nothing to do");
    channel.now = std::max(channel.now, channel.scheduler.next());
    channel.scheduler.step(channel.now);
    collect(channel);
}

// Takes the reads whose data are scheduled; their numbers are free again.
void MemorySystem::collect(Channel& channel) {
    for (const DramScheduler::Finished& finished : channel.scheduler.finished()) {
        channel.free_numbers.push_back(finished.number);
        channel.last_done = std::max(channel.last_done, finished.cycle);
        if (recent_.empty()) continue;
        const std::uint64_t request = channel.request_of[finished.number];
        if (offered_ - request >= recent_.size()) continue;
        Recent& entry = recent(request);
        entry.done = std::max(entry.done, finished.cycle);
        --entry.pending;
    }
    channel.scheduler.finished().clear();
}

// Lets time pass until a request's data are here. Its channels are stepped in order of time, so that none
// gets ahead of the end.
void MemorySystem::wait_for(std::uint64_t request) {
    CHECK(request < offered_ && offered_ - request < recent_.size(), "request {} of {}", request, offered_);
    const Recent& entry = recent(request);
    while (entry.pending != 0) {
        Channel* first = nullptr;
        for (std::uint64_t rest = entry.channels; rest != 0; rest &= rest - 1) {
            Channel* channel = channels_[static_cast<std::size_t>(std::countr_zero(rest))].get();
            if (first == nullptr || channel->scheduler.next() < first->scheduler.next()) first = channel;
        }
        step(*first);
    }
    now_ = std::max(now_, entry.done);
}

DramCycle MemorySystem::finish() {
    DramCycle end = now_;
    for (const auto& channel : channels_) {
        while (channel->scheduler.next() != kNoCycle) step(*channel);
        end = std::max({end, channel->now, channel->last_done, channel->scheduler.last_data()});
    }
    for (const auto& channel : channels_) {
        channel->scheduler.finish(end);
        CHECK(channel->scheduler.statistics().cycles == end, "channel closed at {}, memory at {}",
              channel->scheduler.statistics().cycles, end);
    }
    return end;
}

}  // namespace ropsim
