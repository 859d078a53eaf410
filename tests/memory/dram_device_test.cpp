// Presets, overrides, device files, and what is refused; address layout.
#include "memory/dram_device.h"

#include "dram_driver.h"

#include "base/atomic_file.h"
#include "base/error.h"
#include "memory/address_map.h"

#include <map>
#include <set>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using testing::HasSubstr;

std::string refusal(const std::string& device, const std::vector<std::pair<std::string, std::string>>& keys) {
    try {
        test_config(device, keys);
    } catch (const UserError& error) {
        return error.where() + ": " + error.what();
    }
    return "accepted";
}

TEST(DramDevice, PeakOfThePins) {
    // Pin rates of the data sheets: bits x rate / 8; clock periods are rounded to picoseconds.
    const std::map<std::string, double> gigabytes = {{"gddr3", 4.0},  {"gddr5", 48.0}, {"gddr5x", 48.0},
                                                     {"gddr6", 28.1}, {"hbm2", 32.0},  {"lpddr4", 6.4}};
    EXPECT_EQ(dram_device_names().size(), gigabytes.size());
    for (const std::string& name : dram_device_names()) {
        EXPECT_NEAR(test_config(name).peak_bytes_per_second() * 1e-9 / gigabytes.at(name), 1.0, 0.002)
            << name;
        EXPECT_FALSE(dram_device_summary(name).empty());
        EXPECT_NE(dram_device_summary(name)[0], '#');
    }
}

TEST(DramDevice, KeysOverride) {
    const DramConfig c = test_config("gddr6", {{"dram.trcd_rd", "99"}, {"dram.bank_xor", "true"}});
    EXPECT_EQ(c.trcd_rd, 99u);
    EXPECT_TRUE(c.bank_xor);
    EXPECT_EQ(c.trp, 30u);
    Parameters none("test");
    EXPECT_EQ(dram_config(none, "hbm2").device, "hbm2");
}

TEST(DramDevice, RefusesWhatCannotWork) {
    EXPECT_THAT(refusal("ddr9", {}), HasSubstr("gddr3, gddr5, gddr5x, gddr6, hbm2, lpddr4"));
    EXPECT_THAT(refusal("gddr6", {{"dram.trcdd", "9"}}), HasSubstr("dram.trcdd"));
    EXPECT_THAT(refusal("gddr6", {{"dram.trtw", "5"}}), HasSubstr("collide"));
    EXPECT_THAT(refusal("gddr6", {{"dram.rows", "1000"}}), HasSubstr("power of two"));
    EXPECT_THAT(refusal("gddr6", {{"dram.trefi", "300"}}), HasSubstr("no time"));
    EXPECT_THAT(refusal("gddr6", {{"dram.write_low", "30"}}), HasSubstr("below write_high"));
    EXPECT_THAT(refusal("gddr6", {{"dram.mapping", "row bank column"}}), HasSubstr("bankgroup"));
    EXPECT_THAT(refusal("gddr6", {{"dram.mapping", "row bank bankgroup column column:2 column"}}),
                HasSubstr("column"));
    EXPECT_THAT(refusal("gddr6", {{"dram.mapping", "row stack bank bankgroup column"}}), HasSubstr("stack"));
    EXPECT_THAT(refusal("gddr6", {{"dram.read_queue", "4"}, {"dram.mapping", "row column bank bankgroup"}}),
                HasSubstr("queue entries"));
    EXPECT_THAT(refusal("gddr6", {{"dram.scheduler", "lifo"}}), HasSubstr("fr_fcfs, fcfs"));
    EXPECT_THAT(refusal("gddr6", {{"dram.page_policy", "timeout"}}), HasSubstr("page_timeout"));
    EXPECT_THAT(refusal("hbm2", {{"dram.refresh", "per_bank"}, {"dram.trefipb", "5"}}), HasSubstr("over"));
    EXPECT_THAT(refusal("gddr6", {{"dram.bank_queue", "8"}, {"dram.activated_leave_queue", "true"}}),
                HasSubstr("must be false"));
    EXPECT_THAT(refusal("hbm2", {{"dram.ranks", "4"}}), HasSubstr("at most 64"));
    EXPECT_THAT(refusal("hbm2", {{"dram.mapping", "row bank bankgroup column"}}), HasSubstr("pseudochannel"));
}

TEST(DramDevice, FilesStartFromAPresetOrAreComplete) {
    const std::string path = testing::TempDir() + "ropsim_device.toml";
    write_file(path, "[dram]\ndevice = \"hbm2\"\ntfaw = 16\n");
    EXPECT_EQ(test_config(path).tfaw, 16u);
    EXPECT_EQ(test_config(path).trp, 14u);
    write_file(path, "[dram]\ntfaw = 16\n");
    EXPECT_THAT(refusal(path, {}), HasSubstr("missing"));
    write_file(path, "[dram]\ndevice = \"hbm2\"\ntrtp_l = 3\n");
    EXPECT_THAT(refusal(path, {}), HasSubstr("trtp_l"));
    write_file(path, "[dram]\ndevice = \"" + path + "\"\n");
    EXPECT_THAT(refusal(path, {}), HasSubstr("start from"));
}

// Every address has a place of its own.
TEST(AddressMap, IsOneToOne) {
    for (const char* mapping : {"row bank bankgroup column", "row column bank bankgroup",
                                "row:2 bank column:3 bankgroup row column"})
        for (const char* bank_xor : {"false", "true"}) {
            const DramConfig c = test_config(
                "gddr6", {{"dram.mapping", mapping}, {"dram.rows", "16"}, {"dram.bank_xor", bank_xor}});
            const AddressMap map(c, "test");
            ASSERT_EQ(map.capacity(), c.capacity_bytes());
            std::set<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> places;
            for (std::uint64_t a = 0; a < map.capacity(); a += c.burst_bytes()) {
                const DramPlace p = map.place(a);
                ASSERT_LT(p.bank, c.banks());
                ASSERT_LT(p.row, c.rows);
                ASSERT_LT(p.column, c.columns());
                places.insert({p.bank, p.row, p.column});
                const DramPlace block = map.place(a & ~(map.contiguous_bytes() - 1));
                ASSERT_EQ(p.bank, block.bank);
                ASSERT_EQ(p.row, block.row);
                ASSERT_EQ(p.column - block.column, (a & (map.contiguous_bytes() - 1)) / c.burst_bytes());
            }
            ASSERT_EQ(places.size(), map.capacity() / c.burst_bytes());
        }
}

// Ranks and pseudo-channels, and Ramulator's MOP4CLXOR, which folds column bits into all others.
TEST(AddressMap, RanksPseudochannelsAndColumnXorAreOneToOne) {
    const DramConfig c =
        test_config("hbm2", {{"dram.ranks", "2"},
                             {"dram.rows", "16"},
                             {"dram.column_xor", "true"},
                             {"dram.mapping", "row column rank bank pseudochannel bankgroup column:2"}});
    const AddressMap map(c, "test");
    EXPECT_EQ(map.contiguous_bytes(), c.burst_bytes());
    std::set<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> places;
    for (std::uint64_t a = 0; a < map.capacity(); a += c.burst_bytes()) {
        const DramPlace p = map.place(a);
        ASSERT_EQ(p.bank / c.banks_of_pseudochannel(), p.pseudochannel);
        ASSERT_EQ(p.bank / c.banks_of_rank() % c.ranks, p.rank);
        ASSERT_LT(p.row, c.rows);
        places.insert({p.bank, p.row, p.column});
    }
    EXPECT_EQ(places.size(), map.capacity() / c.burst_bytes());
    // Neighbouring bursts lie in different bank groups; every 16 columns the row's low bits change.
    EXPECT_EQ(map.place(0).bank / c.banks_per_group, 0u);
    EXPECT_EQ(map.place(32).bank / c.banks_per_group, 1u);
    const std::uint64_t column_16 = std::uint64_t{32} << (2 + 2 + 1 + 2 + 1 + 2);
    EXPECT_EQ(map.place(column_16).column, 16u);
    EXPECT_EQ(map.place(column_16).row, 1u);
}

TEST(AddressMap, OrderIsFromHighToLow) {
    const DramConfig c = test_config("gddr6", {{"dram.mapping", "row bank column:4 bankgroup column:2"}});
    const AddressMap map(c, "test");
    EXPECT_EQ(map.contiguous_bytes(), 128u);
    EXPECT_EQ(map.place(96).column, 3u);
    EXPECT_EQ(map.place(128).bank, 4u);  // the next bank group
    EXPECT_EQ(map.place(512).column, 4u);
    EXPECT_EQ(map.place(512 * 16).bank, 1u);  // the next bank of the group
    EXPECT_EQ(map.place(512 * 16 * 4).row, 1u);
}

}  // namespace
}  // namespace ropsim
