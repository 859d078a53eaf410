// Polylines with smooth and sharp corners, and curves through points.
#include "capture/geometry/profile.h"

#include "base/error.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {

std::vector<ProfileEdge> profile_edges(const std::vector<glm::vec2>& points, bool closed,
                                       float crease_degrees) {
    CHECK(points.size() >= 2, "a profile of {} points", points.size());
    const std::size_t count = closed ? points.size() : points.size() - 1;
    std::vector<glm::vec2> flat(count);
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec2 along = points[(i + 1) % points.size()] - points[i];
        const float length = glm::length(along);
        CHECK(length > 0, "points {} and its successor are both ({}, {})", i, points[i].x, points[i].y);
        flat[i] = glm::vec2(along.y, -along.x) / length;
    }
    const float least_cosine = std::cos(glm::radians(crease_degrees));
    const auto blended = [&](std::size_t i, std::size_t neighbour, bool exists) {
        if (!exists || glm::dot(flat[i], flat[neighbour]) < least_cosine) return flat[i];
        return glm::normalize(flat[i] + flat[neighbour]);
    };
    std::vector<ProfileEdge> edges(count);
    for (std::size_t i = 0; i < count; ++i) {
        edges[i].point[0] = points[i];
        edges[i].point[1] = points[(i + 1) % points.size()];
        edges[i].normal[0] = blended(i, (i + count - 1) % count, closed || i > 0);
        edges[i].normal[1] = blended(i, (i + 1) % count, closed || i + 1 < count);
    }
    return edges;
}

std::vector<glm::vec2> smooth_profile(const std::vector<glm::vec2>& points, int steps) {
    CHECK(points.size() >= 2 && steps >= 1, "{} points, {} steps", points.size(), steps);
    // Beyond the ends the curve goes straight on.
    std::vector<glm::vec2> p{2.0f * points[0] - points[1]};
    p.insert(p.end(), points.begin(), points.end());
    p.push_back(2.0f * points[points.size() - 1] - points[points.size() - 2]);
    std::vector<glm::vec2> curve{points.front()};
    for (std::size_t i = 0; i + 3 < p.size(); ++i) {
        float knot[4] = {0};
        for (std::size_t k = 1; k < 4; ++k)
            knot[k] = knot[k - 1] + std::max(std::sqrt(glm::distance(p[i + k], p[i + k - 1])), 1e-6f);
        for (int step = 1; step < steps; ++step) {
            const float t =
                knot[1] + (knot[2] - knot[1]) * static_cast<float>(step) / static_cast<float>(steps);
            // Barry and Goldman's pyramid.
            glm::vec2 level[4] = {p[i], p[i + 1], p[i + 2], p[i + 3]};
            for (int degree = 1; degree <= 3; ++degree)
                for (int k = 0; k + degree < 4; ++k) {
                    const int low = degree == 3 ? 1 : k;
                    const int high = degree == 3 ? 2 : k + degree;
                    level[k] = glm::mix(level[k], level[k + 1], (t - knot[low]) / (knot[high] - knot[low]));
                }
            curve.emplace_back(std::max(level[0].x, 0.0f), level[0].y);
        }
        curve.push_back(p[i + 2]);
    }
    return curve;
}

std::vector<glm::vec2> circle_outline(float radius, int sides) {
    std::vector<glm::vec2> outline;
    for (int i = 0; i < sides; ++i) {
        const float angle = glm::two_pi<float>() * static_cast<float>(i) / static_cast<float>(sides);
        outline.push_back(radius * glm::vec2(std::cos(angle), std::sin(angle)));
    }
    return outline;
}

}  // namespace ropsim
