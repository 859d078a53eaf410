// Address layout: parsing and checking of the mapping text, and the split of an address.
#include "memory/address_map.h"

#include "base/error.h"
#include "memory/dram_device.h"

#include <bit>
#include <charconv>
#include <sstream>
#include <string_view>
#include <vector>

namespace ropsim {
namespace {

enum Field { kBank, kBankGroup, kRow, kColumn, kRank, kPseudochannel };
constexpr std::array<std::string_view, 6> kFieldNames = {"bank",   "bankgroup", "row",
                                                         "column", "rank",      "pseudochannel"};

struct Token {
    int field = 0;
    int bits = -1;  // -1: what the other parts leave
};

Token parse_token(const std::string& text, const std::string& where) {
    const std::size_t colon = text.find(':');
    const std::string_view name = std::string_view(text).substr(0, colon);
    Token token;
    token.field = -1;
    for (std::size_t f = 0; f < kFieldNames.size(); ++f)
        if (kFieldNames[f] == name) token.field = static_cast<int>(f);
    if (token.field < 0)
        throw UserError(where,
                        fmt::format("'{}' is not one of row, rank, pseudochannel, bank, bankgroup, column", text));
    if (colon == std::string::npos) return token;
    const char* end = text.data() + text.size();
    const auto result = std::from_chars(text.data() + colon + 1, end, token.bits);
    if (result.ec != std::errc() || result.ptr != end || token.bits < 0 || token.bits > 31)
        throw UserError(where, fmt::format("'{}' needs a number of bits after the colon", text));
    return token;
}

}  // namespace

AddressMap::AddressMap(const DramConfig& config, const std::string& where) {
    const auto bits_of = [](std::uint32_t n) { return static_cast<int>(std::bit_width(n)) - 1; };
    const std::array<int, kFields> width = {bits_of(config.banks_per_group), bits_of(config.bank_groups),
                                            bits_of(config.rows),            bits_of(config.columns()),
                                            bits_of(config.ranks),           bits_of(config.pseudochannels)};
    std::vector<Token> tokens;
    std::istringstream words(config.mapping);
    for (std::string word; words >> word;) tokens.push_back(parse_token(word, where));
    std::array<int, kFields> given{};
    std::array<int, kFields> open{};
    for (const Token& token : tokens) {
        const auto f = static_cast<std::size_t>(token.field);
        if (token.bits < 0)
            ++open[f];
        else
            given[f] += token.bits;
    }
    for (std::size_t f = 0; f < kFields; ++f) {
        const bool covered = open[f] == 1 ? given[f] <= width[f] : open[f] == 0 && given[f] == width[f];
        if (!covered)
            throw UserError(where, fmt::format("'{}' must place the {} bits of '{}' exactly once",
                                               config.mapping, width[f], kFieldNames[f]));
    }
    int from = bits_of(config.burst_bytes());
    contiguous_bytes_ = config.burst_bytes();
    std::array<int, kFields> placed{};
    for (auto token = tokens.rbegin(); token != tokens.rend(); ++token) {
        const auto f = static_cast<std::size_t>(token->field);
        const int bits = token->bits < 0 ? width[f] - given[f] : token->bits;
        if (bits == 0) continue;
        if (part_count_[f] == kMaxParts)
            throw UserError(where, fmt::format("'{}' is in more than {} parts", kFieldNames[f], kMaxParts));
        Part& part = parts_[f][static_cast<std::size_t>(part_count_[f]++)];
        part.from = static_cast<std::uint8_t>(from);
        part.to = static_cast<std::uint8_t>(placed[f]);
        part.mask = (1u << bits) - 1;
        if (token->field == kColumn && placed[kColumn] == 0 && contiguous_bytes_ == 1u << from)
            contiguous_bytes_ <<= bits;
        from += bits;
        placed[f] += bits;
    }
    bits_ = from;
    bank_bits_ = static_cast<std::uint32_t>(width[kBank]);
    group_bits_ = static_cast<std::uint32_t>(width[kBankGroup]);
    rank_bits_ = static_cast<std::uint32_t>(width[kRank]);
    bank_xor_ = config.bank_xor;
    column_xor_ = config.column_xor;
    if (column_xor_) contiguous_bytes_ = config.burst_bytes();
}

std::uint32_t AddressMap::field(int which, std::uint64_t address) const {
    const auto f = static_cast<std::size_t>(which);
    std::uint32_t value = 0;
    for (int i = 0; i < part_count_[f]; ++i) {
        const Part& part = parts_[f][static_cast<std::size_t>(i)];
        value |= (static_cast<std::uint32_t>(address >> part.from) & part.mask) << part.to;
    }
    return value;
}

DramPlace AddressMap::place(std::uint64_t address) const {
    DramPlace place;
    place.row = field(kRow, address);
    place.column = field(kColumn, address);
    place.rank = field(kRank, address);
    place.pseudochannel = field(kPseudochannel, address);
    std::uint32_t bank = field(kBankGroup, address) << bank_bits_ | field(kBank, address);
    const std::uint32_t mask = (1u << (group_bits_ + bank_bits_)) - 1;
    if (bank_xor_) bank ^= place.row & mask;
    if (column_xor_) {
        const std::uint32_t group = place.column & ((1u << group_bits_) - 1);
        bank ^= (group << bank_bits_ | (place.column >> group_bits_ & ((1u << bank_bits_) - 1)));
    }
    place.bank = (place.pseudochannel << rank_bits_ | place.rank) << (group_bits_ + bank_bits_) | bank;
    return place;
}

}  // namespace ropsim
