// Plane curves from which meshes are turned, swept and extruded.
#pragma once

#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// One side of a polygon, with the normals at its two ends, to the right of the direction of travel.
struct ProfileEdge {
    glm::vec2 point[2];
    glm::vec2 normal[2];
};

// The sides of a polyline or, if `closed`, of a polygon (its last point joins its first). A bend of more than
// `crease_degrees` stays a sharp edge; at others the neighbours share a normal. At least two points, no two
// neighbours equal (CHECK).
std::vector<ProfileEdge> profile_edges(const std::vector<glm::vec2>& points, bool closed,
                                       float crease_degrees);

// A smooth curve through `points` (centripetal Catmull-Rom; at least two, no two neighbours equal) with
// `steps` >= 1 segments between neighbours. x is a distance from an axis: where the curve would go below 0
// it stays at 0.
std::vector<glm::vec2> smooth_profile(const std::vector<glm::vec2>& points, int steps);

// A regular polygon about the origin, anticlockwise, the first corner at (radius, 0).
std::vector<glm::vec2> circle_outline(float radius, int sides);

}  // namespace ropsim
