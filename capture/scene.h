// What a scene consists of: geometry, shaders and a camera, described without any OpenGL object.
#pragma once

#include "traces/trace.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// Read-only data that the shaders of a draw see at a shader storage binding (1 and up; 0 is the capture's
// own).
struct SceneBuffer {
    std::uint32_t binding = 1;
    std::vector<float> values;
};

// A texture of a draw, with all mip levels (box filtered, colour weighted by alpha), trilinear. Stored as
// 8-bit UNORM, so `values` are linear and in [0, 1].
struct SceneTexture {
    int width = 0;  // powers of two
    int height = 0;
    int channels = 1;    // 1: luminance, read as .r; 4: straight linear colour and alpha
    bool repeat = true;  // else clamped to the edge
    std::vector<float> values;
};

// One draw call of triangles. The vertex shader pulls its data from the buffers by gl_VertexID and
// u_first_instance + gl_InstanceID; u_view and u_projection are the camera's, u_viewport.xy the image's size
// in pixels.
struct SceneDraw {
    Draw state;          // as the trace records it; shader costs are measured, object_id is the draw's number
    std::string vertex;  // GLSL 4.50 without #version: gl_Position, and flat out uint v_instance
    std::string shading;  // likewise: vec4 shade(), straight linear colour and alpha; may discard
    std::vector<SceneBuffer> buffers;
    std::vector<std::uint32_t> indices;  // empty: vertices in order
    std::uint32_t primitives = 0;        // triangles of one instance
    std::uint32_t instances = 1;
    std::vector<SceneTexture> textures;  // texture i is on unit i, at most kMaxSceneTextures
    std::vector<glm::vec4> parameters;   // u_parameters, at most kMaxSceneParameters
};
inline constexpr int kMaxSceneParameters = 8;
inline constexpr int kMaxSceneTextures = 4;

struct Scene {
    std::string description;  // one line, for the trace
    Camera camera;
    Camera light;                // orthographic or perspective, sees all transparent geometry
    glm::vec3 background{0.0f};  // linear
    std::vector<SceneDraw> opaque;
    std::vector<SceneDraw> transparent;  // in submission order
    // Whether the trace records materials. shade() may then set the globals surface_transmission,
    // surface_collimation, surface_eta and surface_normal (world space), declared before it.
    bool materials = false;
    // Transparent hairs, particles, splats or triangles: what the scene's paper counts, if it does.
    std::uint64_t counted_primitives = 0;
};

// How much of the transparent geometry there is, relative to the scene's own measure.
struct SceneScale {
    double count = 1;  // instances, strands, particles
    double size = 1;   // linear size of the transparent geometry, about its centre
};

// Makes a scene at any scale: a pure function of (what it was constructed with, scale).
class SceneSource {
 public:
    virtual ~SceneSource() = default;
    virtual Scene build(const SceneScale& scale) const = 0;

    // What build({}) must reach: fragments a pixel of the whole image, and mean layers over the covered
    // pixels; more is drawn until it does. 0: whatever it has.
    double minimum_fragments_per_pixel = 0;
    double minimum_mean_layers = 0;
    // Whether fewer fragments than that come from smaller, not fewer, objects (keeps the layers).
    bool shrinks = false;
};

}  // namespace ropsim
