// Shadows in a uniform slab against the exponential law.
#include "capture/scenery/light_volume.h"

#include <cmath>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

constexpr float kSide = 5.6f;  // 56 cells of 0.1

// Fills y in [0, height) with matter of extinction `sigma`.
LightVolume slab(float height, float sigma) {
    LightVolume volume(glm::vec3(0), glm::vec3(kSide));
    const float cell = kSide / LightVolume::kCells;
    for (int z = 0; z < LightVolume::kCells; ++z) {
        for (int y = 0; static_cast<float>(y) * cell < height - 0.5f * cell; ++y) {
            for (int x = 0; x < LightVolume::kCells; ++x) {
                volume.deposit((glm::vec3(x, y, z) + 0.5f) * cell, sigma * cell * cell * cell);
            }
        }
    }
    return volume;
}

TEST(LightVolumeTest, LightFromAboveFallsExponentiallyWithDepth) {
    LightVolume volume = slab(4.0f, 0.7f);
    volume.illuminate({0, 1, 0});
    for (float y : {0.5f, 1.5f, 3.0f}) {
        // Half a cell of slack: where in its cell the matter sits is unknown.
        const float depth = -std::log(volume.transmittance({2.8f, y, 2.8f}, 1.0f));
        EXPECT_NEAR(depth, 0.7f * (4.0f - y), 0.7f * 0.051f) << y;
        EXPECT_NEAR(-std::log(volume.transmittance({2.8f, y, 2.8f}, 2.0f)), 2 * depth, 1e-4f);
    }
    EXPECT_EQ(volume.transmittance({2.8f, 4.5f, 2.8f}, 1.0f), 1.0f);
}

TEST(LightVolumeTest, SlantedLightCrossesMore) {
    LightVolume volume = slab(2.0f, 0.5f);
    const glm::vec3 light = glm::normalize(glm::vec3(0.4f, 0.8f, -0.3f));
    volume.illuminate(light);
    const float depth = -std::log(volume.transmittance({2.0f, 0.5f, 3.5f}, 1.0f));
    EXPECT_NEAR(depth, 0.5f * 1.5f / light.y, 0.5f * 0.051f / light.y);
}

TEST(LightVolumeTest, MatterOutsideTheBoxIsIgnored) {
    LightVolume volume(glm::vec3(0), glm::vec3(kSide));
    volume.deposit({-0.01f, 1, 1}, 5);
    volume.deposit({1, kSide, 1}, 5);
    volume.illuminate({0, -1, 0});
    EXPECT_EQ(volume.transmittance({1, 5, 1}, 1.0f), 1.0f);
}

}  // namespace
}  // namespace ropsim
