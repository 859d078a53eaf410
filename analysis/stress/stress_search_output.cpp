// Worst pixels as JSON, which is read back, and as a table.
#include "analysis/stress/stress_search.h"
#include "base/error.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

// A float in the fewest digits that say which: the double they spell rounds to it.
double in_few_digits(float value) {
    return std::stod(fmt::format("{}", value));
}
Json fragments_json(const PixelScene& pixel) {
    Json list = Json::array();
    for (const Fragment& f : pixel.fragments) {
        Json& fragment = list.emplace_back(Json::array());
        for (const float value : {f.z, f.r, f.g, f.b, f.a}) fragment.push_back(in_few_digits(value));
    }
    return list;
}

WorstPixel pixel_of(const Json& json, const std::string& where) {
    WorstPixel worst;
    worst.technique = json.at("technique").get<std::string>();
    const auto* goal = std::ranges::find(kStressGoalNames, json.at("goal").get<std::string>());
    if (goal == kStressGoalNames.end()) throw UserError(where, "names a goal that there is not");
    worst.goal = static_cast<StressGoal>(goal - kStressGoalNames.begin());
    worst.error = json.at("error").is_null() ? INFINITY : json.at("error").get<double>();
    for (int c = 0; c < 3; ++c)
        worst.pixel.background[c] = json.at("background").at(static_cast<std::size_t>(c)).get<float>();
    for (const Json& f : json.at("fragments")) {
        const auto primitive = static_cast<std::uint32_t>(worst.pixel.fragments.size());
        worst.pixel.fragments.push_back({f.at(0).get<float>(), f.at(1).get<float>(), f.at(2).get<float>(),
                                         f.at(3).get<float>(), f.at(4).get<float>(), 0, 0, primitive, 1, 0});
    }
    return worst;
}

std::string in_255(double value) {
    const double scaled = 255 * value;
    return std::isfinite(scaled) ? fmt::format("{:.{}g}", scaled, scaled < 0.1 ? 2 : 3) : "not a number";
}

}  // namespace

std::string worst_pixels_json(const std::vector<WorstPixel>& pixels) {
    Json json = Json::array();
    for (const WorstPixel& worst : pixels) {
        const glm::vec3& background = worst.pixel.background;
        json.push_back(
            {{"technique", worst.technique},
             {"goal", kStressGoalNames[static_cast<std::size_t>(worst.goal)]},
             {"error", std::isfinite(worst.error) ? Json(worst.error) : Json(nullptr)},
             {"evaluations", worst.evaluations},
             {"random_pixels", worst.random_pixels},
             {"random_fragments", worst.random_fragments},
             {"random_error", worst.random_error},
             {"background",
              {in_few_digits(background.r), in_few_digits(background.g), in_few_digits(background.b)}},
             {"fragments", fragments_json(worst.pixel)}});
    }
    return json.dump() + "\n";
}

std::vector<WorstPixel> read_worst_pixels(const std::string& json, const std::string& where) {
    try {
        std::vector<WorstPixel> pixels;
        for (const Json& entry : Json::parse(json)) pixels.push_back(pixel_of(entry, where));
        return pixels;
    } catch (const Json::exception& error) {
        throw UserError(where, fmt::format("is not a list of worst pixels: {}", error.what()));
    }
}

std::string worst_pixels_markdown(const std::vector<WorstPixel>& pixels) {
    std::string text =
        "| technique | goal | worst error | fragments | evaluations | random fragments | worst of them |\n"
        "|---|---|---:|---:|---:|---:|---:|\n";
    for (const WorstPixel& worst : pixels)
        text += fmt::format("| `{}` | {} | {} | {} | {} | {} | {} |\n", worst.technique,
                            kStressGoalNames[static_cast<std::size_t>(worst.goal)], in_255(worst.error),
                            worst.pixel.fragments.size(), worst.evaluations, worst.random_fragments,
                            worst.random_pixels == 0 ? "-" : in_255(worst.random_error));
    return text;
}

}  // namespace ropsim
