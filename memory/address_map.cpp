// Address layout: parsing and checking of the mapping text and of explicit bits, and the tables made of them.
#include "memory/address_map.h"

#include "base/error.h"
#include "memory/dram_device.h"

#include <bit>
#include <charconv>
#include <sstream>
#include <string_view>

namespace ropsim {
namespace {

enum Field : std::size_t { kBank, kBankGroup, kRank, kPseudochannel, kRow, kColumn };
constexpr std::size_t kFields = 6;
constexpr std::array<std::string_view, kFields> kFieldNames = {"bank",          "bankgroup", "rank",
                                                               "pseudochannel", "row",       "column"};

int bits_of(std::uint32_t n) {
    return static_cast<int>(std::bit_width(n)) - 1;
}

struct Token {
    std::size_t field = 0;
    int bits = -1;  // -1: what the other parts leave
};

Token parse_token(const std::string& text, const std::string& where) {
    const std::size_t colon = text.find(':');
    const std::string_view name = std::string_view(text).substr(0, colon);
    Token token;
    while (token.field < kFields && kFieldNames[token.field] != name) ++token.field;
    if (token.field == kFields)
        throw UserError(
            where, fmt::format("'{}' is not one of row, rank, pseudochannel, bank, bankgroup, column", text));
    if (colon == std::string::npos) return token;
    const char* end = text.data() + text.size();
    const auto result = std::from_chars(text.data() + colon + 1, end, token.bits);
    if (result.ec != std::errc() || result.ptr != end || token.bits < 0 || token.bits > 31)
        throw UserError(where, fmt::format("'{}' needs a number of bits after the colon", text));
    return token;
}

// A field's bits from low to high.
using FieldBits = std::vector<AddressBit>;

class Layout {
 public:
    Layout(const DramConfig& config, const std::string& where)
        : config_(config),
          where_(where),
          width_{bits_of(config.banks_per_group), bits_of(config.bank_groups), bits_of(config.ranks),
                 bits_of(config.pseudochannels),  bits_of(config.rows),        bits_of(config.columns())},
          burst_bits_(bits_of(config.burst_bytes())) {
        bits_ = burst_bits_;
        for (const int width : width_) bits_ += width;
        take_explicit(kBank, "dram.bank_bits", config.bank_bits);
        take_explicit(kBankGroup, "dram.bankgroup_bits", config.bankgroup_bits);
        take_explicit(kRank, "dram.rank_bits", config.rank_bits);
        take_explicit(kPseudochannel, "dram.pseudochannel_bits", config.pseudochannel_bits);
        take_mapping();
    }
    const FieldBits& field(Field which) const { return fields_[which]; }
    int burst_bits() const { return burst_bits_; }
    int bits() const { return bits_; }

 private:
    void take_explicit(Field which, const char* key, const std::string& text) {
        if (text.empty()) return;
        const std::string place = fmt::format("{}: {} = '{}'", where_, key, text);
        FieldBits bits = parse_address_bits(text, place);
        if (static_cast<int>(bits.size()) != width_[which])
            throw UserError(place, fmt::format("names {} bits; '{}' has {}", bits.size(), kFieldNames[which],
                                               width_[which]));
        for (const AddressBit& bit : bits) {
            const int high = static_cast<int>(std::bit_width(bit.mask)) - 1;
            const int low = std::countr_zero(bit.mask);
            if (low < burst_bits_ || high >= bits_)
                throw UserError(place, fmt::format("bit {} must be from {} (above a burst) to {}",
                                                   low < burst_bits_ ? low : high, burst_bits_, bits_ - 1));
            if ((taken_ >> bit.own & 1) != 0)
                throw UserError(place, fmt::format("bit {} is another field's already", bit.own));
            taken_ |= std::uint64_t{1} << bit.own;
        }
        is_explicit_[which] = true;
        fields_[which] = std::move(bits);
    }

    // The order language, over the bits that are not taken, from low to high.
    void take_mapping() {
        std::vector<Token> tokens;
        std::istringstream words(config_.mapping);
        for (std::string word; words >> word;) {
            const Token token = parse_token(word, where_);
            if (!is_explicit_[token.field]) tokens.push_back(token);
        }
        std::array<int, kFields> given{};
        std::array<int, kFields> open{};
        for (const Token& token : tokens) {
            if (token.bits < 0)
                ++open[token.field];
            else
                given[token.field] += token.bits;
        }
        for (std::size_t f = 0; f < kFields; ++f) {
            const bool covered = open[f] == 1 ? given[f] <= width_[f] : open[f] == 0 && given[f] == width_[f];
            if (!covered && !is_explicit_[f] && (width_[f] != 0 || given[f] != 0 || open[f] > 1))
                throw UserError(where_, fmt::format("'{}' must place the {} bits of '{}' exactly once",
                                                    config_.mapping, width_[f], kFieldNames[f]));
        }
        int from = burst_bits_;
        for (auto token = tokens.rbegin(); token != tokens.rend(); ++token) {
            const int bits = token->bits < 0 ? width_[token->field] - given[token->field] : token->bits;
            for (int i = 0; i < bits; ++i, ++from) {
                while ((taken_ >> from & 1) != 0) ++from;
                fields_[token->field].push_back({from, std::uint64_t{1} << from});
            }
        }
    }

    const DramConfig& config_;
    const std::string& where_;
    std::array<int, kFields> width_;
    std::array<bool, kFields> is_explicit_{};
    std::array<FieldBits, kFields> fields_;
    std::uint64_t taken_ = 0;
    int burst_bits_;
    int bits_ = 0;
};

}  // namespace

AddressMap::AddressMap(const DramConfig& config, const std::string& where) {
    const Layout layout(config, where);
    const int burst_bits = layout.burst_bits();  // the offset in a burst
    bits_ = layout.bits();
    std::vector<PlaceBit> place_bits;
    const auto add = [&](const FieldBits& field, int shift) {
        for (const AddressBit& bit : field) place_bits.push_back({shift++, bit.mask});
    };
    const std::size_t bank_bits = layout.field(kBank).size();
    const std::size_t banks = bank_bits + layout.field(kBankGroup).size();  // of a rank
    int shift = 0;
    for (const Field field : {kBank, kBankGroup, kRank, kPseudochannel}) {
        add(layout.field(field), shift);
        shift += static_cast<int>(layout.field(field).size());
    }
    FieldBits row = layout.field(kRow);
    const FieldBits& column = layout.field(kColumn);
    if (config.bank_xor)
        for (std::size_t i = 0; i < std::min(row.size(), banks); ++i) place_bits[i].mask ^= row[i].mask;
    if (config.column_xor) {
        std::vector<std::uint64_t*> hashed;  // bank groups, banks, rows, from the lowest bits on
        for (std::size_t i = bank_bits; i < banks; ++i) hashed.push_back(&place_bits[i].mask);
        for (std::size_t i = 0; i < bank_bits; ++i) hashed.push_back(&place_bits[i].mask);
        for (AddressBit& bit : row) hashed.push_back(&bit.mask);
        for (std::size_t i = 0; i < std::min(column.size(), hashed.size()); ++i) *hashed[i] ^= column[i].mask;
    }
    add(column, kColumnShift);
    add(row, kRowShift);
    rank_shift_ = static_cast<int>(banks);
    pseudochannel_shift_ = rank_shift_ + static_cast<int>(layout.field(kRank).size());
    rank_mask_ = config.ranks - 1;

    std::vector<std::uint64_t> masks;
    for (const PlaceBit& bit : place_bits) masks.push_back(bit.mask);
    if (binary_rank(masks) != bits_ - burst_bits)
        throw UserError(where, "two addresses share a place: the bits chosen by XOR are not independent");
    contiguous_bytes_ = std::uint64_t{1} << burst_bits;
    find_moves(place_bits);
    find_contiguous_bytes(place_bits);
}

void AddressMap::find_moves(const std::vector<PlaceBit>& place_bits) {
    CHECK(bits_ < 63, "{} address bits", bits_);
    std::array<std::uint64_t, 64> masks{};  // by distance
    for (const PlaceBit& bit : place_bits)
        for (std::uint64_t from = bit.mask; from != 0; from &= from - 1)
            masks[static_cast<std::size_t>(bit.to - std::countr_zero(from)) % masks.size()] |= from & -from;
    for (std::size_t distance = 0; distance < masks.size(); ++distance)
        if (masks[distance] != 0) move_[moves_++] = {masks[distance], static_cast<int>(distance)};
}

// The lowest address bits count columns, and do nothing else, up to here.
void AddressMap::find_contiguous_bytes(const std::vector<PlaceBit>& place_bits) {
    for (int column = kColumnShift; contiguous_bytes_ < capacity(); ++column, contiguous_bytes_ <<= 1)
        for (const PlaceBit& bit : place_bits)
            if ((bit.to == column ? bit.mask != contiguous_bytes_ : (bit.mask & contiguous_bytes_) != 0))
                return;
}

}  // namespace ropsim
