// Every timing rule in one table: a scenario of few requests in which one rule binds. The second command
// comes exactly at its cycle, and the independent checker calls it illegal one cycle earlier.
#include "dram_driver.h"
#include "dram_rules.h"

#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using Keys = std::vector<std::pair<std::string, std::string>>;

struct Request {
    DramCycle cycle;
    bool write;
    std::uint32_t pseudochannel, rank, group, bank, row;
};

struct Rule {
    std::string name;
    Keys keys;  // over a device all of whose rules are as short as they can be
    std::vector<Request> requests;
    DramCommand first;
    std::size_t first_index;  // among its kind
    DramCommand second;
    std::size_t second_index;
    DramCycle cycles;
};

void PrintTo(const Rule& rule, std::ostream* out) {
    *out << rule.name;
}

constexpr std::uint32_t kRowBytes = 2048;

DramConfig quick_device(const Keys& more) {
    Keys keys = {{"dram.mapping", "row pseudochannel rank bankgroup bank column"}};
    const std::pair<const char*, const char*> values[] = {{"pseudochannels", "2"},
                                                          {"ranks", "2"},
                                                          {"bank_groups", "2"},
                                                          {"banks_per_group", "4"},
                                                          {"rows", "64"},
                                                          {"burst", "1"},
                                                          {"cl", "4"},
                                                          {"cwl", "4"},
                                                          {"trcd_rd", "1"},
                                                          {"trcd_wr", "1"},
                                                          {"trp", "1"},
                                                          {"tras", "1"},
                                                          {"trc", "2"},
                                                          {"tccd_s", "1"},
                                                          {"tccd_l", "1"},
                                                          {"trrd_s", "1"},
                                                          {"trrd_l", "1"},
                                                          {"tfaw", "0"},
                                                          {"twr", "0"},
                                                          {"twtr_s", "0"},
                                                          {"twtr_l", "0"},
                                                          {"trtp", "1"},
                                                          {"trtw", "1"},
                                                          {"trtrs", "0"},
                                                          {"refresh", "none"},
                                                          {"separate_buses", "true"},
                                                          {"write_idle", "0"}};
    for (const auto& [key, value] : values) keys.emplace_back(std::string("dram.") + key, value);
    for (const auto& [key, value] : more) keys.emplace_back("dram." + key, value);
    return test_config("gddr6", keys);
}

std::uint64_t address(const DramConfig& c, const Request& r) {
    const std::uint64_t bank =
        ((r.pseudochannel * c.ranks + r.rank) * c.bank_groups + r.group) * c.banks_per_group + r.bank;
    return (r.row * std::uint64_t{c.banks()} + bank) * kRowBytes;
}

std::vector<Rule> rules() {
    using enum DramCommand;
    const Request read{0, false, 0, 0, 0, 0, 0};
    const Request other_row{0, false, 0, 0, 0, 0, 1};
    const Request same_group{0, false, 0, 0, 0, 1, 0};
    const Request other_group{0, false, 0, 0, 1, 0, 0};
    const Request other_rank{0, false, 0, 1, 0, 0, 0};
    const Request other_channel{0, false, 1, 0, 0, 0, 0};
    const auto write = [](Request r, DramCycle cycle = 0) {
        r.write = true;
        r.cycle = cycle;
        return r;
    };
    const auto at = [](Request r, DramCycle cycle) {
        r.cycle = cycle;
        return r;
    };
    std::vector<Request> five, thirty_three;
    for (std::uint32_t i = 0; i < 5; ++i) five.push_back({0, false, 0, 0, i % 2, i / 2, 0});
    for (std::uint32_t i = 0; i < 33; ++i) thirty_three.push_back({0, false, 0, 0, i % 2, i / 2 % 4, i / 8});
    return {
        {"tRCD_read", {{"trcd_rd", "50"}}, {read}, kActivate, 0, kRead, 0, 50},
        {"tRCD_write", {{"trcd_wr", "50"}}, {write(read)}, kActivate, 0, kWrite, 0, 50},
        {"tRAS", {{"tras", "50"}, {"trc", "50"}}, {read, other_row}, kActivate, 0, kPrecharge, 0, 50},
        {"tRC", {{"trc", "50"}}, {read, other_row}, kActivate, 0, kActivate, 1, 50},
        {"tRP", {{"trp", "50"}}, {read, other_row}, kPrecharge, 0, kActivate, 1, 50},
        {"tRTP", {{"trtp", "50"}}, {read, other_row}, kRead, 0, kPrecharge, 0, 50},
        {"tWR", {{"twr", "50"}}, {write(read), write(other_row)}, kWrite, 0, kPrecharge, 0, 4 + 1 + 50},
        {"tCCD_L", {{"tccd_l", "50"}}, {read, same_group}, kRead, 0, kRead, 1, 50},
        {"tCCD_S", {{"tccd_s", "50"}, {"tccd_l", "60"}}, {read, other_group}, kRead, 0, kRead, 1, 50},
        {"tCCD_L_write", {{"tccd_l", "50"}}, {write(read), write(same_group)}, kWrite, 0, kWrite, 1, 50},
        {"burst", {{"burst", "50"}, {"trtw", "50"}}, {read, other_group}, kRead, 0, kRead, 1, 50},
        {"tRRD_L", {{"trrd_l", "50"}}, {read, same_group}, kActivate, 0, kActivate, 1, 50},
        {"tRRD_S", {{"trrd_s", "50"}, {"trrd_l", "60"}}, {read, other_group}, kActivate, 0, kActivate, 1, 50},
        {"tFAW", {{"tfaw", "50"}}, five, kActivate, 0, kActivate, 4, 50},
        {"t32AW", {{"t32aw", "500"}, {"read_queue", "64"}}, thirty_three, kActivate, 0, kActivate, 32, 500},
        {"tWTR_L", {{"twtr_l", "50"}}, {write(read), at(same_group, 3)}, kWrite, 0, kRead, 0, 4 + 1 + 50},
        {"tWTR_S",
         {{"twtr_s", "50"}, {"twtr_l", "60"}},
         {write(read), at(other_group, 3)},
         kWrite,
         0,
         kRead,
         0,
         4 + 1 + 50},
        {"tRTW", {{"trtw", "50"}}, {read, write(same_group)}, kRead, 0, kWrite, 0, 50},
        {"tRTRS_read", {{"trtrs", "50"}}, {read, other_rank}, kRead, 0, kRead, 1, 1 + 50},
        {"tRTRS_write", {{"trtrs", "50"}}, {write(read), write(other_rank)}, kWrite, 0, kWrite, 1, 1 + 50},
        {"tRTRS_read_write",
         {{"trtrs", "50"}, {"cl", "9"}, {"trtw", "6"}},
         {read, write(other_rank)},
         kRead,
         0,
         kWrite,
         0,
         9 + 1 + 50 - 4},
        {"tRTRS_write_read",
         {{"trtrs", "50"}, {"cwl", "9"}},
         {write(read), at(other_rank, 3)},
         kWrite,
         0,
         kRead,
         0,
         9 + 1 + 50 - 4},
        {"tRFC",
         {{"refresh", "all_bank"}, {"trefi", "4000"}, {"trfc", "500"}},
         {at(read, 1001)},
         kRefresh,
         0,
         kActivate,
         0,
         500},
        {"tRFCpb",
         {{"refresh", "per_bank"}, {"trefipb", "4000"}, {"trfcpb", "500"}},
         {at(read, 1001)},
         kRefreshBank,
         0,
         kActivate,
         0,
         500},
        {"tRREFD",
         {{"refresh", "per_bank"}, {"trefipb", "4000"}, {"trfcpb", "5"}, {"trrefd", "90"}},
         {at(same_group, 1001)},
         kRefreshBank,
         0,
         kActivate,
         0,
         90},
        {"row_bus_act", {{"row_bus_act", "8"}}, {read, other_channel}, kActivate, 0, kActivate, 1, 8},
        {"row_bus_pre",
         {{"row_bus_pre", "8"}, {"tras", "50"}, {"trc", "50"}, {"trp", "20"}},
         {read, other_channel, other_row, {0, false, 1, 0, 0, 0, 1}},
         kPrecharge,
         0,
         kPrecharge,
         1,
         8},
        {"column_bus", {{"column_bus", "8"}}, {read, other_channel}, kRead, 0, kRead, 1, 8},
        {"one_bus",
         {{"separate_buses", "false"}, {"column_bus", "8"}, {"trcd_rd", "30"}, {"trtw", "30"}},
         {read, at(other_channel, 23)},
         kRead,
         0,
         kActivate,
         1,
         8},
    };
}

class RuleTable : public testing::TestWithParam<Rule> {};
INSTANTIATE_TEST_SUITE_P(Dram, RuleTable, testing::ValuesIn(rules()),
                         [](const auto& rule) { return rule.param.name; });

TEST_P(RuleTable, BlocksUntilItsCycle) {
    const Rule& rule = GetParam();
    const DramConfig c = quick_device(rule.keys);
    DramDriver d(c);
    for (const Request& request : rule.requests)
        d.offer(address(c, request), 1, request.write, request.cycle);
    d.drain();
    std::vector<IssuedCommand>& commands = d.recorder.commands;
    EXPECT_EQ(DramRules(c).check(commands), "");
    const std::vector<DramCycle> firsts = d.recorder.cycles(rule.first);
    const std::vector<DramCycle> seconds = d.recorder.cycles(rule.second);
    ASSERT_GT(firsts.size(), rule.first_index);
    ASSERT_GT(seconds.size(), rule.second_index);
    const DramCycle second = seconds[rule.second_index];
    EXPECT_EQ(second - firsts[rule.first_index], rule.cycles);
    // The same trace with the second command a cycle earlier.
    std::size_t index = rule.second_index;
    for (IssuedCommand& command : commands)
        if (command.command == rule.second && index-- == 0) {
            --command.cycle;
            break;
        }
    EXPECT_NE(DramRules(c).check(commands), "");
}

// A mix of known counts: energies are counts times the device's values.
TEST(DramEnergy, IsCountsTimesCosts) {
    const DramConfig c = quick_device({{"activate_pj", "1000"},
                                       {"read_pj", "10"},
                                       {"write_pj", "7"},
                                       {"refresh_pj", "500"},
                                       {"active_mw", "20"},
                                       {"idle_mw", "4"},
                                       {"refresh", "all_bank"},
                                       {"trefi", "1000"},
                                       {"trfc", "20"}});
    DramDriver d(c);
    d.offer(0, 64, false, 100);    // ACT at 100, two reads; its rank is open until its refresh at 1000
    d.offer(2048, 32, true, 100);  // the next bank
    d.drain();
    d.scheduler.finish(999);
    const DramStatistics& s = d.scheduler.statistics();
    EXPECT_EQ(s.refreshes, 3u);  // ranks 0 to 2 at 250, 500, 750: rank 0 was closed for its own
    const DramEnergy energy = s.energy(c);
    EXPECT_DOUBLE_EQ(energy.activate, 2 * 1000);
    EXPECT_DOUBLE_EQ(energy.read, 2 * 10);
    EXPECT_DOUBLE_EQ(energy.write, 7);
    EXPECT_DOUBLE_EQ(energy.refresh, 3 * 500);
    // Rank 0 was open from 100 to 250; 4 ranks for 999 cycles of 0.57 ns.
    EXPECT_DOUBLE_EQ(energy.background, (150 * 20 + (4 * 999 - 150) * 4) * 0.57);
    EXPECT_DOUBLE_EQ(energy.total(), 2000 + 20 + 7 + 1500 + energy.background);
}

}  // namespace
}  // namespace ropsim
