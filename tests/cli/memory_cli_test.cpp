// `ropsim memory` as a user and a script meet it.
#include "tests/cli/cli_driver.h"

#include <cmath>

namespace ropsim {
namespace {

using nlohmann::json;

constexpr const char* kLines = "0x0 READ 0\n0x40 READ 0\n0x0 WRITE 500\n0x20000000 read 1000\n";

class MemoryCli : public Cli {
 protected:
    json simulate(const Arguments& more) const {
        Arguments all = {"memory", "--json"};
        all.insert(all.end(), more.begin(), more.end());
        return expect_json(all);
    }
};

TEST_F(MemoryCli, KeysAreThoseThatScriptsRead) {
    write_file(path("t"), kLines);
    const json run = simulate({path("t"), "--device", "gddr5"});
    EXPECT_EQ(run["useful_bytes"], 256);
    EXPECT_EQ(run["bus_bytes"], 256);
    EXPECT_GE(run["cycles"], 1000);
    EXPECT_DOUBLE_EQ(run["seconds"].get<double>(), run["cycles"].get<double>() * 667e-12);
    EXPECT_DOUBLE_EQ(run["bytes_per_second"].get<double>(), 256 / run["seconds"].get<double>());
    // 64 pins at 8 transfers in two cycles of 667 ps
    EXPECT_NEAR(run["percent_of_peak"].get<double>(),
                100 * run["bytes_per_second"].get<double>() / (64.0 / (2 * 667e-12)), 1e-9);
    EXPECT_EQ(run["row_hits"].get<int>() + run["row_misses"].get<int>() + run["row_conflicts"].get<int>(), 4);
    EXPECT_GE(run["activations"], 1);
    const json latency = run["read_latency_ns"];
    for (const char* key : {"mean", "p50", "p99", "max"}) EXPECT_GT(latency[key].get<double>(), 20) << key;
    EXPECT_LE(latency["p99"], latency["max"]);
    EXPECT_GT(run["host"]["seconds"].get<double>(), 0);
    EXPECT_NEAR(run["host"]["requests_per_second"].get<double>(), 4 / run["host"]["seconds"].get<double>(),
                1);
    EXPECT_EQ(run["configuration"]["dram.device"], "\"gddr5\"");
    EXPECT_EQ(run["wrapped_requests"], 0);
    std::uint64_t labelled = 0;
    for (const auto& [label, cycles] : run["bus_cycles"].items()) labelled += cycles.get<std::uint64_t>();
    EXPECT_EQ(labelled, run["cycles"]);
}

TEST_F(MemoryCli, WithoutReadsThereIsNoLatency) {
    write_file(path("t"), "0x0 WRITE 0\n");
    EXPECT_TRUE(simulate({path("t")})["read_latency_ns"]["mean"].is_null());
    EXPECT_THAT(expect_done({"memory", path("t")}), testing::HasSubstr("no reads"));
}

TEST_F(MemoryCli, ChannelsAddUpAndMasksChoose) {
    const Arguments masks = {"--pattern",  "seq_mix50",
                             "--requests", "8000",
                             "--device",   "gddr3",
                             "--set",      "memory.channel_bits=10 9 8",
                             "--set",      "memory.bank_bits=13 12 11"};
    const json run = simulate(masks);
    ASSERT_EQ(run["channels"].size(), 8u);
    for (const char* key :
         {"reads", "writes", "activations", "row_hits", "read_bus_bytes", "write_bus_bytes"}) {
        std::uint64_t sum = 0;
        for (const json& channel : run["channels"]) sum += channel[key].get<std::uint64_t>();
        EXPECT_EQ(run[key], sum) << key;
    }
    for (const json& channel : run["channels"])
        EXPECT_EQ(channel["reads"].get<int>() + channel["writes"].get<int>(), 1000);
    EXPECT_EQ(run["useful_bytes"], 8000 * 64);
    EXPECT_EQ(run["configuration"]["dram.bank_bits"], "\"10 9 8\"");
    // A stride of four times 256 bytes falls into two of the eight channels; a hash spreads it.
    write_file(path("t"), "0x0 READ 0\n0x400 READ 0\n0x800 READ 0\n0xc00 READ 0\n");
    const json strided = simulate({path("t"), "--set", "memory.channels=8"});
    EXPECT_EQ(strided["channels"][0]["reads"], 2);
    EXPECT_EQ(strided["channels"][4]["reads"], 2);
    const json hashed = simulate({path("t"), "--set", "memory.channel_bits=10 9^11 8"});
    EXPECT_EQ(hashed["channels"][0]["reads"], 1);
    EXPECT_EQ(hashed["channels"][2]["reads"], 1);
    EXPECT_EQ(hashed["channels"][6]["reads"], 1);
}

TEST_F(MemoryCli, AWrittenTraceGivesTheSameRun) {
    for (const char* pattern : {"rand_mix50", "chase", "stride_rmw"}) {
        json made = simulate({"--pattern", pattern, "--requests", "3000", "--device", "hbm2", "--write-trace",
                              path("written")});
        json read = simulate({path("written"), "--device", "hbm2"});
        made.erase("host");
        read.erase("host");
        EXPECT_EQ(made, read) << pattern;
    }
    const std::string text = read_file(path("written"));
    EXPECT_THAT(text, testing::StartsWith("0x0 READ 0\n0x1000 READ 0\n"));
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3000);
}

// One at a time: each read alone, ending CL and a burst after its row is open.
TEST_F(MemoryCli, OutstandingLimitsTheStream) {
    const Arguments stream = {"--pattern", "rand_read", "--requests", "2000", "--device", "gddr5"};
    Arguments limited = stream;
    limited.insert(limited.end(), {"--outstanding", "1"});
    const json free = simulate(stream);
    const json one = simulate(limited);
    EXPECT_LT(one["read_latency_ns"]["mean"], free["read_latency_ns"]["mean"]);
    EXPECT_GT(one["cycles"].get<double>(), 3 * free["cycles"].get<double>());
}

TEST_F(MemoryCli, AddressesOverTheCapacityWrapAndAreSaid) {
    write_file(path("t"), kLines);
    const ProgramResult run = run_program({"memory", path("t"), "--json"});  // gddr6: 512 MiB
    EXPECT_EQ(run.status, 0);
    EXPECT_THAT(run.err, testing::HasSubstr("1 of 4 requests"));
    EXPECT_EQ(json::parse(run.out)["wrapped_requests"], 1);
}

TEST_F(MemoryCli, DevicesAreListed) {
    const json list = expect_json({"list", "devices", "--json"});
    ASSERT_GE(list.size(), 6u);
    for (const json& device : list)
        EXPECT_EQ(
            simulate({"--pattern", "chase", "--requests", "10", "--device", device["name"]})["requests"], 10);
}

TEST_F(MemoryCli, TextHasUnits) {
    const std::string text =
        expect_done({"memory", "--pattern", "seq_read", "--requests", "1000", "--set", "memory.channels=2"});
    for (const char* word :
         {"GB/s", "% of the pins' peak", "MB useful", "on the bus", "cycles of 570 ps", "activations",
          "conflicts", "p99", "read_data", "pJ a useful bit", "million requests a second", "channel"})
        EXPECT_THAT(text, testing::HasSubstr(word));
    EXPECT_THAT(expect_done({"memory", "--help"}), testing::HasSubstr("Bandwidth is useful bytes over"));
}

TEST_F(MemoryCli, FaultsAreRefusedInOneLine) {
    write_file(path("bad"), "0x0 READ 0\n0x40 FETCH 1\n");
    write_file(path("empty"), "");
    write_file(path("device.toml"), "[dram]\ndevice = \"gddr6\"\nspeed = 3\n");
    expect_refused({"memory", path("bad")}, {path("bad") + ":2", "'FETCH'"});
    expect_refused({"memory", path("empty")}, {path("empty"), "no request"});
    expect_refused({"memory", path("none")}, {path("none")});
    expect_refused({"memory", path("")}, {"directory"});
    const auto with = [&](const std::string& setting) {
        return Arguments{"memory", "--pattern", "chase", "--set", setting};
    };
    expect_refused(with("dram.trcfd=1"), {"dram.trcfd"});
    expect_refused(with("memory.chanels=2"), {"memory.chanels", "memory.channels"});
    expect_refused(with("memory.channels=3"), {"--set: memory.channels", "power of two"});
    expect_refused(with("memory.channel_bits=60"), {"--set: memory.channel_bits", "bit 60"});
    expect_refused(with("dram.bank_bits=13"), {"--set: dram.bank_bits", "'bank' has 2"});
    expect_refused(with("memory.bank_bits=13 12^"), {"--set: memory.bank_bits", "'12^'"});
    expect_refused(with("channels"), {"--set", "key=value"});
    expect_refused({"memory", "--pattern", "chase", "--device", "ddr9"}, {"--device", "ddr9", "hbm2"});
    expect_refused({"memory", "--pattern", "chase", "--device", path("device.toml")},
                   {"device.toml:3", "speed"});
    expect_refused({"memory", "--pattern", "chase", "--span", "100"}, {"--span", "multiple"});
    expect_refused({"memory", "--pattern", "chase", "--span", "1099511627776"}, {"--span", "holds"});
    expect_refused({"memory", path("bad"), "--write-trace", path("out")}, {":2"});
    expect_refused({"memory", path("bad"), "--write-trace", path("bad")}, {path("bad")});
    EXPECT_FALSE(exists("out"));
    EXPECT_EQ(entries(), 4u);
    expect_misused({"memory"});
    expect_misused({"memory", path("bad"), "--pattern", "chase"});
    expect_misused({"memory", "--pattern", "zigzag"});
    expect_misused({"memory", "--pattern", "chase", "--requests", "0"});
    expect_misused({"memory", "--pattern", "chase", "--outstanding", "-1"});
}

}  // namespace
}  // namespace ropsim
