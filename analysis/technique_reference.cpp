// Declarations and cost tables as Markdown.
#include "analysis/technique_reference.h"

#include "analysis/standard_techniques.h"
#include "base/error.h"
#include "model/machine_config.h"
#include "model/run.h"
#include "rop/path_bytes.h"
#include "rop/registry.h"

#include <fmt/format.h>

namespace ropsim {
namespace {

// In a table a bar would end the cell.
std::string cell(const std::string& text) {
    std::string escaped;
    for (const char c : text) escaped += c == '|' ? std::string("\\|") : std::string(1, c);
    return escaped;
}

std::string unquoted(const std::string& text) {
    return text.size() >= 2 && text.front() == '"' ? text.substr(1, text.size() - 2) : text;
}

// What a key can be: what the technique says when it is given a value that no key takes.
std::string allowed_values(const TechniqueInfo& info, const std::string& key) {
    TechniqueSpec spec = parse_technique(at_default(info), "the registry");
    spec.parameters.set(key, "?", "the registry");
    try {
        make_operation(spec, screen_with_camera());
    } catch (const UserError& error) {
        constexpr std::string_view kMust = "must be ";
        std::string text = error.what();
        if (text.starts_with(kMust)) text.erase(0, kMust.size());
        constexpr std::string_view kOne = "one of ";
        return text.starts_with(kOne) ? text.substr(kOne.size()) : text;
    }
    return "any text";
}

std::string keys_table(const TechniqueInfo& info, const Parameters& parameters) {
    std::string text = "| key | here | values |\n|---|---|---|\n";
    for (const auto& [key, resolved] : parameters.resolved())
        text += fmt::format("| `{}` | {} | {} |\n", key, cell(unquoted(resolved.value)),
                            cell(allowed_values(info, key)));
    return text;
}

const char* layout_name(Layout layout) {
    switch (layout) {
        case Layout::kInterleaved:
            return "interleaved";
        case Layout::kPlanar:
            return "planar";
        case Layout::kPool:
            break;
    }
    return "pool";
}

const char* initial_name(Initial initial) {
    switch (initial) {
        case Initial::kClear:
            return "clear value";
        case Initial::kOpaqueColor:
            return "copy of the opaque colour";
        case Initial::kOpaqueDepth:
            return "copy of the opaque depth";
        case Initial::kOpaqueTarget:
            break;
    }
    return "the opaque layer's own target";
}

std::string fields_text(const Surface& surface) {
    std::string text;
    for (const StoredField& field : surface.fields) {
        if (!text.empty()) text += ", ";
        if (field.format == Format::kBits)
            text += fmt::format("{} bits", field.bits);
        else
            text += field.channels == 1
                        ? std::string(format_info(field.format).name)
                        : fmt::format("{} x {}", field.channels, format_info(field.format).name);
    }
    return text;
}

std::string surfaces_table(const Declaration& declaration) {
    std::string text =
        "| surface | elements a pixel | an element | bits a pixel | layout | begins as |\n"
        "|---|--:|---|--:|---|---|\n";
    for (const Surface& s : declaration.surfaces) {
        const bool pool = s.layout == Layout::kPool;
        text +=
            fmt::format("| `{}` | {} | {} ({} bits) | {} | {}{} | {} |\n", s.name,
                        pool ? "as allocated" : fmt::format("{}", s.elements), fields_text(s), s.element_bits,
                        pool ? "-" : fmt::format("{}", s.bits_per_pixel()), layout_name(s.layout),
                        s.scale == 1 ? "" : fmt::format(", 1/{} of the resolution", s.scale),
                        pool ? "-" : initial_name(s.initial));
    }
    return text;
}

std::string rounds_text(const Declaration& declaration, std::size_t pass) {
    const Repeat& repeat = declaration.repeat;
    const auto number = static_cast<int>(pass);
    if (number < repeat.first || number > repeat.last || repeat.rounds == 1) return "1";
    if (repeat.path < 0) return fmt::format("{}", repeat.rounds);
    return fmt::format("up to {}, while `{}` is taken", repeat.rounds,
                       declaration.paths[static_cast<std::size_t>(repeat.path)]);
}

std::string passes_table(const Declaration& declaration) {
    std::string text = "| pass | over | shading | rounds |\n|---|---|---|---|\n";
    for (std::size_t p = 0; p < declaration.passes.size(); ++p) {
        const Pass& pass = declaration.passes[p];
        const bool fragments = pass.kind == PassKind::kGeometry;
        text += fmt::format("| `{}` | {}{} | {} | {} |\n", pass.name,
                            fragments ? "fragments" : "pixels of touched tiles",
                            pass.scale == 1 ? "" : fmt::format(", 1/{} of the resolution", pass.scale),
                            !fragments                            ? "-"
                            : pass.shading == Shading::kAlphaOnly ? "alpha only"
                                                                  : "full",
                            rounds_text(declaration, p));
    }
    return text;
}

std::string units_text(const Work& work) {
    std::string text;
    for (std::size_t u = 0; u < static_cast<std::size_t>(kUnitCount); ++u)
        if (work.units[u] > 0)
            text += fmt::format("{}{} {}", text.empty() ? "" : ", ", work.units[u], kUnitNames[u]);
    return text.empty() ? "-" : text;
}

std::string paths_table(const Declaration& declaration, const CostTable& table) {
    std::string text =
        "| control path | pass | latency | interval | read, B | write, B | units |\n"
        "|---|---|--:|--:|--:|--:|---|\n";
    for (const PathCost& path : table) {
        if (path.name.empty()) continue;
        const ByteCount bytes = path_bytes(declaration, path);
        text += fmt::format("| `{}` | {} | {} | {} | {} | {} | {} |\n", path.name,
                            path.pass == kResolvePass
                                ? "resolve"
                                : declaration.passes[static_cast<std::size_t>(path.pass)].name,
                            path.latency(), path.interval, bytes.read, bytes.write, units_text(path.work));
        for (std::size_t k = 0; k < path.step.size(); ++k)
            if (path.has_step[k])
                text += fmt::format("| - a list step | | {} | {} | | | {} |\n", path.step[k].latency,
                                    path.step_interval[k], units_text(path.step[k]));
    }
    return text;
}

std::string needs_text(const Declaration& declaration) {
    std::string text = declaration.ordering == Ordering::kRaster ? "Operations on a pixel in raster order."
                                                                 : "Operations on a pixel in any order.";
    if (declaration.random) text += " The image depends on the seed.";
    if (declaration.uses_coverage) text += " Handles fragments that cover a part of the spatial samples.";
    if (!declaration.zero_alpha_harmless) text += " Fragments without alpha and colour are operated on too.";
    if (!declaration.image_is_color) text += " The image is no colour.";
    if (declaration.shades_materials) text += " Goes by the materials of the surfaces.";
    if (!declaration.resolves) text += " Nothing to resolve: the first surface is the image.";
    return text;
}

std::string section(const TechniqueInfo& info, const DatapathShape& datapath) {
    TechniqueSpec spec = parse_technique(at_default(info), "the registry");
    const auto operation = make_operation(spec, screen_with_camera());
    const Declaration& declaration = operation->declaration();
    const CostTable table = operation->cost(datapath);
    const ByteCount worst = worst_case_bytes(declaration, table);
    std::string text =
        fmt::format("## {}\n\n{}. Shown: `{}`.\n\n", info.name, info.summary, at_default(info));
    if (!info.keys.empty()) text += fmt::format("Parameters: `{}`\n\n", info.keys);
    text += keys_table(info, spec.parameters) + "\n";
    text += fmt::format(
        "{} Storage {} bits a pixel{}; {} bytes read and {} written by the operations on a "
        "fragment at worst.\n\n",
        needs_text(declaration), declaration.storage_bits_per_pixel(),
        declaration.node_words > 0 ? ", without the pool" : "", worst.read, worst.write);
    return text + surfaces_table(declaration) + "\n" + passes_table(declaration) + "\n" +
           paths_table(declaration, table) + "\n";
}

}  // namespace

std::string technique_reference() {
    const std::string hardware = RunOptions().hardware;
    Parameters parameters = hardware_parameters(hardware);
    const MachineConfig config = machine_config(parameters, hardware);
    std::string text = fmt::format(
        "# Technique reference\n\n"
        "Every technique of the registry as it declares itself, at the parameters that its paper leads with. "
        "This page is\n"
        "generated: `ropsim list techniques --markdown > docs/technique-reference.md`; a test fails where it "
        "is stale.\n"
        "\n"
        "*Keys* are those that this configuration reads, with the values it would take. Latency and interval "
        "of a\n"
        "control path are in ROP cycles on `{}`; its bytes are those of one operation when nothing is "
        "cached, as\n"
        "`ropsim cost` prints them. At worst: each pass and surface on its costliest path, all passes over "
        "the fragments,\n"
        "one round each, without depth test, resolve and walks of lists.\n\n",
        hardware);
    for (const TechniqueInfo& info : technique_list()) text += section(info, config.datapath);
    text.pop_back();
    return text;
}

}  // namespace ropsim
