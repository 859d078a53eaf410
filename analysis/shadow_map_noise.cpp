#include "analysis/shadow_map_noise.h"

namespace ropsim {

namespace {

double mean_square_difference(const MomentImage& a, const MomentImage& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.texels.size(); ++i) {
        const double error = static_cast<double>(a.texels[i].mean) - static_cast<double>(b.texels[i].mean);
        sum += error * error;
    }
    return sum / static_cast<double>(a.texels.size());
}

double mean_of_means(const MomentImage& image) {
    double sum = 0;
    for (const DepthMoments& m : image.texels) sum += static_cast<double>(m.mean);
    return sum / static_cast<double>(image.texels.size());
}

StageNoise through(const AxisKernel& kernel, const MomentImage& stored, const MomentImage& expected,
                   const MomentImage& variance, int threads) {
    StageNoise noise;
    noise.measured = mean_square_difference(filtered(stored, kernel, threads, {}),
                                            filtered(expected, kernel, threads, {}));
    // Variances of independent texels add up with the squares of their weights.
    AxisKernel squared = kernel;
    for (double& weight : squared.weights) weight *= weight;
    noise.expected = mean_of_means(filtered(variance, squared, threads, {0, 0}));
    return noise;
}

}  // namespace

MapNoise map_noise(const MomentImage& stored, const ExpectedMoments& expected, int samples,
                   const VarianceOptions& options, int threads) {
    MomentImage variance{stored.width, stored.height, {}};
    for (const double v : expected.variance)
        variance.texels.push_back({static_cast<float>(v / samples), 0.0f});
    VarianceOptions unreduced = options;
    unreduced.downsample = 1;
    MapNoise noise;
    noise.stored = {mean_square_difference(stored, expected.moments), mean_of_means(variance)};
    noise.filtered = through(conversion_kernel(unreduced), stored, expected.moments, variance, threads);
    noise.reduced = through(conversion_kernel(options), stored, expected.moments, variance, threads);
    return noise;
}

}  // namespace ropsim
