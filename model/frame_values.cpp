// The bytes that a frame's operations write, where a surface is compressed and they matter.
#include "model/frame.h"
#include "model/frame_shard.h"
#include "rop/stored_bytes.h"

#include <algorithm>

namespace ropsim {

const PixelStore& Frame::initial_pixels() const {
    return shards_[0]->store;
}

// By surface of the technique, as OperationLog takes it.
std::vector<std::uint8_t> Frame::kept_values() const {
    std::vector<std::uint8_t> kept;
    for (int s = 0; s < map_.technique_surfaces(); ++s)
        kept.push_back(quads_ && map_.needs_values(s) ? 1 : 0);
    return kept;
}

// The elements as the operation that was the pixel's last left them: for passes over pixels, each of which
// writes one once.
const std::uint8_t* Frame::stored_values(const PixelStore& store, int surface, std::size_t tile,
                                         std::uint32_t quad, std::uint32_t pixel, std::uint64_t elements,
                                         std::vector<std::uint8_t>& bytes) const {
    if (elements == 0 || !map_.needs_values(surface)) return nullptr;
    const Surface& declared = operation_.declaration().surfaces[static_cast<std::size_t>(surface)];
    const int across = tiles_across(trace_.header().width);
    const int x = static_cast<int>(tile) % across * kTileSize + static_cast<int>(quad % 4 * 2 + pixel % 2);
    const int y = static_cast<int>(tile) / across * kTileSize + static_cast<int>(quad / 4 * 2 + pixel / 2);
    const std::uint32_t* words = store.find_pixel(x, y);
    CHECK(words != nullptr, "pixel {}, {}", x, y);
    bytes.assign(count_elements(elements) * static_cast<std::size_t>(declared.element_bytes()), 0);
    store_elements(declared, words + declared.first_word, elements, bytes.data());
    return bytes.data();
}

// Pixels beyond the image's edge have no colour.
void Frame::write_image_quad(LineCollector& collector, std::size_t tile, std::uint32_t quad) const {
    const int image = map_.image();
    if (!map_.needs_values(image)) return collector.write_quad(image, tile, quad, nullptr);
    constexpr std::size_t kLargestTexel = 16;
    std::array<std::uint8_t, 4 * kLargestTexel> bytes{};
    const std::uint32_t texel = map_.pixel_bytes(image);
    const int across = tiles_across(trace_.header().width);
    for (std::uint32_t p = 0; p < 4; ++p) {
        const int x = static_cast<int>(tile) % across * kTileSize + static_cast<int>(quad % 4 * 2 + p % 2);
        const int y = static_cast<int>(tile) / across * kTileSize + static_cast<int>(quad / 4 * 2 + p / 2);
        if (x >= image_.width || y >= image_.height) continue;
        const float* rgb =
            &image_.values[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image_.width) +
                                static_cast<std::size_t>(x))];
        store_color(operation_.declaration().image_format, rgb, texel, bytes.data() + p * texel);
    }
    collector.write_quad(image, tile, quad, bytes.data());
}

}  // namespace ropsim
