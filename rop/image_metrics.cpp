// RMSE, PSNR, largest and mean signed difference, SSIM and FLIP of two images.
#include "rop/image_metrics.h"

#include "base/error.h"
#include "rop/flip.h"
#include "rop/transcendental.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ropsim {
namespace {

constexpr std::array<const char*, 3> kChannels{"R", "G", "B"};

// Sums over pixels, kept a row at a time and added in row order.
struct Sums {
    double squared = 0;
    double covered_squared = 0;
    double signed_sum = 0;
    double max_abs = 0;
    std::uint64_t covered = 0;
    void add(const Sums& other) {
        squared += other.squared;
        covered_squared += other.covered_squared;
        signed_sum += other.signed_sum;
        max_abs = std::max(max_abs, other.max_abs);
        covered += other.covered;
    }
};

// Both images as planes clamped to [0, 1], as the perceptual measures want them.
struct Pair {
    ColorPlanes image, reference;
};

// One channel of one pixel. A value that is not finite is put as far from the other as the range allows.
void compare_value(float value, float expected, float& clamped, float& clamped_expected, double& difference8,
                   double& absolute) {
    const bool finite = std::isfinite(value), expected_finite = std::isfinite(expected);
    clamped = finite ? std::clamp(value, 0.0f, 1.0f) : 0.0f;
    clamped_expected = expected_finite ? std::clamp(expected, 0.0f, 1.0f) : 0.0f;
    if (finite && expected_finite) {
        difference8 = 255.0 * (static_cast<double>(clamped) - static_cast<double>(clamped_expected));
        absolute = std::abs(static_cast<double>(value) - static_cast<double>(expected));
        return;
    }
    absolute = std::numeric_limits<double>::infinity();
    const bool image_higher = finite ? false : !(value < 0.0f);  // NaN and +infinity count as too bright
    difference8 = image_higher ? 255.0 : -255.0;
    if (!finite)
        clamped = clamped_expected >= 0.5f ? 0.0f : 1.0f;
    else
        clamped_expected = clamped >= 0.5f ? 0.0f : 1.0f;
}

std::array<int, 3> color_channels(const Image& image, const char* which) {
    std::array<int, 3> found{};
    for (std::size_t c = 0; c < 3; ++c) {
        found[c] = image.channel(kChannels[c]);
        if (found[c] < 0)
            throw UserError(
                which, fmt::format("has no channel {}; the images compared need R, G and B", kChannels[c]));
    }
    return found;
}

Sums compare(const Image& image, const Image& reference, const std::vector<std::uint8_t>& covered,
             Pair& pair) {
    const auto from = color_channels(image, "the image");
    const auto expected_from = color_channels(reference, "the reference image");
    for (std::size_t c = 0; c < 3; ++c) {
        pair.image[c] = Plane<float>(image.width, image.height);
        pair.reference[c] = Plane<float>(image.width, image.height);
    }
    std::vector<Sums> rows(static_cast<std::size_t>(image.height));
    for_each_row(image.height, [&](int y) {
        Sums& sums = rows[static_cast<std::size_t>(y)];
        for (int x = 0; x < image.width; ++x) {
            const auto index = static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                               static_cast<std::size_t>(x);
            double squared = 0;
            for (std::size_t c = 0; c < 3; ++c) {
                double difference8 = 0, absolute = 0;
                compare_value(image.pixel(x, y)[from[c]], reference.pixel(x, y)[expected_from[c]],
                              pair.image[c].row(y)[x], pair.reference[c].row(y)[x], difference8, absolute);
                squared += difference8 * difference8;
                sums.signed_sum += difference8;
                sums.max_abs = std::max(sums.max_abs, absolute);
            }
            sums.squared += squared;
            if (!covered.empty() && covered[index] != 0) {
                sums.covered_squared += squared;
                ++sums.covered;
            }
        }
    });
    Sums total;
    for (const Sums& row : rows) total.add(row);
    return total;
}

double srgb_encoded(double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * deterministic_power(linear, 1.0 / 2.4) - 0.055;
}

// Rec. 709 luma, whose primaries sRGB has.
Plane<double> luma(const ColorPlanes& rgb) {
    Plane<double> out(rgb[0].width, rgb[0].height);
    for_each_row(out.height, [&](int y) {
        for (int x = 0; x < out.width; ++x)
            out.row(y)[x] = 0.2126 * srgb_encoded(rgb[0].row(y)[x]) +
                            0.7152 * srgb_encoded(rgb[1].row(y)[x]) + 0.0722 * srgb_encoded(rgb[2].row(y)[x]);
    });
    return out;
}

Plane<double> product(const Plane<double>& a, const Plane<double>& b) {
    Plane<double> out = a;
    for (std::size_t i = 0; i < out.values.size(); ++i) out.values[i] *= b.values[i];
    return out;
}

// An axis shorter than the window gets a window of its own length, so that every size has a
// value.
std::vector<double> window_taps(int length) {
    constexpr double kDeviation = 1.5;
    const int count = std::min(11, length);
    std::vector<double> taps;
    double sum = 0;
    for (int i = 0; i < count; ++i) {
        const double u = (i - 0.5 * (count - 1)) / kDeviation;
        taps.push_back(deterministic_power(2.718281828459045, -0.5 * u * u));
        sum += taps.back();
    }
    for (double& tap : taps) tap /= sum;
    return taps;
}

// Mean over the windows that lie wholly inside the image, as in the authors' own program.
double mean_ssim(const Plane<double>& a, const Plane<double>& b) {
    constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;
    const auto across = window_taps(a.width), down = window_taps(a.height);
    const auto blur = [&](const Plane<double>& plane) {
        return filter_down(filter_across(plane, across), down);
    };
    const Plane<double> mean_a = blur(a), mean_b = blur(b);
    const Plane<double> square_a = blur(product(a, a)), square_b = blur(product(b, b)),
                        cross = blur(product(a, b));
    const int x0 = static_cast<int>(across.size()) / 2, y0 = static_cast<int>(down.size()) / 2;
    const int x1 = x0 + a.width - static_cast<int>(across.size()) + 1;
    const int y1 = y0 + a.height - static_cast<int>(down.size()) + 1;
    return mean_of_pixels(x0, y0, x1, y1, [&](int x, int y) {
        const double ma = mean_a.row(y)[x], mb = mean_b.row(y)[x];
        const double va = square_a.row(y)[x] - ma * ma, vb = square_b.row(y)[x] - mb * mb;
        const double covariance = cross.row(y)[x] - ma * mb;
        return (2 * (ma * mb) + kC1) * (2 * covariance + kC2) / ((ma * ma + mb * mb + kC1) * (va + vb + kC2));
    });
}

}  // namespace

ImageError image_error(const Image& image, const Image& reference, const std::vector<std::uint8_t>& covered) {
    if (image.width != reference.width || image.height != reference.height)
        throw UserError("the images differ in size",
                        fmt::format("{}x{} against {}x{}; compare images of one trace", image.width,
                                    image.height, reference.width, reference.height));
    if (image.width < 1 || image.height < 1) throw UserError("the image", "has no pixels");
    const double pixels = static_cast<double>(image.width) * image.height;
    CHECK(covered.empty() || static_cast<double>(covered.size()) == pixels, "{} bytes, {} pixels",
          covered.size(), pixels);
    Pair pair;
    const Sums sums = compare(image, reference, covered, pair);
    ImageError error;
    error.rmse8 = std::sqrt(sums.squared / (3.0 * pixels));
    error.rmse8_covered = sums.covered == 0
                              ? std::numeric_limits<double>::quiet_NaN()
                              : std::sqrt(sums.covered_squared / (3.0 * static_cast<double>(sums.covered)));
    error.psnr_db =
        error.rmse8 == 0.0 ? std::numeric_limits<double>::infinity() : decibels(255.0 / error.rmse8);
    error.max_abs = sums.max_abs;
    error.mean_signed8 = sums.signed_sum / (3.0 * pixels);
    error.ssim = mean_ssim(luma(pair.image), luma(pair.reference));
    error.flip = mean_flip(pair.image, pair.reference);
    return error;
}

}  // namespace ropsim
