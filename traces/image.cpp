// Images with named float channels, and their OpenEXR and PNG files.
#include "traces/image.h"

#include "base/atomic_file.h"
#include "base/error.h"
#include "traces/interchange/deep_exr_guard.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>

#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <png.h>

namespace ropsim {

namespace {

constexpr int kLargestSide = 65536;
constexpr std::size_t kBandValues = std::size_t{1} << 24;
constexpr std::size_t kMostBandRows = 65536;
constexpr std::uint64_t kLargestImageValues = std::uint64_t{1} << 31;  // 8 GiB of float32

// Fifth root by Newton's method: only IEEE operations, so every machine gets the same bits (std::pow may
// not).
double fifth_root(double value) {
    double root = 1.0;  // value is in [0, 1]: convergence from above is monotonic
    for (int i = 0; i < 64; ++i) root -= (root - value / (root * root * root * root)) / 5.0;
    return root;
}

// sRGB's inverse transfer function (IEC 61966-2-1); u^2.4 is the fifth root of u^12.
double linear_from_srgb(double encoded) {
    if (encoded <= 0.04045) return encoded / 12.92;
    const double u = (encoded + 0.055) / 1.055;
    const double u3 = u * u * u;
    return fifth_root(u3 * u3 * u3 * u3);
}

// Entry k: the smallest linear value whose encoding rounds to k + 1.
std::array<double, 255> srgb_thresholds() {
    std::array<double, 255> thresholds{};
    for (std::size_t k = 0; k < thresholds.size(); ++k)
        thresholds[k] = linear_from_srgb((static_cast<double>(k) + 0.5) / 255.0);
    return thresholds;
}

std::uint8_t srgb8(float linear) {
    static const std::array<double, 255> thresholds = srgb_thresholds();
    // A NaN compares false with everything and ends at 0.
    if (!(linear > 0)) return 0;
    const auto above = std::upper_bound(thresholds.begin(), thresholds.end(), static_cast<double>(linear));
    return static_cast<std::uint8_t>(above - thresholds.begin());
}

// Slices of a frame buffer over interleaved float channels; `origin` is the data window's corner.
Imf::FrameBuffer frame_buffer(Image& image, int origin_x, int origin_y) {
    Imf::FrameBuffer buffer;
    const std::size_t pixel_bytes = image.channels.size() * sizeof(float);
    const std::size_t row_bytes = pixel_bytes * static_cast<std::size_t>(image.width);
    for (std::size_t c = 0; c < image.channels.size(); ++c) {
        // OpenEXR addresses pixels from (0, 0) of its own plane, which lies outside the array when the data
        // window does not start there: Slice::Make does that arithmetic.
        buffer.insert(image.channels[c],
                      Imf::Slice::Make(Imf::FLOAT, image.values.data() + c, {origin_x, origin_y}, image.width,
                                       image.height, pixel_bytes, row_bytes));
    }
    return buffer;
}

// R, G, B, A lead where they exist; the rest follow as the file has them, in alphabetical order.
std::vector<std::string> ordered_channels(const std::string& path, const Imf::ChannelList& list) {
    std::vector<std::string> names;
    for (const char* name : {"R", "G", "B", "A"})
        if (list.findChannel(name)) names.emplace_back(name);
    const std::size_t leading = names.size();
    for (auto channel = list.begin(); channel != list.end(); ++channel) {
        if (channel.channel().xSampling != 1 || channel.channel().ySampling != 1)
            throw UserError(
                path, fmt::format("channel {} is subsampled; write it at full resolution", channel.name()));
        const std::string name = channel.name();
        if (std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(leading), name) ==
            names.begin() + static_cast<std::ptrdiff_t>(leading))
            names.push_back(name);
    }
    return names;
}

// In bands: a file that claims more rows than it holds fails before their memory is asked for.
void read_pixels(Imf::InputFile& file, const Imath::Box2i& window, Image& image) {
    const std::size_t row = static_cast<std::size_t>(image.width) * image.channels.size();
    const int rows = static_cast<int>(std::clamp<std::size_t>(kBandValues / row, 1, kMostBandRows));
    const int height = image.height;
    for (int y = 0; y < height; y += rows) {
        Image band(image.width, std::min(rows, height - y), image.channels);
        file.setFrameBuffer(frame_buffer(band, window.min.x, window.min.y + y));
        file.readPixels(window.min.y + y, window.min.y + y + band.height - 1);
        image.values.insert(image.values.end(), band.values.begin(), band.values.end());
    }
}

Image read_checked(const std::string& path) {
    check_exr_claims(path);
    Imf::InputFile file(path.c_str(), 0);
    const Imath::Box2i window = file.header().dataWindow();
    const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
    const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
    if (width < 1 || height < 1 || width > kLargestSide || height > kLargestSide)
        throw UserError(
            path, fmt::format("is {}x{} pixels; 1 to {} a side can be read", width, height, kLargestSide));
    std::vector<std::string> names = ordered_channels(path, file.header().channels());
    if (names.empty()) throw UserError(path, "has no channels");
    if (static_cast<std::uint64_t>(width * height) * names.size() > kLargestImageValues)
        throw UserError(path, fmt::format("{}x{} pixels of {} channels are too many to hold", width, height,
                                          names.size()));
    Image image;
    image.width = static_cast<int>(width);
    image.height = static_cast<int>(height);
    image.channels = std::move(names);
    read_pixels(file, window, image);
    return image;
}

}  // namespace

int Image::channel(const std::string& name) const {
    const auto found = std::find(channels.begin(), channels.end(), name);
    return found == channels.end() ? -1 : static_cast<int>(found - channels.begin());
}

void write_exr(const std::string& path, const Image& image) {
    CHECK(image.width > 0 && image.height > 0 && !image.channels.empty(), "{}x{}", image.width, image.height);
    AtomicFile target(path);
    try {
        Imf::Header header(image.width, image.height);
        header.compression() = Imf::ZIP_COMPRESSION;
        for (const std::string& name : image.channels)
            header.channels().insert(name, Imf::Channel(Imf::FLOAT));
        // OpenEXR only reads through these pointers; its frame buffer is one type for both directions.
        Imf::OutputFile file(target.temporary_path().c_str(), header, 0);
        file.setFrameBuffer(frame_buffer(const_cast<Image&>(image), 0, 0));
        file.writePixels(image.height);
    } catch (const UserError&) {
        throw;
    } catch (const std::exception& error) {
        throw UserError(path, fmt::format("cannot write OpenEXR ({})", error.what()));
    }
    target.commit();
}

Image read_exr(const std::string& path) {
    std::error_code error;
    if (!std::filesystem::exists(path, error)) throw UserError(path, "no such file; check the name");
    try {
        return read_checked(path);
    } catch (const UserError&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& fault) {
        throw UserError(path, fmt::format("not a flat OpenEXR image that can be read ({})", fault.what()));
    }
}

void write_png(const std::string& path, const Image& image) {
    const std::array<int, 3> sources{image.channel("R"), image.channel("G"), image.channel("B")};
    for (const int source : sources) CHECK(source >= 0, "{}: a PNG needs channels R, G, B", path);
    std::vector<std::uint8_t> bytes;
    bytes.reserve(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * 3);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            for (const int source : sources) bytes.push_back(srgb8(image.pixel(x, y)[source]));

    AtomicFile target(path);
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = static_cast<png_uint_32>(image.width);
    png.height = static_cast<png_uint_32>(image.height);
    png.format = PNG_FORMAT_RGB;
    const bool written =
        png_image_write_to_file(&png, target.temporary_path().c_str(), 0, bytes.data(), 0, nullptr) != 0;
    if (!written) throw UserError(path, fmt::format("cannot write PNG ({})", png.message));
    target.commit();
}

}  // namespace ropsim
