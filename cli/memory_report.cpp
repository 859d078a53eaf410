// A memory's run as JSON and as text.
#include "cli/memory_report.h"

#include "analysis/text_table.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

double ratio(double part, double whole) {
    return whole == 0 ? 0.0 : part / whole;
}
double ratio(std::uint64_t part, std::uint64_t whole) {
    return ratio(static_cast<double>(part), static_cast<double>(whole));
}

double nanoseconds(double cycles, const MemoryConfig& config) {
    return cycles * config.dram.tck_ps * 1e-3;
}

Json latency_json(const LatencyHistogram& latency, const MemoryConfig& config) {
    Json json = {{"mean", nullptr}, {"p50", nullptr}, {"p99", nullptr}, {"max", nullptr}};
    if (latency.count() == 0) return json;
    json["mean"] = nanoseconds(latency.mean(), config);
    json["p50"] = nanoseconds(latency.percentile(0.5), config);
    json["p99"] = nanoseconds(latency.percentile(0.99), config);
    json["max"] = nanoseconds(static_cast<double>(latency.maximum()), config);
    json["histogram"] = Json::array();
    double below = 2;
    for (const std::uint64_t count : latency.octaves()) {
        if (count != 0)
            json["histogram"].push_back({{"below", nanoseconds(below, config)}, {"reads", count}});
        below *= 2;
    }
    return json;
}

// Null where the device says nothing about energy.
Json energy_json(const DramEnergy& energy) {
    if (energy.total() == 0) return nullptr;
    return {{"activate", energy.activate * 1e-12},     {"read", energy.read * 1e-12},
            {"write", energy.write * 1e-12},           {"refresh", energy.refresh * 1e-12},
            {"background", energy.background * 1e-12}, {"total", energy.total() * 1e-12}};
}

// What a channel and the whole have in common.
void add_counts(Json& json, const DramStatistics& s, const MemoryConfig& config) {
    const DramBytes read = s.total_read();
    const DramBytes write = s.total_write();
    json["reads"] = s.reads;
    json["writes"] = s.writes;
    json["read_useful_bytes"] = read.useful;
    json["write_useful_bytes"] = write.useful;
    json["read_bus_bytes"] = read.bus;
    json["write_bus_bytes"] = write.bus;
    json["forwarded_bytes"] = read.forwarded;
    json["merged_bytes"] = write.forwarded;
    json["utilisation"] = s.utilisation();
    json["activations"] = s.activations;
    json["precharges"] = s.precharges;
    json["refreshes"] = s.refreshes;
    json["bank_refreshes"] = s.bank_refreshes;
    json["turnarounds"] = s.turnarounds;
    json["row_hits"] = s.row_hits;
    json["row_misses"] = s.row_misses;
    json["row_conflicts"] = s.row_conflicts;
    json["blocked_cycles"] = s.blocked_cycles;
    json["read_queue_mean"] = ratio(s.read_queue_sum, s.cycles);
    json["write_queue_mean"] = ratio(s.write_queue_sum, s.cycles);
    json["read_latency_ns"] = latency_json(s.read_latency, config);
    json["energy_joules"] = energy_json(s.energy(config.dram));
    Json labels = Json::object();
    for (int i = 0; i < kDramLabels; ++i) {
        const auto label = static_cast<DramLabel>(i);
        labels[to_string(label)] = s.label(label);
    }
    json["bus_cycles"] = std::move(labels);
}

std::string megabytes(std::uint64_t bytes) {
    return fmt::format("{:.3f} MB", static_cast<double>(bytes) * 1e-6);
}

std::string gigabytes_per_second(std::uint64_t bytes, double seconds) {
    return fmt::format("{:.3f}", ratio(static_cast<double>(bytes), seconds) * 1e-9);
}

std::string latency_text(const MemoryRun& run, const MemoryConfig& config) {
    const LatencyHistogram& latency = run.total.read_latency;
    if (latency.count() == 0) return "no reads";
    const auto ns = [&](double cycles) { return nanoseconds(cycles, config); };
    return fmt::format("mean {:.1f} ns, p50 {:.1f}, p99 {:.1f}, max {:.1f}", ns(latency.mean()),
                       ns(latency.percentile(0.5)), ns(latency.percentile(0.99)),
                       ns(static_cast<double>(latency.maximum())));
}

// The labels of the channels' cycles, the largest first.
std::string cycles_text(const DramStatistics& total) {
    std::vector<std::pair<std::uint64_t, const char*>> parts;
    for (int i = 0; i < kDramLabels; ++i) {
        const auto label = static_cast<DramLabel>(i);
        if (total.label(label) != 0) parts.emplace_back(total.label(label), to_string(label));
    }
    std::stable_sort(parts.begin(), parts.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    std::string text;
    for (const auto& [cycles, name] : parts)
        text += fmt::format("{}{} {:.1f}%", text.empty() ? "" : ", ", name,
                            100 * ratio(cycles, total.bus_cycles));
    return text;
}

std::string energy_text(const MemoryRun& run, const MemoryConfig& config) {
    const DramEnergy energy = run.total.energy(config.dram);
    const double total = energy.total();
    if (total == 0) return "unknown: the device gives none";
    const auto share = [&](double part) { return 100 * ratio(part, total); };
    return fmt::format(
        "{:.3f} mJ, {:.2f} pJ a useful bit: activate {:.1f}%, read {:.1f}%, write {:.1f}%, refresh {:.1f}%, "
        "background {:.1f}%",
        total * 1e-9, ratio(total, 8.0 * static_cast<double>(run.useful_bytes())), share(energy.activate),
        share(energy.read), share(energy.write), share(energy.refresh), share(energy.background));
}

std::string channel_table(const MemoryRun& run, const MemoryConfig& config) {
    std::vector<std::vector<std::string>> rows = {
        {"channel", "requests", "GB/s", "% of peak", "row hits", "misses", "conflicts", "mean read ns"}};
    for (std::size_t c = 0; c < run.channels.size(); ++c) {
        const DramStatistics& s = run.channels[c];
        const std::uint64_t useful = s.total_read().useful + s.total_write().useful;
        const double share =
            100 * ratio(static_cast<double>(useful), run.seconds * config.dram.peak_bytes_per_second());
        rows.push_back(
            {fmt::format("{}", c), fmt::format("{}", s.reads + s.writes),
             gigabytes_per_second(useful, run.seconds), fmt::format("{:.1f}", share),
             fmt::format("{}", s.row_hits), fmt::format("{}", s.row_misses),
             fmt::format("{}", s.row_conflicts),
             s.reads == 0 ? "-" : fmt::format("{:.1f}", nanoseconds(s.read_latency.mean(), config))});
    }
    return aligned_table(rows);
}

}  // namespace

std::string memory_run_json(const MemoryRun& run, const MemoryConfig& config, const Parameters& parameters) {
    const double peak = config.peak_bytes_per_second();
    Json json = {{"device", config.dram.device},
                 {"requests", run.requests},
                 {"useful_bytes", run.useful_bytes()},
                 {"bus_bytes", run.bus_bytes()},
                 {"cycles", run.cycles},
                 {"seconds", run.seconds},
                 {"bytes_per_second", run.bytes_per_second()},
                 {"bus_bytes_per_second", ratio(static_cast<double>(run.bus_bytes()), run.seconds)},
                 {"peak_bytes_per_second", peak},
                 {"percent_of_peak", 100 * run.bytes_per_second() / peak}};
    add_counts(json, run.total, config);
    json["capacity_bytes"] = run.capacity;
    json["wrapped_requests"] = run.wrapped_requests;
    json["channels"] = Json::array();
    for (const DramStatistics& s : run.channels) {
        Json channel = Json::object();
        add_counts(channel, s, config);
        json["channels"].push_back(std::move(channel));
    }
    json["configuration"] = Json::object();
    for (const auto& [key, resolved] : parameters.resolved()) json["configuration"][key] = resolved.value;
    json["host"] = {{"seconds", run.host_seconds},
                    {"requests_per_second", ratio(static_cast<double>(run.requests), run.host_seconds)},
                    {"source_seconds", run.host_source_seconds}};
    return json.dump(2) + "\n";
}

std::string memory_run_text(const MemoryRun& run, const MemoryConfig& config) {
    const DramStatistics& s = run.total;
    const double peak = config.peak_bytes_per_second();
    const std::uint64_t accesses = s.row_hits + s.row_misses + s.row_conflicts;
    const auto share = [&](std::uint64_t count) { return 100 * ratio(count, accesses); };
    std::string text;
    const auto line = [&](const char* name, const std::string& value) {
        text += fmt::format("{:<14}{}\n", name, value);
    };
    line("memory",
         fmt::format("{}, {} channel{} of {} data pins, {:.3f} GB/s at the pins, {} MiB", config.dram.device,
                     config.channels, config.channels == 1 ? "" : "s",
                     config.dram.pseudochannels * config.dram.bus_bits, peak * 1e-9, run.capacity >> 20));
    line("requests",
         fmt::format("{} of {} bytes: {} reads, {} writes{}", run.requests, config.request_bytes, s.reads,
                     s.writes, s.reads + s.writes == run.requests ? "" : " (parts in one channel each)"));
    line("bandwidth", fmt::format("{:.3f} GB/s, {:.1f}% of the pins' peak", run.bytes_per_second() * 1e-9,
                                  100 * run.bytes_per_second() / peak));
    line("bytes", fmt::format("{} useful, {} on the bus, {} served or merged in the write queue",
                              megabytes(run.useful_bytes()), megabytes(run.bus_bytes()),
                              megabytes(s.total_read().forwarded + s.total_write().forwarded)));
    line("time",
         fmt::format("{} cycles of {} ps, {:.6f} ms", run.cycles, config.dram.tck_ps, run.seconds * 1e3));
    line("rows", fmt::format("{} activations; hits {} ({:.1f}%), misses {} ({:.1f}%), conflicts {} ({:.1f}%)",
                             s.activations, s.row_hits, share(s.row_hits), s.row_misses, share(s.row_misses),
                             s.row_conflicts, share(s.row_conflicts)));
    line("read latency", latency_text(run, config));
    line("bus cycles", cycles_text(s));
    line("energy", energy_text(run, config));
    line("host",
         fmt::format(
             "{:.3f} s of a core, {:.2f} million requests a second; {:.3f} s for reading or making them",
             run.host_seconds, ratio(static_cast<double>(run.requests), run.host_seconds) * 1e-6,
             run.host_source_seconds));
    if (config.channels > 1) text += "\n" + channel_table(run, config);
    return text;
}

}  // namespace ropsim
