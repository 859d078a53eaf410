// Visibility functions at one pixel.
#include "analysis/visibility_curve.h"

#include "analysis/comparison.h"
#include "analysis/standard_techniques.h"
#include "base/error.h"
#include "rop/registry.h"
#include "traces/depth_test.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include <fmt/ranges.h>

namespace ropsim {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// "X,Y" as two numbers.
std::pair<int, int> parse_pixel(const std::string& text) {
    int x = 0, y = 0;
    const char* const end = text.data() + text.size();
    const auto [comma, x_error] = std::from_chars(text.data(), end, x);
    if (x_error == std::errc() && comma != end && *comma == ',') {
        const auto [rest, y_error] = std::from_chars(comma + 1, end, y);
        if (y_error == std::errc() && rest == end) return {x, y};
    }
    throw UserError("--pixel", fmt::format("'{}' is neither X,Y nor deepest", text));
}

PixelFragments chosen_pixel(TraceReader& trace, const std::string& text) {
    const TraceHeader& header = trace.header();
    int x = 0, y = 0;
    std::optional<DeepestPixel> deepest;
    if (text == "deepest") {
        deepest = deepest_pixel(trace);
        x = deepest->x;
        y = deepest->y;
    } else {
        std::tie(x, y) = parse_pixel(text);
        if (x < 0 || y < 0 || x >= header.width || y >= header.height)
            throw UserError(
                "--pixel",
                fmt::format("{},{} lies outside the image of {}x{} pixels; the deepest is {},{}", x, y,
                            header.width, header.height, deepest_pixel(trace).x, deepest_pixel(trace).y));
    }
    PixelFragments pixel = read_pixel(trace, x, y);
    if (!pixel.fragments.empty()) return pixel;
    if (!deepest) deepest = deepest_pixel(trace);
    if (deepest->fragments == 0)
        throw UserError(trace.path(), "has no transparent fragment that the opaque layer does not hide");
    throw UserError("--pixel",
                    fmt::format("{},{} has no transparent fragment to be seen; {},{} has the most, {}", x, y,
                                deepest->x, deepest->y, deepest->fragments));
}

bool represents_visibility(const std::string& technique, const Screen& screen) {
    try {
        TechniqueSpec spec = parse_technique(technique, "--technique");
        const auto operation = make_operation(spec, screen);
        return operation->has_visibility() && operation->declaration().image_is_color;
    } catch (const UserError&) {
        return false;
    }
}

std::vector<std::string> chosen_techniques(const CurveOptions& options, const TraceHeader& header) {
    const Screen screen = screen_of(header, options.seed);
    std::vector<std::string> techniques;
    if (options.techniques.empty()) {
        for (const std::string& technique : default_techniques())
            if (represents_visibility(technique, screen)) techniques.push_back(technique);
        return techniques;
    }
    std::set<std::string> seen;
    for (const std::string& technique : options.techniques) {
        if (!seen.insert(technique).second)
            throw UserError("--technique", fmt::format("'{}' is given twice; leave one out", technique));
        TechniqueSpec spec = parse_technique(technique, "--technique");
        if (make_operation(spec, screen)->has_visibility()) continue;
        std::vector<std::string_view> able;
        for (const TechniqueInfo& info : technique_list())
            if (represents_visibility(std::string(info.name), screen)) able.push_back(info.name);
        throw UserError("--technique", fmt::format("'{}' represents no visibility; those that do: {}",
                                                   technique, fmt::join(able, ", ")));
    }
    return options.techniques;
}

float farthest_opaque(const TraceHeader& header, int x, int y) {
    if (!header.opaque) return kInfinity;
    const auto samples = static_cast<std::size_t>(header.samples);
    const std::size_t first =
        (static_cast<std::size_t>(y) * static_cast<std::size_t>(header.width) + static_cast<std::size_t>(x)) *
        samples;
    const auto begin = header.opaque->depth.begin() + static_cast<std::ptrdiff_t>(first);
    return *std::max_element(begin, begin + header.samples);
}

CurveOfTechnique curve_of(const VisibilityCurve& curve, const TraceHeader& header,
                          const ExactVisibility& exact, const std::string& technique) {
    CurveOfTechnique result;
    result.technique = technique;
    PixelRun run(header, curve.pixel, technique, curve.options.seed);
    TechniqueSpec spec = parse_technique(technique, "--technique");
    make_operation(spec, screen_of(header, curve.options.seed));
    for (const auto& [key, resolved] : spec.parameters.resolved()) result.parameters[key] = resolved.value;
    result.visibility = run.visibility(curve.depths);
    result.error =
        curve_error(exact, curve.depths, result.visibility, run.visibility(exact.fragment_depths()));
    return result;
}

}  // namespace

ExactVisibility::ExactVisibility(const PixelFragments& pixel, int samples) {
    const auto positions = sample_positions(samples);
    for (std::size_t m = 0; m < static_cast<std::size_t>(samples); ++m) {
        std::vector<Step> steps;  // `after` is the fragment's own transmittance first
        for (std::size_t i = 0; i < pixel.fragments.size(); ++i) {
            const Fragment& f = pixel.fragments[i];
            if ((f.coverage >> m & 1) == 0) continue;
            const float z = samples == 1 ? f.z : sample_depth(f, pixel.slopes[i], positions[m]);
            steps.push_back({z, 1.0 - static_cast<double>(f.a)});
            fragment_depths_.push_back(z);
        }
        std::stable_sort(steps.begin(), steps.end(), [](const Step& a, const Step& b) { return a.z < b.z; });
        double transmittance = 1;
        for (Step& step : steps) step.after = transmittance *= step.after;
        samples_.push_back(std::move(steps));
    }
    depths_ = fragment_depths_;
    std::sort(depths_.begin(), depths_.end());
    depths_.erase(std::unique(depths_.begin(), depths_.end()), depths_.end());
}

double ExactVisibility::operator()(double z) const {
    double sum = 0;
    for (const std::vector<Step>& steps : samples_) {
        const auto behind = std::partition_point(
            steps.begin(), steps.end(), [z](const Step& step) { return static_cast<double>(step.z) < z; });
        sum += behind == steps.begin() ? 1.0 : (behind - 1)->after;
    }
    return sum / static_cast<double>(samples_.size());
}

std::vector<float> shown_depths(const std::vector<float>& steps, float farthest) {
    CHECK(!steps.empty());
    const double low = static_cast<double>(steps.front());
    const double high = static_cast<double>(steps.back());
    const double margin = std::max((high - low) / 20, 1e-4);
    const double from = std::max(0.0, low - margin);
    const double to = std::min({1.0, high + margin, static_cast<double>(farthest)});
    std::vector<float> depths;
    for (int i = 0; i < kUniformDepths; ++i)
        depths.push_back(static_cast<float>(from + (to - from) * i / (kUniformDepths - 1)));
    const std::size_t chosen = std::min(steps.size(), kMostSteps);
    for (std::size_t i = 0; i < chosen; ++i) {
        const float z = steps[chosen < 2 ? 0 : i * (steps.size() - 1) / (chosen - 1)];
        for (const float at : {std::nextafter(z, -kInfinity), z, std::nextafter(z, kInfinity)})
            depths.push_back(std::clamp(at, 0.0f, 1.0f));
    }
    std::sort(depths.begin(), depths.end());
    depths.erase(std::unique(depths.begin(), depths.end()), depths.end());
    return depths;
}

CurveError curve_error(const ExactVisibility& exact, std::span<const float> depths,
                       std::span<const float> values, std::span<const float> at_fragments) {
    CurveError error;
    double before = 0;
    for (std::size_t i = 0; i < depths.size(); ++i) {
        const double here = std::abs(static_cast<double>(values[i]) - exact(static_cast<double>(depths[i])));
        error.max = std::max(error.max, here);
        if (i > 0)
            error.area +=
                (here + before) / 2 * (static_cast<double>(depths[i]) - static_cast<double>(depths[i - 1]));
        before = here;
    }
    const double length = static_cast<double>(depths.back()) - static_cast<double>(depths.front());
    error.mean = length > 0 ? error.area / length : error.max;
    const std::vector<float>& fragments = exact.fragment_depths();
    for (std::size_t i = 0; i < fragments.size(); ++i) {
        const double here =
            std::abs(static_cast<double>(at_fragments[i]) - exact(static_cast<double>(fragments[i])));
        error.fragments_mean += here;
        error.fragments_rms += here * here;
        error.fragments_max = std::max(error.fragments_max, here);
    }
    const auto count = static_cast<double>(fragments.size());
    error.fragments_mean /= count;
    error.fragments_rms = std::sqrt(error.fragments_rms / count);
    return error;
}

VisibilityCurve visibility_curve(const CurveOptions& options) {
    TraceReader trace(options.trace);
    const TraceHeader& header = trace.header();
    const std::vector<std::string> techniques = chosen_techniques(options, header);
    VisibilityCurve curve{options,
                          trace.hash(),
                          header.scene,
                          header.width,
                          header.height,
                          header.samples,
                          chosen_pixel(trace, options.pixel),
                          {},
                          {},
                          {},
                          {},
                          {}};
    const ExactVisibility exact(curve.pixel, header.samples);
    curve.truth_depths = exact.depths();
    for (const float z : curve.truth_depths)
        curve.truth_behind.push_back(exact(static_cast<double>(std::nextafter(z, kInfinity))));
    curve.depths = shown_depths(exact.depths(), farthest_opaque(header, curve.pixel.x, curve.pixel.y));
    for (const float z : curve.depths) curve.truth.push_back(exact(static_cast<double>(z)));
    for (const std::string& technique : techniques)
        curve.techniques.push_back(curve_of(curve, header, exact, technique));
    return curve;
}

}  // namespace ropsim
