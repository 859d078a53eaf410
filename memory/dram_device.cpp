// Reading and checking of DRAM parameters.
#include "memory/dram_device.h"

#include "base/error.h"
#include "memory/address_map.h"
#include "memory/dram_presets.h"

#include <algorithm>
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

constexpr std::int64_t kCycles = 1 << 20;  // longest timing

constexpr IntegerKey kIntegerKeys[] = {
    {"tck_ps", &DramConfig::tck_ps, 1, 1'000'000},
    {"bus_bits", &DramConfig::bus_bits, 8, 1024},
    {"burst_length", &DramConfig::burst_length, 1, 64},
    {"burst", &DramConfig::burst, 1, 64},
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
    {"trefi", &DramConfig::trefi, 0, kCycles},
    {"trfc", &DramConfig::trfc, 0, kCycles},
    {"read_queue", &DramConfig::read_queue, 1, 63},
    {"write_queue", &DramConfig::write_queue, 1, 63},
    {"write_high", &DramConfig::write_high, 1, 63},
    {"write_low", &DramConfig::write_low, 0, 62},
    {"write_idle", &DramConfig::write_idle, 0, kCycles},
    {"age_cap", &DramConfig::age_cap, 1, std::numeric_limits<std::int32_t>::max()},
    {"forward_cycles", &DramConfig::forward_cycles, 1, kCycles},
};

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
    config.bank_xor = parameters.get_flag("dram.bank_xor", config.bank_xor);
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
                  {"dram.bank_groups", c.bank_groups},
                  {"dram.banks_per_group", c.banks_per_group},
                  {"dram.rows", c.rows},
                  {"dram.row_bytes", c.row_bytes}};
    for (const auto& power : powers)
        require(std::has_single_bit(power.value), p, power.key,
                fmt::format("{} is not a power of two", power.value));
    require(c.banks() <= 32, p, "dram.banks_per_group",
            fmt::format("{} banks, at most 32 are modelled", c.banks()));
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
    const std::uint64_t refresh =
        std::uint64_t{c.trfc} + std::uint64_t{2} * c.trc + c.cl + c.cwl + c.burst + c.twr;
    require(c.trefi == 0 || c.trefi > refresh, p, "dram.trefi",
            fmt::format("refreshes leave no time for requests: must be 0 (none) or over {}", refresh));
}

void check_controller(const DramConfig& c, const Parameters& p) {
    require(c.read_queue + c.write_queue <= 64, p, "dram.write_queue",
            fmt::format("read and write queues hold {} accesses, at most 64", c.read_queue + c.write_queue));
    require(c.write_high <= c.write_queue, p, "dram.write_high",
            fmt::format("must not be over write_queue = {}", c.write_queue));
    require(c.write_low < c.write_high, p, "dram.write_low",
            fmt::format("must be below write_high = {}", c.write_high));
    const AddressMap map(c, place_of(p, "dram.mapping"));
    const std::uint64_t pieces = (kMaxRequestBytes - 1) / map.contiguous_bytes() + 2;
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
