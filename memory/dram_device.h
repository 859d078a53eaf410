// A DRAM channel as data: timings, geometry, controller queues; presets by name, every value overridable.
#pragma once

#include "base/parameters.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

inline constexpr std::uint32_t kMaxRequestBytes = 256;  // of one request to a channel

// All times in cycles of the command clock unless named otherwise. Keys of the parameters are "dram." +
// member name.
struct DramConfig {
    std::string device;  // preset name or file

    // clock and pins
    std::uint32_t tck_ps = 0;        // command clock period, ps
    std::uint32_t bus_bits = 0;      // data pins of the channel
    std::uint32_t burst_length = 0;  // transfers a pin makes for one column command
    std::uint32_t burst = 0;         // cycles of the data bus one column command takes

    // geometry, each a power of two
    std::uint32_t bank_groups = 0;
    std::uint32_t banks_per_group = 0;
    std::uint32_t rows = 0;       // a bank
    std::uint32_t row_bytes = 0;  // a row of the channel (all its chips)

    // timings
    std::uint32_t cl = 0, cwl = 0;           // column command to first data
    std::uint32_t trcd_rd = 0, trcd_wr = 0;  // activate to column command
    std::uint32_t trp = 0, tras = 0,
                  trc = 0;  // precharge time, row open at least, activate to activate of a bank
    std::uint32_t tccd_s = 0, tccd_l = 0;  // column to column: other, same bank group
    std::uint32_t trrd_s = 0, trrd_l = 0;  // activate to activate: other, same bank group
    std::uint32_t tfaw = 0, t32aw = 0;     // at most 4 (32) activates in this window; 0: no limit
    std::uint32_t twr = 0;                 // end of write data to precharge
    std::uint32_t twtr_s = 0, twtr_l = 0;  // end of write data to read command
    std::uint32_t trtp = 0;                // read command to precharge
    std::uint32_t trtw = 0;                // read command to write command
    std::uint32_t trefi = 0, trfc = 0;     // refresh interval (0: none), all-bank refresh time

    // address layout, see AddressMap
    std::string mapping;
    bool bank_xor = false;  // bank and bank group bits are XORed with the lowest row bits

    // controller
    std::uint32_t read_queue = 0, write_queue = 0;  // accesses (bursts of one row) held, at most 64 together
    std::uint32_t write_high = 0, write_low = 0;    // drain writes from `high` queued down to `low`
    std::uint32_t write_idle = 0;                   // ... or once no read is queued for this long
    std::uint32_t age_cap = 0;         // a request older than this is served before younger hits of its bank
    std::uint32_t forward_cycles = 0;  // latency of a read served from the write queue

    std::uint32_t banks() const { return bank_groups * banks_per_group; }
    std::uint32_t burst_bytes() const { return bus_bits / 8 * burst_length; }
    std::uint32_t columns() const { return row_bytes / burst_bytes(); }
    std::uint64_t capacity_bytes() const { return std::uint64_t{banks()} * rows * row_bytes; }
    // Of the pins, without any loss.
    double peak_bytes_per_second() const { return burst_bytes() / (burst * tck_ps * 1e-12); }
    // Fewest cycles between column commands: to another bank group.
    std::uint32_t column_interval() const { return tccd_s > burst ? tccd_s : burst; }
};

// Names of the presets: gddr3, gddr5, gddr5x, gddr6, hbm2, lpddr4.
std::vector<std::string> dram_device_names();
// One line on a preset, for `ropsim list`.
std::string dram_device_summary(const std::string& name);
// The preset that `dram.device` names (default `fallback`), or the TOML file if it ends in ".toml" (whose own
// dram.device names the preset it starts from, otherwise it must give every key), with every "dram.*" key of
// `parameters` on top. Throws UserError on an unknown device, key or a combination that cannot work.
DramConfig dram_config(Parameters& parameters, const std::string& fallback = "gddr6");

}  // namespace ropsim
