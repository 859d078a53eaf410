// Which texels a quad fetches: an estimate, because traces have no texture coordinates.
#pragma once

#include "model/line_read.h"
#include "model/machine_config.h"
#include "model/quad_operation.h"

#include <algorithm>
#include <cstdint>

namespace ropsim {

// Texels follow the screen, one a pixel of the mip level that is sampled, in quads of 2x2 one behind the
// other: the filters of a quad's four fetches share their texels, so together they touch what one of them
// reads. Each fetch of a draw has a texture of its own, which repeats after texture.kibibytes; all lie in
// texture.mebibytes, where they repeat, too. Calls visit(LineRead), addresses counted from the first texture.
template <class Visit>
void for_texture_lines(const MachineConfig& config, int surface, const QuadOperation& q, Visit&& visit) {
    const TextureConfig& texture = config.front.texture;
    const std::uint64_t texture_bytes = std::uint64_t{texture.kibibytes} << 10;
    const std::uint64_t all_bytes = std::uint64_t{texture.mebibytes} << 20;
    const std::uint64_t line_bytes = config.cache.line_bytes;
    const std::uint64_t sector_bytes = config.cache.sector_bytes;
    for (std::uint32_t fetch = 0; fetch < q.texture_fetches; ++fetch) {
        const std::uint64_t number = std::uint64_t{q.draw} * 8 + fetch;
        std::uint64_t at =
            (number * texture_bytes + std::uint64_t{q.quad_id} * q.fetch_bytes % texture_bytes) % all_bytes;
        for (std::uint64_t left = q.fetch_bytes; left > 0;) {
            const std::uint64_t offset = at % line_bytes;
            const std::uint64_t here = std::min(left, line_bytes - offset);
            const std::uint64_t first = offset / sector_bytes;
            const std::uint64_t last = (offset + here - 1) / sector_bytes;
            visit(LineRead{at - offset,
                           static_cast<std::uint32_t>(((std::uint64_t{2} << (last - first)) - 1) << first),
                           static_cast<std::uint8_t>(surface)});
            at = (at + here) % all_bytes;
            left -= here;
        }
    }
}

}  // namespace ropsim
