// WebP through libwebp.
#include "analysis/report/picture_encoding.h"

#include "base/error.h"
#include "base/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <new>

#include <webp/encode.h>

namespace ropsim {
namespace {

constexpr int kEffort = 3;  // of 0..9: beyond, seconds a picture buy a few percent

WebPConfig configuration(PictureLoss loss) {
    WebPConfig config;
    CHECK(WebPConfigInit(&config) != 0, "libwebp of another version");
    const auto lossless = [&](int near) {
        WebPConfigLosslessPreset(&config, kEffort);
        config.near_lossless = near;
    };
    const auto lossy = [&](float quality) {
        config.quality = quality;
        config.use_sharp_yuv = 1;
    };
    switch (loss) {
        case PictureLoss::kNone:
            lossless(100);
            break;
        case PictureLoss::kNear:
            lossless(60);
            break;
        case PictureLoss::kNearer:
            lossless(20);
            break;
        case PictureLoss::kFine:
            lossy(90);
            break;
        case PictureLoss::kCoarse:
            lossy(70);
            break;
    }
    CHECK(WebPValidateConfig(&config) != 0);
    return config;
}

}  // namespace

const char* loss_text(PictureLoss loss) {
    switch (loss) {
        case PictureLoss::kNone:
            return "exact to 8 bits";
        case PictureLoss::kNear:
            return "within 2 of 255 of exact";
        case PictureLoss::kNearer:
            return "within 8 of 255 of exact";
        case PictureLoss::kFine:
            return "compressed with a slight loss";
        case PictureLoss::kCoarse:
            return "compressed with a visible loss";
    }
    return "";
}

std::string picture_uri(const Picture& picture, PictureLoss loss) {
    CHECK(picture.width > 0 && picture.height > 0, "{}x{}", picture.width, picture.height);
    if (picture.width > WEBP_MAX_DIMENSION || picture.height > WEBP_MAX_DIMENSION) return data_uri(picture);
    const WebPConfig config = configuration(loss);
    WebPPicture input;
    CHECK(WebPPictureInit(&input) != 0);
    input.width = picture.width;
    input.height = picture.height;
    input.use_argb = config.lossless;
    WebPMemoryWriter writer;
    WebPMemoryWriterInit(&writer);
    input.writer = WebPMemoryWrite;
    input.custom_ptr = &writer;
    const bool done = WebPPictureImportRGB(&input, picture.rgb.data(), picture.width * 3) != 0 &&
                      WebPEncode(&config, &input) != 0;
    const WebPEncodingError why = input.error_code;
    WebPPictureFree(&input);
    const std::vector<std::uint8_t> bytes(writer.mem, writer.mem + writer.size);
    WebPMemoryWriterClear(&writer);
    if (why == VP8_ENC_ERROR_OUT_OF_MEMORY || why == VP8_ENC_ERROR_BITSTREAM_OUT_OF_MEMORY)
        throw std::bad_alloc();
    CHECK(done, "libwebp: {}", static_cast<int>(why));
    return "data:image/webp;base64," + base64(bytes);
}

std::vector<EncodedPicture> encode_within(const std::vector<Picture>& pictures, std::size_t bytes,
                                          int threads) {
    std::vector<EncodedPicture> encoded(pictures.size());
    const auto encode = [&](std::size_t i, PictureLoss loss) {
        encoded[i] = {picture_uri(pictures[i], loss), loss};
    };
    parallel_for(threads, static_cast<int>(pictures.size()),
                 [&](int i) { encode(static_cast<std::size_t>(i), PictureLoss::kNone); });
    for (;;) {
        std::size_t total = 0;
        for (const EncodedPicture& picture : encoded) total += picture.uri.size();
        if (total <= bytes) return encoded;
        std::vector<std::size_t> order;
        for (std::size_t i = 0; i < encoded.size(); ++i)
            if (encoded[i].loss != PictureLoss::kCoarse) order.push_back(i);
        if (order.empty()) return encoded;
        std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
            return encoded[a].uri.size() > encoded[b].uri.size();
        });
        // The largest few at a time, so that all cores work: as many whatever the threads.
        order.resize(std::min<std::size_t>(order.size(), 4));
        parallel_for(threads, static_cast<int>(order.size()), [&](int k) {
            const std::size_t i = order[static_cast<std::size_t>(k)];
            encode(i, static_cast<PictureLoss>(static_cast<int>(encoded[i].loss) + 1));
        });
    }
}

Picture packed_numbers(int width, int height, const std::vector<double>& values) {
    constexpr double kMost = (1 << 24) - 1;
    Picture picture{width, height, {}};
    picture.rgb.reserve(values.size() * 3);
    for (const double value : values) {
        const auto whole = static_cast<std::uint32_t>(std::lround(std::clamp(value, 0.0, kMost)));
        for (const int shift : {16, 8, 0}) picture.rgb.push_back(static_cast<std::uint8_t>(whole >> shift));
    }
    return picture;
}

}  // namespace ropsim
