#include "model/tile_sample_json.h"

#include <cmath>

#include <nlohmann/json.hpp>

namespace ropsim {

namespace {
using Json = nlohmann::ordered_json;

Json number(double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}
}  // namespace

void put_estimates(const TileSample& sample, Json& json) {
    json["sample"] = {{"percent", sample.percent},
                      {"seed", sample.seed},
                      {"partitions", sample.plan.partitions},
                      {"fragment_share", sample.fragment_share},
                      {"timed_share", sample.timed_share},
                      {"stretches", sample.stretches},
                      {"all_tiles_run", sample.function_complete}};
    if (!sample.function_complete)
        for (const char* key : {"touched_tiles", "pool"})
            if (json.contains(key)) json[key] = nullptr;
    const auto put = [&json](const std::string& place, const Estimate& e) {
        json[Json::json_pointer(place)] = {{"value", number(e.value)},
                                           {"ci95", {number(e.low), number(e.high)}}};
    };
    for (const auto& [place, e] : sample.estimates) put(place, e);
    if (sample.find("/error/rmse8") != nullptr)
        for (const char* key : {"psnr_db", "max_abs", "ssim", "flip"})
            if (!json["error"].contains(key)) json["error"][key] = nullptr;
    for (const char* stage : {"/stages/rop_tag/instances", "/stages/rop_operation/instances"}) {
        const Json::json_pointer at(stage);
        if (json.contains(at)) json[at] = static_cast<int>(json[at]["value"].get<double>());
    }
}

}  // namespace ropsim
