// A pixel's data for the inspector.
#include "analysis/report/report_inspector.h"

#include "analysis/visibility_curve.h"
#include "base/error.h"
#include "base/parallel.h"
#include "rop/registry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

// On the page curves are some hundred dots wide; `ropsim curve` has them in full.
constexpr int kCurveUniform = 40;
constexpr std::size_t kCurveSteps = 56;      // fragments' depths, in front of and behind each
constexpr std::size_t kMostFragments = 400;  // listed
constexpr std::size_t kMostElements = 64;    // listed of a surface
constexpr double kVisibilityScale = 1e4;     // curves are whole numbers of this part

Json number(float value, int digits) {
    if (!std::isfinite(value)) return nullptr;
    return std::stod(fmt::format("{:.{}g}", value, digits));
}

Json color(const Image& image, int x, int y) {
    Json rgb = Json::array();
    for (const char* name : {"R", "G", "B"}) rgb.push_back(number(image.pixel(x, y)[image.channel(name)], 5));
    return rgb;
}

std::vector<float> curve_depths(const ExactVisibility& exact) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const std::vector<float>& steps = exact.depths();
    const float low = steps.front(), high = steps.back();
    const float margin = std::max((high - low) / 20, 1e-4f);
    const float from = std::max(0.0f, low - margin), to = std::min(1.0f, high + margin);
    std::vector<float> depths;
    for (int i = 0; i < kCurveUniform; ++i)
        depths.push_back(from + (to - from) * static_cast<float>(i) / (kCurveUniform - 1));
    // Where the exact function falls most.
    std::vector<std::pair<double, float>> falls;
    for (const float z : steps) {
        const auto behind = static_cast<double>(std::nextafter(z, kInfinity));
        falls.emplace_back(exact(behind) - exact(static_cast<double>(z)), z);
    }
    std::stable_sort(falls.begin(), falls.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    if (falls.size() > kCurveSteps) falls.resize(kCurveSteps);
    for (const auto& [fall, z] : falls) {
        depths.push_back(z);
        depths.push_back(std::clamp(std::nextafter(z, kInfinity), 0.0f, 1.0f));
    }
    std::sort(depths.begin(), depths.end());
    depths.erase(std::unique(depths.begin(), depths.end()), depths.end());
    return depths;
}

template <class Values>
Json scaled(const Values& values) {
    Json list = Json::array();
    for (const auto value : values)
        if (std::isfinite(value))
            list.push_back(std::lround(kVisibilityScale * static_cast<double>(value)));
        else
            list.push_back(nullptr);
    return list;
}

// Nearest first; of equal depths the earlier arrival, as in the reference.
Json fragment_list(const PixelFragments& pixel) {
    std::vector<std::size_t> order(pixel.fragments.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return pixel.fragments[a].z < pixel.fragments[b].z;
    });
    if (order.size() > kMostFragments) order.resize(kMostFragments);
    Json list = Json::array();
    for (const std::size_t i : order) {
        const Fragment& f = pixel.fragments[i];
        list.push_back({i + 1, std::stod(fmt::format("{}", f.z)), number(f.a, 4), number(f.r, 3),
                        number(f.g, 3), number(f.b, 3), f.coverage});
    }
    return list;
}

Json surface_list(PixelRun& run) {
    Json list = Json::array();
    for (StoredSurface& surface : run.stored()) {
        Json rows = Json::array();
        const std::size_t shown = std::min(surface.changed.size(), kMostElements);
        for (std::size_t i = 0; i < shown; ++i)
            rows.push_back({surface.changed[i].element, surface.changed[i].values});
        list.push_back({{"name", surface.name},
                        {"fields", surface.fields},
                        {"elements", surface.elements},
                        {"changed", surface.changed.size()},
                        {"rows", rows}});
    }
    return list;
}

// What only the technique itself knows of the pixel.
void add_state(Json& json, const InspectedRun& run, const TraceHeader& header, const PixelFragments& pixel,
               const ExactVisibility& exact, const std::vector<float>& depths) {
    TechniqueSpec spec = parse_technique(run.technique, "--technique");
    const auto operation = make_operation(spec, screen_of(header, run.seed));
    std::string why = PixelRun::beyond_one_pixel(operation->declaration(), header);
    if (why.empty()) why = run.only_in_frame;
    if (!why.empty()) {
        json["why"] = why + ", so that one pixel's fragments are not enough";
        return;
    }
    PixelRun state(header, pixel, run.technique, run.seed);
    if (state.has_visibility()) {
        const std::vector<float> values = state.visibility(depths);
        json["visibility"] = scaled(values);
        const CurveError error =
            curve_error(exact, depths, values, state.visibility(exact.fragment_depths()));
        json["error"] = number(static_cast<float>(error.fragments_mean), 4);
    }
    json["surfaces"] = surface_list(state);
}

Json technique_at(const InspectedRun& run, const TraceHeader& header, const PixelFragments& pixel,
                  const ExactVisibility* exact, const std::vector<float>& depths) {
    Json json{{"color", color(*run.image, pixel.x, pixel.y)}};
    if (exact == nullptr) return json;
    try {
        add_state(json, run, header, pixel, *exact, depths);
    } catch (const UserError& error) {
        json["why"] = error.what();
    }
    return json;
}

std::string pixel_json(const ChosenPixel& chosen, const TraceHeader& header, const PixelFragments& pixel,
                       const Image& reference, const std::vector<InspectedRun>& runs) {
    Json json{{"x", pixel.x},           {"y", pixel.y},
              {"why", chosen.why},      {"count", pixel.fragments.size()},
              {"hidden", pixel.hidden}, {"reference", color(reference, pixel.x, pixel.y)}};
    json["fragments"] = fragment_list(pixel);
    std::vector<float> depths;
    std::optional<ExactVisibility> exact;
    if (!pixel.fragments.empty()) {
        exact.emplace(pixel, header.samples);
        depths = curve_depths(*exact);
        Json list = Json::array();
        std::vector<double> values;
        for (const float z : depths) {
            list.push_back(std::stod(fmt::format("{}", z)));
            values.push_back((*exact)(static_cast<double>(z)));
        }
        json["depths"] = std::move(list);
        json["exact"] = scaled(values);
    }
    json["techniques"] = Json::array();
    for (const InspectedRun& run : runs)
        json["techniques"].push_back(technique_at(run, header, pixel, exact ? &*exact : nullptr, depths));
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

std::vector<ReportData> inspector_data(const std::string& id, const std::string& trace_file,
                                       const Image& reference, const std::vector<InspectedRun>& runs,
                                       const std::vector<ChosenPixel>& pixels, std::size_t asked,
                                       std::size_t bytes, int threads) {
    TraceReader trace(trace_file);
    std::vector<PixelPlace> places;
    places.reserve(pixels.size());
    for (const ChosenPixel& pixel : pixels) places.push_back(pixel.place);
    const std::vector<PixelFragments> fragments = read_pixels(trace, places);
    std::vector<std::string> texts(pixels.size());
    parallel_for(threads, static_cast<int>(pixels.size()), [&](int n) {
        const auto i = static_cast<std::size_t>(n);
        if (i < asked || !fragments[i].fragments.empty())
            texts[i] = pixel_json(pixels[i], trace.header(), fragments[i], reference, runs);
    });
    Json list = Json::array();
    std::vector<ReportData> data;
    std::size_t used = 0;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        if (texts[i].empty() || (i >= asked && used + texts[i].size() > bytes)) continue;
        used += texts[i].size();
        list.push_back({{"x", pixels[i].place.x}, {"y", pixels[i].place.y}, {"why", pixels[i].why}});
        data.push_back(
            {fmt::format("{}-{}-{}", id, pixels[i].place.x, pixels[i].place.y), std::move(texts[i])});
    }
    data.push_back({id, Json{{"samples", trace.header().samples}, {"pixels", list}}.dump()});
    return data;
}

}  // namespace ropsim
