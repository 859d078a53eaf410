// Pictures as data: URIs small enough to be part of a page.
#pragma once

#include "analysis/html.h"

#include <cstddef>
#include <string>
#include <vector>

namespace ropsim {

// How a picture is kept, from exact to small.
enum class PictureLoss { kNone, kNear, kNearer, kFine, kCoarse };
inline constexpr int kPictureLosses = 5;

// In a few words, for the reader of the page.
const char* loss_text(PictureLoss loss);

// "data:image/webp;base64,..."; exact PNG where WebP's limit of 16383 pixels is passed.
std::string picture_uri(const Picture& picture, PictureLoss loss);

struct EncodedPicture {
    std::string uri;
    PictureLoss loss = PictureLoss::kNone;
};

// All of them, exact if they fit into `bytes` of URIs together; else the largest loses first, step by step,
// until they do, or until all are coarse. The same pictures give the same text, whatever the threads.
std::vector<EncodedPicture> encode_within(const std::vector<Picture>& pictures, std::size_t bytes,
                                          int threads);

// Whole numbers below 2^24 as exact pictures, red the highest byte; larger ones are cut to the largest.
Picture packed_numbers(int width, int height, const std::vector<double>& values);

}  // namespace ropsim
