// Round pipes along bent paths: pipework, posts, branches.
#pragma once

#include "capture/geometry/mesh.h"

#include <span>

namespace ropsim {

struct PipeShape {
    int sides = 12;        // facets around, at least 3
    bool capped = false;   // closed by flat discs at both ends
    bool faceted = false;  // flat facets instead of smooth normals around
};

// A tube through `path` (at least 2 points, no two neighbours alike) with a radius a point. The frame is
// carried along without twisting; at a bend the ring stands in the plane halfway, so that the tube keeps its
// width. 2 * sides triangles a segment, 2 * (sides - 2) more when capped.
TriangleMesh pipe_mesh(std::span<const glm::vec3> path, std::span<const float> radii,
                       const PipeShape& shape = {});

}  // namespace ropsim
