// How a channel's byte addresses are laid out over pseudo-channels, ranks, banks, rows and columns.
#pragma once

#include "memory/address_bits.h"

#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

struct DramConfig;

// A place in the DRAM. `bank` counts all banks of the channel: pseudo-channel, rank, bank group, bank in
// group from high to low.
struct DramPlace {
    std::uint32_t pseudochannel = 0;
    std::uint32_t rank = 0;
    std::uint32_t bank = 0;
    std::uint32_t row = 0;
    std::uint32_t column = 0;  // in bursts
};

// `mapping` names the fields above the burst offset from high to low: row, rank, pseudochannel, bank,
// bankgroup, column, each once (one without bits may be left out), or in parts with an explicit width in bits
// for all but one part of a field ("row bank column:3 bankgroup column:2"). A field with explicit bits
// (bank_bits, bankgroup_bits, rank_bits, pseudochannel_bits; see parse_address_bits) takes those, whatever
// `mapping` says of it, and the other fields share the bits that are left. Then bank_xor and column_xor.
//
// Every bit of a place is an XOR of address bits. Those that move by the same distance move together: a field
// in one piece, or what one is hashed with, is one rotation of a masked address.
class AddressMap {
 public:
    // Throws UserError at `where` unless every bit of every field is placed exactly once and no two addresses
    // share a place.
    AddressMap(const DramConfig& config, const std::string& where);
    // `address` < capacity().
    DramPlace place(std::uint64_t address) const {
        std::uint64_t packed = 0;
        for (std::uint32_t m = 0; m < moves_; ++m)
            packed ^= std::rotl(address & move_[m].mask, move_[m].distance);
        const auto bank = static_cast<std::uint32_t>(packed & kBankMask);
        return {bank >> pseudochannel_shift_, bank >> rank_shift_ & rank_mask_, bank,
                static_cast<std::uint32_t>(packed >> kRowShift),
                static_cast<std::uint32_t>(packed >> kColumnShift & kColumnMask)};
    }
    std::uint64_t capacity() const { return std::uint64_t{1} << bits_; }
    // An aligned block of this many bytes (a power of two) lies in successive columns of one row.
    std::uint64_t contiguous_bytes() const { return contiguous_bytes_; }

 private:
    // A place in one word: row, column, bank from high to low.
    static constexpr int kColumnShift = 8;
    static constexpr int kRowShift = 32;
    static constexpr std::uint64_t kBankMask = (1u << kColumnShift) - 1;
    static constexpr std::uint64_t kColumnMask = (1u << (kRowShift - kColumnShift)) - 1;

    // Which address bits make bit `to` of a packed place.
    struct PlaceBit {
        int to = 0;
        std::uint64_t mask = 0;
    };
    struct Move {
        std::uint64_t mask = 0;  // of address bits
        int distance = 0;        // to the left, around
    };
    void find_moves(const std::vector<PlaceBit>& place_bits);
    void find_contiguous_bytes(const std::vector<PlaceBit>& place_bits);

    std::uint32_t moves_ = 0;
    std::array<Move, 64> move_{};
    std::uint64_t contiguous_bytes_ = 0;
    int bits_ = 0;
    // of the rank and the pseudo-channel in a bank's number
    int rank_shift_ = 0;
    int pseudochannel_shift_ = 0;
    std::uint32_t rank_mask_ = 0;
};

}  // namespace ropsim
