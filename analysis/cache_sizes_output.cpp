// Every number of a study of cache sizes for programs.
#include "analysis/cache_sizes_output.h"

#include "analysis/text_table.h"
#include "base/version.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

Json units_json() {
    return {
        {"kibibytes", "KiB, of one ROP partition's cache"},
        {"read, write", "bytes of the frame"},
        {"per_fragment", "bytes read and written, a fragment of the trace"},
        {"worst_case",
         "no cache; if every operation took its pass's costliest control path (the papers' model)"},
        {"touched", "no cache; what the operations of this trace asked for"},
        {"uncached_bursts",
         "no cache; the same on the pins in whole bursts, accesses of one quad to a line merged"},
        {"caches.pins", "on the DRAM pins in whole bursts, behind set-associative caches of that size"},
        {"caches.surfaces", "the same by surface"},
        {"caches.sector_hit_share", "sectors read that were in the cache or cleared on chip, over all read"},
        {"ideal.size_bytes", "of one partition's fully associative LRU cache; null: without end"},
        {"ideal.miss_port", "whole sectors between it and memory"},
        {"ideal.line_hit_share", "uses of a line by a quad that found it, over all uses"},
        {"ideal.saved_share", "of what a cache without end saves over uncached_bursts"},
        {"near_largest_kibibytes",
         "KiB; smallest of the caches with at most 5% more bytes on the pins than the largest"},
        {"half_saved_bytes", "bytes of the smallest ideal cache whose saved_share is 1/2; null: none swept"},
        {"near_floor_bytes",
         "bytes of the smallest ideal cache with at most 5% more bytes than one without end; null: none "
         "swept"},
        {"tile_bytes", "bytes of a tile of 8x8 pixels in all surfaces that the run uses, pools left out"},
        {"largest_footprint_bytes", "bytes of the lines used in the partition that uses most"},
        {"line_uses", "uses of a line by a quad"},
    };
}

Json bytes_json(const CacheSizesScene& scene, const ReadWriteBytes& bytes) {
    return {{"read", bytes.read}, {"write", bytes.write}, {"per_fragment", scene.per_fragment(bytes)}};
}

Json surfaces_json(const CacheSizesRun& run, const BytesByCause& pins) {
    Json json = Json::object();
    for (std::size_t s = 0; s < pins.size(); ++s) {
        ReadWriteBytes sum;
        for (const CauseBytes& cause : pins[s]) {
            sum.read += cause.read;
            sum.write += cause.write;
        }
        if (sum.sum() > 0) json[run.surfaces[s]] = {{"read", sum.read}, {"write", sum.write}};
    }
    return json;
}

Json caches_json(const CacheSizesScene& scene, const CacheSizesRun& run) {
    Json json = Json::array();
    for (std::size_t i = 0; i < run.sweep.caches.size(); ++i) {
        const SweptCache& cache = run.sweep.caches[i];
        const auto hits = static_cast<double>(cache.cache.sector_hits);
        const auto misses = static_cast<double>(cache.cache.sector_misses);
        json.push_back(
            {{"kibibytes", cache.size_bytes / 1024},
             {"pins", bytes_json(scene, run.pins(i))},
             {"surfaces", surfaces_json(run, cache.pins)},
             {"sector_hit_share", hits + misses > 0 ? Json(hits / (hits + misses)) : Json(nullptr)}});
    }
    return json;
}

template <class Number>
Json or_null(const std::optional<Number>& number) {
    return number ? Json(*number) : Json(nullptr);
}

Json ideal_json(const CacheSizesScene& scene, const CacheSizesRun& run) {
    Json json = Json::array();
    for (std::size_t i = 0; i < run.sweep.ideal.size(); ++i) {
        const IdealCache& cache = run.sweep.ideal[i];
        const bool endless = cache.size_bytes == 0;
        json.push_back(
            {{"size_bytes", endless ? Json(nullptr) : Json(cache.size_bytes)},
             {"miss_port", bytes_json(scene, run.ideal(i))},
             {"line_hit_share", cache.line_hit_share},
             {"saved_share", or_null(run.saved_share(endless ? ~std::uint64_t{0} : cache.size_bytes))}});
    }
    return json;
}

Json run_json(const CacheSizesScene& scene, const CacheSizesRun& run) {
    Json json = {{"technique", run.technique}};
    json["why_null"] = run.failure.empty() ? Json(nullptr) : Json(run.failure);
    if (!run.failure.empty()) return json;
    json["worst_case"] = bytes_json(scene, run.worst_case);
    json["touched"] = bytes_json(scene, run.touched);
    json["uncached_bursts"] = bytes_json(scene, run.uncached);
    json["near_largest_kibibytes"] = run.near_largest() / 1024;
    json["half_saved_bytes"] = or_null(run.half_saved());
    json["near_floor_bytes"] = or_null(run.near_floor());
    json["tile_bytes"] = run.tile_bytes;
    json["largest_footprint_bytes"] = run.sweep.largest_footprint;
    json["line_uses"] = run.sweep.line_uses;
    json["caches"] = caches_json(scene, run);
    json["ideal"] = ideal_json(scene, run);
    return json;
}

}  // namespace

std::string cache_sizes_json(const CacheSizes& study) {
    const CacheSizesOptions& options = study.options;
    Json json;
    json["ropsim"] = kVersion;
    json["configuration"] = {{"techniques", options.techniques},
                             {"kibibytes", options.kibibytes},
                             {"hardware", options.hardware},
                             {"settings", options.settings},
                             {"seed", options.seed},
                             {"fidelity", "cached"},
                             {"partitions", study.partitions},
                             {"partition_tiles", study.partition_tiles},
                             {"ways", study.ways},
                             {"line_bytes", study.line_bytes},
                             {"sector_bytes", study.sector_bytes},
                             {"burst_bytes", study.burst_bytes}};
    json["units"] = units_json();
    json["scenes"] = Json::array();
    for (const CacheSizesScene& scene : study.scenes) {
        Json entry = {{"trace", scene.trace},     {"name", scene.name},          {"hash", scene.hash},
                      {"scene", scene.scene},     {"width", scene.width},        {"height", scene.height},
                      {"samples", scene.samples}, {"fragments", scene.fragments}};
        entry["runs"] = Json::array();
        for (const CacheSizesRun& run : scene.runs) entry["runs"].push_back(run_json(scene, run));
        json["scenes"].push_back(entry);
    }
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string cache_sizes_csv(const CacheSizes& study) {
    std::string text =
        "scene,technique,cache,kibibytes,read_bytes,write_bytes,bytes_per_fragment,gigabytes_per_frame\n";
    for (const CacheSizesScene& scene : study.scenes) {
        for (const CacheSizesRun& run : scene.runs) {
            if (!run.failure.empty()) continue;
            const auto line = [&](const char* cache, double kibibytes, const ReadWriteBytes& bytes) {
                text += fmt::format(
                    "{},{},{},{},{},{},{},{}\n", csv_field(scene.name), csv_field(run.technique), cache,
                    kibibytes > 0 ? fmt::format("{}", kibibytes) : "", bytes.read, bytes.write,
                    scene.per_fragment(bytes), static_cast<double>(bytes.sum()) * 1e-9);
            };
            line("none_worst_case", 0, run.worst_case);
            line("none_touched", 0, run.touched);
            line("none_bursts", 0, run.uncached);
            for (std::size_t i = 0; i < run.sweep.caches.size(); ++i)
                line("set_associative", run.sweep.caches[i].size_bytes / 1024.0, run.pins(i));
            for (std::size_t i = 0; i < run.sweep.ideal.size(); ++i)
                line(run.sweep.ideal[i].size_bytes == 0 ? "endless" : "fully_associative",
                     static_cast<double>(run.sweep.ideal[i].size_bytes) / 1024, run.ideal(i));
        }
    }
    return text;
}

}  // namespace ropsim
