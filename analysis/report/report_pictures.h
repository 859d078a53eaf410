// The pictures of a report: images, differences and details, small enough to be embedded.
#pragma once

#include "analysis/html.h"
#include "traces/image.h"

#include <vector>

namespace ropsim {

// A rectangle of pixels.
struct Region {
    int x = 0, y = 0, width = 0, height = 0;
};

// How many times smaller than its image a picture on the page is: whole, so that pixels are averaged alike.
int reduction_for(int width);

// R, G, B of `region`, each n x n pixels averaged in linear light, clamped, sRGB-encoded.
Picture image_picture(const Image& image, const Region& region, int reduction);

// 8 x (image - reference) around mid-grey, of linear values clamped to [0, 1]; of n x n pixels the largest
// difference of each channel, so that noise is not averaged away.
Picture difference_picture(const Image& image, const Image& reference, const Region& region, int reduction);

// The window of a tenth of the width (at least 48 pixels) where the images differ most from the reference,
// each image weighing the same. Empty (width 0) where the images are hardly larger than such a window or
// nothing differs.
Region detail_region(const std::vector<const Image*>& images, const Image& reference);

}  // namespace ropsim
