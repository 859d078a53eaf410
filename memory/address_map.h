// How a channel's byte addresses are laid out over bank groups, banks, rows and columns.
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace ropsim {

struct DramConfig;

// A place in the DRAM. `bank` counts all banks of the channel: pseudo-channel, rank, bank group, bank in group
// from high to low.
struct DramPlace {
    std::uint32_t pseudochannel = 0;
    std::uint32_t rank = 0;
    std::uint32_t bank = 0;
    std::uint32_t row = 0;
    std::uint32_t column = 0;  // in bursts
};

// `mapping` names the fields above the burst offset from high to low: row, rank, pseudochannel, bank,
// bankgroup, column, each once (a field without bits may be left out), or in parts with an explicit width in bits for all but one part of a field ("row bank column:3
// bankgroup column:2").
class AddressMap {
 public:
    // Throws UserError at `where` unless every bit of every field is placed exactly once.
    AddressMap(const DramConfig& config, const std::string& where);
    // `address` < capacity().
    DramPlace place(std::uint64_t address) const;
    std::uint64_t capacity() const { return std::uint64_t{1} << bits_; }
    // An aligned block of this many bytes (a power of two) lies in successive columns of one row.
    std::uint64_t contiguous_bytes() const { return contiguous_bytes_; }

 private:
    struct Part {
        std::uint8_t from = 0;  // lowest bit in the address
        std::uint8_t to = 0;    // lowest bit in the field
        std::uint32_t mask = 0;
    };
    static constexpr int kFields = 6;
    static constexpr int kMaxParts = 4;
    std::uint32_t field(int which, std::uint64_t address) const;

    std::array<std::array<Part, kMaxParts>, kFields> parts_{};
    std::array<int, kFields> part_count_{};
    std::uint64_t contiguous_bytes_ = 0;
    std::uint32_t bank_bits_ = 0;  // bits of the bank within its group
    std::uint32_t group_bits_ = 0;
    std::uint32_t rank_bits_ = 0;
    bool bank_xor_ = false;
    bool column_xor_ = false;
    int bits_ = 0;
};

}  // namespace ropsim
