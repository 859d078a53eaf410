// How much several images of the same scene differ from each other, and an image from the reference, by the
// rules of rop/image_metrics.h: linear values clamped to [0, 1], times 255.
#pragma once

#include "traces/image.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ropsim {

struct SpreadFigures {
    double rms_sd8 = 0;       // root of the mean variance (n - 1 in the denominator) of a value over images
    double mean_spread8 = 0;  // mean of a value's largest minus smallest
    double max_spread8 = 0;   // the largest of them
    double differing = 0;     // share of the pixels where some value is not the same in all images
};

// Values are the channels R, G, B of `pixels` (numbers row by row), which all images share. Memory: 76 bytes
// a pixel.
class ImageSpread {
 public:
    explicit ImageSpread(std::vector<std::uint32_t> pixels);
    // Channels R, G, B come first in `image`. A value that is not finite counts as 255 (-infinity as 0).
    void add(const Image& image);
    // Of at least two images (CHECK); zeros without pixels.
    SpreadFigures figures() const;

 private:
    struct Value {
        double mean = 0;
        double squares = 0;  // sum of squared deviations from the mean
        float low = 0;
        float high = 0;
    };
    std::vector<std::uint32_t> pixels_;
    std::vector<Value> values_;
    int images_ = 0;
};

// Root mean square difference of two images over `pixels` and channels R, G, B, which come first in both; NaN
// without pixels. A value that is not finite in one of them is 255 off.
double rmse8_over(const Image& image, const Image& reference, const std::vector<std::uint32_t>& pixels);

}  // namespace ropsim
