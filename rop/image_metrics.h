// Differences between two images: the error figures of every report.
#pragma once

#include "traces/image.h"

#include <cstdint>
#include <vector>

namespace ropsim {

// Of channels R, G, B. rmse8 and mean_signed8 are of linear values clamped to [0,1] times 255.
struct ImageError {
    double rmse8 = 0;  // root mean square over all pixels and channels
    double rmse8_covered =
        0;               // the same over `covered` pixels only; NaN when no mask was given or none is covered
    double psnr_db = 0;  // 20 log10(255 / rmse8); infinity when equal
    double max_abs = 0;  // largest absolute difference, unclamped, linear units
    double mean_signed8 = 0;  // mean of (image - reference)
    double ssim = 0;  // Wang et al. 2004, 11x11 Gaussian (sigma 1.5), luma of the sRGB-encoded images, mean
    double flip = 0;  // Andersson et al. 2020 LDR-FLIP, mean, 67 pixels per degree
};

// Throws UserError naming the sizes when they differ or R, G, B are missing. `covered`, if not empty, is one
// byte a pixel. Non-finite pixels are a difference: they make max_abs infinite and count as 255 in the 8-bit
// figures.
ImageError image_error(const Image& image, const Image& reference,
                       const std::vector<std::uint8_t>& covered = {});

}  // namespace ropsim
