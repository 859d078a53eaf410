// Every number of a study of compression for programs.
#include "analysis/compression_output.h"

#include "analysis/text_table.h"
#include "base/version.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

Json units_json() {
    return {
        {"pins", "bytes of the frame on the DRAM pins, in whole bursts, behind the ROP caches"},
        {"pins.fill", "read for operations, copies, resolve and passes over the image"},
        {"pins.write", "write-backs and the flush at the end of the frame"},
        {"pins.repack", "compressed blocks read because some of them was written back"},
        {"pins.metadata",
         "states of blocks, read and written; those written at the end go to the first surface"},
        {"saved_share", "of the bytes on the pins without compression; negative: compression moves more"},
        {"blocks.of_N_bytes", "blocks stored in N bytes, each time that one was written"},
        {"blocks.raw", "blocks that fitted no level"},
        {"blocks.kept_raw", "write-backs to raw blocks that were not tried, for want of the rest"},
        {"repacks", "compressed blocks read because some of them was written back"},
        {"tried_bytes", "of all blocks tried, as they are, the padding of tiles included"},
        {"stored_bytes", "and as stored: raw ones whole"},
        {"storage_ratio", "tried_bytes over stored_bytes; null: no block was tried"},
        {"elements", "of a pixel; 0: a pool"},
        {"element_bytes", "bytes"},
    };
}

Json pins_json(const PinGroups& off, const PinGroups& pins) {
    return {{"fill", pins.fill},
            {"write", pins.write},
            {"repack", pins.repack},
            {"metadata", pins.metadata},
            {"sum", pins.sum()},
            {"saved_share", off.sum() > 0 ? Json(saved_share(off, pins)) : Json(nullptr)}};
}

Json blocks_json(const CompressionStudy& study, const CompressionCounts& counts) {
    Json blocks = Json::object();
    for (std::size_t l = 0; l < counts.by_level.size(); ++l)
        blocks[fmt::format("of_{}_bytes", study.machine.compression.levels[l])] = counts.by_level[l];
    blocks["raw"] = counts.raw;
    blocks["kept_raw"] = counts.kept_raw;
    return blocks;
}

Json surface_json(const CompressionStudy& study, const StudiedSurface& surface) {
    Json json = {{"class", class_name(surface.surface_class)},
                 {"element_bytes", surface.element_bytes},
                 {"elements", surface.elements},
                 {"outcomes", Json::array()}};
    for (std::size_t i = 0; i < study.setups.size(); ++i) {
        const SurfaceOutcome& outcome = surface.outcomes[i];
        Json entry = {{"setup", study.setups[i].name()},
                      {"codec", study.setups[i].codecs[static_cast<std::size_t>(surface.surface_class)]},
                      {"pins", pins_json(surface.outcomes[0].pins, outcome.pins)}};
        if (!study.setups[i].off()) {
            const double ratio = storage_ratio(outcome.blocks);
            entry["blocks"] = blocks_json(study, outcome.blocks);
            entry["repacks"] = outcome.blocks.repacks;
            entry["tried_bytes"] = outcome.blocks.block_bytes;
            entry["stored_bytes"] = outcome.blocks.stored_bytes;
            entry["storage_ratio"] = ratio > 0 ? Json(ratio) : Json(nullptr);
        }
        json["outcomes"].push_back(entry);
    }
    return json;
}

Json run_json(const CompressionStudy& study, const CompressionRun& run) {
    Json json = {{"technique", run.technique}};
    json["why_null"] = run.failure.empty() ? Json(nullptr) : Json(run.failure);
    if (!run.failure.empty()) return json;
    json["frame"] = Json::array();
    for (std::size_t i = 0; i < study.setups.size(); ++i)
        json["frame"].push_back(
            {{"setup", study.setups[i].name()}, {"pins", pins_json(run.pins(0), run.pins(i))}});
    json["surfaces"] = Json::object();
    for (const StudiedSurface& surface : run.surfaces)
        json["surfaces"][surface.name] = surface_json(study, surface);
    return json;
}

Json configuration_json(const CompressionStudy& study) {
    const CompressionStudyOptions& options = study.options;
    const MachineConfig& machine = study.machine;
    Json setups = Json::array();
    for (const CompressionSetup& setup : study.setups)
        setups.push_back({{"name", setup.name()}, {"settings", setup.settings()}});
    return {{"techniques", options.techniques},
            {"hardware", options.hardware},
            {"settings", options.settings},
            {"setups", setups},
            {"seed", options.seed},
            {"fidelity", "cached"},
            {"partitions", machine.partitions},
            {"cache_bytes", machine.cache.size_bytes},
            {"line_bytes", machine.cache.line_bytes},
            {"block_bytes", machine.compression.block_bytes},
            {"levels", machine.compression.levels},
            {"burst_bytes", machine.dram.burst_bytes()}};
}

}  // namespace

std::string compression_json(const CompressionStudy& study) {
    Json json;
    json["ropsim"] = kVersion;
    json["configuration"] = configuration_json(study);
    json["units"] = units_json();
    json["scenes"] = Json::array();
    for (const CompressionScene& scene : study.scenes) {
        Json entry = {{"trace", scene.trace},     {"name", scene.name},          {"hash", scene.hash},
                      {"scene", scene.scene},     {"width", scene.width},        {"height", scene.height},
                      {"samples", scene.samples}, {"fragments", scene.fragments}};
        entry["runs"] = Json::array();
        for (const CompressionRun& run : scene.runs) entry["runs"].push_back(run_json(study, run));
        json["scenes"].push_back(entry);
    }
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string compression_csv(const CompressionStudy& study) {
    const std::vector<std::uint32_t>& levels = study.machine.compression.levels;
    std::string text = "scene,technique,setup,surface,class,elements,element_bytes,codec";
    for (const std::uint32_t level : levels) text += fmt::format(",blocks_of_{}", level);
    text +=
        ",blocks_raw,blocks_kept_raw,repacks,tried_bytes,stored_bytes,fill_bytes,write_bytes,repack_bytes,"
        "metadata_bytes,off_bytes,saved_share\n";
    const auto line = [&](const CompressionScene& scene, const CompressionRun& run,
                          const StudiedSurface& surface, std::size_t setup) {
        const SurfaceOutcome& outcome = surface.outcomes[setup];
        const PinGroups& off = surface.outcomes[0].pins;
        text += fmt::format("{},{},{},{},{},{},{},{}", csv_field(scene.name), csv_field(run.technique),
                            study.setups[setup].name(), surface.name, class_name(surface.surface_class),
                            surface.elements, surface.element_bytes,
                            study.setups[setup].codecs[static_cast<std::size_t>(surface.surface_class)]);
        for (std::size_t l = 0; l < levels.size(); ++l)
            text += fmt::format(",{}", l < outcome.blocks.by_level.size() ? outcome.blocks.by_level[l] : 0);
        const CompressionCounts& blocks = outcome.blocks;
        const PinGroups& pins = outcome.pins;
        text += fmt::format(",{},{},{},{},{},{},{},{},{},{},{}\n", blocks.raw, blocks.kept_raw,
                            blocks.repacks, blocks.block_bytes, blocks.stored_bytes, pins.fill, pins.write,
                            pins.repack, pins.metadata, off.sum(),
                            off.sum() > 0 ? fmt::format("{}", saved_share(off, pins)) : "");
    };
    for (const CompressionScene& scene : study.scenes)
        for (const CompressionRun& run : scene.runs)
            for (const StudiedSurface& surface : run.surfaces)
                for (std::size_t setup = 0; setup < study.setups.size(); ++setup)
                    line(scene, run, surface, setup);
    return text;
}

}  // namespace ropsim
