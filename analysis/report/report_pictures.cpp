// Reduced images, signed differences, and the choice of a telling detail.
#include "analysis/report/report_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ropsim {
namespace {

using Channels = std::array<int, 3>;

Channels channels_of(const Image& image) {
    return {image.channel("R"), image.channel("G"), image.channel("B")};
}

float unit(float value) {
    return std::isfinite(value) ? std::clamp(value, 0.0f, 1.0f) : 1.0f;
}

std::uint8_t srgb8(double linear) {
    const double encoded = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
    return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(encoded, 0.0, 1.0)));
}

// Calls visit(x, y) for the pixels of `region` that fall into the reduced pixel (u, v).
template <typename Visit>
void each_pixel(const Region& region, int reduction, int u, int v, const Visit& visit) {
    for (int y = v * reduction; y < std::min(region.height, (v + 1) * reduction); ++y)
        for (int x = u * reduction; x < std::min(region.width, (u + 1) * reduction); ++x)
            visit(region.x + x, region.y + y);
}

template <typename Value>
Picture make_picture(const Region& region, int reduction, const Value& value) {
    Picture picture{
        (region.width + reduction - 1) / reduction, (region.height + reduction - 1) / reduction, {}};
    picture.rgb.reserve(static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height) *
                        3);
    for (int v = 0; v < picture.height; ++v)
        for (int u = 0; u < picture.width; ++u)
            for (std::size_t c = 0; c < 3; ++c) picture.rgb.push_back(value(u, v, c));
    return picture;
}

double squared_difference(const Image& image, const Channels& from, const Image& reference,
                          const Channels& to, int x, int y) {
    double sum = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        const double d = unit(image.pixel(x, y)[from[c]]) - unit(reference.pixel(x, y)[to[c]]);
        sum += d * d;
    }
    return sum;
}

}  // namespace

int reduction_for(int width) {
    constexpr int kWidest = 640;
    return std::max(1, (width + kWidest - 1) / kWidest);
}

Picture image_picture(const Image& image, const Region& region, int reduction) {
    const Channels channels = channels_of(image);
    return make_picture(region, reduction, [&](int u, int v, std::size_t c) {
        double sum = 0;
        int count = 0;
        each_pixel(region, reduction, u, v, [&](int x, int y) {
            sum += unit(image.pixel(x, y)[channels[c]]);
            ++count;
        });
        return srgb8(sum / count);
    });
}

Picture difference_picture(const Image& image, const Image& reference, const Region& region, int reduction) {
    constexpr double kGain = 8;
    const Channels from = channels_of(image), to = channels_of(reference);
    return make_picture(region, reduction, [&](int u, int v, std::size_t c) {
        double largest = 0;
        each_pixel(region, reduction, u, v, [&](int x, int y) {
            const double d =
                static_cast<double>(unit(image.pixel(x, y)[from[c]])) - unit(reference.pixel(x, y)[to[c]]);
            if (std::abs(d) > std::abs(largest)) largest = d;
        });
        return static_cast<std::uint8_t>(std::clamp(128 + std::lround(255.0 * kGain * largest), 0L, 255L));
    });
}

Region detail_region(const std::vector<const Image*>& images, const Image& reference) {
    const int width = std::max(48, reference.width / 10);
    const int height = std::max(1, width * reference.height / std::max(1, reference.width));
    if (2 * width > reference.width || 2 * height > reference.height) return {};
    // Sums over blocks of a quarter window; a window is 4 x 4 blocks.
    const int block_w = width / 4, block_h = std::max(1, height / 4);
    const int across = reference.width / block_w, down = reference.height / block_h;
    std::vector<double> blocks(static_cast<std::size_t>(across) * static_cast<std::size_t>(down));
    const auto block_index = [across](int u, int v) {
        return static_cast<std::size_t>(v) * static_cast<std::size_t>(across) + static_cast<std::size_t>(u);
    };
    const Channels to = channels_of(reference);
    for (const Image* image : images) {
        const Channels from = channels_of(*image);
        std::vector<double> own(blocks.size());
        double total = 0;
        for (int y = 0; y < down * block_h; ++y)
            for (int x = 0; x < across * block_w; ++x) {
                const double d = squared_difference(*image, from, reference, to, x, y);
                own[block_index(x / block_w, y / block_h)] += d;
                total += d;
            }
        if (total <= 0) continue;
        for (std::size_t i = 0; i < blocks.size(); ++i) blocks[i] += own[i] / total;
    }
    Region best;
    double most = 0;
    for (int v = 0; v + 4 <= down; ++v)
        for (int u = 0; u + 4 <= across; ++u) {
            double sum = 0;
            for (int j = 0; j < 4; ++j)
                for (int i = 0; i < 4; ++i) sum += blocks[block_index(u + i, v + j)];
            if (sum > most * (1 + 1e-12)) {
                most = sum;
                best = {u * block_w, v * block_h, 4 * block_w, 4 * block_h};
            }
        }
    return best;
}

}  // namespace ropsim
