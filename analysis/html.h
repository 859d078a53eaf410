// Text and pictures as parts of an HTML page.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace ropsim {

// For element content and quoted attributes: & < > " ' as entities, control characters but tab and newline
// dropped.
std::string html_escape(std::string_view text);

std::string base64(const std::vector<std::uint8_t>& bytes);

// 8-bit sRGB pixels, three bytes each, row-major from the top left.
struct Picture {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> rgb;
};

// "data:image/png;base64,...".
std::string data_uri(const Picture& picture);

}  // namespace ropsim
