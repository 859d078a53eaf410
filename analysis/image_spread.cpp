// Welford's running variance for each value.
#include "analysis/image_spread.h"

#include "base/error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace ropsim {
namespace {

double shown8(float value) {
    if (std::isnan(value)) return 255;
    return 255.0 * static_cast<double>(std::clamp(value, 0.0f, 1.0f));
}

}  // namespace

ImageSpread::ImageSpread(std::vector<std::uint32_t> pixels)
    : pixels_(std::move(pixels)), values_(3 * pixels_.size()) {}

void ImageSpread::add(const Image& image) {
    ++images_;
    const std::size_t channels = image.channels.size();
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
        const float* rgb = &image.values[channels * pixels_[i]];
        for (std::size_t c = 0; c < 3; ++c) {
            Value& v = values_[3 * i + c];
            const double x = shown8(rgb[c]);
            const auto rounded = static_cast<float>(x);
            v.low = images_ == 1 ? rounded : std::min(v.low, rounded);
            v.high = images_ == 1 ? rounded : std::max(v.high, rounded);
            const double step = x - v.mean;
            v.mean += step / images_;
            v.squares += step * (x - v.mean);
        }
    }
}

SpreadFigures ImageSpread::figures() const {
    CHECK(images_ >= 2, "{} images", images_);
    SpreadFigures f;
    if (pixels_.empty()) return f;
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
        bool differs = false;
        for (std::size_t c = 0; c < 3; ++c) {
            const Value& v = values_[3 * i + c];
            const double spread = static_cast<double>(v.high) - static_cast<double>(v.low);
            f.rms_sd8 += v.squares / (images_ - 1);
            f.mean_spread8 += spread;
            f.max_spread8 = std::max(f.max_spread8, spread);
            differs = differs || spread > 0;
        }
        f.differing += differs ? 1 : 0;
    }
    const auto values = static_cast<double>(values_.size());
    f.rms_sd8 = std::sqrt(f.rms_sd8 / values);
    f.mean_spread8 /= values;
    f.differing /= static_cast<double>(pixels_.size());
    return f;
}

double rmse8_over(const Image& image, const Image& reference, const std::vector<std::uint32_t>& pixels) {
    double sum = 0;
    for (const std::uint32_t pixel : pixels) {
        const float* a = &image.values[image.channels.size() * pixel];
        const float* b = &reference.values[reference.channels.size() * pixel];
        for (std::size_t c = 0; c < 3; ++c) {
            const bool finite = std::isfinite(a[c]) && std::isfinite(b[c]);
            const double off = finite ? shown8(a[c]) - shown8(b[c]) : 255.0;
            sum += off * off;
        }
    }
    return pixels.empty() ? std::numeric_limits<double>::quiet_NaN()
                          : std::sqrt(sum / (3.0 * static_cast<double>(pixels.size())));
}

}  // namespace ropsim
