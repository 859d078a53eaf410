// Distance fields of blobs and their polygons by surface nets: one vertex in every cell that the surface
// crosses, one quad for every edge (Gibson 1998).
#include "capture/geometry/implicit_mesh.h"

#include "base/parallel.h"

#include <algorithm>
#include <cmath>

namespace ropsim {
namespace {

float round_cone_distance(const Blob& blob, glm::vec3 position) {
    const glm::vec3 p = (position - blob.a) / blob.stretch;
    const glm::vec3 axis = (blob.b - blob.a) / blob.stretch;
    const float squared = glm::dot(axis, axis);
    const float along = squared > 0 ? glm::clamp(glm::dot(p, axis) / squared, 0.0f, 1.0f) : 0.0f;
    const glm::vec3 away = p - along * axis;
    const float radius = glm::mix(blob.radius_a, blob.radius_b, along);
    const float length = glm::length(away);
    if (blob.stretch == glm::vec3(1.0f)) return length - radius;
    // First-order distance to the stretched surface: the value over the length of its gradient.
    const float slope = glm::length(away / blob.stretch) / std::max(length, 1e-6f);
    return (length - radius) / std::max(slope, 1e-6f);
}

float smooth_minimum(float a, float b, float blend) {
    const float h = std::max(blend - std::fabs(a - b), 0.0f) / blend;
    return std::min(a, b) - 0.25f * h * h * blend;
}

// Samples of a field on a lattice, and the surface cells between them.
class SurfaceNet {
 public:
    SurfaceNet(const BlobBody& body, glm::vec3 low, glm::vec3 high, float cell)
        : body_(body), low_(low), cell_(cell), size_(glm::ivec3(glm::ceil((high - low) / cell)) + 1) {
        values_.resize(static_cast<std::size_t>(size_.x) * static_cast<std::size_t>(size_.y) *
                       static_cast<std::size_t>(size_.z));
        constexpr int kBlock = 6;
        const glm::ivec3 blocks = (size_ + kBlock - 1) / kBlock;
        parallel_for(default_threads(), blocks.z, [&](int z) {
            for (int y = 0; y < blocks.y; ++y)
                for (int x = 0; x < blocks.x; ++x) fill(kBlock * glm::ivec3(x, y, z), kBlock);
        });
        vertex_of_.assign(values_.size(), kNone);
    }

    TriangleMesh mesh() {
        for (int z = 0; z + 1 < size_.z; ++z)
            for (int y = 0; y + 1 < size_.y; ++y)
                for (int x = 0; x + 1 < size_.x; ++x) add_vertex({x, y, z});
        for (int z = 1; z + 1 < size_.z; ++z)
            for (int y = 1; y + 1 < size_.y; ++y)
                for (int x = 1; x + 1 < size_.x; ++x)
                    for (int axis = 0; axis < 3; ++axis) add_quad({x, y, z}, axis);
        return std::move(mesh_);
    }

 private:
    static constexpr std::uint32_t kNone = ~0u;

    std::size_t at(glm::ivec3 i) const {
        return (static_cast<std::size_t>(i.z) * static_cast<std::size_t>(size_.y) +
                static_cast<std::size_t>(i.y)) *
                   static_cast<std::size_t>(size_.x) +
               static_cast<std::size_t>(i.x);
    }
    glm::vec3 position(glm::vec3 i) const { return low_ + cell_ * i; }

    // Far from the surface one value stands for the whole block: only its sign matters.
    void fill(glm::ivec3 first, int side) {
        const float middle = body_.distance(position(glm::vec3(first) + 0.5f * static_cast<float>(side - 1)));
        const bool far = std::fabs(middle) > 2.0f * static_cast<float>(side) * cell_;
        const glm::ivec3 last = glm::min(first + side, size_);
        for (int z = first.z; z < last.z; ++z)
            for (int y = first.y; y < last.y; ++y)
                for (int x = first.x; x < last.x; ++x)
                    values_[at({x, y, z})] = far ? middle : body_.distance(position(glm::vec3(x, y, z)));
    }

    // Cells that the surface may cross: the field changes by about the distance gone.
    bool near(glm::ivec3 i) const { return std::fabs(values_[at(i)]) < 4 * cell_; }

    void add_vertex(glm::ivec3 cell) {
        if (!near(cell)) return;
        glm::vec3 sum(0);
        int crossings = 0;
        for (int edge = 0; edge < 12; ++edge) {
            const int axis = edge / 4;
            glm::ivec3 from = cell;
            from[(axis + 1) % 3] += edge & 1;
            from[(axis + 2) % 3] += (edge >> 1) & 1;
            glm::ivec3 to = from;
            ++to[axis];
            const float a = values_[at(from)];
            const float b = values_[at(to)];
            if ((a < 0) == (b < 0)) continue;
            sum += glm::mix(glm::vec3(from), glm::vec3(to), a / (a - b));
            ++crossings;
        }
        if (crossings == 0) return;
        const glm::vec3 p = position(sum / static_cast<float>(crossings));
        vertex_of_[at(cell)] = static_cast<std::uint32_t>(mesh_.positions.size());
        mesh_.positions.push_back(p);
        mesh_.normals.push_back(body_.normal(p));
    }

    void add_quad(glm::ivec3 from, int axis) {
        if (!near(from)) return;
        glm::ivec3 to = from;
        ++to[axis];
        const bool inside = values_[at(from)] < 0;
        if (inside == (values_[at(to)] < 0)) return;
        std::uint32_t corner[4];
        for (int i = 0; i < 4; ++i) {
            // Around the edge: (-1,-1), (0,-1), (0,0), (-1,0).
            glm::ivec3 cell = from;
            cell[(axis + 1) % 3] -= i == 0 || i == 3;
            cell[(axis + 2) % 3] -= i < 2;
            corner[i] = vertex_of_[at(cell)];
        }
        if (!inside) std::swap(corner[1], corner[3]);
        mesh_.indices.insert(mesh_.indices.end(),
                             {corner[0], corner[1], corner[2], corner[0], corner[2], corner[3]});
    }

    const BlobBody& body_;
    glm::vec3 low_;
    float cell_;
    glm::ivec3 size_;
    std::vector<float> values_;
    std::vector<std::uint32_t> vertex_of_;
    TriangleMesh mesh_;
};

}  // namespace

Blob ellipsoid(glm::vec3 centre, glm::vec3 radii, float blend) {
    return {.a = centre, .b = centre, .blend = blend, .stretch = radii};
}

Blob limb(glm::vec3 a, glm::vec3 b, float radius_a, float radius_b, float blend) {
    return {.a = a, .b = b, .radius_a = radius_a, .radius_b = radius_b, .blend = blend};
}

BlobBody::BlobBody(std::vector<Blob> blobs) : blobs_(std::move(blobs)) {
    for (const Blob& blob : blobs_) {
        const float widest = std::max({blob.stretch.x, blob.stretch.y, blob.stretch.z});
        bounds_.push_back({0.5f * (blob.a + blob.b), 0.5f * glm::distance(blob.a, blob.b) +
                                                         widest * std::max(blob.radius_a, blob.radius_b)});
    }
}

float BlobBody::distance(glm::vec3 position) const {
    float nearest = 1e6f;
    for (std::size_t i = 0; i < blobs_.size(); ++i) {
        const Blob& blob = blobs_[i];
        // A blob farther away than what it could change is not looked at.
        const float reach = (blob.carved ? -nearest : nearest) + blob.blend + bounds_[i].radius;
        const glm::vec3 away = position - bounds_[i].centre;
        if (reach <= 0 || glm::dot(away, away) > reach * reach) continue;
        const float d = round_cone_distance(blob, position);
        nearest =
            blob.carved ? -smooth_minimum(-nearest, d, blob.blend) : smooth_minimum(nearest, d, blob.blend);
    }
    return nearest;
}

glm::vec3 BlobBody::normal(glm::vec3 position) const {
    constexpr float kStep = 2e-3f;
    // Four corners of a tetrahedron instead of six along the axes.
    glm::vec3 sum(0);
    for (const glm::vec3& corner :
         {glm::vec3(1, -1, -1), glm::vec3(-1, -1, 1), glm::vec3(-1, 1, -1), glm::vec3(1, 1, 1)})
        sum += corner * distance(position + kStep * corner);
    const float length = glm::length(sum);
    return length > 0 ? sum / length : glm::vec3(0, 1, 0);
}

TriangleMesh BlobBody::mesh(glm::vec3 low, glm::vec3 high, float cell) const {
    return SurfaceNet(*this, low, high, cell).mesh();
}

}  // namespace ropsim
