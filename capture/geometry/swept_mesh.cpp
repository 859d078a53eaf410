// Outlines carried along paths by frames that turn as little as possible; polygons cut into triangles.
#include "capture/geometry/swept_mesh.h"

#include "base/error.h"
#include "capture/geometry/profile.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/matrix_inverse.hpp>

namespace ropsim {
namespace {

struct Frame {
    glm::vec3 origin;
    glm::vec3 side;  // the outline's x axis
    glm::vec3 up;    // the outline's y axis
    float scale = 1;
    float slope = 0;  // of the scale along the path

    glm::vec3 at(glm::vec2 p) const { return origin + scale * (p.x * side + p.y * up); }
    glm::vec3 normal_at(glm::vec2 p, glm::vec2 outward) const {
        const glm::vec3 along = glm::cross(side, up);
        return glm::normalize(outward.x * side + outward.y * up - along * (slope * glm::dot(p, outward)));
    }
};

std::vector<Frame> carry_frames(const SweptProfile& sweep) {
    const std::size_t count = sweep.path.size();
    CHECK(count >= 2 && sweep.outline.size() >= 3, "{} points of a path, {} of an outline", count,
          sweep.outline.size());
    CHECK(sweep.scales.empty() || sweep.scales.size() == count, "{} scales, {} points", sweep.scales.size(),
          count);
    std::vector<Frame> frames(count);
    glm::vec3 up = sweep.up;
    for (std::size_t i = 0; i < count; ++i) {
        const bool first = i == 0 && !sweep.closed;
        const bool last = i + 1 == count && !sweep.closed;
        const std::size_t before = first ? i : (i + count - 1) % count;
        const std::size_t after = last ? i : (i + 1) % count;
        const glm::vec3 step = sweep.path[after] - sweep.path[before];
        const glm::vec3 along = glm::normalize(step);
        up -= along * glm::dot(along, up);
        CHECK(glm::length(up) > 1e-6f, "the path runs along its up direction at point {}", i);
        up = glm::normalize(up);
        frames[i] = {sweep.path[i], glm::cross(up, along), up};
        if (sweep.scales.empty()) continue;
        frames[i].scale = sweep.scales[i];
        frames[i].slope = (sweep.scales[after] - sweep.scales[before]) / glm::length(step);
    }
    return frames;
}

// A fan about the path's end; `sign` is +1 where the path leaves through it.
void add_cap(TriangleMesh& mesh, const Frame& frame, const std::vector<glm::vec2>& outline, float sign) {
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    const glm::vec3 normal = sign * glm::cross(frame.side, frame.up);
    mesh.positions.push_back(frame.origin);
    for (const glm::vec2& point : outline) mesh.positions.push_back(frame.at(point));
    mesh.normals.resize(mesh.positions.size(), normal);
    const auto count = static_cast<std::uint32_t>(outline.size());
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t here = base + 1 + i;
        const std::uint32_t next = base + 1 + (i + 1) % count;
        mesh.indices.insert(mesh.indices.end(), {base, sign > 0 ? here : next, sign > 0 ? next : here});
    }
}

float cross(glm::vec2 a, glm::vec2 b) {
    return a.x * b.y - a.y * b.x;
}

bool inside(glm::vec2 p, glm::vec2 a, glm::vec2 b, glm::vec2 c) {
    return cross(b - a, p - a) >= 0 && cross(c - b, p - b) >= 0 && cross(a - c, p - c) >= 0;
}

// Ear clipping; the triangles' corners as indices into `outline`, anticlockwise.
std::vector<std::uint32_t> cut_polygon(const std::vector<glm::vec2>& outline) {
    std::vector<std::uint32_t> left;
    for (std::uint32_t i = 0; i < outline.size(); ++i) left.push_back(i);
    std::vector<std::uint32_t> triangles;
    const auto is_ear = [&](std::size_t at) {
        const std::uint32_t a = left[(at + left.size() - 1) % left.size()];
        const std::uint32_t b = left[at];
        const std::uint32_t c = left[(at + 1) % left.size()];
        if (cross(outline[b] - outline[a], outline[c] - outline[b]) <= 0) return false;
        return std::none_of(left.begin(), left.end(), [&](std::uint32_t p) {
            return p != a && p != b && p != c && inside(outline[p], outline[a], outline[b], outline[c]);
        });
    };
    std::size_t at = 0;
    std::size_t misses = 0;
    while (left.size() > 2) {
        at %= left.size();
        if (is_ear(at)) {
            triangles.insert(triangles.end(), {left[(at + left.size() - 1) % left.size()], left[at],
                                               left[(at + 1) % left.size()]});
            left.erase(left.begin() + static_cast<std::ptrdiff_t>(at));
            misses = 0;
        } else {
            CHECK(++misses <= left.size(), "an outline of {} points is not a simple anticlockwise polygon",
                  outline.size());
        }
        ++at;
    }
    return triangles;
}

}  // namespace

TriangleMesh swept_mesh(const SweptProfile& sweep) {
    const std::vector<Frame> frames = carry_frames(sweep);
    const std::size_t steps = sweep.closed ? frames.size() : frames.size() - 1;
    TriangleMesh mesh;
    for (const ProfileEdge& edge : profile_edges(sweep.outline, true, sweep.crease_degrees)) {
        const auto base = static_cast<std::uint32_t>(mesh.positions.size());
        for (const Frame& frame : frames) {
            for (int end = 0; end < 2; ++end) {
                mesh.positions.push_back(frame.at(edge.point[end]));
                mesh.normals.push_back(frame.normal_at(edge.point[end], edge.normal[end]));
            }
        }
        for (std::size_t i = 0; i < steps; ++i) {
            const std::uint32_t here = base + 2 * static_cast<std::uint32_t>(i);
            const std::uint32_t next = base + 2 * static_cast<std::uint32_t>((i + 1) % frames.size());
            mesh.indices.insert(mesh.indices.end(), {here, here + 1, next, here + 1, next + 1, next});
        }
    }
    if (!sweep.closed && sweep.capped) {
        add_cap(mesh, frames.front(), sweep.outline, -1);
        add_cap(mesh, frames.back(), sweep.outline, 1);
    }
    return mesh;
}

TriangleMesh tube_mesh(const std::vector<glm::vec3>& path, float radius, int sides) {
    CHECK(path.size() >= 2, "a tube along {} points", path.size());
    SweptProfile sweep;
    sweep.path = path;
    sweep.outline = circle_outline(radius, sides);
    const glm::vec3 along = glm::abs(glm::normalize(path[1] - path[0]));
    sweep.up = along.y < 0.8f ? glm::vec3(0, 1, 0) : glm::vec3(0, 0, 1);
    sweep.crease_degrees = 100;
    return swept_mesh(sweep);
}

TriangleMesh extruded_mesh(const std::vector<glm::vec2>& outline, float half_depth, float crease_degrees) {
    SweptProfile sweep;
    sweep.path = {{0, 0, -half_depth}, {0, 0, half_depth}};
    sweep.outline = outline;
    sweep.capped = false;
    sweep.crease_degrees = crease_degrees;
    TriangleMesh mesh = swept_mesh(sweep);
    const std::vector<std::uint32_t> triangles = cut_polygon(outline);
    for (float side : {-1.0f, 1.0f}) {
        const auto base = static_cast<std::uint32_t>(mesh.positions.size());
        for (const glm::vec2& point : outline) mesh.positions.emplace_back(point, side * half_depth);
        mesh.normals.resize(mesh.positions.size(), glm::vec3(0, 0, side));
        for (std::size_t i = 0; i < triangles.size(); i += 3) {
            mesh.indices.push_back(base + triangles[i]);
            mesh.indices.push_back(base + triangles[side > 0 ? i + 1 : i + 2]);
            mesh.indices.push_back(base + triangles[side > 0 ? i + 2 : i + 1]);
        }
    }
    return mesh;
}

void append_mesh(TriangleMesh& mesh, const TriangleMesh& piece, const glm::mat4& model) {
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    const glm::mat3 for_normals = glm::inverseTranspose(glm::mat3(model));
    for (const glm::vec3& position : piece.positions)
        mesh.positions.emplace_back(model * glm::vec4(position, 1.0f));
    for (const glm::vec3& normal : piece.normals)
        mesh.normals.push_back(glm::normalize(for_normals * normal));
    for (std::uint32_t index : piece.indices) mesh.indices.push_back(base + index);
}

}  // namespace ropsim
