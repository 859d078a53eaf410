#include "model/tile_pictures.h"

#include "traces/image.h"
#include "traces/overdraw_picture.h"

#include <algorithm>
#include <limits>

namespace ropsim {

void write_tiles(const TrafficBreakdown& breakdown, const std::string& directory) {
    const std::vector<ReadWriteBytes>& tiles = breakdown.tiles();
    Image bytes(breakdown.across(), breakdown.down(), {"read", "write"});
    std::vector<std::uint32_t> kibibytes;
    for (std::size_t t = 0; t < tiles.size(); ++t) {
        bytes.values[2 * t] = static_cast<float>(tiles[t].read);
        bytes.values[2 * t + 1] = static_cast<float>(tiles[t].write);
        constexpr std::uint64_t kMost = 1 << 22;  // the picture has a colour for each number
        kibibytes.push_back(static_cast<std::uint32_t>(std::min((tiles[t].sum() + 1023) / 1024, kMost)));
    }
    write_exr(directory + "/tiles.exr", bytes);
    write_png(directory + "/tiles.png",
              overdraw_picture(kibibytes, breakdown.across(), breakdown.down(), "KiB"));
}

}  // namespace ropsim
