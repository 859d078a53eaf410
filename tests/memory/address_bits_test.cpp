// Explicit and hashed address bits: what they select, that no two addresses meet, and what is refused.
#include "dram_driver.h"

#include "base/error.h"
#include "memory/address_map.h"
#include "memory/memory_system.h"

#include <bit>
#include <set>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using Keys = std::vector<std::pair<std::string, std::string>>;

std::uint32_t bit(std::uint64_t address, int number) {
    return static_cast<std::uint32_t>(address >> number & 1);
}

// A small channel: 32-byte bursts, 4 groups of 4 banks, 8 rows of 8 columns; address bits 5 to 14.
Keys small(Keys keys) {
    keys.insert(keys.end(), {{"dram.rows", "8"}, {"dram.row_bytes", "256"}});
    return keys;
}

void expect_one_to_one(const AddressMap& map, std::uint64_t step) {
    std::set<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> seen;
    for (std::uint64_t a = 0; a < map.capacity(); a += step) {
        const DramPlace p = map.place(a);
        EXPECT_TRUE(seen.insert({p.bank, p.row, p.column}).second) << a;
        const DramPlace block = map.place(a & ~(map.contiguous_bytes() - 1));
        EXPECT_EQ(std::tie(p.bank, p.row), std::tie(block.bank, block.row));
        EXPECT_EQ(p.column, block.column + (a % map.contiguous_bytes()) / step);
    }
}

std::string refusal(const Keys& keys) {
    try {
        Parameters parameters("test");
        parameters.set("dram.device", "gddr6", "test");
        for (const auto& [key, value] : keys) parameters.set(key, value, "test");
        const MemoryConfig config = memory_config(parameters);
        const MemorySystem system(config);
    } catch (const UserError& error) {
        return error.where() + ": " + error.what();
    }
    return "";
}

TEST(AddressBits, TakeTheirPlaceOutOfTheMapping) {
    const DramConfig c = test_config(
        "gddr6", small({{"dram.mapping", "row bank bankgroup column"}, {"dram.bank_bits", "10 7"}}));
    const AddressMap map(c, "test");
    ASSERT_EQ(map.capacity(), 1u << 15);
    for (std::uint64_t a = 0; a < map.capacity(); a += 32) {
        const DramPlace p = map.place(a);
        EXPECT_EQ(p.bank & 3, bit(a, 10) << 1 | bit(a, 7));
        EXPECT_EQ(p.column, bit(a, 8) << 2 | bit(a, 6) << 1 | bit(a, 5));
        EXPECT_EQ(p.bank >> 2, bit(a, 11) << 1 | bit(a, 9));
        EXPECT_EQ(p.row, a >> 12);
    }
    EXPECT_EQ(map.contiguous_bytes(), 128u);  // bit 7 is a bank's
    expect_one_to_one(map, 32);
}

TEST(AddressBits, XorOfSeveralBits) {
    const DramConfig c = test_config("gddr6", small({{"dram.mapping", "row bank bankgroup column"},
                                                     {"dram.bankgroup_bits", "9^13 8^12^14"},
                                                     {"dram.bank_xor", "true"}}));
    const AddressMap map(c, "test");
    for (std::uint64_t a = 0; a < map.capacity(); a += 32) {
        const DramPlace p = map.place(a);
        const std::uint32_t group = (bit(a, 9) ^ bit(a, 13)) << 1 | (bit(a, 8) ^ bit(a, 12) ^ bit(a, 14));
        const std::uint32_t plain = group << 2 | (bit(a, 11) << 1 | bit(a, 10));
        EXPECT_EQ(p.row, a >> 12);
        EXPECT_EQ(p.bank, plain ^ p.row);
    }
    expect_one_to_one(map, 32);
}

// Hashing a bank bit with a column bit moves blocks, but keeps every burst in a place of its own.
TEST(AddressBits, XorWithColumnsShortensTheContiguousBlock) {
    const AddressMap map(test_config("gddr6", small({{"dram.bank_bits", "11^6 10"}})), "test");
    EXPECT_EQ(map.contiguous_bytes(), 64u);
    expect_one_to_one(map, 32);
}

TEST(AddressBits, EveryPresetIsOneToOneWithHashes) {
    for (const std::string& device : dram_device_names()) {
        const Keys keys = {{"dram.rows", "16"}, {"dram.bank_xor", "true"}, {"dram.column_xor", "true"}};
        const DramConfig c = test_config(device, keys);
        expect_one_to_one(AddressMap(c, "test"), c.burst_bytes());
    }
}

// ATTILA's settings: eight channels by bits 10 9 8, eight banks by 13 12 11, of the whole memory's addresses.
TEST(AddressBits, MasksOfTheWholeMemory) {
    Parameters parameters("test");
    parameters.set("dram.device", "gddr3", "test");
    parameters.set("memory.channel_bits", "10 9 8", "test");
    parameters.set("memory.bank_bits", "13 12 11", "test");
    const DramConfig plain = test_config("gddr3");
    ASSERT_EQ(plain.banks_per_group, 8u);
    const MemoryConfig config = memory_config(parameters);
    EXPECT_EQ(config.channels, 8u);
    const ChannelMap channels(config.channel_bits, 40, "test");
    const AddressMap map(config.dram, "test");
    EXPECT_EQ(channels.granule(), 256u);
    for (std::uint64_t a = 0; a < 1 << 20; a += 32) {
        EXPECT_EQ(channels.channel(a), a >> 8 & 7);
        EXPECT_EQ(channels.local(a), (a >> 11) << 8 | (a & 255));
        EXPECT_EQ(map.place(channels.local(a)).bank, a >> 11 & 7);
    }
}

TEST(AddressBits, HashedChannelsAreOneToOne) {
    const ChannelMap map(parse_address_bits("9^12^13 7^11", "test"), 14, "test");
    EXPECT_EQ(map.granule(), 128u);
    std::set<std::pair<std::uint32_t, std::uint64_t>> seen;
    for (std::uint64_t a = 0; a < map.capacity(); ++a) {
        EXPECT_TRUE(seen.insert({map.channel(a), map.local(a)}).second) << a;
        EXPECT_LT(map.local(a), 1u << 12);
        EXPECT_EQ(map.channel(a), (bit(a, 9) ^ bit(a, 12) ^ bit(a, 13)) << 1 | (bit(a, 7) ^ bit(a, 11)));
        const std::uint64_t block = a & ~(map.granule() - 1);
        EXPECT_EQ(map.channel(a), map.channel(block));
        EXPECT_EQ(map.local(a), map.local(block) + a - block);
    }
}

// Over all small matrices: the rank is the logarithm of how many vectors the rows make.
TEST(AddressBits, RankAgreesWithTheSpan) {
    for (std::uint64_t m = 0; m < 1 << 12; ++m) {
        const std::vector<std::uint64_t> rows = {m & 15, m >> 4 & 15, m >> 8};
        std::set<std::uint64_t> span;
        for (unsigned pick = 0; pick < 8; ++pick)
            span.insert(((pick & 1) != 0 ? rows[0] : 0) ^ ((pick & 2) != 0 ? rows[1] : 0) ^
                        ((pick & 4) != 0 ? rows[2] : 0));
        EXPECT_EQ(std::size_t{1} << binary_rank(rows), span.size());
    }
}

TEST(AddressBits, WhatMakesNoMapIsRefused) {
    using testing::HasSubstr;
    EXPECT_EQ(refusal({{"memory.channel_bits", "10 9 8"}}), "");
    EXPECT_THAT(refusal({{"dram.bank_bits", "13"}}), HasSubstr("names 1 bits; 'bank' has 2"));
    EXPECT_THAT(refusal({{"dram.bank_bits", "13 x"}}), HasSubstr("'x' is no address bit"));
    EXPECT_THAT(refusal({{"dram.bank_bits", "13 12^"}}), HasSubstr("'12^'"));
    EXPECT_THAT(refusal({{"dram.bank_bits", "13 -1"}}), HasSubstr("'-1'"));
    EXPECT_THAT(refusal({{"dram.bank_bits", "13 13"}}), HasSubstr("takes bit 13 twice"));
    EXPECT_THAT(refusal({{"dram.bank_bits", "13 12^12"}}), HasSubstr("has bit 12 twice"));
    EXPECT_THAT(refusal({{"dram.bank_bits", "13 3"}}), HasSubstr("bit 3 must be from 5"));
    EXPECT_THAT(refusal({{"dram.bank_bits", "13 40"}}), HasSubstr("bit 40 must be"));
    EXPECT_THAT(refusal({{"dram.bank_bits", "13 12"}, {"dram.bankgroup_bits", "12 11"}}),
                HasSubstr("bit 12 is another field's"));
    EXPECT_THAT(refusal({{"dram.bank_bits", "13^12 12^13"}}), HasSubstr("two addresses share a place"));
    EXPECT_THAT(refusal({{"memory.channel_bits", "9^8 8^9"}}), HasSubstr("two addresses share a place"));
    EXPECT_THAT(refusal({{"memory.channel_bits", "50"}}), HasSubstr("bit 50 is beyond"));
    EXPECT_THAT(refusal({{"memory.channel_bits", "4"}}), HasSubstr("within a burst of 32 bytes"));
    EXPECT_THAT(refusal({{"memory.channels", "6"}}), HasSubstr("6 is not a power of two"));
    EXPECT_THAT(refusal({{"memory.channels", "4"}, {"memory.channel_bits", "8"}}), HasSubstr("4 channels"));
    EXPECT_THAT(refusal({{"memory.channels", "8"}, {"memory.bank_bits", "12 9"}}),
                HasSubstr("bit 9 is the channel's"));
    EXPECT_THAT(refusal({{"memory.bank_bits", "13 12"}, {"dram.bank_bits", "13 12"}}),
                HasSubstr("dram.bank_bits is given"));
}

}  // namespace
}  // namespace ropsim
