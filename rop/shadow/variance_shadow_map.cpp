#include "rop/shadow/variance_shadow_map.h"

#include "base/error.h"
#include "base/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace ropsim {

namespace {

enum class Axis { kAcross, kDown };

MomentImage filtered_along(const MomentImage& in, const AxisKernel& kernel, Axis axis, DepthMoments outside,
                           int threads) {
    const bool across = axis == Axis::kAcross;
    MomentImage out;
    out.width = across ? reduced_size(in.width, kernel.step) : in.width;
    out.height = across ? in.height : reduced_size(in.height, kernel.step);
    out.texels.resize(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height));
    const int length = across ? in.width : in.height;
    const auto taps = static_cast<int>(kernel.weights.size());
    parallel_for(threads, out.height, [&](int y) {
        for (int x = 0; x < out.width; ++x) {
            const int start = kernel.step * (across ? x : y) + kernel.first;
            double mean = 0;
            double square = 0;
            for (int tap = 0; tap < taps; ++tap) {
                const int at = start + tap;
                const bool inside = at >= 0 && at < length;
                const DepthMoments& m =
                    inside ? in.texels[across ? in.texel(at, y) : in.texel(x, at)] : outside;
                const double weight = kernel.weights[static_cast<std::size_t>(tap)];
                mean += weight * static_cast<double>(m.mean);
                square += weight * static_cast<double>(m.square);
            }
            out.texels[out.texel(x, y)] = {static_cast<float>(mean), static_cast<float>(square)};
        }
    });
    return out;
}

}  // namespace

MomentImage stored_moments(const StoredShadowMap& map) {
    MomentImage moments{map.width, map.height, {}};
    const auto samples = static_cast<std::size_t>(map.samples);
    moments.texels.reserve(map.depths.size() / samples);
    for (std::size_t i = 0; i < map.depths.size(); i += samples) {
        double mean = 0;
        double square = 0;
        for (std::size_t s = 0; s < samples; ++s) {
            const auto z = static_cast<double>(std::min(map.depths[i + s], 1.0f));
            mean += z;
            square += z * z;
        }
        moments.texels.push_back({static_cast<float>(mean / static_cast<double>(samples)),
                                  static_cast<float>(square / static_cast<double>(samples))});
    }
    return moments;
}

AxisKernel conversion_kernel(const VarianceOptions& options) {
    CHECK(options.tent >= 1 && options.tent % 2 == 1, "a tent of {} texels", options.tent);
    CHECK(options.downsample >= 1, "a reduction by {}", options.downsample);
    const int half = options.tent / 2;
    const bool mean = options.reduction == Reduction::kMean;
    const int box = mean ? options.downsample : 1;
    AxisKernel kernel;
    kernel.step = options.downsample;
    kernel.first = (mean ? 0 : options.downsample / 2) - half;
    kernel.weights.assign(static_cast<std::size_t>(options.tent + box - 1), 0.0);
    for (int b = 0; b < box; ++b)
        for (int i = -half; i <= half; ++i)
            kernel.weights[static_cast<std::size_t>(b + i + half)] +=
                (half + 1 - std::abs(i)) / static_cast<double>((half + 1) * (half + 1) * box);
    return kernel;
}

MomentImage filtered(const MomentImage& moments, const AxisKernel& kernel, int threads,
                     DepthMoments outside) {
    const MomentImage across = filtered_along(moments, kernel, Axis::kAcross, outside, threads);
    return filtered_along(across, kernel, Axis::kDown, outside, threads);
}

MomentImage converted(const MomentImage& moments, const VarianceOptions& options, int threads,
                      DepthMoments outside) {
    return filtered(moments, conversion_kernel(options), threads, outside);
}

double chebyshev_visibility(const DepthMoments& moments, double t, const VarianceOptions& options) {
    const auto mean = static_cast<double>(moments.mean);
    const double away = t - mean;
    if (away <= 0) return 1;
    const double variance = std::max(static_cast<double>(moments.square) - mean * mean, options.min_variance);
    const double bound = variance / (variance + away * away);
    if (options.light_bleeding <= 0) return bound;
    return std::clamp((bound - options.light_bleeding) / (1 - options.light_bleeding), 0.0, 1.0);
}

VarianceShadowMap::VarianceShadowMap(MomentImage image, const VarianceOptions& options)
    : image_(std::move(image)), options_(options), centre_(conversion_kernel(options).centre()) {
    CHECK(!image_.texels.empty(), "a variance shadow map without texels");
}

const DepthMoments& VarianceShadowMap::at(int x, int y) const {
    return image_
        .texels[image_.texel(std::clamp(x, 0, image_.width - 1), std::clamp(y, 0, image_.height - 1))];
}

double VarianceShadowMap::visibility(double x, double y, double z) const {
    // In texels of the reduced map, centres at whole numbers.
    const double u = (x - centre_) / options_.downsample;
    const double v = (y - centre_) / options_.downsample;
    if (!options_.bilinear)
        return chebyshev_visibility(
            at(static_cast<int>(std::floor(u + 0.5)), static_cast<int>(std::floor(v + 0.5))), z, options_);
    const auto left = static_cast<int>(std::floor(u));
    const auto top = static_cast<int>(std::floor(v));
    const double right = u - left;
    const double down = v - top;
    const auto mixed = [&](float DepthMoments::*moment) {
        const auto of = [&](int dx, int dy) { return static_cast<double>(at(left + dx, top + dy).*moment); };
        return static_cast<float>((1 - down) * ((1 - right) * of(0, 0) + right * of(1, 0)) +
                                  down * ((1 - right) * of(0, 1) + right * of(1, 1)));
    };
    return chebyshev_visibility({mixed(&DepthMoments::mean), mixed(&DepthMoments::square)}, z, options_);
}

}  // namespace ropsim
