// How the surface that receives a shadow runs on in the light's view: what a wide kernel must ask its texels
// about if the surface is not to shade itself.
#pragma once

#include "rop/shadow/light_space.h"
#include "traces/trace.h"

#include <cstddef>

#include <glm/glm.hpp>

namespace ropsim {

// The tangent plane of a receiver in the light's view, window depth a texel.
struct ReceiverPlane {
    double dx = 0;
    double dy = 0;

    // Depth of the plane through `at` at the centre of texel (x, y).
    double depth(const ViewPoint& at, int x, int y) const {
        return at.z + dx * (x + 0.5 - at.x) + dy * (y + 0.5 - at.y);
    }
};

// Tangent planes of what the camera sees, by a fragment's normal or by the opaque layer's depths. Where
// neither says anything the plane faces the light. A plane steeper than acos(kLeastCosine) to the light is
// taken as that steep: edge on it has no depth.
class ReceiverPlanes {
 public:
    static constexpr double kLeastCosine = 0.125;

    // Both views must have a camera (CHECK), and `camera` must outlive this.
    ReceiverPlanes(const TraceHeader& camera, const TraceHeader& light);

    // Of a fragment; `at` is where it lies in the light's view.
    ReceiverPlane of_material(const Material& material, const ViewPoint& at) const;
    // Of a sample of the camera's opaque layer (an index of its depths) at `point`, and `at` in the light's:
    // along each axis through the neighbour that is nearer in depth, so that silhouettes do not bend the
    // plane.
    ReceiverPlane of_opaque(std::size_t sample, const ViewPoint& point, const ViewPoint& at) const;

 private:
    // `normal`: in the world, of any length.
    ReceiverPlane of_normal(const glm::dvec3& normal, const ViewPoint& at) const;

    const TraceHeader& camera_;
    glm::dmat4 camera_pixels_to_world_, light_pixels_to_world_;
    glm::dmat3 to_world_;  // of the camera's directions
};

}  // namespace ropsim
