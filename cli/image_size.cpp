// Image sizes as users type them.
#include "cli/image_size.h"

#include "base/error.h"

#include <charconv>

namespace ropsim {

std::pair<int, int> parse_size(const std::string& text) {
    std::pair<int, int> size;
    const char* end = text.data() + text.size();
    const auto width = std::from_chars(text.data(), end, size.first);
    if (width.ec == std::errc() && width.ptr != end && *width.ptr == 'x') {
        const auto height = std::from_chars(width.ptr + 1, end, size.second);
        if (height.ec == std::errc() && height.ptr == end) return size;
    }
    throw UserError("--size", fmt::format("'{}' is not WIDTHxHEIGHT in pixels, e.g. 1280x720", text));
}

}  // namespace ropsim
