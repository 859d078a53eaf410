// Reference images kept in the user's cache directory.
#include "base/error.h"
#include "rop/reference.h"

#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

namespace ropsim {
namespace {

constexpr int kResultChannels = 6;

// Empty where the environment names no usable place.
std::filesystem::path cache_directory() {
    const char* cache = std::getenv("XDG_CACHE_HOME");
    if (cache != nullptr && cache[0] == '/') return std::filesystem::path(cache) / "ropsim";
    const char* home = std::getenv("HOME");
    if (home != nullptr && home[0] == '/') return std::filesystem::path(home) / ".cache" / "ropsim";
    return {};
}

bool fits(const Image& image, const TraceHeader& header) {
    if (image.width != header.width || image.height != header.height ||
        image.channels.size() != kResultChannels)
        return false;
    for (const char* channel : {"R", "G", "B", "A", "layers", "ties"})
        if (image.channel(channel) < 0) return false;
    return true;
}

std::string file_name(const TraceReader& trace, DisplayFilter filter, Transmission transmission) {
    std::string name = trace.hash();
    if (filter == DisplayFilter::kGaussian) name += "-gaussian";
    // Without materials the two references are the same image.
    if (transmission == Transmission::kColored && trace.header().materials) name += "-colored";
    return name + "-v3.exr";
}

Image computed(TraceReader& trace, int threads, DisplayFilter filter, Transmission transmission) {
    return reference_image(trace, threads, filter, kReferenceBandFragments, transmission);
}

}  // namespace

Image cached_reference_image(TraceReader& trace, int threads, DisplayFilter filter,
                             Transmission transmission) {
    const std::filesystem::path directory = cache_directory();
    if (directory.empty()) return computed(trace, threads, filter, transmission);
    const std::string path = (directory / file_name(trace, filter, transmission)).string();
    std::error_code ignored;
    if (std::filesystem::exists(path, ignored)) {
        try {
            Image image = read_exr(path);
            if (fits(image, trace.header())) return image;
        } catch (const UserError&) {
            // Damaged or unreadable: computed again below.
        }
    }
    Image image = computed(trace, threads, filter, transmission);
    std::filesystem::create_directories(directory, ignored);
    try {
        write_exr(path, image);
    } catch (const UserError&) {
        // A cache that cannot be written costs time, not the result.
    }
    return image;
}

}  // namespace ropsim
