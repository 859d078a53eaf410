// The keys of a whole memory, and how addresses fall to its channels.
#include "base/error.h"
#include "memory/memory_system.h"

#include <algorithm>
#include <bit>

namespace ropsim {
namespace {

constexpr std::int64_t kMaxChannels = 64;
constexpr int kDefaultChannelBit = 8;

std::string place_of(const Parameters& parameters, const std::string& key) {
    return parameters.has(key) ? parameters.where(key) : fmt::format("{}: {}", parameters.context(), key);
}

std::uint64_t own_bits(const std::vector<AddressBit>& bits) {
    std::uint64_t mask = 0;
    for (const AddressBit& bit : bits) mask |= std::uint64_t{1} << bit.own;
    return mask;
}

// The same bits as a channel counts them, which does not see its own number's.
std::string local_bits(const std::string& text, const std::vector<AddressBit>& channel_bits,
                       const std::string& where) {
    const std::uint64_t taken = own_bits(channel_bits);
    const auto local = [&](int bit) {
        if ((taken >> bit & 1) != 0)
            throw UserError(where,
                            fmt::format("bit {} is the channel's: it is the same for every address of a "
                                        "channel; name another",
                                        bit));
        return bit - std::popcount(taken & ((std::uint64_t{1} << bit) - 1));
    };
    std::string result;
    const std::vector<AddressBit> bits = parse_address_bits(text, where);
    for (auto bit = bits.rbegin(); bit != bits.rend(); ++bit) {
        result += fmt::format("{}{}", result.empty() ? "" : " ", local(bit->own));
        const std::uint64_t others = bit->mask & ~(std::uint64_t{1} << bit->own);
        for (std::uint64_t rest = others; rest != 0; rest &= rest - 1)
            result += fmt::format("^{}", local(std::countr_zero(rest)));
    }
    return result;
}

void read_channels(Parameters& parameters, MemoryConfig& config) {
    config.channel_place = place_of(parameters, "memory.channel_bits");
    const std::string text = parameters.get_string("memory.channel_bits", "");
    config.channel_bits = parse_address_bits(text, config.channel_place);
    if (config.channel_bits.size() > 6)
        throw UserError(config.channel_place, fmt::format("names {} bits; at most {} channels are modelled",
                                                          config.channel_bits.size(), kMaxChannels));
    const auto named = std::int64_t{1} << config.channel_bits.size();
    config.channels =
        static_cast<std::uint32_t>(parameters.get_integer("memory.channels", named, 1, kMaxChannels));
    const std::string place = place_of(parameters, "memory.channels");
    if (!std::has_single_bit(config.channels))
        throw UserError(place, fmt::format("{} is not a power of two", config.channels));
    if (text.empty())
        for (int bit = 0; bit < std::countr_zero(config.channels); ++bit)
            config.channel_bits.push_back(
                {kDefaultChannelBit + bit, std::uint64_t{1} << (kDefaultChannelBit + bit)});
    else if (config.channels != named)
        throw UserError(place, fmt::format("{} channels, but memory.channel_bits names {} bits",
                                           config.channels, config.channel_bits.size()));
}

}  // namespace

MemoryConfig memory_config(Parameters& parameters) {
    MemoryConfig config;
    read_channels(parameters, config);
    for (const char* field : {"bank_bits", "bankgroup_bits", "rank_bits", "pseudochannel_bits"}) {
        const std::string key = std::string("memory.") + field;
        const std::string dram_key = std::string("dram.") + field;
        const std::string text = parameters.get_string(key, "");
        if (text.empty()) continue;
        if (parameters.has(dram_key))
            throw UserError(parameters.where(key), fmt::format("{} is given, too; leave one out", dram_key));
        parameters.set(dram_key, local_bits(text, config.channel_bits, parameters.where(key)),
                       parameters.where(key));
    }
    config.dram = dram_config(parameters);
    config.request_bytes =
        static_cast<std::uint32_t>(parameters.get_integer("memory.request_bytes", 64, 1, kMaxRequestBytes));
    return config;
}

ChannelMap::ChannelMap(const std::vector<AddressBit>& bits, int address_bits, const std::string& where)
    : bits_(bits), address_bits_(address_bits) {
    const std::uint64_t own = own_bits(bits);
    std::vector<std::uint64_t> rows;
    for (const AddressBit& bit : bits) {
        if (bit.mask >> address_bits != 0)
            throw UserError(where, fmt::format("bit {} is beyond the memory's {} address bits",
                                               std::bit_width(bit.mask) - 1, address_bits));
        rows.push_back(bit.mask);
    }
    for (int bit = 0; bit < address_bits; ++bit)
        if ((own >> bit & 1) == 0) rows.push_back(std::uint64_t{1} << bit);
    if (binary_rank(rows) != address_bits)
        throw UserError(where, "two addresses share a place: the bits chosen by XOR are not independent");
    // Runs of bits between the own ones move down together.
    for (int bit = 0, gone = 0; bit < address_bits; ++bit) {
        if ((own >> bit & 1) != 0) {
            ++gone;
            continue;
        }
        if (segments_.empty() || segments_.back().shift != gone) segments_.push_back({0, gone});
        segments_.back().mask |= std::uint64_t{1} << bit;
    }
    std::uint64_t any = 0;
    for (const AddressBit& bit : bits) any |= bit.mask;
    granule_ = any == 0 ? capacity() : any & (~any + 1);
}

std::uint32_t ChannelMap::channel(std::uint64_t address) const {
    std::uint32_t number = 0;
    for (std::size_t i = 0; i < bits_.size(); ++i)
        number |= static_cast<std::uint32_t>(std::popcount(address & bits_[i].mask) & 1) << i;
    return number;
}

std::uint64_t ChannelMap::local(std::uint64_t address) const {
    std::uint64_t result = 0;
    for (const Segment& segment : segments_) result |= (address & segment.mask) >> segment.shift;
    return result;
}

}  // namespace ropsim
