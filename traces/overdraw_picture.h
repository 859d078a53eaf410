// A heat map of how many fragments each pixel has.
#pragma once

#include "traces/image.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

// Channels R, G, B for write_png. Colour runs on a logarithmic scale from 1 fragment (dark violet) to the
// largest number (light yellow), its lightness rising evenly (Ottosson's OKLab); pixels without a fragment
// are black. Below the map stands the scale with a tick at every power of two and the numbers beside them.
// Maps narrower than 256 pixels are enlarged by a whole factor. `layers` has width * height entries,
// row-major; they may count something else, in `unit` ("KiB"), which then stands behind the scale.
Image overdraw_picture(const std::vector<std::uint32_t>& layers, int width, int height,
                       const std::string& unit = "");

}  // namespace ropsim
