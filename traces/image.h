// Images with named float channels, and their OpenEXR and PNG files.
#pragma once

#include <string>
#include <vector>

namespace ropsim {

// Row-major from the top left, channels interleaved, linear scene-referred values.
struct Image {
    int width = 0;
    int height = 0;
    std::vector<std::string> channels;  // e.g. R, G, B, A, error.R
    std::vector<float> values;          // width * height * channels.size()

    Image() = default;
    Image(int w, int h, std::vector<std::string> names)
        : width(w),
          height(h),
          channels(std::move(names)),
          values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * channels.size()) {}
    float* pixel(int x, int y) {
        return &values[(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                        static_cast<std::size_t>(x)) *
                       channels.size()];
    }
    const float* pixel(int x, int y) const { return const_cast<Image*>(this)->pixel(x, y); }
    // Index of a channel, -1 if absent.
    int channel(const std::string& name) const;
};

// Float32 OpenEXR, ZIP compression, deterministic bytes; atomic. Throws UserError.
void write_exr(const std::string& path, const Image& image);
// Any flat scanline or tiled OpenEXR, channels as float. Throws UserError.
Image read_exr(const std::string& path);
// Channels R, G, B as 8-bit sRGB (clamped to [0,1]); atomic. Throws UserError.
void write_png(const std::string& path, const Image& image);

}  // namespace ropsim
