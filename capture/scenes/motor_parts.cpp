// The motor put together: fittings, bolts and pipes, and the number of all its triangles.
#include "capture/scenes/motor_parts.h"

#include "base/error.h"
#include "capture/geometry/lathe_mesh.h"
#include "capture/geometry/profile.h"
#include "capture/geometry/swept_mesh.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {
namespace {

constexpr float kTau = glm::two_pi<float>();

glm::mat4 moved(glm::vec3 to) {
    return glm::translate(glm::mat4(1.0f), to);
}

// A screw with a hexagonal head on a washer, its thread towards -y; the head's underside is at the origin.
TriangleMesh bolt(float radius, float length) {
    TriangleMesh mesh;
    const glm::mat4 upright = glm::rotate(moved({0, 0.62f * radius, 0}), -0.25f * kTau, glm::vec3(1, 0, 0));
    append_mesh(mesh, extruded_mesh(circle_outline(1.75f * radius, 6), 0.55f * radius, 20), upright);
    append_mesh(mesh, lathe_mesh({{radius, -0.25f * radius},
                                  {2.1f * radius, -0.25f * radius},
                                  {2.1f * radius, 0.02f * radius},
                                  {radius, 0.02f * radius},
                                  {radius, -0.25f * radius}},
                                 24));
    std::vector<glm::vec2> thread{{0, -length}};
    const int turns = static_cast<int>(length / (0.42f * radius));
    for (int i = 0; i <= turns; ++i) {
        const float y = -length + length * static_cast<float>(i) / static_cast<float>(turns);
        thread.emplace_back((i % 2 == 0 ? 0.82f : 1.0f) * radius, y);
    }
    thread.emplace_back(0.0f, 0.0f);
    append_mesh(mesh, lathe_mesh(thread, 18));
    return mesh;
}

// A bolt whose head points along `out`.
void add_bolt(TriangleMesh& mesh, const TriangleMesh& shape, glm::vec3 at, glm::vec3 out) {
    const glm::vec3 side =
        glm::normalize(std::fabs(out.y) < 0.9f ? glm::cross(glm::vec3(0, 1, 0), out) : glm::vec3(1, 0, 0));
    append_mesh(mesh, shape,
                glm::mat4(glm::vec4(side, 0), glm::vec4(out, 0), glm::vec4(glm::cross(side, out), 0),
                          glm::vec4(at, 1)));
}

// A smooth path through a few points.
std::vector<glm::vec3> smooth_path(const std::vector<glm::vec3>& points, int steps) {
    std::vector<glm::vec3> path;
    const auto count = static_cast<int>(points.size());
    for (int i = 0; i + 1 < count; ++i) {
        const auto at = [&](int k) { return points[static_cast<std::size_t>(std::clamp(k, 0, count - 1))]; };
        for (int step = 0; step < steps; ++step) {
            const float t = static_cast<float>(step) / static_cast<float>(steps);
            const glm::vec3 a = 2.0f * at(i);
            const glm::vec3 b = at(i + 1) - at(i - 1);
            const glm::vec3 c = 2.0f * at(i - 1) - 5.0f * at(i) + 4.0f * at(i + 1) - at(i + 2);
            const glm::vec3 d = 3.0f * at(i) - at(i - 1) - 3.0f * at(i + 1) + at(i + 2);
            path.push_back(0.5f * (a + t * (b + t * (c + t * d))));
        }
    }
    path.push_back(points.back());
    return path;
}

TriangleMesh fittings() {
    TriangleMesh mesh;
    const glm::mat4 flat = glm::rotate(glm::mat4(1.0f), -0.25f * kTau, glm::vec3(1, 0, 0));
    // Terminal box with lid, cable glands, terminals.
    append_mesh(mesh, extruded_mesh(rounded_rectangle({0.42f, 0.36f}, 0.07f, 6), 0.14f),
                moved({0.1f, 1.16f, 0}) * flat);
    append_mesh(mesh, extruded_mesh(rounded_rectangle({0.45f, 0.39f}, 0.08f, 6), 0.035f),
                moved({0.1f, 1.345f, 0}) * flat);
    for (int i = 0; i < 6; ++i) {
        const glm::vec3 at(-0.1f + 0.2f * static_cast<float>(i % 3), 1.1f, i < 3 ? -0.12f : 0.12f);
        append_mesh(
            mesh,
            lathe_mesh({{0, 0}, {0.05f, 0}, {0.05f, 0.04f}, {0.025f, 0.05f}, {0.025f, 0.14f}, {0, 0.15f}},
                       24),
            moved(at));
    }
    for (const float z : {-0.15f, 0.15f}) {
        append_mesh(
            mesh,
            turned_ring(
                {{0.05f, 0.5f}, {0.1f, 0.5f}, {0.1f, 0.58f}, {0.08f, 0.6f}, {0.08f, 0.7f}, {0.05f, 0.72f}},
                32, {1.16f, z}));
        append_mesh(mesh, tube_mesh(smooth_path({{0.3f, 1.16f, z},
                                                 {0.7f, 1.16f, z},
                                                 {1.05f, 1.2f, 1.3f * z},
                                                 {1.4f, 1.5f, 2.2f * z},
                                                 {1.6f, 1.75f, 2.4f * z}},
                                                10),
                                    0.045f, 14));
    }
    // Feet.
    for (const float x : {-0.65f, 0.7f})
        for (const float z : {-1.0f, 1.0f})
            append_mesh(mesh,
                        extruded_mesh({{-0.55f, -1.2f},
                                       {0.4f, -1.2f},
                                       {0.4f, -1.1f},
                                       {0.12f, -1.08f},
                                       {-0.1f, -0.86f},
                                       {-0.4f, -0.88f}},
                                      0.14f),
                        moved({x, 0, 0.45f * z}) *
                            glm::rotate(glm::mat4(1.0f), -0.25f * kTau * z, glm::vec3(0, 1, 0)));
    // A lifting eye.
    std::vector<glm::vec3> eye;
    for (int i = 0; i < 36; ++i) {
        const float angle = kTau * static_cast<float>(i) / 36;
        eye.emplace_back(-0.72f + 0.12f * std::cos(angle), 1.24f + 0.12f * std::sin(angle), 0.0f);
    }
    SweptProfile ring;
    ring.path = eye;
    ring.outline = circle_outline(0.032f, 14);
    ring.closed = true;
    ring.up = {0, 0, 1};
    append_mesh(mesh, swept_mesh(ring));
    return mesh;
}

TriangleMesh pipes() {
    TriangleMesh mesh;
    // Cooling water in and out along the housing, and an oil line to the gears.
    const std::vector<std::vector<glm::vec3>> lines = {{{1.25f, 0.35f, 1.3f},
                                                        {0.9f, 0.35f, 1.3f},
                                                        {-0.5f, 0.35f, 1.3f},
                                                        {-0.9f, 0.3f, 1.3f},
                                                        {-1.0f, -0.1f, 1.25f},
                                                        {-1.0f, -0.6f, 1.2f},
                                                        {-0.9f, -0.95f, 1.2f},
                                                        {-0.4f, -1.05f, 1.2f},
                                                        {1.6f, -1.05f, 1.25f}},
                                                       {{-1.2f, 0.75f, -1.05f},
                                                        {-0.7f, 0.8f, -1.1f},
                                                        {0.7f, 0.8f, -1.1f},
                                                        {1.1f, 0.75f, -1.1f},
                                                        {1.3f, 0.5f, -1.25f},
                                                        {1.3f, -0.4f, -1.3f},
                                                        {1.35f, -1.0f, -1.1f}},
                                                       {{1.0f, 1.0f, 0.55f},
                                                        {1.15f, 1.15f, 0.6f},
                                                        {1.5f, 1.2f, 0.55f},
                                                        {1.8f, 1.1f, 0.4f},
                                                        {1.85f, 0.75f, 0.35f}}};
    for (const std::vector<glm::vec3>& line : lines) {
        append_mesh(mesh, tube_mesh(smooth_path(line, 10), 0.055f, 20));
        // The bore, and flanges at the ends.
        append_mesh(mesh, tube_mesh(smooth_path(line, 10), 0.042f, 16));
    }
    append_mesh(mesh, flat_ring(0.056f, 0.12f, 1.22f, 1.27f, 32, {0.35f, 1.3f}));
    append_mesh(mesh, flat_ring(0.056f, 0.12f, -1.22f, -1.17f, 32, {0.75f, -1.05f}));
    append_mesh(mesh, flat_ring(0.056f, 0.12f, 1.57f, 1.62f, 32, {-1.05f, 1.25f}));
    return mesh;
}

TriangleMesh bolts() {
    TriangleMesh mesh;
    const TriangleMesh big = bolt(0.035f, 0.22f);
    const TriangleMesh small = bolt(0.024f, 0.16f);
    for (int i = 0; i < 10; ++i) {
        const float angle = kTau * (static_cast<float>(i) + 0.5f) / 10;
        const glm::vec3 at(0, 1.01f * std::cos(angle), 1.01f * std::sin(angle));
        add_bolt(mesh, small, at + glm::vec3(-1.09f, 0, 0), {-1, 0, 0});
    }
    for (int i = 0; i < 14; ++i) {
        const float angle = kTau * (static_cast<float>(i) + 0.5f) / 14;
        const float bump = 0.08f * std::cos(2 * angle);
        add_bolt(
            mesh, big,
            {2.24f, -0.16f + (0.92f - bump) * std::cos(angle), -0.02f + (1.16f + bump) * std::sin(angle)},
            {1, 0, 0});
    }
    for (int i = 0; i < 6; ++i) {
        const float angle = kTau * static_cast<float>(i) / 6;
        add_bolt(mesh, small, {2.35f, -0.1f + 0.3f * std::cos(angle), -0.52f + 0.3f * std::sin(angle)},
                 {1, 0, 0});
        add_bolt(mesh, small, {2.3f, -0.42f + 0.2f * std::cos(angle), 0.5f + 0.2f * std::sin(angle)},
                 {1, 0, 0});
    }
    for (const float x : {-0.65f, 0.7f})
        for (const float z : {-0.92f, 0.92f}) add_bolt(mesh, big, {x, -1.08f, z}, {0, 1, 0});
    for (const float x : {-0.26f, 0.46f})
        for (const float z : {-0.3f, 0.3f}) add_bolt(mesh, small, {x, 1.38f, z}, {0, 1, 0});
    return mesh;
}

}  // namespace

std::vector<MotorAssembly> motor_assemblies() {
    std::vector<MotorAssembly> assemblies;
    assemblies.push_back({"housing", motor_housing()});
    assemblies.push_back({"cowl", motor_cowl()});
    assemblies.push_back({"stator", motor_stator()});
    assemblies.push_back({"rotor", motor_rotor()});
    assemblies.push_back({"bearings", motor_bearings()});
    assemblies.push_back({"gears", motor_gears()});
    assemblies.push_back({"gear case", motor_gear_case()});
    assemblies.push_back({"fittings", fittings()});
    assemblies.push_back({"pipes", pipes()});
    assemblies.push_back({"bolts", bolts()});
    return assemblies;
}

void refine_to(std::vector<MotorAssembly>& assemblies, std::uint32_t triangles) {
    struct Candidate {
        float area;
        std::size_t assembly;
        std::uint32_t triangle;
    };
    std::vector<Candidate> candidates;
    for (std::size_t a = 0; a < assemblies.size(); ++a) {
        const TriangleMesh& mesh = assemblies[a].mesh;
        for (std::uint32_t t = 0; t < mesh.triangles(); ++t) {
            const auto corner = [&](std::uint32_t k) { return mesh.positions[mesh.indices[3 * t + k]]; };
            candidates.push_back(
                {glm::length(glm::cross(corner(1) - corner(0), corner(2) - corner(0))), a, t});
        }
    }
    CHECK(triangles >= candidates.size() && (triangles - candidates.size()) % 2 == 0 &&
              triangles <= 3 * candidates.size(),
          "{} triangles cannot become {}", candidates.size(), triangles);
    const std::size_t cuts = (triangles - candidates.size()) / 2;
    const auto larger = [](const Candidate& a, const Candidate& b) {
        return a.area != b.area ? a.area > b.area
                                : std::pair(a.assembly, a.triangle) < std::pair(b.assembly, b.triangle);
    };
    std::partial_sort(candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(cuts),
                      candidates.end(), larger);
    for (std::size_t i = 0; i < cuts; ++i) {
        TriangleMesh& mesh = assemblies[candidates[i].assembly].mesh;
        const std::size_t at = std::size_t{3} * candidates[i].triangle;
        const std::uint32_t a = mesh.indices[at];
        const std::uint32_t b = mesh.indices[at + 1];
        const std::uint32_t c = mesh.indices[at + 2];
        const auto middle = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.push_back((mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) / 3.0f);
        mesh.normals.push_back(glm::normalize(mesh.normals[a] + mesh.normals[b] + mesh.normals[c]));
        mesh.indices[at + 2] = middle;
        mesh.indices.insert(mesh.indices.end(), {b, c, middle, c, a, middle});
    }
}

}  // namespace ropsim
