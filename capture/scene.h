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

// Luminance, bilinear and repeating, on texture unit 0; values in [0, 1].
struct SceneTexture {
    int width = 0;
    int height = 0;
    std::vector<float> values;
};

// One draw call of triangles. The vertex shader pulls its data from the buffers by gl_VertexID and
// u_first_instance + gl_InstanceID.
struct SceneDraw {
    Draw state;           // as the trace records it
    std::string vertex;   // GLSL 4.50 without #version: gl_Position, and flat out uint v_instance
    std::string shading;  // likewise: vec4 shade(), straight linear colour and alpha; may discard
    std::vector<SceneBuffer> buffers;
    std::vector<std::uint32_t> indices;  // empty: vertices in order
    std::uint32_t primitives = 0;        // triangles of one instance
    std::uint32_t instances = 1;
    SceneTexture texture;               // width 0: none
    std::vector<glm::vec4> parameters;  // u_parameters, at most kMaxSceneParameters
};
inline constexpr int kMaxSceneParameters = 8;

struct Scene {
    std::string description;  // one line, for the trace
    Camera camera;
    glm::vec3 background{0.0f};  // linear
    std::vector<SceneDraw> opaque;
    std::vector<SceneDraw> transparent;  // in submission order
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

// Each scene's source; `aspect` is width / height.
// Throws UserError when the file is missing, unreadable, or holds no triangles.
std::unique_ptr<SceneSource> make_mesh_scene(const std::string& path, double aspect, std::uint64_t seed);
std::unique_ptr<SceneSource> make_hair_scene(double aspect, std::uint64_t seed);
std::unique_ptr<SceneSource> make_plume_scene(double aspect, std::uint64_t seed);

}  // namespace ropsim
