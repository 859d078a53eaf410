// Vehicles from a loft (the body up to the windows), pillars, panes, a roof and wheels.
#include "capture/geometry/vehicle_mesh.h"

#include "capture/geometry/pipe_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

// A cross-section of the body.
struct Station {
    float x;
    float bottom;
    float top;
    float half_width;
};

// The windows' frame, seen from the side: where its corners are.
struct Form {
    std::vector<Station> stations;  // front to back
    glm::vec2 belt_front;           // x, y: foot of the windscreen
    glm::vec2 roof_front;
    glm::vec2 roof_rear;
    glm::vec2 belt_rear;
    float belt_half;  // half width at the foot of the windows
    float roof_half;
    std::vector<float> pillars;  // shares of the way from front to rear
    float front_axle;
    float rear_axle;
    float wheel;  // radius
    glm::vec3 color;
};

constexpr glm::vec4 kRubber(0.018f, 0.018f, 0.02f, 1);
constexpr glm::vec4 kTrim(0.03f, 0.03f, 0.033f, 1);
constexpr glm::vec4 kMetal(0.42f, 0.43f, 0.45f, 1);
constexpr glm::vec4 kPane(0.06f, 0.085f, 0.09f, 0.38f);

// Half of a cross-section from the middle of the bottom to the middle of the top: z and y.
std::vector<glm::vec2> section(const Station& s) {
    const float high = s.top - s.bottom;
    std::vector<glm::vec2> points = {{0, s.bottom},
                                     {0.86f * s.half_width, s.bottom},
                                     {0.97f * s.half_width, s.bottom + 0.07f * high},
                                     {s.half_width, s.bottom + 0.3f * high},
                                     {s.half_width, s.bottom + 0.6f * high},
                                     {0.975f * s.half_width, s.bottom + 0.8f * high},
                                     {0.94f * s.half_width, s.top - 0.07f * high},
                                     {0.88f * s.half_width, s.top - 0.01f * high},
                                     {0.5f * s.half_width, s.top + 0.025f * high},
                                     {0, s.top + 0.035f * high}};
    return points;
}

// A closed surface through the stations' sections, smooth.
TriangleMesh loft(const std::vector<Station>& stations) {
    TriangleMesh mesh;
    std::uint32_t row = 0;
    for (const Station& station : stations) {
        const std::vector<glm::vec2> half = section(station);
        for (const glm::vec2& p : half) mesh.positions.emplace_back(station.x, p.y, p.x);
        for (std::size_t i = half.size() - 1; i-- > 0;)
            mesh.positions.emplace_back(station.x, half[i].y, -half[i].x);
        row = static_cast<std::uint32_t>(2 * half.size() - 1);
    }
    for (std::uint32_t i = 0; i + 1 < stations.size(); ++i) {
        for (std::uint32_t k = 0; k + 1 < row; ++k) {
            const std::uint32_t v = i * row + k;
            mesh.indices.insert(mesh.indices.end(), {v, v + 1, v + row, v + 1, v + row + 1, v + row});
        }
    }
    mesh.normals.assign(mesh.positions.size(), glm::vec3(0));
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const std::uint32_t* v = &mesh.indices[i];
        const glm::vec3 normal = glm::cross(mesh.positions[v[1]] - mesh.positions[v[0]],
                                            mesh.positions[v[2]] - mesh.positions[v[0]]);
        for (int k = 0; k < 3; ++k) mesh.normals[v[k]] += normal;
    }
    for (glm::vec3& normal : mesh.normals) normal = glm::normalize(normal + glm::vec3(0, 1e-6f, 0));
    return mesh;
}

void add_bar(SceneryMesh& mesh, glm::vec3 from, glm::vec3 to, float radius, glm::vec4 color) {
    const std::array<glm::vec3, 2> path = {from, to};
    const std::array<float, 2> radii = {radius, radius};
    mesh.add(pipe_mesh(path, radii, {.sides = 10, .capped = true}), glm::mat4(1.0f), color, Finish::kLacquer);
}

void add_wheels(const Form& form, SceneryMesh& body) {
    const float half = form.stations[form.stations.size() / 2].half_width;
    for (float x : {form.front_axle, form.rear_axle}) {
        for (float side : {-1.0f, 1.0f}) {
            const glm::vec3 hub(x, form.wheel, side * half);
            const glm::vec3 out(0, 0, side);
            const auto disc = [&](glm::vec3 inner, glm::vec3 outer, float radius, glm::vec4 color) {
                const std::array<glm::vec3, 2> path = {inner, outer};
                const std::array<float, 2> radii = {radius, radius};
                body.add(pipe_mesh(path, radii, {.sides = 32, .capped = true}), glm::mat4(1.0f), color);
            };
            // The dark arch, the tyre, the rim and its hub, each a little further out.
            disc(hub + glm::vec3(0, 0.2f * form.wheel, 0) - 0.2f * out,
                 hub + glm::vec3(0, 0.2f * form.wheel, 0) + 0.008f * out, 1.2f * form.wheel, kTrim);
            disc(hub - 0.2f * out, hub + 0.03f * out, form.wheel, kRubber);
            disc(hub, hub + 0.036f * out, 0.66f * form.wheel, kMetal);
            disc(hub, hub + 0.04f * out, 0.5f * form.wheel, kTrim);
            for (int spoke = 0; spoke < 5; ++spoke) {
                const float angle = glm::two_pi<float>() * static_cast<float>(spoke) / 5;
                const glm::vec3 rim =
                    hub + 0.6f * form.wheel * glm::vec3(std::cos(angle), std::sin(angle), 0);
                add_bar(body, hub + 0.03f * out, rim + 0.025f * out, 0.035f, kMetal);
            }
        }
    }
}

// A point of the windows' frame: `t` from front to rear, at the belt (0) or the roof (1).
glm::vec3 frame_point(const Form& form, float t, float level, float side) {
    const glm::vec2 belt = glm::mix(form.belt_front, form.belt_rear, t);
    const glm::vec2 roof = glm::mix(form.roof_front, form.roof_rear, t);
    const glm::vec2 at = glm::mix(belt, roof, level);
    return {at.x, at.y, side * glm::mix(form.belt_half, form.roof_half, level)};
}

void add_windows(const Form& form, SceneryMesh& body, SceneryMesh& glass) {
    const glm::vec4 color(form.color, 1);
    const auto point = [&](float t, float level, float side) { return frame_point(form, t, level, side); };
    for (float side : {-1.0f, 1.0f}) {
        for (float t : form.pillars) add_bar(body, point(t, 0, side), point(t, 1, side), 0.04f, color);
        add_bar(body, point(0, 1, side), point(1, 1, side), 0.045f, color);
        add_bar(body, point(0, 0, side), point(1, 0, side), 0.03f, kTrim);
        for (std::size_t i = 0; i + 1 < form.pillars.size(); ++i) {
            const float from = form.pillars[i];
            const float to = form.pillars[i + 1];
            glass.add_quad(point(from, 0, side), point(to, 0, side), point(to, 1, side), point(from, 1, side),
                           kPane);
        }
    }
    for (float t : {0.0f, 1.0f}) {
        add_bar(body, point(t, 1, -1), point(t, 1, 1), 0.045f, color);
        glass.add_quad(point(t, 0, -1), point(t, 0, 1), point(t, 1, 1), point(t, 1, -1), kPane,
                       Finish::kPlain, 4, 3);
    }
    // The roof is a shallow loft of its own.
    std::vector<Station> roof;
    for (float t : {-0.01f, 0.04f, 0.2f, 0.5f, 0.8f, 0.96f, 1.01f}) {
        const glm::vec2 at = glm::mix(form.roof_front, form.roof_rear, t);
        const float bulge = 0.06f * (1 - std::pow(std::abs(2 * t - 1), 2.0f));
        roof.push_back({at.x, at.y - 0.04f, at.y + 0.01f + bulge, form.roof_half + 0.02f + 0.3f * bulge});
    }
    body.add(loft(roof), glm::mat4(1.0f), color, Finish::kLacquer);
}

// Floor, seats and dashboard, all dark.
void add_inside(const Form& form, SceneryMesh& body) {
    const float belt = std::max(form.belt_front.y, form.belt_rear.y) + 0.03f;
    const float length = form.belt_front.x - form.belt_rear.x;
    body.add_box({0.5f * (form.belt_front.x + form.belt_rear.x), belt - 0.02f, 0},
                 {0.46f * length, 0.03f, 0.97f * form.belt_half}, kTrim);
    for (float t : {0.42f, 0.72f}) {
        const float x = glm::mix(form.belt_front.x, form.belt_rear.x, t);
        for (float side : {-0.5f, 0.5f}) {
            body.add_box({x, belt + 0.1f, side * form.belt_half}, {0.07f, 0.16f, 0.3f * form.belt_half},
                         kTrim);
            body.add_box({x, belt + 0.31f, side * form.belt_half}, {0.05f, 0.07f, 0.14f * form.belt_half},
                         kTrim);
        }
    }
}

void add_lamps(const Form& form, SceneryMesh& body) {
    const Station& front = form.stations[1];
    const Station& rear = form.stations[form.stations.size() - 2];
    for (float side : {-0.72f, 0.72f}) {
        body.add_box({front.x + 0.03f, glm::mix(front.bottom, front.top, 0.68f), side * front.half_width},
                     {0.06f, 0.07f, 0.17f}, {0.75f, 0.76f, 0.74f, 1}, Finish::kLacquer);
        body.add_box({rear.x - 0.03f, glm::mix(rear.bottom, rear.top, 0.72f), side * rear.half_width},
                     {0.06f, 0.07f, 0.15f}, {0.4f, 0.02f, 0.02f, 1}, Finish::kLacquer);
    }
    body.add_box({front.x + 0.05f, glm::mix(front.bottom, front.top, 0.62f), 0},
                 {0.05f, 0.06f, 0.42f * front.half_width}, kTrim);
    for (const Station* end : {&front, &rear}) {
        const float out = end == &front ? 0.06f : -0.06f;
        body.add_box({end->x + out, end->bottom + 0.1f, 0}, {0.06f, 0.07f, 0.97f * end->half_width}, kTrim);
    }
}

Vehicle make_vehicle(const Form& form) {
    Vehicle vehicle;
    vehicle.body.add(loft(form.stations), glm::mat4(1.0f), glm::vec4(form.color, 1), Finish::kLacquer);
    add_wheels(form, vehicle.body);
    add_windows(form, vehicle.body, vehicle.glass);
    add_inside(form, vehicle.body);
    add_lamps(form, vehicle.body);
    return vehicle;
}

}  // namespace

Vehicle make_car(glm::vec3 color) {
    Form form;
    form.stations = std::vector<Station>{
        {2.22f, 0.45f, 0.5f, 0.5f},    {2.18f, 0.3f, 0.68f, 0.74f},  {2.0f, 0.24f, 0.76f, 0.83f},
        {1.5f, 0.22f, 0.84f, 0.87f},   {0.95f, 0.22f, 0.92f, 0.88f}, {0.0f, 0.22f, 0.94f, 0.89f},
        {-1.0f, 0.22f, 0.97f, 0.88f},  {-1.6f, 0.24f, 0.98f, 0.86f}, {-2.05f, 0.28f, 0.94f, 0.82f},
        {-2.18f, 0.34f, 0.84f, 0.74f}, {-2.22f, 0.5f, 0.55f, 0.5f}};
    form.belt_front = {0.98f, 0.93f};
    form.roof_front = {0.28f, 1.4f};
    form.roof_rear = {-0.85f, 1.4f};
    form.belt_rear = {-1.5f, 0.98f};
    form.belt_half = 0.76f;
    form.roof_half = 0.6f;
    form.pillars = {0.0f, 0.48f, 0.86f, 1.0f};
    form.front_axle = 1.38f;
    form.rear_axle = -1.32f;
    form.wheel = 0.32f;
    form.color = color;
    return make_vehicle(form);
}

Vehicle make_van(glm::vec3 color) {
    Form form;
    form.stations = std::vector<Station>{
        {2.52f, 0.55f, 0.65f, 0.7f}, {2.48f, 0.35f, 0.92f, 0.84f},  {2.3f, 0.3f, 1.05f, 0.92f},
        {1.9f, 0.28f, 1.14f, 0.95f}, {1.4f, 0.28f, 1.18f, 0.96f},   {0.0f, 0.28f, 1.2f, 0.97f},
        {-2.0f, 0.28f, 1.2f, 0.96f}, {-2.45f, 0.32f, 1.18f, 0.93f}, {-2.5f, 0.55f, 0.9f, 0.8f}};
    form.belt_front = {1.85f, 1.17f};
    form.roof_front = {1.1f, 2.02f};
    form.roof_rear = {-2.32f, 2.05f};
    form.belt_rear = {-2.42f, 1.2f};
    form.belt_half = 0.9f;
    form.roof_half = 0.8f;
    form.pillars = {0.0f, 0.3f, 0.64f, 1.0f};
    form.front_axle = 1.6f;
    form.rear_axle = -1.55f;
    form.wheel = 0.34f;
    form.color = color;
    return make_vehicle(form);
}

}  // namespace ropsim
