// A point captured from the camera lies where the light's capture saw it: texel and depth.
#include "rop/shadow/light_space.h"
#include "tests/capture/test_scene.h"

#include <cmath>
#include <map>
#include <utility>

#include <glm/gtc/matrix_transform.hpp>

namespace ropsim::testing {
namespace {

using LightViewCapture = OpenGlTest;

constexpr int kWidth = 192;
constexpr int kHeight = 128;

// One triangle in world space.
SceneDraw world_triangle() {
    SceneDraw draw = window_draw({{{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}}}, 2, 2, {1, 1, 1, 0.5f});
    draw.vertex =
        "layout(std430, binding = 1) readonly buffer Corners { vec4 corners[]; };\n"
        "uniform uint u_first_instance; uniform mat4 u_view; uniform mat4 u_projection;\n"
        "flat out uint v_instance;\n"
        "void main() { v_instance = u_first_instance + uint(gl_InstanceID);\n"
        "  gl_Position = u_projection * u_view * corners[gl_VertexID]; }\n";
    draw.buffers[0].values = {-1, 0.2f, -1, 1, 1.2f, 0.5f, 0, 1, -0.5f, 0.9f, 1.1f, 1};
    return draw;
}

TEST_F(LightViewCapture, MapsFragmentsOfTheCameraOntoThoseOfTheLight) {
    const GlContext context;
    Scene scene;
    scene.transparent.push_back(world_triangle());
    scene.camera.view = glm::lookAt(glm::vec3(1, 3, 4), glm::vec3(0, 0.4f, 0), glm::vec3(0, 1, 0));
    scene.camera.projection =
        glm::perspective(0.8f, static_cast<float>(kWidth) / static_cast<float>(kHeight), 0.5f, 20.0f);
    TraceHeader camera;
    camera.width = kWidth;
    camera.height = kHeight;
    camera.camera = scene.camera;
    const std::vector<Fragment> seen = capture_all(scene, kWidth, kHeight);
    ASSERT_GT(seen.size(), 300u);

    TraceHeader light;
    light.width = light.height = kHeight;
    scene.camera.view = glm::lookAt(glm::vec3(-1, 4, 2), glm::vec3(0), glm::vec3(0, 1, 0));
    scene.camera.projection = glm::ortho(-2.0f, 2.0f, -2.0f, 2.0f, 1.0f, 8.0f);
    light.camera = scene.camera;
    std::map<std::pair<int, int>, float> map;
    for (const Fragment& f : capture_all(scene, kHeight, kHeight)) map[{f.x, f.y}] = f.z;

    const LightSpace to_light(camera, light);
    std::size_t found = 0;
    for (const Fragment& f : seen) {
        const ViewPoint point = to_light({f.x + 0.5, f.y + 0.5, static_cast<double>(f.z)});
        const int x = static_cast<int>(std::floor(point.x));
        const int y = static_cast<int>(std::floor(point.y));
        const auto here = map.find({x, y});
        const auto right = map.find({x + 1, y});
        const auto below = map.find({x, y + 1});
        if (here == map.end() || right == map.end() || below == map.end()) continue;  // the triangle's edge
        ++found;
        // The light's depths are a plane over its texels; take it from the texel's centre to the point.
        const double z = static_cast<double>(here->second);
        const double across = (static_cast<double>(right->second) - z) * (point.x - x - 0.5);
        const double down = (static_cast<double>(below->second) - z) * (point.y - y - 0.5);
        EXPECT_NEAR(point.z, z + across + down, 2e-6) << f.x << ',' << f.y;
    }
    EXPECT_GT(found, seen.size() * 3 / 4) << seen.size();
}

}  // namespace
}  // namespace ropsim::testing
