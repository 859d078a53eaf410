// A whole memory: channels interleaved over an address space, fed by one stream of requests, without SystemC.
#pragma once

#include "memory/address_bits.h"
#include "memory/address_trace.h"
#include "memory/dram_device.h"
#include "memory/dram_scheduler.h"
#include "memory/dram_statistics.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace ropsim {

// Which channel an address belongs to, and where in it: the own bits of the channel's number are taken out of
// the address and the rest closes up.
class ChannelMap {
 public:
    // `bits`: of the channel's number from low to high. `address_bits`: of the whole memory. Throws UserError
    // at `where` unless they are a channel and a place for every address.
    ChannelMap(const std::vector<AddressBit>& bits, int address_bits, const std::string& where);

    std::uint32_t channel(std::uint64_t address) const;
    std::uint64_t local(std::uint64_t address) const;
    std::uint64_t capacity() const { return std::uint64_t{1} << address_bits_; }
    // An aligned block of this many bytes lies in one channel, at successive addresses.
    std::uint64_t granule() const { return granule_; }

 private:
    struct Segment {
        std::uint64_t mask;
        int shift;
    };
    std::vector<AddressBit> bits_;
    std::vector<Segment> segments_;
    std::uint64_t granule_ = 0;
    int address_bits_;
};

// Keys: every "dram.*" of dram_config(), and
//   memory.channels       1 to 64, a power of two
//   memory.channel_bits   address bits that make the channel's number, see parse_address_bits; default those
//                         from bit 8 up: 256 bytes of a channel after another
//   memory.bank_bits, memory.bankgroup_bits, memory.rank_bits, memory.pseudochannel_bits
//                         as the same of dram.*, but counted in the whole memory's
//                         addresses
//   memory.request_bytes  1 to 256, of every request
struct MemoryConfig {
    DramConfig dram;  // of one channel
    std::uint32_t channels = 1;
    std::vector<AddressBit> channel_bits;  // from low to high
    std::string channel_place;             // of channel_bits, for messages
    std::uint32_t request_bytes = 64;

    double peak_bytes_per_second() const { return channels * dram.peak_bytes_per_second(); }
};
// Throws UserError on an unknown device or values that do not fit together.
MemoryConfig memory_config(Parameters& parameters);

// One controller a channel; all share a clock. The stream is in order: a request is offered when the one
// before was accepted, at its own cycle at the earliest, any number in a cycle. While its channel has no room
// it waits, and all behind it. A request that crosses from one channel to another is several, offered in
// order.
class MemorySystem {
 public:
    // `needs`: the largest AddressRequest::needs that will be used. `outstanding`: every request needs the
    // data of the one this many before it; 0: none does. Throws UserError when the channel bits do not fit
    // the addresses.
    explicit MemorySystem(const MemoryConfig& config, std::uint32_t needs = 0, std::uint32_t outstanding = 0);

    // Offers a request, until it is taken. Addresses wrap at capacity(). Returns the cycle at which it was
    // first offered.
    DramCycle offer(const AddressRequest& request);
    // Runs until everything is done and closes every channel's account at the same cycle, which it returns.
    DramCycle finish();

    std::uint64_t capacity() const { return map_.capacity(); }
    std::uint64_t wrapped_requests() const { return wrapped_; }
    std::uint32_t channels() const { return static_cast<std::uint32_t>(channels_.size()); }
    const DramStatistics& statistics(std::uint32_t channel) const {
        return channels_[channel]->scheduler.statistics();
    }
    // Every command of a channel is reported to `trace` from now on.
    void set_trace(std::uint32_t channel, DramCommandTrace* trace) {
        channels_[channel]->scheduler.set_trace(trace);
    }

 private:
    struct Channel {
        explicit Channel(const DramConfig& config);
        DramScheduler scheduler;
        std::vector<std::uint32_t> free_numbers;
        std::vector<std::uint64_t> request_of;  // by read number: the stream's request
        DramCycle now = 0;
        DramCycle last_done = 0;  // data of a read
    };
    // A recent request, for those that need its data.
    struct Recent {
        DramCycle done = 0;
        std::uint64_t channels = 0;  // that it went to, one bit each
        std::uint32_t pending = 0;   // parts whose data are not scheduled
    };
    void offer_part(Channel& channel, std::uint64_t address, std::uint32_t bytes, bool write);
    bool try_push(Channel& channel, DramRequest& request, DramCycle arrival);
    void step(Channel& channel);
    void collect(Channel& channel);
    void wait_for(std::uint64_t request);
    Recent& recent(std::uint64_t request) { return recent_[request & (recent_.size() - 1)]; }

    MemoryConfig config_;
    ChannelMap map_;
    std::vector<std::unique_ptr<Channel>> channels_;
    std::vector<Recent> recent_;  // ring of a power of two; empty: nothing is tracked
    std::uint32_t outstanding_;
    std::uint64_t offered_ = 0;
    std::uint64_t wrapped_ = 0;
    DramCycle now_ = 0;
};

}  // namespace ropsim
