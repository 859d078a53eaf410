// Fits a scene's scale by counting fragments at trial scales.
#include "capture/scene_fit.h"

#include "base/error.h"
#include "capture/fragment_capture.h"
#include "capture/opaque_pass.h"

#include <algorithm>
#include <cmath>

namespace ropsim {
namespace {

constexpr int kMaxTrials = 8;
constexpr double kMargin = 1.04;        // so that the next trial passes a minimum rather than just misses it
constexpr double kCloseEnough = 0.005;  // relative error of the fragment count at which fitting stops

// The scale whose layers meet the scene's own minimum.
SceneScale meet_minimum(const SceneSource& source, int width, int height, LayerCounts& counts) {
    SceneScale scale;
    for (int trial = 0; trial < kMaxTrials; ++trial) {
        counts = count_layers(source.build(scale), width, height);
        if (counts.fragments == 0) {
            throw UserError("--size", fmt::format("at {}x{} no pixel centre is covered; use a larger size",
                                                  width, height));
        }
        const double pixels = static_cast<double>(width) * static_cast<double>(height);
        const double by_fragments =
            source.minimum_fragments_per_pixel * pixels / static_cast<double>(counts.fragments);
        const double by_layers = source.minimum_mean_layers / counts.mean_layers();
        const double more = std::max(by_fragments, by_layers);
        if (more <= 1.0) return scale;
        scale.count *= more * kMargin;
    }
    return scale;
}

// For fragments at the pixels' centres.
SceneScale fit_centres(const SceneSource& source, int width, int height,
                       std::optional<std::uint64_t> fragments) {
    const bool has_minimum = source.minimum_fragments_per_pixel > 0 || source.minimum_mean_layers > 0;
    if (!fragments && !has_minimum) return {};
    LayerCounts counts;
    SceneScale scale = meet_minimum(source, width, height, counts);
    if (!fragments) return scale;
    if (*fragments == 0) throw UserError("--fragments", "0 asks for an empty trace; give a positive number");
    const auto wanted = static_cast<double>(*fragments);
    if (!source.shrinks && wanted >= static_cast<double>(counts.fragments)) {
        // Thousands of like objects have been counted; more of them follow the same average.
        scale.count *= wanted / static_cast<double>(counts.fragments);
        return scale;
    }
    SceneScale best = scale;
    double best_error = std::fabs(static_cast<double>(counts.fragments) / wanted - 1.0);
    for (int trial = 0; trial < kMaxTrials && best_error > kCloseEnough; ++trial) {
        const double ratio = wanted / std::max<double>(static_cast<double>(counts.fragments), 1.0);
        // Whole objects cannot be had in part: the last percents of a scene of few objects come from their
        // size.
        const bool by_size = source.shrinks && (ratio < 1.0 || trial > 0);
        if (by_size) {
            scale.size *= std::sqrt(ratio);
        } else {
            scale.count *= ratio;
        }
        counts = count_layers(source.build(scale), width, height);
        const double error = std::fabs(static_cast<double>(counts.fragments) / wanted - 1.0);
        if (error < best_error) {
            best_error = error;
            best = scale;
        }
    }
    return best;
}

// How many fragments several samples make of one at a centre: edges cover samples of pixels whose centre they
// miss.
double fragments_a_centre(const Scene& scene, int width, int height, int samples) {
    const LayerCounts centres = count_layers(scene, width, height);
    const FragmentCaptureCounts counts =
        capture_fragments(scene, width, height, samples, {}, [](const FragmentChunk&) {});
    return static_cast<double>(counts.fragments) /
           std::max<double>(static_cast<double>(centres.fragments), 1);
}

}  // namespace

SceneScale fit_scene(const SceneSource& source, int width, int height, int samples,
                     std::optional<std::uint64_t> fragments) {
    const SceneScale scale = fit_centres(source, width, height, fragments);
    if (!fragments || samples == 1) return scale;
    const double more = fragments_a_centre(source.build(scale), width, height, samples);
    const auto centres = static_cast<std::uint64_t>(static_cast<double>(*fragments) / more);
    return fit_centres(source, width, height, std::max<std::uint64_t>(centres, 1));
}

}  // namespace ropsim
