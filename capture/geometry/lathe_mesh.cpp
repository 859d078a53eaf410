// Surfaces of revolution, with sharp edges where the profile bends.
#include "capture/geometry/lathe_mesh.h"

#include "base/error.h"
#include "capture/geometry/profile.h"

#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {

TriangleMesh lathe_mesh(const std::vector<glm::vec2>& profile, int sectors, float crease_degrees) {
    CHECK(sectors >= 3, "{} sectors", sectors);
    const auto row = static_cast<std::uint32_t>(sectors + 1);
    TriangleMesh mesh;
    for (const ProfileEdge& edge : profile_edges(profile, false, crease_degrees)) {
        const auto base = static_cast<std::uint32_t>(mesh.positions.size());
        for (int end = 0; end < 2; ++end) {
            const glm::vec2 point = edge.point[end];
            const glm::vec2 normal = edge.normal[end];
            CHECK(point.x >= 0, "a profile's point is {} from the axis", point.x);
            for (int sector = 0; sector <= sectors; ++sector) {
                // The seam's two columns are the same angle, so that they agree to the last bit.
                const float turn = static_cast<float>(sector % sectors) / static_cast<float>(sectors);
                const float cosine = std::cos(glm::two_pi<float>() * turn);
                const float sine = std::sin(glm::two_pi<float>() * turn);
                mesh.positions.emplace_back(point.x * cosine, point.y, point.x * sine);
                mesh.normals.emplace_back(normal.x * cosine, normal.y, normal.x * sine);
            }
        }
        for (std::uint32_t a = base; a + 1 < base + row; ++a) {
            // On the axis a side of the quad is a point.
            if (edge.point[0].x > 0) mesh.indices.insert(mesh.indices.end(), {a, a + row, a + 1});
            if (edge.point[1].x > 0) mesh.indices.insert(mesh.indices.end(), {a + 1, a + row, a + row + 1});
        }
    }
    return mesh;
}

}  // namespace ropsim
