// Image sizes as users type them.
#pragma once

#include <string>
#include <utility>

namespace ropsim {

// "1280x720" as width and height in pixels. Throws UserError on anything else; the range is the caller's
// matter.
std::pair<int, int> parse_size(const std::string& text);

}  // namespace ropsim
