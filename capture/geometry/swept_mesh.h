// Tubes, belts and prisms: an outline carried along a path.
#pragma once

#include "capture/geometry/mesh.h"

#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

struct SweptProfile {
    std::vector<glm::vec3> path;     // at least two points, no two neighbours equal
    std::vector<glm::vec2> outline;  // anticlockwise about the path, seen against the direction of travel
    bool closed = false;             // the path's last point joins its first
    bool capped = true;              // open ends are filled; the outline is seen whole from the path then
    // Which way the outline's y axis points at the start, not along the path; from there it turns as little
    // as it can.
    glm::vec3 up{0, 1, 0};
    std::vector<float> scales;  // of the outline at each point of the path; empty: 1
    float crease_degrees = 35;  // sharper corners of the outline stay edges
};

// Broken preconditions are a CHECK.
TriangleMesh swept_mesh(const SweptProfile& sweep);

// A tube of circular section.
TriangleMesh tube_mesh(const std::vector<glm::vec3>& path, float radius, int sides);

// A prism about the x-y plane: `outline` is a simple polygon, anticlockwise, any shape; z from -half_depth to
// half_depth.
TriangleMesh extruded_mesh(const std::vector<glm::vec2>& outline, float half_depth,
                           float crease_degrees = 35);

// Adds a copy of `piece`; `model` is a rotation, a translation and a scale per axis (not mirrored).
void append_mesh(TriangleMesh& mesh, const TriangleMesh& piece, const glm::mat4& model = glm::mat4(1.0f));

}  // namespace ropsim
