#include "rop/sampling/sample_resolve.h"

#include <limits>

namespace ropsim {

SampleResolver::SampleResolver(const SamplingOptions& options, const SampleSurfaces& surfaces)
    : SampleMeans(options, surfaces,
                  stored_value(surfaces.depth.format, std::numeric_limits<float>::infinity())) {
    if (options.filter == DisplayFilter::kBox) return;
    const int stored = options.hardware_samples / options.spatial_samples;
    for (const auto& pixel : filter_weights(options.filter, options.spatial_samples)) {
        weights_.emplace_back();
        for (const double w : pixel) weights_.back().push_back(static_cast<float>(w / stored));
    }
}

}  // namespace ropsim
