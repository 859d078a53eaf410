// Pipes by parallel transport of a ring.
#include "capture/geometry/pipe_mesh.h"

#include "base/error.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

// A ring of the tube: where it stands, its axes (each scaled so that the tube keeps its width), which way the
// path runs.
struct Ring {
    glm::vec3 centre;
    glm::vec3 across;
    glm::vec3 up;
    glm::vec3 along;
};

std::vector<Ring> make_rings(std::span<const glm::vec3> path) {
    std::vector<Ring> rings;
    glm::vec3 direction = glm::normalize(path[1] - path[0]);
    const glm::vec3 hint = std::abs(direction.y) > 0.9f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
    glm::vec3 across = glm::normalize(glm::cross(hint, direction));
    for (std::size_t i = 0; i < path.size(); ++i) {
        const glm::vec3 next = i + 1 < path.size() ? glm::normalize(path[i + 1] - path[i]) : direction;
        const glm::vec3 along = glm::normalize(direction + next + 1e-6f * across);
        // Onto the plane halfway through the bend; the mitre makes the ring an ellipse.
        across = glm::normalize(across - glm::dot(across, along) * along);
        const glm::vec3 up = glm::cross(along, across);
        const glm::vec3 bend = next - direction;
        const float bent = glm::length(bend);
        glm::vec3 wide_across = across;
        glm::vec3 wide_up = up;
        if (bent > 1e-4f) {
            const glm::vec3 out = bend / bent;
            const float cosine = std::max(glm::dot(along, next), 0.3f);
            wide_across += (1 / cosine - 1) * glm::dot(across, out) * out;
            wide_up += (1 / cosine - 1) * glm::dot(up, out) * out;
        }
        rings.push_back({path[i], wide_across, wide_up, along});
        across = glm::normalize(across - glm::dot(across, next) * next);
        direction = next;
    }
    return rings;
}

void add_cap(TriangleMesh& mesh, const Ring& ring, float radius, int sides, bool start) {
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    for (int k = 0; k < sides; ++k) {
        const float angle = glm::two_pi<float>() * static_cast<float>(k) / static_cast<float>(sides);
        mesh.positions.push_back(ring.centre +
                                 radius * (std::cos(angle) * ring.across + std::sin(angle) * ring.up));
        mesh.normals.push_back(start ? -ring.along : ring.along);
    }
    for (std::uint32_t k = 2; k < static_cast<std::uint32_t>(sides); ++k) {
        if (start) {
            mesh.indices.insert(mesh.indices.end(), {base, base + k, base + k - 1});
        } else {
            mesh.indices.insert(mesh.indices.end(), {base, base + k - 1, base + k});
        }
    }
}

}  // namespace

TriangleMesh pipe_mesh(std::span<const glm::vec3> path, std::span<const float> radii,
                       const PipeShape& shape) {
    CHECK(path.size() >= 2 && radii.size() == path.size() && shape.sides >= 3,
          "{} points, {} radii, {} sides", path.size(), radii.size(), shape.sides);
    const std::vector<Ring> rings = make_rings(path);
    TriangleMesh mesh;
    // A facet has corners of its own, a smooth tube shares them.
    const int columns = shape.faceted ? 2 * shape.sides : shape.sides + 1;
    for (std::size_t i = 0; i < rings.size(); ++i) {
        for (int column = 0; column < columns; ++column) {
            const int corner = shape.faceted ? (column + 1) / 2 : column;
            const float step = glm::two_pi<float>() / static_cast<float>(shape.sides);
            const float angle = step * static_cast<float>(corner);
            const float facing =
                shape.faceted ? step * (std::floor(0.5f * static_cast<float>(column)) + 0.5f) : angle;
            const Ring& ring = rings[i];
            mesh.positions.push_back(ring.centre +
                                     radii[i] * (std::cos(angle) * ring.across + std::sin(angle) * ring.up));
            mesh.normals.push_back(
                glm::normalize(std::cos(facing) * ring.across + std::sin(facing) * ring.up));
        }
    }
    const auto row = static_cast<std::uint32_t>(columns);
    for (std::uint32_t ring = 0; ring + 1 < rings.size(); ++ring) {
        for (std::uint32_t k = 0; k + 1 < row; k += shape.faceted ? 2 : 1) {
            const std::uint32_t a = ring * row + k;
            mesh.indices.insert(mesh.indices.end(), {a, a + 1, a + row, a + 1, a + row + 1, a + row});
        }
    }
    if (shape.capped) {
        add_cap(mesh, rings.front(), radii.front(), shape.sides, true);
        add_cap(mesh, rings.back(), radii.back(), shape.sides, false);
    }
    return mesh;
}

}  // namespace ropsim
