// What the tests of phenomenological transparency share: its shader by itself, cameras, and render targets
// filled by hand.
#pragma once

#include "rop/phenomenological/surface_shader.h"
#include "tests/rop/random_fragments.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

namespace ropsim::test {

inline Camera perspective_camera(int width, int height, float fovy_degrees = 60, float near_plane = 0.1f,
                                 float far_plane = 200) {
    Camera camera;
    camera.near_plane = near_plane;
    camera.far_plane = far_plane;
    camera.fovy_degrees = fovy_degrees;
    camera.projection =
        glm::perspective(glm::radians(fovy_degrees), static_cast<float>(width) / static_cast<float>(height),
                         near_plane, far_plane);
    return camera;
}
inline Screen screen_with(int width, int height, const Camera& camera) {
    Screen screen{width, height};
    screen.camera = camera;
    screen.materials = true;
    return screen;
}
inline Screen perspective_screen(int width, int height, float fovy_degrees = 60) {
    return screen_with(width, height, perspective_camera(width, height, fovy_degrees));
}
// `keys`: of the technique, may be empty.
inline SurfaceShader shader_of(const std::string& keys, const Screen& screen) {
    TechniqueSpec spec =
        parse_technique(keys.empty() ? "phenomenological" : "phenomenological:" + keys, "--technique");
    const PhenomenologicalOptions options(spec.parameters, screen);
    return {options, spec.parameters, screen};
}
// Window depth of what is `distance` scene units away along the view.
inline float depth_at(const Camera& camera, double distance) {
    const glm::dmat4 p(camera.projection);
    const double clip_z = p[2][2] * -distance + p[3][2];
    const double clip_w = p[2][3] * -distance + p[3][3];
    return static_cast<float>(0.5 * (clip_z / clip_w + 1));
}

inline Material material_of(std::array<float, 3> transmission, float collimation = 1, float eta = 1,
                            glm::vec3 normal = {0, 0, 1}) {
    Material m;
    for (std::size_t c = 0; c < 3; ++c) {
        m.transmission[c] = transmission[c];
        m.normal[c] = normal[static_cast<int>(c)];
    }
    m.collimation = collimation;
    m.eta = eta;
    return m;
}

// An opaque layer of that depth, its colours by rgb(x, y).
template <class Color>
TraceHeader pictured(int width, int height, float depth, Color rgb) {
    TraceHeader header = header_of(width, height);
    header.camera = perspective_camera(width, height);
    header.materials = true;
    OpaqueLayer layer;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const std::array<float, 3> c = rgb(x, y);
            layer.rgb.insert(layer.rgb.end(), c.begin(), c.end());
            layer.depth.push_back(depth);
        }
    }
    header.opaque = std::move(layer);
    return header;
}
inline TraceHeader random_picture(int width, int height, Random& random) {
    return pictured(width, height, 0.75f, [&](int, int) -> std::array<float, 3> {
        return {random.real(0, 1), random.real(0, 1), random.real(0, 1)};
    });
}
// Black but for one pixel.
inline TraceHeader single_bright_pixel(int size, int at_x, int at_y) {
    return pictured(size, size, 0.75f, [=](int x, int y) -> std::array<float, 3> {
        const float v = x == at_x && y == at_y ? 1.0f : 0.0f;
        return {v, v, v};
    });
}

// The render targets of a pixel, in stored units.
struct Targets {
    std::array<float, 3> color{};
    float net = 0;
    std::array<float, 3> beta{1, 1, 1};
    float diffusion = 0;  // D^2 / 63^2
    float x = 0, y = 0;   // of the displacement, in 63 pixels
};
inline constexpr std::size_t kTargetWords = 10;
// Of the form=full layout with separate_alpha=on. `first`: word of the first target.
inline void fill(TestFrame& frame, int x, int y, const Targets& t, std::size_t first = 0) {
    const std::array<float, kTargetWords> values = {t.color[0], t.color[1], t.color[2],  t.net, t.beta[0],
                                                    t.beta[1],  t.beta[2],  t.diffusion, t.x,   t.y};
    std::uint32_t* words = frame.store().pixel(x, y);
    for (std::size_t i = 0; i < kTargetWords; ++i) words[first + i] = std::bit_cast<std::uint32_t>(values[i]);
}
inline float word(TestFrame& frame, int x, int y, std::size_t i) {
    return std::bit_cast<float>(frame.words(x, y)[i]);
}
inline float pixel_of(const std::vector<float>& image, int width, int x, int y, int channel = 0) {
    return image[static_cast<std::size_t>(3 * (y * width + x) + channel)];
}

// A field of targets to resolve and the picture behind, for a reimplementation that knows neither.
struct TargetField {
    int width, height;
    TraceHeader header;
    std::vector<Targets> targets;

    TargetField(int w, int h, Random& random)
        : width(w), height(h), header(random_picture(w, h, random)), targets(count()) {}
    std::size_t count() const { return static_cast<std::size_t>(width * height); }
    const Targets& at(int x, int y) const {
        return targets[static_cast<std::size_t>(std::clamp(y, 0, height - 1) * width +
                                                std::clamp(x, 0, width - 1))];
    }
    std::array<double, 3> behind(int x, int y) const {
        return background_of(header, std::clamp(x, 0, width - 1), std::clamp(y, 0, height - 1));
    }
    std::vector<float> resolved(const std::string& technique) const {
        TestFrame frame(technique, header);
        EXPECT_EQ(frame.declaration().pixel_words, static_cast<int>(kTargetWords));
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) fill(frame, x, y, at(x, y));
        return frame.image();
    }
};

// Variance along x of an image that spreads around (x, y), in square pixels.
inline double variance_along_x(const std::vector<float>& image, int size, int at_x) {
    double sum = 0, moment = 0;
    for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
            const double v = pixel_of(image, size, x, y);
            sum += v;
            moment += v * (x - at_x) * (x - at_x);
        }
    }
    return moment / sum;
}

}  // namespace ropsim::test
