// Errors of an image of which some tiles are known.
#include "model/tile_sample.h"
#include "model/tile_sample_squares.h"
#include "rop/transcendental.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ropsim {

namespace {

// By square: squared and signed differences of values clamped to [0, 1], all channels, and covered pixels.
struct SquareErrors {
    std::vector<double> squared, difference, covered;
};

SquareErrors square_errors(const Image& image, const Image& reference, const SampleSquares& squares,
                           const std::vector<std::uint8_t>& covered) {
    SquareErrors sums;
    for (auto* sum : {&sums.squared, &sums.difference, &sums.covered}) sum->resize(squares.size());
    const auto across = static_cast<std::size_t>(tiles_across(image.width));
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const std::size_t tile =
                static_cast<std::size_t>(y / kTileSize) * across + static_cast<std::size_t>(x / kTileSize);
            const std::size_t s = squares.square_of(tile);
            if (!squares.sampled(s)) continue;
            const float* a = image.pixel(x, y);
            const float* b = reference.pixel(x, y);
            for (int c = 0; c < 3; ++c) {
                const double ours = std::isfinite(a[c]) ? std::clamp(a[c], 0.0f, 1.0f) : 0.0;
                const double d = ours - (std::isfinite(b[c]) ? std::clamp(b[c], 0.0f, 1.0f) : 1.0);
                sums.squared[s] += d * d;
                sums.difference[s] += d;
            }
            sums.covered[s] += covered[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                                       static_cast<std::size_t>(x)];
        }
    }
    return sums;
}

// 255 * sqrt(sum / values), a function of the sum that rises.
Estimate root_mean(const Estimate& sum, double values) {
    const auto root = [values](double s) {
        return values > 0 ? 255 * std::sqrt(std::max(0.0, s) / values) : 0;
    };
    return {root(sum.value), root(sum.low), root(sum.high)};
}

}  // namespace

void estimate_error(const Frame& frame, const TraceReader& trace, const MachineConfig& config,
                    const Image& reference, const std::vector<std::uint8_t>& covered, TileSample& sample) {
    const SampleSquares squares(frame.surfaces(), trace, config.partition_tiles, sample.plan.partitions);
    const SquareErrors sums = square_errors(frame.image(), reference, squares, covered);
    const double values = 3.0 * frame.width() * frame.height();
    const Estimate squared = squares.total(sums.squared);
    const Estimate difference = squares.total(sums.difference);
    const double covered_pixels = squares.total(sums.covered).value;
    const Estimate rmse = root_mean(squared, values);
    sample.estimates.emplace_back("/error/rmse8", rmse);
    sample.estimates.emplace_back("/error/rmse8_covered", root_mean(squared, 3 * covered_pixels));
    const auto psnr = [](double error) { return decibels(255 / error); };
    if (rmse.low > 0)
        sample.estimates.emplace_back("/error/psnr_db",
                                      Estimate{psnr(rmse.value), psnr(rmse.high), psnr(rmse.low)});
    const double unit = 255 / values;
    sample.estimates.emplace_back(
        "/error/mean_signed8",
        Estimate{difference.value * unit, difference.low * unit, difference.high * unit});
}

}  // namespace ropsim
