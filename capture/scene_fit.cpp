// Fits a scene's scale by counting fragments at trial scales.
#include "capture/scene_fit.h"

#include "base/error.h"
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

}  // namespace

SceneScale fit_scene(const SceneSource& source, int width, int height,
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

}  // namespace ropsim
