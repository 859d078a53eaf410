// A DRAM channel as data: timings, geometry, controller queues; presets by name, every value overridable.
#pragma once

#include "base/parameters.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

inline constexpr std::uint32_t kMaxRequestBytes = 256;  // of one request to a channel

enum class DramRefresh : std::uint8_t { kNone, kAllBank, kPerBank };
enum class DramScheduling : std::uint8_t { kFirstReady, kInOrder };
enum class DramArbitration : std::uint8_t { kColumnFirst, kOldest, kRoundRobin };
enum class DramPagePolicy : std::uint8_t { kOpen, kClosed, kTimeout };
enum class DramWriteDrain : std::uint8_t { kWatermark, kSnapshot, kNone };

// All times in cycles of the command clock unless named otherwise. Keys of the parameters are "dram." +
// member name; docs/dram-device-files.md says what each means.
struct DramConfig {
    std::string device;  // preset name or file

    // clock and pins
    std::uint32_t tck_ps = 0;        // command clock period, ps
    std::uint32_t bus_bits = 0;      // data pins of a pseudo-channel (of the channel, if it has only one)
    std::uint32_t burst_length = 0;  // transfers a pin makes for one column command
    std::uint32_t burst = 0;         // cycles of the data bus one column command takes

    // geometry, each a power of two
    std::uint32_t pseudochannels = 0;  // own data pins, banks and queues; the command buses are shared
    std::uint32_t ranks = 0;           // of a pseudo-channel
    std::uint32_t bank_groups = 0;     // of a rank
    std::uint32_t banks_per_group = 0;
    std::uint32_t rows = 0;       // a bank
    std::uint32_t row_bytes = 0;  // a row of the pseudo-channel (all its chips)

    // timings
    std::uint32_t cl = 0, cwl = 0;           // column command to first data
    std::uint32_t trcd_rd = 0, trcd_wr = 0;  // activate to column command
    std::uint32_t trp = 0, tras = 0,
                  trc = 0;  // precharge time, row open at least, activate to activate of a bank
    std::uint32_t tccd_s = 0, tccd_l = 0;  // column to column: other, same bank group
    std::uint32_t trrd_s = 0, trrd_l = 0;  // activate to activate: other, same bank group
    std::uint32_t tfaw = 0, t32aw = 0;     // at most 4 (32) activates of a rank in this window; 0: no limit
    std::uint32_t twr = 0;                 // end of write data to precharge
    std::uint32_t twtr_s = 0, twtr_l = 0;  // end of write data to read command
    std::uint32_t trtp = 0;                // read command to precharge
    std::uint32_t trtw = 0;                // read command to write command
    std::uint32_t trtrs = 0;               // gap on the data bus between ranks
    DramRefresh refresh = DramRefresh::kAllBank;
    std::uint32_t trefi = 0, trfc = 0;      // of a rank: interval (0: none), all-bank refresh time
    std::uint32_t trefipb = 0, trfcpb = 0;  // interval between two banks of a rank, one bank's refresh time
    std::uint32_t trrefd = 0;               // one bank's refresh to an activate or refresh of another

    // command buses; all times above count from a command's last cycle
    bool separate_buses = false;    // row and column commands have a bus each
    std::uint32_t row_bus_act = 0;  // cycles an activate takes
    std::uint32_t row_bus_pre = 0;  // ... a precharge or refresh
    std::uint32_t column_bus = 0;   // ... a read or write

    // address layout, see AddressMap
    std::string mapping;
    // explicit address bits of these fields, instead of the mapping's
    std::string bank_bits, bankgroup_bits, rank_bits, pseudochannel_bits;
    bool bank_xor = false;    // bank and bank group bits are XORed with the lowest row bits
    bool column_xor = false;  // bank group, bank, row bits with column bits from the lowest on (MOP4CLXOR)

    // controller
    DramScheduling scheduler = DramScheduling::kFirstReady;
    DramArbitration arbitration = DramArbitration::kColumnFirst;
    std::uint32_t age_cap = 0;  // a request older than this is served before younger hits of its bank
    std::uint32_t hit_cap = 0;  // column commands a row serves before an older access may close it
    DramPagePolicy page_policy = DramPagePolicy::kOpen;
    std::uint32_t page_timeout = 0;                 // idle cycles after which `timeout` closes a row
    std::uint32_t read_queue = 0, write_queue = 0;  // accesses held, each at most 64
    bool shared_queue = false;                      // one pair of queues for all pseudo-channels
    bool queue_bursts = false;           // an entry is one burst, else the bursts of a request in one row
    std::uint32_t bank_queue = 0;        // commands a bank holds behind the queues; 0: it sees the queues
    bool activated_leave_queue = false;  // an activate frees the entry, and its access goes first
    DramWriteDrain write_drain = DramWriteDrain::kWatermark;
    std::uint32_t write_high = 0, write_low = 0;  // drain writes from `high` queued down to `low`
    std::uint32_t write_idle = 0;                 // ... or once no read is queued for this long
    std::uint32_t write_idle_min = 0;             // ... or at once if this many writes wait
    std::uint32_t write_idle_low = 0;             // ... until, reads having come, so many are left
    std::uint32_t write_batch = 0;                // most writes of a drain while reads wait; 0: no limit
    bool merge_writes = false;           // a write into bytes of a queued write takes no entry of its own
    std::uint32_t forward_cycles = 0;    // latency of a read served from the write queue
    std::uint32_t front_cycles = 0;      // from the queue to the first command
    std::uint32_t back_cycles = 0;       // from the last data to the response
    bool refresh_closes_singly = false;  // banks are closed for a refresh one by one, not all at once

    // energy, of all chips of a rank
    double activate_pj = 0;             // an activate and its precharge
    double read_pj = 0, write_pj = 0;   // a column command
    double refresh_pj = 0;              // a refresh of all banks
    double refresh_bank_pj = 0;         // ... of one
    double active_mw = 0, idle_mw = 0;  // background of a rank with a row open, with none

    std::uint32_t banks_of_rank() const { return bank_groups * banks_per_group; }
    // All of the channel, numbered pseudo-channel, rank, bank group, bank from high to low.
    std::uint32_t banks() const { return pseudochannels * ranks * banks_of_rank(); }
    std::uint32_t banks_of_pseudochannel() const { return ranks * banks_of_rank(); }
    std::uint32_t burst_bytes() const { return bus_bits / 8 * burst_length; }
    std::uint32_t columns() const { return row_bytes / burst_bytes(); }
    std::uint64_t capacity_bytes() const { return std::uint64_t{banks()} * rows * row_bytes; }
    // Of the pins, without any loss.
    double peak_bytes_per_second() const { return pseudochannels * burst_bytes() / (burst * tck_ps * 1e-12); }
    // Fewest cycles between column commands of a pseudo-channel: to another bank group.
    std::uint32_t column_interval() const { return tccd_s > burst ? tccd_s : burst; }
    // From the first cycle of a column command to the end of its data.
    std::uint32_t read_cycles() const { return column_bus - 1 + cl + burst; }
    std::uint32_t write_cycles() const { return column_bus - 1 + cwl + burst; }
    // From the first cycle of an activate to the first of a column command.
    std::uint32_t activate_to_read() const { return issue_gap(row_bus_act, trcd_rd, column_bus); }
    std::uint32_t activate_to_write() const { return issue_gap(row_bus_act, trcd_wr, column_bus); }
    // Between the first cycles of two commands of these lengths whose last are `time` apart.
    static std::uint32_t issue_gap(std::uint32_t first, std::uint32_t time, std::uint32_t second) {
        return time + first > second ? time + first - second : 0;
    }
    // Separate pairs of queues.
    std::uint32_t queue_pairs() const { return shared_queue ? 1 : pseudochannels; }
    // Reads that can be in the channel at a time.
    std::uint32_t max_reads() const {
        return queue_pairs() * read_queue + banks() * (bank_queue + (activated_leave_queue ? 1 : 0));
    }
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
