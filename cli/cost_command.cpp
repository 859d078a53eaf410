// `ropsim cost`: what a technique's control paths take in hardware.
#include "cli/commands.h"
#include "model/machine_config.h"
#include "rop/path_bytes.h"
#include "rop/registry.h"

#include <algorithm>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

struct CostOptions {
    std::string technique;
    std::string hardware = "desktop";
    std::vector<std::string> settings;
    int samples = 1;
    bool json = false;
};

Json units_json(const Work& work) {
    Json json = Json::object();
    for (std::size_t u = 0; u < static_cast<std::size_t>(kUnitCount); ++u)
        if (work.units[u] > 0) json[std::string(kUnitNames[u])] = work.units[u];
    return json;
}

std::string pass_name(const Declaration& declaration, int pass) {
    return pass == kResolvePass ? "resolve" : declaration.passes[static_cast<std::size_t>(pass)].name;
}

Json path_json(const Declaration& declaration, const PathCost& path) {
    Json json = {{"path", path.name},
                 {"pass", pass_name(declaration, path.pass)},
                 {"latency_cycles", path.latency()},
                 {"interval_cycles", path.interval},
                 {"units", units_json(path.work)}};
    Json steps = Json::array();
    for (std::size_t k = 0; k < 2; ++k)
        if (path.has_step[k])
            steps.push_back({{"latency_cycles", path.step[k].latency},
                             {"interval_cycles", path.step_interval[k]},
                             {"units", units_json(path.step[k])}});
    if (!steps.empty()) json["steps"] = steps;
    const ByteCount bytes = path_bytes(declaration, path);
    json["worst_case_read_bytes"] = bytes.read;
    json["worst_case_write_bytes"] = bytes.write;
    return json;
}

// The width of a column: its longest text, under a title.
std::size_t column_width(const Json& paths, const char* key, std::size_t least) {
    std::size_t width = least;
    for (const Json& p : paths) width = std::max(width, p[key].get_ref<const std::string&>().size());
    return width;
}

void print_table(const Json& all) {
    const Json& worst = all["operation_worst_case_bytes_per_fragment"];
    fmt::print(
        "{}\nstorage: {} bits per pixel\nworst case of a fragment, all passes: {} bytes read, {} written "
        "(walks of lists left out)\n\n",
        all["technique"].get<std::string>(), all["storage_bits_per_pixel"].get<int>(),
        worst["read"].get<int>(), worst["write"].get<int>());
    const std::size_t path_width = column_width(all["paths"], "path", 18);
    const std::size_t pass_width = column_width(all["paths"], "pass", 12);
    fmt::print("{:<{}} {:<{}} {:>8} {:>9} {:>7} {:>8}  {}\n", "path", path_width, "pass", pass_width,
               "latency", "interval", "read B", "write B", "units");
    const auto units = [](const Json& json) {
        std::string text;
        for (const auto& [unit, count] : json.items())
            text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count.get<int>(), unit);
        return text;
    };
    for (const Json& p : all["paths"]) {
        fmt::print("{:<{}} {:<{}} {:>8} {:>9} {:>7} {:>8}  {}\n", p["path"].get<std::string>(), path_width,
                   p["pass"].get<std::string>(), pass_width, p["latency_cycles"].get<int>(),
                   p["interval_cycles"].get<int>(), p["worst_case_read_bytes"].get<int>(),
                   p["worst_case_write_bytes"].get<int>(), units(p["units"]));
        if (!p.contains("steps")) continue;
        for (const Json& s : p["steps"])
            fmt::print("{:<{}} {:<{}} {:>8} {:>9} {:>7} {:>8}  {}\n", "  a list step", path_width, "",
                       pass_width, s["latency_cycles"].get<int>(), s["interval_cycles"].get<int>(), "", "",
                       units(s["units"]));
    }
    fmt::print("\nlatency and interval in ROP cycles; bytes of one operation when nothing is cached\n");
}

void cost(const CostOptions& options) {
    TechniqueSpec spec = parse_technique(options.technique, "TECHNIQUE");
    Parameters hardware = hardware_parameters(options.hardware);
    for (const std::string& setting : options.settings) set_from_text(hardware, setting, "--set");
    const MachineConfig config = machine_config(hardware, options.hardware);
    hardware.close();
    const auto operation = make_operation(spec, {.samples = options.samples, .camera = Camera{}});
    Json all = {{"technique", options.technique},
                {"hardware", options.hardware},
                {"storage_bits_per_pixel", operation->declaration().storage_bits_per_pixel()},
                {"paths", Json::array()}};
    const CostTable table = operation->cost(config.datapath);
    const ByteCount worst = worst_case_bytes(operation->declaration(), table);
    all["operation_worst_case_bytes_per_fragment"] = {{"read", worst.read}, {"write", worst.write}};
    for (const PathCost& path : table)
        if (!path.name.empty()) all["paths"].push_back(path_json(operation->declaration(), path));
    if (options.json)
        fmt::print("{}\n", all.dump(2));
    else
        print_table(all);
}

}  // namespace

void add_cost_command(CLI::App& app) {
    auto options = std::make_shared<CostOptions>();
    CLI::App* command =
        app.add_subcommand("cost", "Prints a technique's control paths: latency, interval, units, bytes");
    command->add_option("technique", options->technique, "NAME[:key=value,...]")->required();
    command->add_option("--hardware", options->hardware, "Preset or .toml file: unit latencies and budgets");
    command->add_option("--set", options->settings, "A hardware key=value, repeatable")
        ->expected(1)
        ->take_all();
    command->add_option("--samples", options->samples, "Spatial samples of the traces it is meant for")
        ->check(CLI::IsMember({1, 2, 4, 8, 16}));
    command->add_flag("--json", options->json, "As JSON on stdout");
    command->callback([options] { cost(*options); });
}

}  // namespace ropsim
