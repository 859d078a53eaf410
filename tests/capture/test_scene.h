// Hand-made scenes of a few triangles in window coordinates, whose fragments can be told without OpenGL.
#pragma once

#include "base/error.h"
#include "capture/fragment_capture.h"
#include "capture/gl_context.h"
#include "capture/scene.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim::testing {

// Three corners: pixels from the top left, window depth.
struct WindowTriangle {
    glm::vec3 corners[3];
};

// Draws `triangles` as one draw with a constant straight colour and alpha; each further instance is shifted
// right by `instance_shift` pixels.
inline SceneDraw window_draw(const std::vector<WindowTriangle>& triangles, int width, int height,
                             glm::vec4 color, std::uint32_t instances = 1, float instance_shift = 0) {
    SceneDraw draw;
    draw.state.name = "triangles";
    draw.vertex =
        "layout(std430, binding = 1) readonly buffer Corners { vec4 corners[]; };\n"
        "uniform uint u_first_instance; uniform vec4 u_parameters[8]; flat out uint v_instance;\n"
        "void main() { v_instance = u_first_instance + uint(gl_InstanceID);\n"
        "  gl_Position = corners[gl_VertexID] + vec4(float(v_instance) * u_parameters[1].x, 0, 0, 0); }\n";
    draw.shading = "uniform vec4 u_parameters[8]; vec4 shade() { return u_parameters[0]; }\n";
    draw.primitives = static_cast<std::uint32_t>(triangles.size());
    draw.instances = instances;
    SceneBuffer corners{1, {}};
    for (const WindowTriangle& triangle : triangles) {
        for (const glm::vec3& corner : triangle.corners) {
            corners.values.insert(corners.values.end(),
                                  {2 * corner.x / static_cast<float>(width) - 1,
                                   1 - 2 * corner.y / static_cast<float>(height), 2 * corner.z - 1, 1.0f});
        }
    }
    draw.buffers = {corners};
    draw.parameters = {color, glm::vec4(2 * instance_shift / static_cast<float>(width), 0, 0, 0)};
    return draw;
}

// Fragments with their channels at `samples` spatial samples.
inline FragmentChunk capture_chunk(const Scene& scene, int width, int height, int samples,
                                   const FragmentCaptureLimits& limits = {},
                                   FragmentCaptureCounts* counts = nullptr) {
    FragmentChunk all;
    const FragmentCaptureCounts result =
        capture_fragments(scene, width, height, samples, limits, [&](const FragmentChunk& piece) {
            all.fragments.insert(all.fragments.end(), piece.fragments.begin(), piece.fragments.end());
            all.slopes.insert(all.slopes.end(), piece.slopes.begin(), piece.slopes.end());
            all.materials.insert(all.materials.end(), piece.materials.begin(), piece.materials.end());
        });
    if (counts != nullptr) *counts = result;
    EXPECT_EQ(result.fragments, all.size());
    return all;
}

inline std::vector<Fragment> capture_all(const Scene& scene, int width, int height,
                                         const FragmentCaptureLimits& limits = {},
                                         FragmentCaptureCounts* counts = nullptr) {
    return capture_chunk(scene, width, height, 1, limits, counts).fragments;
}

// Whether headless OpenGL can be had at all on this machine, and why not.
inline bool opengl_available(std::string& why) {
    try {
        const GlContext context;
        return true;
    } catch (const UserError& error) {
        why = error.what();
        return false;
    }
}

class OpenGlTest : public ::testing::Test {
 protected:
    void SetUp() override {
        std::string why;
        if (!opengl_available(why)) GTEST_SKIP() << "no OpenGL: " << why;
    }
};

}  // namespace ropsim::testing
