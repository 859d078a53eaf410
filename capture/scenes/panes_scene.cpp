// Scene: a row of glass panes in a hall, clear at its left end and frosted at its right, before things that
// touch the glass or stand further and further behind it (McGuire and Mara 2017, Figs. 1 left and 8).
//
// Materials as the paper means them (section 4.1), recorded as they are: coverage 1 and the transmission
// (covering() in capture/shaders/surface.glsl). A pane is two interfaces. The front one is smooth glass,
// collimation 1; the back one of frosted panes is sandblasted, lets all or nearly all light through and
// scatters it. Flat panes let rays go on as they came: index 1. Those that bend rays, of index 1.5, are the
// bevels of the first pane and the ripples of the second. Coloured panes stand before the row, one behind it;
// one of them is frosted.
#include "base/error.h"
#include "base/random.h"
#include "capture/scene_list.h"
#include "capture/scenery/table_light.h"
#include "capture/scenery/transmissive_draw.h"
#include "capture/scenes/panes_hall.h"
#include "capture/shader_sources.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {
namespace {

constexpr double kMaxPanes = 2e6;
constexpr double kFurtherPerPane = 7;     // further panes that show as much as one of the scene's own
constexpr float kHalfThickness = 0.006f;  // metres
constexpr float kFoot = 0.03f;            // height of a pane's lower edge
constexpr float kBevel = 0.055f;          // width of the bevels
constexpr float kBevelTilt = 0.2f;        // radians
constexpr float kRippleTilt = 0.055f;     // steepest, radians
constexpr float kRippleLength = 0.17f;
constexpr glm::vec3 kColourless(0.955f, 0.975f, 0.965f);  // of one interface
constexpr glm::vec3 kEdge(0.22f, 0.52f, 0.4f);

enum class Finish : std::uint8_t { kClear, kBevelled, kRippled, kFrosted };

struct Pane {
    glm::vec3 place;  // middle of the lower edge
    float yaw;
    glm::vec2 half;          // half width and half height
    glm::vec3 transmission;  // of one interface
    Finish finish;
    float collimation = 1;
    float frost = 1;  // transmission of the frosted interface
};

std::vector<Pane> own_panes() {
    std::vector<Pane> panes;
    constexpr float kCollimation[] = {1, 1, 0.9f, 0.75f, 0.5f, 0.25f, 0.05f};
    constexpr Finish kFinish[] = {Finish::kBevelled, Finish::kRippled, Finish::kFrosted, Finish::kFrosted,
                                  Finish::kFrosted,  Finish::kFrosted, Finish::kFrosted};
    // The middle one of the five that are frosted loses nothing at all.
    constexpr float kFrost[] = {1, 1, 0.98f, 0.97f, 1, 0.95f, 0.93f};
    for (std::size_t i = 0; i < 7; ++i)
        panes.push_back({{0.735f * (static_cast<float>(i) - 3), kFoot, 0},
                         0,
                         {0.34f, 1.0f},
                         kColourless,
                         kFinish[i],
                         kCollimation[i],
                         kFrost[i]});
    const glm::vec3 amber(0.98f, 0.8f, 0.36f);
    const glm::vec3 blue(0.42f, 0.66f, 0.95f);
    const glm::vec3 red(0.94f, 0.36f, 0.32f);
    const glm::vec3 green(0.5f, 0.9f, 0.6f);
    const glm::vec3 violet(0.76f, 0.55f, 0.92f);
    panes.push_back({{-1.62f, kFoot, 0.75f}, 0.35f, {0.26f, 0.34f}, amber, Finish::kClear});
    panes.push_back({{-1.2f, kFoot, 0.95f}, -0.3f, {0.26f, 0.3f}, blue, Finish::kClear});
    panes.push_back({{-0.28f, kFoot, 0.8f}, 0.25f, {0.26f, 0.42f}, red, Finish::kFrosted, 0.6f, 0.97f});
    panes.push_back({{0.14f, kFoot, 0.98f}, -0.35f, {0.24f, 0.36f}, green, Finish::kClear});
    panes.push_back({{-0.4f, kFoot, -1.2f}, 0.2f, {0.3f, 0.8f}, violet, Finish::kClear});
    return panes;
}

// Beyond the scene's own: small ones anywhere behind the row, clear and frosted, in every colour.
Pane further_pane(std::uint64_t seed, std::uint64_t index) {
    const std::uint64_t key = mix64(seed * 0x9E3779B97F4A7C15ull + index);
    const auto channel = [&](std::uint32_t draw) { return 0.25f + 0.7f * random_unit(key, draw); };
    Pane pane{{5.0f * (random_unit(key, 0) - 0.5f), kFoot, -0.3f - 3.5f * random_unit(key, 1)},
              1.2f * (random_unit(key, 2) - 0.5f),
              {0.15f, 0.45f},
              {channel(3), channel(4), channel(5)},
              random_unit(key, 6) < 0.5f ? Finish::kClear : Finish::kFrosted};
    if (pane.finish == Finish::kFrosted) pane.collimation = 0.95f * random_unit(key, 7);
    return pane;
}

glm::mat4 standing(const Pane& pane) {
    return placed(pane.place + glm::vec3(0, pane.half.y, 0), glm::vec3(1.0f), pane.yaw);
}

glm::vec3 both_interfaces(const Pane& pane) {
    return pane.transmission * (pane.finish == Finish::kFrosted ? glm::vec3(pane.frost) : pane.transmission);
}

// What arrives of the sun on the floor through the panes.
TableLight floor_light(const std::vector<Pane>& panes) {
    TableLight light({-4.5f, -4.6f}, 9.0f, hall_sun());
    for (const Pane& pane : panes) {
        const glm::mat4 to_pane = glm::inverse(standing(pane));
        const glm::vec3 along(to_pane * glm::vec4(hall_sun(), 0));
        const glm::vec3 passes = both_interfaces(pane);
        const float blur = 0.01f + 0.25f * (1 - pane.collimation);
        light.filter([&](glm::vec2 at) {
            const glm::vec3 from(to_pane * glm::vec4(at.x, 0, at.y, 1));
            const float way = -from.z / along.z;
            if (way <= 0) return glm::vec3(1.0f);
            const glm::vec2 edge = glm::abs(glm::vec2(from + way * along)) - pane.half;
            const float inside = glm::smoothstep(blur, -blur, edge.x) * glm::smoothstep(blur, -blur, edge.y);
            return glm::mix(glm::vec3(1.0f), passes, inside);
        });
    }
    return light;
}

void add_quad(TriangleMesh& mesh, const glm::vec3 (&corners)[4], glm::vec3 normal) {
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    for (const glm::vec3& corner : corners) {
        mesh.positions.push_back(corner);
        mesh.normals.push_back(normal);
    }
    for (std::uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(base + i);
}

// From -1 to 1 in x and y, towards +z.
TriangleMesh face_mesh() {
    TriangleMesh mesh;
    add_quad(mesh, {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, {0, 0, 1});
    return mesh;
}

// The sides of a box from -1 to 1 between its faces towards +z and -z.
TriangleMesh sides_mesh() {
    TriangleMesh mesh;
    for (int side = 0; side < 4; ++side) {
        constexpr glm::vec2 kCorners[] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
        const glm::vec2 a = kCorners[side];
        const glm::vec2 b = kCorners[(side + 1) % 4];
        add_quad(mesh, {{a, -1}, {b, -1}, {b, 1}, {a, 1}}, {0.5f * (a + b), 0});
    }
    return mesh;
}

// Four strips along the edges of a pane, each turned outwards.
TriangleMesh bevels_mesh(glm::vec2 half) {
    TriangleMesh mesh;
    const glm::vec2 inner = half - kBevel;
    const float drop = kBevel * std::tan(kBevelTilt);
    constexpr glm::vec2 kCorners[] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    for (int side = 0; side < 4; ++side) {
        const glm::vec2 a = kCorners[side];
        const glm::vec2 b = kCorners[(side + 1) % 4];
        add_quad(mesh, {{half * a, -drop}, {half * b, -drop}, {inner * b, 0}, {inner * a, 0}},
                 glm::normalize(glm::vec3(0.5f * (a + b) * std::sin(kBevelTilt), std::cos(kBevelTilt))));
    }
    return mesh;
}

// Rings about the middle, as of a stone in water.
TriangleMesh ripples_mesh(glm::vec2 half) {
    TriangleMesh mesh;
    constexpr std::uint32_t kColumns = 68;
    constexpr std::uint32_t kRows = 200;
    const float wave = glm::two_pi<float>() / kRippleLength;
    for (std::uint32_t row = 0; row <= kRows; ++row)
        for (std::uint32_t column = 0; column <= kColumns; ++column) {
            const glm::vec2 at = half * glm::vec2(2.0f * static_cast<float>(column) / kColumns - 1,
                                                  2.0f * static_cast<float>(row) / kRows - 1);
            const float away = glm::length(at);
            // Flat in the very middle.
            const float steep = kRippleTilt * glm::smoothstep(0.0f, 0.5f * kRippleLength, away);
            const glm::vec2 outwards = away > 0 ? at / away : glm::vec2(0.0f);
            mesh.positions.emplace_back(at, steep / wave * (std::cos(wave * away) - 1));
            mesh.normals.push_back(glm::normalize(glm::vec3(steep * std::sin(wave * away) * outwards, 1.0f)));
        }
    for (std::uint32_t row = 0; row < kRows; ++row)
        for (std::uint32_t column = 0; column < kColumns; ++column) {
            const std::uint32_t a = row * (kColumns + 1) + column;
            const std::uint32_t c = a + kColumns + 1;
            for (std::uint32_t i : {a, a + 1, c + 1, a, c + 1, c}) mesh.indices.push_back(i);
        }
    return mesh;
}

// The copies of each mesh that the panes consist of.
struct Interfaces {
    std::vector<MeshInstance> smooth, sides, bevels, ripples, frosted;

    void add(const Pane& pane, const glm::mat4& sized) {
        const glm::mat4 model = sized * standing(pane);
        const auto part = [&](glm::vec2 half, float z) {
            return glm::scale(glm::translate(model, glm::vec3(0, 0, z)), glm::vec3(half, 1));
        };
        const glm::vec4 color(pane.transmission, 1);
        sides.push_back({glm::scale(model, glm::vec3(pane.half, kHalfThickness)),
                         glm::vec4(kEdge * pane.transmission, 1)});
        const glm::mat4 front = glm::translate(model, glm::vec3(0, 0, kHalfThickness));
        if (pane.finish == Finish::kRippled)
            ripples.push_back({front, color});
        else if (pane.finish == Finish::kBevelled)
            bevels.push_back({front, color});
        if (pane.finish != Finish::kRippled)
            smooth.push_back(
                {part(pane.half - (pane.finish == Finish::kBevelled ? kBevel : 0.0f), kHalfThickness),
                 color});
        if (pane.finish == Finish::kFrosted)
            frosted.push_back({part(pane.half, -kHalfThickness),
                               glm::vec4(pane.frost * glm::vec3(1.0f), pane.collimation)});
        else
            smooth.push_back({part(pane.half, -kHalfThickness), color});
    }
};

GlassLook look(float eta) {
    GlassLook look;
    look.environment = "hall_environment";
    look.to_sun = hall_sun();
    look.sun = glm::vec3(60, 52, 40);
    look.reflectance = 0.035f;
    look.inner_reflections = 0.02f;
    look.eta = eta;
    look.least_alpha = false;
    return look;
}

class PanesScene final : public SceneSource {
 public:
    PanesScene(double aspect, std::uint64_t seed) : aspect_(aspect), seed_(seed) {
        shrinks = true;
        const std::vector<Pane> panes = own_panes();
        std::vector<glm::vec4> stands;
        for (const Pane& pane : panes)
            for (float side : {-0.6f, 0.6f})
                stands.emplace_back(glm::vec3(standing(pane) * glm::vec4(side * pane.half.x, 0, 0, 1)),
                                    pane.yaw);
        hall_ = hall_draws(stands, floor_light(panes));
    }

    Scene build(const SceneScale& scale) const override {
        std::vector<Pane> panes = own_panes();
        const double further =
            std::round(kFurtherPerPane * static_cast<double>(panes.size()) * std::max(scale.count - 1, 0.0));
        if (further > kMaxPanes) {
            throw UserError("--fragments",
                            fmt::format("'panes' would need {:.0f} panes, more than {:.0f}; ask for fewer "
                                        "fragments or use a larger --size",
                                        further, kMaxPanes));
        }
        Scene scene;
        scene.materials = true;
        scene.camera = look_at({-0.1f, 1.42f, 5.45f}, {0, 0.93f, 0}, 31, aspect_, 1.75, 0.5f, 16);
        scene.light = light_camera(hall_sun(), {0, 0.9f, -0.5f}, 3.6f);
        scene.background = {0.5f, 0.47f, 0.4f};
        scene.opaque = hall_;
        const glm::vec2 half = panes.front().half;
        for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(further); ++i)
            panes.push_back(further_pane(seed_, i));
        scene.description = fmt::format(
            "{} panes of glass, clear, frosted, coloured, rippled and bevelled, before a garden's "
            "chess pieces, a chequered box and a figure",
            panes.size());
        const glm::mat4 sized = glm::scale(glm::mat4(1.0f), glm::vec3(static_cast<float>(scale.size)));
        Interfaces parts;
        for (const Pane& pane : panes) parts.add(pane, sized);
        scene.transparent.push_back(frost(parts.frosted));
        const TriangleMesh face = face_mesh();
        scene.transparent.push_back(transmissive_draw("glass", face, parts.smooth, look(1)));
        scene.transparent.push_back(
            transmissive_draw("ripples", ripples_mesh(half), parts.ripples, look(1.5f)));
        scene.transparent.push_back(transmissive_draw("bevels", bevels_mesh(half), parts.bevels, look(1.5f)));
        scene.transparent.push_back(transmissive_draw("edges", sides_mesh(), parts.sides, look(1)));
        return scene;
    }

 private:
    static SceneDraw frost(const std::vector<MeshInstance>& copies) {
        SceneDraw draw = matte_draw("frost", face_mesh(), copies);
        draw.shading = shader_source("frosted_shading");
        draw.parameters = {glm::vec4(0.9f, 0.9f, 0.88f, 0)};
        return draw;
    }

    double aspect_;
    std::uint64_t seed_;
    std::vector<SceneDraw> hall_;
};

}  // namespace

std::unique_ptr<SceneSource> make_panes_scene(double aspect, std::uint64_t seed) {
    return std::make_unique<PanesScene>(aspect, seed);
}

}  // namespace ropsim
