// Pixels that show a hazard: a few fragments, or series of layers.
#pragma once

#include "analysis/stress/stress_inputs.h"
#include "rop/single_pixel.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace ropsim::hazard_scenes {

using Color = std::array<float, 3>;
inline constexpr Color kBlack{0, 0, 0};
inline constexpr Color kWhite{1, 1, 1};
inline constexpr double kStep = 1.0 / 255;

inline void add(PixelScene& scene, float z, float alpha, const Color& color) {
    scene.fragments.push_back({z, alpha * color[0], alpha * color[1], alpha * color[2], alpha, 0, 0,
                               static_cast<std::uint32_t>(scene.fragments.size()), 1, 0});
}
inline PixelScene before(float background) {
    PixelScene scene;
    scene.background = glm::vec3(background);
    return scene;
}
// At even depths, the nearest first, before white: of black layers what comes out is the transmittance.
inline PixelScene layers(int count, float alpha, const Color& color = kBlack, float depth = 1.0f) {
    PixelScene scene = before(1);
    for (int i = 0; i < count; ++i)
        add(scene, depth * static_cast<float>(i + 1) / static_cast<float>(count + 1), alpha, color);
    return scene;
}
inline PixelScene two(float z0, float alpha0, const Color& color0, float z1, float alpha1,
                      const Color& color1) {
    PixelScene scene = before(0);
    add(scene, z0, alpha0, color0);
    add(scene, z1, alpha1, color1);
    return scene;
}
// Of random depth, alpha and colour.
inline std::vector<PixelScene> random_scenes(int count, std::size_t fragments) {
    std::vector<PixelScene> scenes;
    for (int i = 0; i < count; ++i) {
        PixelScene scene = layer_input("bright", fragments, static_cast<std::uint64_t>(i)).pixels[0];
        for (Fragment& f : scene.fragments) {
            f.r /= 64;
            f.g /= 64;
            f.b /= 64;
        }
        scenes.push_back(std::move(scene));
    }
    return scenes;
}
// Pixels of one such layer each, with a random draw of its own.
inline std::vector<PixelScene> pixels_of_one_layer(int count, float alpha) {
    std::vector<PixelScene> scenes(static_cast<std::size_t>(count), layers(1, alpha));
    for (std::uint32_t i = 0; i < scenes.size(); ++i) scenes[i].fragments[0].primitive = i;
    return scenes;
}
// Half of them red, the others blue.
inline PixelScene red_then_blue(int count, float alpha) {
    PixelScene scene = layers(count, alpha, {1, 0, 0});
    for (std::size_t i = scene.fragments.size() / 2; i < scene.fragments.size(); ++i)
        std::swap(scene.fragments[i].r, scene.fragments[i].b);
    for (Fragment& f : scene.fragments) f.z = 0.999f;
    return scene;
}

}  // namespace ropsim::hazard_scenes
