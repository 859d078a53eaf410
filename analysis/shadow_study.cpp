#include "analysis/shadow_study.h"

#include "base/error.h"
#include "base/outputs.h"
#include "rop/reference.h"
#include "traces/image.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace ropsim {

namespace {

bool same_view(const Camera& a, const Camera& b) {
    return a.view == b.view && a.projection == b.projection;
}

// Mean stored depth, the nearest white and what holds nothing black; of several wavelengths in red, green
// and blue.
Image map_picture(const ShadowMapRun& run) {
    const std::size_t maps = run.is_colored() ? run.wavelengths.size() : 1;
    const auto map = [&](std::size_t w) -> const StoredShadowMap& {
        return run.is_colored() ? run.wavelengths[w] : run.map;
    };
    Image image(map(0).width, map(0).height, {"R", "G", "B"});
    const auto held = [](float depth) { return depth < StoredShadowMap::kEmpty; };
    float nearest = 1;
    float farthest = 0;
    for (std::size_t w = 0; w < maps; ++w)
        for (const float depth : map(w).depths) {
            if (!held(depth)) continue;
            nearest = std::min(nearest, depth);
            farthest = std::max(farthest, depth);
        }
    const float range = std::max(farthest - nearest, 1e-6f);
    const auto samples = static_cast<std::size_t>(map(0).samples);
    for (std::size_t w = 0; w < maps; ++w)
        for (std::size_t i = 0; i < map(w).depths.size() / samples; ++i) {
            float sum = 0;
            for (std::size_t s = 0; s < samples; ++s) {
                const float depth = map(w).depths[i * samples + s];
                if (held(depth)) sum += 1.0f - 0.9f * (depth - nearest) / range;
            }
            std::fill_n(&image.values[3 * i + w], maps == 1 ? 3 : 1, sum / static_cast<float>(samples));
        }
    return image;
}

}  // namespace

void check_light_view(const TraceReader& light, const TraceReader& camera) {
    const TraceHeader& seen_by_light = light.header();
    const TraceHeader& seen_by_camera = camera.header();
    if (seen_by_light.view != "light")
        throw UserError(light.path(), fmt::format("shows the view of the {}, not of a light; capture it with "
                                                  "--view light",
                                                  seen_by_light.view));
    if (seen_by_camera.view == "light")
        throw UserError(camera.path(), "shows the view of the light; the second trace is the camera's");
    for (const TraceReader* trace : {&light, &camera})
        if (!trace->header().camera)
            throw UserError(trace->path(),
                            "has no camera, so that no point can be placed in the world; "
                            "capture the scene, or give the trace a camera");
    if (seen_by_light.scene != seen_by_camera.scene)
        throw UserError(camera.path(), fmt::format("shows '{}' where the light's trace shows '{}'; capture "
                                                   "both views of one scene with the same seed",
                                                   seen_by_camera.scene, seen_by_light.scene));
    if (seen_by_camera.light && !same_view(*seen_by_camera.light, *seen_by_light.camera))
        throw UserError(camera.path(),
                        "has another light than the one whose view the first trace shows; "
                        "capture both with the same options");
    if (!LightSpace(seen_by_camera, seen_by_light).valid())
        throw UserError(camera.path(),
                        "the cameras of the two traces have matrices that cannot be inverted; "
                        "give the traces proper cameras");
}

ShadowStudy study_shadows(const ShadowStudyOptions& options) {
    ShadowStudy study;
    study.options = options;
    const auto start = std::chrono::steady_clock::now();
    TraceReader light(options.map.trace);
    TraceReader camera(options.camera_trace);
    check_light_view(light, camera);
    study.camera_hash = camera.hash();
    study.run = draw_shadow_map(options.map);
    start_directory(options.directory, {"shadow.json"});
    ShadowReceiving receiving = options.receiving;
    receiving.seed = options.map.seed;
    receiving.threads = options.map.threads;
    const std::string shadowed = options.directory + "/shadowed.trace";
    const std::string exact = options.directory + "/exact.trace";
    if (study.run.is_colored()) {
        study.colored =
            study_colored_shadows(light, camera, study.run, options.filter, receiving, shadowed, exact);
    } else {
        const DeepShadowMap deep(light, options.map.threads);
        study.shadowed =
            cast_shadows(camera, light.header(), study.run.map, deep, receiving, shadowed, exact);
    }
    study.host_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    write_png(options.directory + "/map.png", map_picture(study.run));
    TraceReader result(shadowed);
    write_png(options.directory + "/shadowed.png",
              reference_image(result, options.map.threads, DisplayFilter::kBox, kReferenceBandFragments,
                              study.colored ? Transmission::kColored : Transmission::kAlpha));
    return study;
}

}  // namespace ropsim
