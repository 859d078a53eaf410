#include "analysis/stress/stress_inputs.h"

#include "analysis/child_process.h"
#include "analysis/progress.h"
#include "analysis/standard_techniques.h"
#include "base/error.h"
#include "base/random.h"
#include "base/temporary_directory.h"
#include "traces/depth_test.h"
#include "traces/stress_traces.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <numeric>
#include <unordered_map>

#include <fmt/format.h>

namespace ropsim {
namespace {

// Of the pixels, how many are the deepest ones; the others are spread over the rest.
constexpr std::size_t kDeepestShare = 4;

std::vector<std::uint32_t> chosen_pixels(const std::unordered_map<std::uint32_t, std::uint32_t>& counts,
                                         std::size_t most) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pixels(counts.begin(), counts.end());
    std::ranges::sort(pixels, [](const auto& a, const auto& b) {
        return a.second != b.second ? a.second > b.second : a.first < b.first;
    });
    std::vector<std::uint32_t> chosen;
    const std::size_t deepest = std::min(pixels.size(), std::max(most / kDeepestShare, std::size_t{1}));
    for (std::size_t i = 0; i < deepest; ++i) chosen.push_back(pixels[i].first);
    const std::size_t rest = pixels.size() - deepest;
    const std::size_t others = std::min(rest, most - deepest);
    for (std::size_t i = 0; i < others; ++i) chosen.push_back(pixels[deepest + i * rest / others].first);
    return chosen;
}

// Calls take(pixel's number, fragment) for all that is to be seen.
template <class Take>
void for_visible(TraceReader& trace, Take take) {
    const OpaqueDepthTest test(trace.header());
    FragmentChunk chunk;
    trace.rewind();
    while (trace.next(chunk, kSlopeChannels | kLeastAlpha))
        for (std::size_t i = 0; i < chunk.size(); ++i) {
            Fragment f = chunk.fragments[i];
            if (test.visible_samples(f, chunk.slopes.empty() ? DepthSlope{} : chunk.slopes[i]) == 0) continue;
            const auto at = static_cast<std::uint32_t>(f.y * trace.header().width + f.x);
            f.x = f.y = 0;
            f.coverage = 1;
            take(at, f);
        }
}

PixelScene empty_pixel(const TraceHeader& header, std::uint32_t at) {
    PixelScene pixel;
    pixel.background = header.background;
    if (header.opaque) {
        const auto sample = static_cast<std::size_t>(at) * static_cast<std::size_t>(header.samples);
        const float* rgb = &header.opaque->rgb[3 * sample];
        pixel.background = {rgb[0], rgb[1], rgb[2]};
        pixel.opaque_depth = header.opaque->depth[sample];
    }
    return pixel;
}

void capture(const std::string& scene, const std::string& path) {
    const ChildResult child = run_child({own_program_path(), "capture", scene, "--fragments",
                                         std::to_string(kStressSceneFragments), "-o", path});
    if (const std::string why = child.failure(); !why.empty())
        throw UserError(scene, "cannot be captured: " + why);
}

}  // namespace

std::size_t StressInput::most_fragments() const {
    std::size_t most = 0;
    for (const PixelScene& pixel : pixels) most = std::max(most, pixel.fragments.size());
    return most;
}

std::array<double, 3> exact_color(const PixelScene& pixel) {
    std::vector<const Fragment*> sorted;
    for (const Fragment& f : pixel.fragments) sorted.push_back(&f);
    std::ranges::stable_sort(sorted, {}, [](const Fragment* f) { return f->z; });
    std::array<double, 3> color{};
    double transmittance = 1;
    for (const Fragment* f : sorted) {
        color[0] += transmittance * static_cast<double>(f->r);
        color[1] += transmittance * static_cast<double>(f->g);
        color[2] += transmittance * static_cast<double>(f->b);
        transmittance *= 1 - static_cast<double>(f->a);
    }
    for (int c = 0; c < 3; ++c)
        color[static_cast<std::size_t>(c)] += transmittance * static_cast<double>(pixel.background[c]);
    return color;
}

StressInput trace_input(const std::string& name, const std::string& kind, const std::string& path,
                        std::size_t most_pixels) {
    TraceReader trace(path);
    StressInput input;
    input.name = name;
    input.kind = kind;
    input.header = trace.header();
    input.physical = !trace.header().non_finite;
    std::unordered_map<std::uint32_t, std::uint32_t> counts;
    for_visible(trace, [&](std::uint32_t at, const Fragment&) { ++counts[at]; });
    std::unordered_map<std::uint32_t, std::size_t> place;
    for (const std::uint32_t at : chosen_pixels(counts, most_pixels)) {
        place.emplace(at, input.pixels.size());
        input.pixels.push_back(empty_pixel(trace.header(), at));
    }
    if (input.pixels.empty()) input.pixels.push_back(empty_pixel(trace.header(), 0));
    for_visible(trace, [&](std::uint32_t at, const Fragment& f) {
        const auto found = place.find(at);
        if (found != place.end()) input.pixels[found->second].fragments.push_back(f);
    });
    input.header.opaque.reset();
    if (!input.header.camera) input.header.camera = plain_camera();
    return input;
}

StressInput layer_input(const std::string& kind, std::size_t layers, std::uint64_t seed) {
    StressInput input;
    input.name = fmt::format("layers {} {}", kind, layers);
    input.kind = kind;
    input.layers = layers;
    input.header.width = input.header.height = 1;
    input.header.camera = plain_camera();
    input.header.draws.emplace_back().name = "layers";
    const bool bright = kind == "bright";
    CHECK(bright || kind == "thin" || kind == "even", "{}", kind);
    PixelScene pixel;
    pixel.background = {0.25f, 0.5f, 0.75f};
    for (std::uint32_t i = 0; i < layers; ++i) {
        const std::uint64_t key = mix64(mix64(seed + 1) ^ i);
        float a = kind == "thin" ? 1.0f / static_cast<float>(layers) : 0.01f;
        if (bright) a = random_unit(key, 5);
        const float scale = bright ? 64.0f * a : a;
        Fragment f{};
        f.z = random_unit(key, 0);
        f.r = scale * random_unit(key, 1);
        f.g = scale * random_unit(key, 2);
        f.b = scale * random_unit(key, 3);
        f.a = a;
        f.primitive = i;
        f.coverage = 1;
        pixel.fragments.push_back(f);
    }
    input.pixels.push_back(std::move(pixel));
    return input;
}

std::vector<StressInput> stress_inputs(const StressInputOptions& options) {
    std::vector<StressInput> inputs;
    const TemporaryDirectory directory;
    for (const StressTrace& stress : stress_traces()) {
        const std::string path = directory.path() + "/" + stress.name + ".trace";
        write_stress_trace(stress.name, path, options.seed);
        inputs.push_back(
            trace_input(fmt::format("trace {}", stress.name), "traces", path,
                        std::string_view(stress.name) == "non_finite" ? 105 : options.trace_pixels));
    }
    Progress progress(options.scenes.size());
    for (const std::string& scene : options.scenes) {
        const std::string path = directory.path() + "/" + scene + ".trace";
        capture(scene, path);
        inputs.push_back(trace_input(fmt::format("scene {}", scene), "scenes", path, options.scene_pixels));
        std::filesystem::remove(path);
        progress.finished("capture " + scene);
    }
    for (const char* kind : {"thin", "even", "bright"})
        for (const std::size_t layers : options.layers)
            inputs.push_back(layer_input(kind, layers, options.seed));
    return inputs;
}

}  // namespace ropsim
