// Parsing of explicit address bits, and the test whether they are independent.
#include "memory/address_bits.h"

#include "base/error.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <sstream>

namespace ropsim {
namespace {

AddressBit parse_term(const std::string& term, const std::string& where) {
    AddressBit bit;
    const char* at = term.data();
    const char* const end = at + term.size();
    for (bool first = true;; first = false) {
        int number = -1;
        const auto result = std::from_chars(at, end, number);
        if (result.ec != std::errc() || number < 0 || number > 62 ||
            (result.ptr != end && *result.ptr != '^'))
            throw UserError(where,
                            fmt::format("'{}' is no address bit (0 to 62) nor several joined by '^'", term));
        const std::uint64_t mask = std::uint64_t{1} << number;
        if ((bit.mask & mask) != 0)
            throw UserError(where, fmt::format("'{}' has bit {} twice", term, number));
        bit.mask |= mask;
        if (first) bit.own = number;
        if (result.ptr == end) return bit;
        at = result.ptr + 1;
    }
}

}  // namespace

std::vector<AddressBit> parse_address_bits(const std::string& text, const std::string& where) {
    std::vector<AddressBit> bits;
    std::istringstream words(text);
    for (std::string word; words >> word;) {
        const AddressBit bit = parse_term(word, where);
        for (const AddressBit& other : bits)
            if (other.own == bit.own)
                throw UserError(where, fmt::format("'{}' takes bit {} twice", text, bit.own));
        bits.push_back(bit);
    }
    std::reverse(bits.begin(), bits.end());
    return bits;
}

int binary_rank(std::vector<std::uint64_t> rows) {
    int rank = 0;
    while (!rows.empty()) {
        const std::uint64_t row = rows.back();
        rows.pop_back();
        if (row == 0) continue;
        ++rank;
        const std::uint64_t lead = std::bit_floor(row);
        for (std::uint64_t& other : rows)
            if ((other & lead) != 0) other ^= row;
    }
    return rank;
}

}  // namespace ropsim
