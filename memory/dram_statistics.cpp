// Sums and checks over a channel's counts.
#include "memory/dram_statistics.h"

#include "base/error.h"
#include "memory/dram_device.h"

namespace ropsim {
namespace {

constexpr std::array<const char*, kDramLabels> kLabelNames = {
    "read_data",         "write_data", "idle",       "refresh",     "precharge", "activate",
    "activation_window", "turnaround", "column_gap", "command_bus", "write_wait"};

void add_to(DramBytes& sum, const DramBytes& other) {
    sum.useful += other.useful;
    sum.bus += other.bus;
    sum.forwarded += other.forwarded;
}

DramBytes total(const DramStatistics::ByClient& clients) {
    DramBytes sum;
    for (const auto& surface : clients)
        for (const DramBytes& bytes : surface) add_to(sum, bytes);
    return sum;
}

void add_to(DramStatistics::ByClient& sum, const DramStatistics::ByClient& other) {
    for (std::size_t s = 0; s < sum.size(); ++s)
        for (std::size_t c = 0; c < sum[s].size(); ++c) add_to(sum[s][c], other[s][c]);
}

}  // namespace

const char* to_string(DramLabel label) {
    return kLabelNames[static_cast<std::size_t>(label)];
}

DramBytes DramStatistics::total_read() const {
    return total(read);
}
DramBytes DramStatistics::total_write() const {
    return total(write);
}

double DramStatistics::utilisation() const {
    const std::uint64_t data = label(DramLabel::kReadData) + label(DramLabel::kWriteData);
    return bus_cycles == 0 ? 0.0 : static_cast<double>(data) / static_cast<double>(bus_cycles);
}

DramEnergy DramStatistics::energy(const DramConfig& config) const {
    const auto times = [](std::uint64_t count, double each) { return static_cast<double>(count) * each; };
    const double pj_of_mw_cycle = config.tck_ps * 1e-3;  // mW x ps = 1e-15 J
    DramEnergy energy;
    energy.activate = times(activations, config.activate_pj);
    energy.read = times(read_bursts, config.read_pj);
    energy.write = times(write_bursts, config.write_pj);
    energy.refresh = times(refreshes, config.refresh_pj) + times(bank_refreshes, config.refresh_bank_pj);
    energy.background = (times(rank_active_cycles, config.active_mw) +
                         times(rank_cycles - rank_active_cycles, config.idle_mw)) *
                        pj_of_mw_cycle;
    return energy;
}

void DramStatistics::add(const DramStatistics& other) {
    add_to(read, other.read);
    add_to(write, other.write);
    reads += other.reads;
    writes += other.writes;
    forwarded_reads += other.forwarded_reads;
    merged_writes += other.merged_writes;
    read_bursts += other.read_bursts;
    write_bursts += other.write_bursts;
    row_hits += other.row_hits;
    row_misses += other.row_misses;
    row_conflicts += other.row_conflicts;
    activations += other.activations;
    precharges += other.precharges;
    refreshes += other.refreshes;
    bank_refreshes += other.bank_refreshes;
    turnarounds += other.turnarounds;
    blocking_requests += other.blocking_requests;
    blocking_bytes += other.blocking_bytes;
    for (std::size_t i = 0; i < label_cycles.size(); ++i) label_cycles[i] += other.label_cycles[i];
    cycles += other.cycles;
    bus_cycles += other.bus_cycles;
    rank_cycles += other.rank_cycles;
    rank_active_cycles += other.rank_active_cycles;
    read_queue_sum += other.read_queue_sum;
    write_queue_sum += other.write_queue_sum;
    blocked_cycles += other.blocked_cycles;
    read_latency.add(other.read_latency);
}

void DramStatistics::check(std::uint32_t burst_bytes, std::uint32_t burst) const {
    std::uint64_t labelled = 0;
    for (const std::uint64_t count : label_cycles) labelled += count;
    CHECK(labelled == bus_cycles, "{} cycles labelled of {}", labelled, bus_cycles);
    CHECK(rank_active_cycles <= rank_cycles, "{} of {}", rank_active_cycles, rank_cycles);
    CHECK(total_read().bus == read_bursts * burst_bytes, "{} bytes in {} bursts", total_read().bus,
          read_bursts);
    CHECK(total_write().bus == write_bursts * burst_bytes, "{} bytes in {} bursts", total_write().bus,
          write_bursts);
    CHECK(label(DramLabel::kReadData) == read_bursts * burst, "{} cycles", label(DramLabel::kReadData));
    CHECK(label(DramLabel::kWriteData) == write_bursts * burst, "{} cycles", label(DramLabel::kWriteData));
    CHECK(read_latency.count() == reads, "{} latencies of {} reads", read_latency.count(), reads);
}

}  // namespace ropsim
