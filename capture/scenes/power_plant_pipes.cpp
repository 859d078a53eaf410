// Pipes and beams of the power plant, and the runs of its pipework.
#include "base/parallel.h"
#include "base/random.h"
#include "capture/geometry/pipe_mesh.h"
#include "capture/scenes/power_plant_parts.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

constexpr std::uint32_t kRackPipes = 9;  // of every kCycle pipes, so many run on the rack
constexpr std::uint32_t kCycle = 60;

// Colours of systems: steam, feed water, fuel, air, cooling water, fire water, oil.
constexpr std::array<glm::vec3, 7> kSystems = {{{0.62f, 0.12f, 0.06f},
                                                {0.1f, 0.42f, 0.16f},
                                                {0.65f, 0.42f, 0.05f},
                                                {0.12f, 0.36f, 0.6f},
                                                {0.05f, 0.2f, 0.5f},
                                                {0.55f, 0.04f, 0.05f},
                                                {0.36f, 0.26f, 0.16f}}};

float whole(float at, float step) {
    return step * std::round(at / step);
}

// A run inside the house: it starts somewhere and turns by right angles.
std::vector<glm::vec3> house_run(std::uint64_t key, float radius) {
    const auto unit = [&](std::uint32_t draw) { return random_unit(key, draw); };
    const glm::vec3 room = kHouseHalf - glm::vec3(0.6f, 0, 0.6f);
    glm::vec3 at((2 * unit(0) - 1) * room.x, 1.0f + (kHouseHeight - 2.5f) * unit(1),
                 (2 * unit(2) - 1) * room.z);
    // Pipes share racks: below the floors, in planes between the columns.
    at.y = whole(at.y, 0.5f * kFloorHeight) - 0.7f + 0.5f * unit(3);
    std::vector<glm::vec3> corners = {at};
    const int turns = 1 + static_cast<int>(3 * unit(4));
    int axis = static_cast<int>(3 * unit(5));
    for (int i = 0; i < turns; ++i) {
        const auto draw = static_cast<std::uint32_t>(8 + 4 * i);
        const float low = axis == 1 ? 0.6f : -room[axis];
        const float high = axis == 1 ? kHouseHeight - 1 : room[axis];
        const float share = 0.2f + 0.6f * unit(draw);
        const float goal = unit(draw + 1) < (at[axis] - low) / (high - low) ? glm::mix(at[axis], low, share)
                                                                            : glm::mix(at[axis], high, share);
        if (std::abs(goal - at[axis]) > 6 * radius + 0.4f) {
            at[axis] = goal;
            corners.push_back(at);
        }
        axis = (axis + (unit(draw + 2) < 0.5f ? 1 : 2)) % 3;
    }
    if (corners.size() < 2) corners.push_back(at + glm::vec3(0, at.y > 14 ? -6.0f : 6.0f, 0));
    return corners;
}

// A run on the rack in front of the house, from inside it to a tank.
std::vector<glm::vec3> rack_run(std::uint64_t key) {
    const auto unit = [&](std::uint32_t draw) { return random_unit(key, draw); };
    const float level = 4.6f + 1.5f * std::floor(3 * unit(0));
    const float lane = 12.5f + 3.4f * unit(1);
    const float from = -12 + 24 * unit(2);
    const float to = 17 + 20 * unit(3);
    return {{from, level + 4, 8.0f}, {from, level + 4, 11.0f}, {from, level, 11.0f},
            {from, level, lane},     {to, level, lane},        {to, level, lane + 2.5f},
            {to, 1.0f, lane + 2.5f}, {to, 1.0f, lane + 4.5f}};
}

// Corners replaced by arcs, long straights divided.
std::vector<glm::vec3> rounded(const std::vector<glm::vec3>& corners, float bend, float length) {
    std::vector<glm::vec3> path = {corners.front()};
    const auto run_to = [&](glm::vec3 end) {
        const glm::vec3 start = path.back();
        const int pieces = std::max(1, static_cast<int>(std::ceil(glm::length(end - start) / length)));
        for (int i = 1; i <= pieces; ++i)
            path.push_back(glm::mix(start, end, static_cast<float>(i) / static_cast<float>(pieces)));
    };
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
        const glm::vec3 in = corners[i] - corners[i - 1];
        const glm::vec3 out = corners[i + 1] - corners[i];
        const float turn = std::min({bend, 0.45f * glm::length(in), 0.45f * glm::length(out)});
        const glm::vec3 from = corners[i] - turn * glm::normalize(in);
        const glm::vec3 to = corners[i] + turn * glm::normalize(out);
        run_to(from);
        const glm::vec3 centre = from + to - corners[i];
        for (int k = 1; k <= 3; ++k) {
            const float angle = glm::half_pi<float>() * static_cast<float>(k) / 3;
            path.push_back(centre + std::cos(angle) * (from - centre) + std::sin(angle) * (to - centre));
        }
    }
    run_to(corners.back());
    return path;
}

SceneryMesh make_run(std::uint32_t index, std::uint64_t seed) {
    const std::uint64_t key = mix64(seed ^ (0x50697065ull << 32) ^ index);
    const bool on_rack = index % kCycle < kRackPipes;
    const auto unit = [&](std::uint32_t draw) { return random_unit(key, draw); };
    const float radius = on_rack ? 0.2f + 0.2f * unit(60) : 0.13f + 0.43f * std::pow(unit(60), 1.3f);
    const auto system = static_cast<std::size_t>(unit(61) * static_cast<float>(kSystems.size()));
    const glm::vec4 color(kSystems[system] * (0.85f + 0.3f * unit(62)), 0.3f + 0.15f * unit(63));
    SceneryMesh mesh;
    const std::vector<glm::vec3> corners = on_rack ? rack_run(key) : house_run(key, radius);
    const int sides = radius < 0.42f ? 6 : 8;
    add_pipe(mesh, corners, radius, sides, 5.0f, color);
    // Flanges here and there.
    for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
        const glm::vec3 along = corners[i + 1] - corners[i];
        if (glm::length(along) < 3 || unit(70 + static_cast<std::uint32_t>(i)) < 0.4f) continue;
        const glm::vec3 middle = corners[i] + 0.5f * along;
        const glm::vec3 half = 0.12f * glm::normalize(along);
        add_pipe(mesh, {middle - half, middle + half}, 1.55f * radius, 10, 1, color);
    }
    return mesh;
}

}  // namespace

void add_pipe(SceneryMesh& mesh, const std::vector<glm::vec3>& corners, float radius, int sides, float length,
              glm::vec4 color) {
    const std::vector<glm::vec3> path = rounded(corners, 2.2f * radius, length);
    const std::vector<float> radii(path.size(), radius);
    mesh.add(pipe_mesh(path, radii, {.sides = sides}), glm::mat4(1.0f), color);
}

void add_beam(SceneryMesh& mesh, glm::vec3 from, glm::vec3 to, float half, glm::vec4 color) {
    const std::array<glm::vec3, 2> path = {from, to};
    const std::array<float, 2> radii = {std::sqrt(2.0f) * half, std::sqrt(2.0f) * half};
    mesh.add(pipe_mesh(path, radii, {.sides = 4, .faceted = true}), glm::mat4(1.0f), color);
}

PlantParts make_pipework(std::uint32_t count, std::uint64_t seed) {
    PlantParts parts(count);
    constexpr std::uint32_t kBatch = 32;
    const auto batches = static_cast<int>((count + kBatch - 1) / kBatch);
    parallel_for(default_threads(), batches, [&](int batch) {
        const std::uint32_t first = static_cast<std::uint32_t>(batch) * kBatch;
        for (std::uint32_t i = first; i < std::min(first + kBatch, count); ++i) parts[i] = make_run(i, seed);
    });
    return parts;
}

}  // namespace ropsim
