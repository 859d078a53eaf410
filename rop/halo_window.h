// A tile with a border around it, and the pixels around one of its pixels as a resolve with a footprint reads
// them.
#pragma once

#include "rop/technique_input.h"
#include "rop/window.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ropsim {

// A tile's functional words with a border of `footprint` pixels around it, and what is behind them.
struct HaloTile {
    HaloTile(const StoreMap& stores, int tile_x, int tile_y, int footprint)
        : border(footprint), side(kTileSize + 2 * footprint) {
        const PixelWindow window(stores);
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const int u = tile_x * kTileSize + x - border;
                const int v = tile_y * kTileSize + y - border;
                window.copy(u, v, words.emplace_back());
                background.push_back(window.background(u, v));
            }
    }
    int border;
    int side;
    std::vector<std::vector<std::uint32_t>> words;
    std::vector<PixelBackground> background;
};

// The pixels around one, read only. Fetches of all of them are the same bytes of each.
template <class P>
class Window {
 public:
    using D = typename P::D;
    // x, y: the pixel in its tile.
    Window(HaloTile& halo, int x, int y, PixelAccess& access, bool worst)
        : halo_(halo), x_(x + halo.border), y_(y + halo.border), access_(access), worst_(worst) {}
    int footprint() const { return halo_.border; }
    P at(int dx, int dy) {
        if constexpr (D::kCharged)
            return P(halo_.words[index(dx, dy)].data(), access_, nullptr, worst_);
        else
            return P(halo_.words[index(dx, dy)].data(), access_, nullptr);
    }
    Background<D> background(int dx, int dy) const { return Background<D>(halo_.background[index(dx, dy)]); }

 private:
    std::size_t index(int dx, int dy) const {
        return static_cast<std::size_t>(y_ + dy) * static_cast<std::size_t>(halo_.side) +
               static_cast<std::size_t>(x_ + dx);
    }
    HaloTile& halo_;
    int x_;
    int y_;
    PixelAccess& access_;
    bool worst_;
};

}  // namespace ropsim
