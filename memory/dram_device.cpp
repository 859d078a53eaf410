// Reading and checking of DRAM parameters.
#include "memory/dram_device.h"

#include "base/error.h"
#include "memory/address_map.h"
#include "memory/dram_presets.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <string_view>

namespace ropsim {
namespace {

struct IntegerKey {
    const char* name;
    std::uint32_t DramConfig::*member;
    std::int64_t low;
    std::int64_t high;
};

struct BitsKey {
    const char* name;
    std::string DramConfig::*member;
};

constexpr BitsKey kBitsKeys[] = {{"bank_bits", &DramConfig::bank_bits},
                                 {"bankgroup_bits", &DramConfig::bankgroup_bits},
                                 {"rank_bits", &DramConfig::rank_bits},
                                 {"pseudochannel_bits", &DramConfig::pseudochannel_bits}};

constexpr std::int64_t kCycles = 1 << 20;  // longest timing

constexpr IntegerKey kIntegerKeys[] = {
    {"tck_ps", &DramConfig::tck_ps, 1, 1'000'000},
    {"bus_bits", &DramConfig::bus_bits, 8, 1024},
    {"burst_length", &DramConfig::burst_length, 1, 64},
    {"burst", &DramConfig::burst, 1, 64},
    {"pseudochannels", &DramConfig::pseudochannels, 1, 4},
    {"ranks", &DramConfig::ranks, 1, 4},
    {"bank_groups", &DramConfig::bank_groups, 1, 8},
    {"banks_per_group", &DramConfig::banks_per_group, 1, 32},
    {"rows", &DramConfig::rows, 1, 1 << 24},
    {"row_bytes", &DramConfig::row_bytes, 64, 1 << 20},
    {"cl", &DramConfig::cl, 1, 1000},
    {"cwl", &DramConfig::cwl, 1, 1000},
    {"trcd_rd", &DramConfig::trcd_rd, 1, 1000},
    {"trcd_wr", &DramConfig::trcd_wr, 1, 1000},
    {"trp", &DramConfig::trp, 1, 1000},
    {"tras", &DramConfig::tras, 1, 1000},
    {"trc", &DramConfig::trc, 1, 1000},
    {"tccd_s", &DramConfig::tccd_s, 1, 1000},
    {"tccd_l", &DramConfig::tccd_l, 1, 1000},
    {"trrd_s", &DramConfig::trrd_s, 1, 1000},
    {"trrd_l", &DramConfig::trrd_l, 1, 1000},
    {"tfaw", &DramConfig::tfaw, 0, 10'000},
    {"t32aw", &DramConfig::t32aw, 0, 100'000},
    {"twr", &DramConfig::twr, 0, 1000},
    {"twtr_s", &DramConfig::twtr_s, 0, 1000},
    {"twtr_l", &DramConfig::twtr_l, 0, 1000},
    {"trtp", &DramConfig::trtp, 1, 1000},
    {"trtw", &DramConfig::trtw, 1, 1000},
    {"trtrs", &DramConfig::trtrs, 0, 1000},
    {"trefi", &DramConfig::trefi, 0, kCycles},
    {"trfc", &DramConfig::trfc, 0, kCycles},
    {"trefipb", &DramConfig::trefipb, 0, kCycles},
    {"trfcpb", &DramConfig::trfcpb, 0, kCycles},
    {"trrefd", &DramConfig::trrefd, 0, 1000},
    {"row_bus_act", &DramConfig::row_bus_act, 1, 8},
    {"row_bus_pre", &DramConfig::row_bus_pre, 1, 8},
    {"column_bus", &DramConfig::column_bus, 1, 8},
    {"age_cap", &DramConfig::age_cap, 1, std::numeric_limits<std::int32_t>::max()},
    {"hit_cap", &DramConfig::hit_cap, 0, kCycles},
    {"page_timeout", &DramConfig::page_timeout, 0, kCycles},
    {"read_queue", &DramConfig::read_queue, 1, 64},
    {"write_queue", &DramConfig::write_queue, 1, 64},
    {"bank_queue", &DramConfig::bank_queue, 0, 64},
    {"write_high", &DramConfig::write_high, 1, 64},
    {"write_low", &DramConfig::write_low, 0, 63},
    {"write_idle", &DramConfig::write_idle, 0, kCycles},
    {"write_idle_min", &DramConfig::write_idle_min, 1, 64},
    {"write_idle_low", &DramConfig::write_idle_low, 0, 64},
    {"write_batch", &DramConfig::write_batch, 0, kCycles},
    {"forward_cycles", &DramConfig::forward_cycles, 1, kCycles},
    {"front_cycles", &DramConfig::front_cycles, 0, 1000},
    {"back_cycles", &DramConfig::back_cycles, 0, 1000},
};

struct FlagKey {
    const char* name;
    bool DramConfig::*member;
};
constexpr FlagKey kFlagKeys[] = {
    {"bank_xor", &DramConfig::bank_xor},
    {"column_xor", &DramConfig::column_xor},
    {"separate_buses", &DramConfig::separate_buses},
    {"shared_queue", &DramConfig::shared_queue},
    {"queue_bursts", &DramConfig::queue_bursts},
    {"activated_leave_queue", &DramConfig::activated_leave_queue},
    {"merge_writes", &DramConfig::merge_writes},
    {"refresh_closes_singly", &DramConfig::refresh_closes_singly},
};

struct RealKey {
    const char* name;
    double DramConfig::*member;
};
constexpr RealKey kEnergyKeys[] = {
    {"activate_pj", &DramConfig::activate_pj},
    {"read_pj", &DramConfig::read_pj},
    {"write_pj", &DramConfig::write_pj},
    {"refresh_pj", &DramConfig::refresh_pj},
    {"refresh_bank_pj", &DramConfig::refresh_bank_pj},
    {"active_mw", &DramConfig::active_mw},
    {"idle_mw", &DramConfig::idle_mw},
};

// A key whose value is one of a few words; the words stand in the order of the enumerators.
template <class Enum, std::size_t N>
void read_choice(Parameters& parameters, const std::string& key, const std::array<const char*, N>& words,
                 Enum& value) {
    const std::string fallback = words[static_cast<std::size_t>(value)];
    const std::string word = parameters.get_string(key, fallback);
    for (std::size_t i = 0; i < N; ++i)
        if (word == words[i]) {
            value = static_cast<Enum>(i);
            return;
        }
    std::string list;
    for (const char* one : words) list += std::string(list.empty() ? "" : ", ") + one;
    throw UserError(parameters.where(key), fmt::format("'{}' is not one of {}", word, list));
}

// Reads every key of `parameters` over what `config` holds. `complete`: a key that is not given is an error.
void read_keys(Parameters& parameters, DramConfig& config, bool complete) {
    const auto need = [&](const std::string& key) {
        if (complete && !parameters.has(key))
            throw UserError(
                parameters.context(),
                fmt::format("'{}' is missing; give it, or name a device to start from with dram.device",
                            key));
    };
    for (const IntegerKey& entry : kIntegerKeys) {
        const std::string key = std::string("dram.") + entry.name;
        need(key);
        std::uint32_t& value = config.*entry.member;
        const std::int64_t fallback = complete ? entry.low : value;
        value = static_cast<std::uint32_t>(parameters.get_integer(key, fallback, entry.low, entry.high));
    }
    need("dram.mapping");
    config.mapping = parameters.get_string("dram.mapping", config.mapping);
    for (const BitsKey& entry : kBitsKeys) {
        std::string& value = config.*entry.member;
        value = parameters.get_string(std::string("dram.") + entry.name, value);
    }
    for (const FlagKey& entry : kFlagKeys) {
        const std::string key = std::string("dram.") + entry.name;
        need(key);
        config.*entry.member = parameters.get_flag(key, config.*entry.member);
    }
    for (const RealKey& entry : kEnergyKeys) {
        const std::string key = std::string("dram.") + entry.name;
        need(key);
        config.*entry.member = parameters.get_real(key, config.*entry.member, 0, 1e9);
    }
    for (const char* key : {"refresh", "scheduler", "arbitration", "page_policy", "write_drain"})
        need(std::string("dram.") + key);
    read_choice(parameters, "dram.refresh", std::array{"none", "all_bank", "per_bank"}, config.refresh);
    read_choice(parameters, "dram.scheduler", std::array{"fr_fcfs", "fcfs"}, config.scheduler);
    read_choice(parameters, "dram.arbitration", std::array{"column_first", "oldest", "round_robin"},
                config.arbitration);
    read_choice(parameters, "dram.page_policy", std::array{"open", "closed", "timeout"}, config.page_policy);
    read_choice(parameters, "dram.write_drain", std::array{"watermark", "snapshot", "none"},
                config.write_drain);
}

const DramPreset* find_preset(std::string_view name) {
    for (const DramPreset& preset : dram_presets())
        if (preset.name == name) return &preset;
    return nullptr;
}

std::string place_of(const Parameters& parameters, const std::string& key) {
    return parameters.has(key) ? parameters.where(key) : fmt::format("{}: {}", parameters.context(), key);
}

void require(bool holds, const Parameters& parameters, const char* key, const std::string& rule) {
    if (!holds) throw UserError(place_of(parameters, key), rule);
}

void check_geometry(const DramConfig& c, const Parameters& p) {
    const struct {
        const char* key;
        std::uint32_t value;
    } powers[] = {{"dram.bus_bits", c.bus_bits},
                  {"dram.burst_length", c.burst_length},
                  {"dram.pseudochannels", c.pseudochannels},
                  {"dram.ranks", c.ranks},
                  {"dram.bank_groups", c.bank_groups},
                  {"dram.banks_per_group", c.banks_per_group},
                  {"dram.rows", c.rows},
                  {"dram.row_bytes", c.row_bytes}};
    for (const auto& power : powers)
        require(std::has_single_bit(power.value), p, power.key,
                fmt::format("{} is not a power of two", power.value));
    require(c.banks() <= 64, p, "dram.banks_per_group",
            fmt::format("{} banks in the channel, at most 64 are modelled", c.banks()));
    require(c.burst_bytes() <= c.row_bytes, p, "dram.row_bytes",
            fmt::format("a row of {} bytes is smaller than a burst of {}", c.row_bytes, c.burst_bytes()));
}

void check_timings(const DramConfig& c, const Parameters& p) {
    require(c.trtw + c.cwl >= c.cl + c.burst, p, "dram.trtw",
            fmt::format("read and write data collide: trtw must be at least cl + burst - cwl = {}",
                        std::int64_t{c.cl} + c.burst - c.cwl));
    require(c.trtw >= c.burst, p, "dram.trtw", fmt::format("must be at least the burst of {}", c.burst));
    require(c.trc >= c.tras, p, "dram.trc", fmt::format("must be at least tras = {}", c.tras));
    require(c.tccd_l >= c.tccd_s, p, "dram.tccd_l", fmt::format("must be at least tccd_s = {}", c.tccd_s));
    require(c.trrd_l >= c.trrd_s, p, "dram.trrd_l", fmt::format("must be at least trrd_s = {}", c.trrd_s));
    require(c.twtr_l >= c.twtr_s, p, "dram.twtr_l", fmt::format("must be at least twtr_s = {}", c.twtr_s));
    // A refresh must end, and leave time for a row cycle, before the next one is due.
    const std::uint64_t row_cycle = std::uint64_t{2} * c.trc + c.cl + c.cwl + c.burst + c.twr +
                                    std::uint64_t{c.banks_of_rank()} * c.row_bus_pre;
    require(
        c.refresh != DramRefresh::kAllBank || c.trefi == 0 || c.trefi > c.trfc + row_cycle, p, "dram.trefi",
        fmt::format("refreshes leave no time for requests: must be 0 (none) or over {}", c.trfc + row_cycle));
    if (c.refresh != DramRefresh::kPerBank) return;
    require(std::uint64_t{c.trefipb} * c.banks_of_rank() > c.trfcpb + row_cycle && c.trefipb > c.trrefd, p,
            "dram.trefipb",
            fmt::format("a bank's refreshes leave no time for requests: must be over {}",
                        std::max<std::uint64_t>((c.trfcpb + row_cycle) / c.banks_of_rank(), c.trrefd)));
}

void check_controller(const DramConfig& c, const Parameters& p) {
    require(c.write_high <= c.write_queue, p, "dram.write_high",
            fmt::format("must not be over write_queue = {}", c.write_queue));
    require(c.write_low < c.write_high, p, "dram.write_low",
            fmt::format("must be below write_high = {}", c.write_high));
    require(c.page_policy != DramPagePolicy::kTimeout || c.page_timeout != 0, p, "dram.page_timeout",
            "must be at least 1 with page_policy = timeout");
    require(c.bank_queue == 0 || !c.activated_leave_queue, p, "dram.activated_leave_queue",
            "must be false with a bank_queue: accesses leave the queue for it");
    std::string layout_key = "dram.mapping";
    for (const BitsKey& entry : kBitsKeys)
        if (const std::string key = std::string("dram.") + entry.name; p.has(key)) layout_key = key;
    const AddressMap map(c, place_of(p, layout_key));
    const std::uint64_t entry = c.queue_bursts ? c.burst_bytes() : map.contiguous_bytes();
    const std::uint64_t pieces = (kMaxRequestBytes - 1) / entry + 2;
    require(pieces <= std::min(c.read_queue, c.write_queue), p, "dram.mapping",
            fmt::format("a request of {} bytes may take {} queue entries, more than a queue has",
                        kMaxRequestBytes, pieces));
}

DramConfig from_preset(const DramPreset& preset) {
    Parameters values = Parameters::from_toml_text(fmt::format("DRAM preset '{}'", preset.name), preset.text,
                                                   fmt::format("memory/devices/{}.toml", preset.name));
    DramConfig config;
    read_keys(values, config, true);
    values.close();
    config.device = preset.name;
    return config;
}

DramConfig from_device(const std::string& device, const std::string& where) {
    if (const DramPreset* preset = find_preset(device)) return from_preset(*preset);
    if (!device.ends_with(".toml")) {
        std::string names;
        for (const std::string& name : dram_device_names()) names += (names.empty() ? "" : ", ") + name;
        throw UserError(where, fmt::format("no DRAM device '{}'; one of {}, or a .toml file", device, names));
    }
    Parameters values = Parameters::from_toml_file(fmt::format("DRAM device '{}'", device), device);
    DramConfig config;
    const std::string base = values.get_string("dram.device", "");
    if (base.ends_with(".toml"))
        throw UserError(values.where("dram.device"),
                        "a device file can start from a preset only, not from a file");
    if (!base.empty()) config = from_device(base, values.where("dram.device"));
    read_keys(values, config, base.empty());
    values.close();
    config.device = device;
    return config;
}

}  // namespace

std::vector<std::string> dram_device_names() {
    std::vector<std::string> names;
    for (const DramPreset& preset : dram_presets()) names.emplace_back(preset.name);
    return names;
}

std::string dram_device_summary(const std::string& name) {
    const DramPreset* preset = find_preset(name);
    CHECK(preset != nullptr, "{}", name);
    const std::string_view line = preset->text.substr(0, preset->text.find('\n'));
    return std::string(line.substr(line.find_first_not_of("# ")));
}

DramConfig dram_config(Parameters& parameters, const std::string& fallback) {
    const std::string device = parameters.get_string("dram.device", fallback);
    DramConfig config = from_device(device, place_of(parameters, "dram.device"));
    read_keys(parameters, config, false);
    check_geometry(config, parameters);
    check_timings(config, parameters);
    check_controller(config, parameters);
    return config;
}

}  // namespace ropsim
