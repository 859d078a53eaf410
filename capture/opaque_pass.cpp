// Opaque layer and layer counts, by ordinary rendering into float images.
#include "capture/opaque_pass.h"

#include "capture/gpu_draw.h"

#include <limits>
#include <memory>
#include <vector>

namespace ropsim {

OpaqueLayer draw_opaque_layer(const Scene& scene, int width, int height, int samples) {
    const GlTarget target(width, height, GL_RGBA32F, true);
    target.bind();
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_BLEND);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glDepthMask(GL_TRUE);
    const float clear_color[4] = {scene.background.r, scene.background.g, scene.background.b, 0.0f};
    const float clear_depth = 1.0f;
    std::vector<std::unique_ptr<GpuDraw>> draws;
    for (const SceneDraw& draw : scene.opaque)
        draws.push_back(std::make_unique<GpuDraw>(draw, scene.camera, "fragment_opaque"));
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    const auto stride = static_cast<std::size_t>(samples);
    std::vector<float> rgba(4 * pixels);
    std::vector<float> depth(pixels);
    OpaqueLayer layer;
    layer.rgb.resize(3 * pixels * stride);
    layer.depth.resize(pixels * stride);
    for (std::size_t m = 0; m < stride; ++m) {
        glClearBufferfv(GL_COLOR, 0, clear_color);
        glClearBufferfv(GL_DEPTH, 0, &clear_depth);
        for (const auto& draw : draws) {
            draw->set_sample_position(sample_positions(samples)[m], width, height);
            draw->submit(draw->everything());
        }
        glReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, rgba.data());
        glReadPixels(0, 0, width, height, GL_DEPTH_COMPONENT, GL_FLOAT, depth.data());
        for (std::size_t i = 0; i < pixels; ++i) {
            for (std::size_t c = 0; c < 3; ++c) layer.rgb[3 * (i * stride + m) + c] = rgba[4 * i + c];
            const bool drawn = rgba[4 * i + 3] != 0.0f;
            layer.depth[i * stride + m] = drawn ? depth[i] : std::numeric_limits<float>::infinity();
        }
    }
    check_gl("drawing the opaque layer");
    glDisable(GL_DEPTH_TEST);
    return layer;
}

LayerCounts count_layers(const Scene& scene, int width, int height) {
    const GlTarget target(width, height, GL_R32F, false);
    target.bind();
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_DEPTH_TEST);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    const float clear[4] = {0, 0, 0, 0};
    glClearBufferfv(GL_COLOR, 0, clear);
    for (const SceneDraw& draw : scene.transparent) {
        const GpuDraw gpu(draw, scene.camera, "fragment_count");
        if (draw.primitives > 0) gpu.submit(gpu.everything());
    }
    std::vector<float> layers(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    glReadPixels(0, 0, width, height, GL_RED, GL_FLOAT, layers.data());
    check_gl("counting layers");
    glDisable(GL_BLEND);
    LayerCounts counts;
    for (float value : layers) {
        const auto depth = static_cast<std::uint64_t>(value);
        counts.fragments += depth;
        counts.covered += depth > 0;
        counts.deepest = std::max(counts.deepest, depth);
    }
    return counts;
}

}  // namespace ropsim
