// `ropsim list`: what there is to choose from.
#include "analysis/claims/claims.h"
#include "analysis/technique_reference.h"
#include "base/error.h"
#include "capture/scene_list.h"
#include "cli/commands.h"
#include "memory/dram_device.h"
#include "model/machine_config.h"
#include "rop/format.h"
#include "rop/registry.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

Json entries(const std::string& what) {
    Json list = Json::array();
    if (what == "techniques") {
        for (const TechniqueInfo& t : technique_list())
            list.push_back(
                {{"name", t.name}, {"summary", t.summary}, {"parameters", t.keys}, {"headline", t.headline}});
    } else if (what == "scenes") {
        for (const SceneInfo& s : scene_list()) list.push_back({{"name", s.name}, {"summary", s.summary}});
    } else if (what == "hardware") {
        for (const HardwarePreset& p : hardware_presets())
            list.push_back({{"name", p.name}, {"summary", p.summary}});
    } else if (what == "devices") {
        for (const std::string& name : dram_device_names())
            list.push_back({{"name", name}, {"summary", dram_device_summary(name)}});
    } else if (what == "claims") {
        for (const Claim& c : all_claims())
            list.push_back({{"name", c.id},
                            {"summary", fmt::format("{}, {}: {}", c.paper, c.place, c.claim)},
                            {"paper", c.paper},
                            {"place", c.place},
                            {"claim", c.claim},
                            {"printed", c.printed.text}});
    } else {
        for (const FormatInfo& f : format_table())
            list.push_back({{"name", f.name}, {"summary", f.summary}, {"bits", f.bits}});
    }
    return list;
}

void list(const std::string& what, bool json) {
    const Json all = entries(what);
    if (json) {
        fmt::print("{}\n", all.dump(2));
        return;
    }
    std::size_t width = 0;
    for (const Json& e : all) width = std::max(width, e["name"].get<std::string>().size());
    for (const Json& e : all) {
        const std::string parameters = e.value("parameters", "");
        fmt::print("{:<{}}  {}{}\n", e["name"].get<std::string>(), width, e["summary"].get<std::string>(),
                   parameters.empty() ? "" : fmt::format(" [{}]", parameters));
    }
    if (what == "techniques") fmt::print("Every technique takes format=paper (default) or float32.\n");
}

}  // namespace

void add_list_command(CLI::App& app) {
    struct Options {
        std::string what;
        bool json = false, markdown = false;
    };
    auto options = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand(
        "list", "Lists techniques, scenes, hardware presets, DRAM devices, stored formats or claims");
    command->add_option("what", options->what, "What to list")
        ->required()
        ->check(CLI::IsMember({"techniques", "scenes", "hardware", "devices", "formats", "claims"}));
    CLI::Option* json = command->add_flag("--json", options->json, "As JSON on stdout");
    command
        ->add_flag(
            "--markdown", options->markdown,
            "Of techniques: the whole of docs/technique-reference.md, with surfaces, passes and control "
            "paths")
        ->excludes(json);
    command->callback([options] {
        if (!options->markdown) {
            list(options->what, options->json);
            return;
        }
        if (options->what != "techniques")
            throw UserError("--markdown",
                            fmt::format("is a page of techniques; leave it out for {}", options->what));
        fmt::print("{}", technique_reference());
    });
}

}  // namespace ropsim
