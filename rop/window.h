// The pixels around one, as a resolve with a footprint reads them.
#pragma once

#include "rop/pixel_store.h"

#include <algorithm>
#include <vector>

namespace ropsim {

// Which store holds which tile: partitions keep their own, a resolve may read across.
class StoreMap {
 public:
    StoreMap(int width, int height, std::vector<const PixelStore*> store_of_tile)
        : width_(width), height_(height), store_of_tile_(std::move(store_of_tile)) {}

    int width() const { return width_; }
    int height() const { return height_; }
    const PixelStore& store(int x, int y) const {
        const std::size_t tile =
            static_cast<std::size_t>(y / kTileSize) * static_cast<std::size_t>(tiles_across(width_)) +
            static_cast<std::size_t>(x / kTileSize);
        return *store_of_tile_[tile];
    }

 private:
    int width_;
    int height_;
    std::vector<const PixelStore*> store_of_tile_;
};

// Copies of the functional words of the pixels around one, the image's border repeated. A pixel of a tile
// that no fragment reached holds its initial words.
class PixelWindow {
 public:
    explicit PixelWindow(const StoreMap& stores) : stores_(stores) {}

    // x and y in the image once clamped to it. `words`: room for the pixel's words.
    void copy(int x, int y, std::vector<std::uint32_t>& words) const {
        const int u = std::clamp(x, 0, stores_.width() - 1);
        const int v = std::clamp(y, 0, stores_.height() - 1);
        stores_.store(u, v).copy_pixel(u, v, words);
    }
    PixelBackground background(int x, int y) const {
        const int u = std::clamp(x, 0, stores_.width() - 1);
        const int v = std::clamp(y, 0, stores_.height() - 1);
        return stores_.store(u, v).background(u, v);
    }

 private:
    const StoreMap& stores_;
};

}  // namespace ropsim
