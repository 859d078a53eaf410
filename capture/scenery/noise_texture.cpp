// Lattice noise.
#include "capture/scenery/noise_texture.h"

#include "base/random.h"

#include <glm/glm.hpp>

namespace ropsim {
namespace {

constexpr int kTextureSize = 64;

}  // namespace

SceneTexture noise_texture(std::uint64_t seed) {
    SceneTexture texture;
    texture.width = texture.height = kTextureSize;
    const auto lattice = [&](int cells, int x, int y) {
        const auto index = static_cast<std::uint32_t>((y % cells) * cells + x % cells);
        return random_unit(mix64(seed ^ (0x54657874ull << 32) ^ static_cast<std::uint64_t>(cells)), index);
    };
    for (int y = 0; y < kTextureSize; ++y) {
        for (int x = 0; x < kTextureSize; ++x) {
            float sum = 0;
            for (int cells : {8, 16}) {
                const int side = kTextureSize / cells;
                const float u =
                    glm::smoothstep(0.0f, 1.0f, static_cast<float>(x % side) / static_cast<float>(side));
                const float v =
                    glm::smoothstep(0.0f, 1.0f, static_cast<float>(y % side) / static_cast<float>(side));
                const int i = x / side;
                const int j = y / side;
                sum +=
                    0.5f * glm::mix(glm::mix(lattice(cells, i, j), lattice(cells, i + 1, j), u),
                                    glm::mix(lattice(cells, i, j + 1), lattice(cells, i + 1, j + 1), u), v);
            }
            texture.values.push_back(sum);
        }
    }
    return texture;
}

}  // namespace ropsim
