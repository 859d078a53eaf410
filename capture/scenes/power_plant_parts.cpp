// The power plant's frame, floors, boiler, vessels, ducts and hall.
#include "capture/scenes/power_plant_parts.h"

#include "base/random.h"
#include "capture/geometry/lathe_mesh.h"
#include "capture/scenery/scene_parts.h"

#include <algorithm>
#include <cmath>

namespace ropsim {
namespace {

constexpr glm::vec4 kSteel(0.26f, 0.33f, 0.42f, 0.42f);
constexpr glm::vec4 kGrating(0.5f, 0.47f, 0.36f, 0.2f);
constexpr glm::vec4 kRail(0.7f, 0.55f, 0.08f, 0.5f);
constexpr glm::vec4 kTube(0.55f, 0.24f, 0.13f, 0.3f);
constexpr glm::vec4 kSheet(0.5f, 0.3f, 0.2f, 0.12f);
constexpr glm::vec4 kDuct(0.42f, 0.45f, 0.48f, 0.26f);
constexpr glm::vec4 kHall(0.42f, 0.55f, 0.66f, 0.17f);
constexpr glm::vec4 kConcrete(0.62f, 0.6f, 0.56f, 0.4f);

// A surface of revolution standing at `foot`.
SceneryMesh turned(const std::vector<glm::vec2>& profile, int sectors, glm::vec3 foot, glm::vec4 color) {
    SceneryMesh mesh;
    mesh.add(lathe_mesh(profile, sectors), placed(foot, glm::vec3(1)), color);
    return mesh;
}

// Wall of a vessel cut into rings, then its dome.
std::vector<glm::vec2> domed(float radius, float height, int rings) {
    std::vector<glm::vec2> profile;
    for (int i = 0; i <= rings; ++i)
        profile.emplace_back(radius, height * static_cast<float>(i) / static_cast<float>(rings));
    for (int i = 1; i <= 5; ++i) {
        const float angle = 1.5708f * static_cast<float>(i) / 5;
        profile.emplace_back(radius * std::max(std::cos(angle), 0.0f),
                             height + 0.35f * radius * std::sin(angle));
    }
    return profile;
}

// The six sides of a box, each cut into pieces of about `piece` metres.
void add_shell(SceneryMesh& mesh, glm::vec3 low, glm::vec3 high, float piece, glm::vec4 color) {
    const glm::vec3 size = high - low;
    const auto cut = [&](float length) { return std::max(1, static_cast<int>(std::round(length / piece))); };
    const auto at = [&](float x, float y, float z) { return low + size * glm::vec3(x, y, z); };
    const auto side = [&](glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d) {
        mesh.add_quad(a, b, c, d, color, Finish::kPlain, cut(glm::length(b - a)), cut(glm::length(d - a)));
    };
    side(at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1));
    side(at(1, 0, 0), at(0, 0, 0), at(0, 1, 0), at(1, 1, 0));
    side(at(1, 0, 1), at(1, 0, 0), at(1, 1, 0), at(1, 1, 1));
    side(at(0, 0, 0), at(0, 0, 1), at(0, 1, 1), at(0, 1, 0));
    side(at(0, 1, 1), at(1, 1, 1), at(1, 1, 0), at(0, 1, 0));
    side(at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1));
}

}  // namespace

PlantParts make_frame() {
    PlantParts parts;
    const auto beam = [&](glm::vec3 from, glm::vec3 to, float half) {
        parts.emplace_back();
        add_beam(parts.back(), from, to, half, kSteel);
    };
    for (int i = -2; i <= 2; ++i) {
        for (int k = -1; k <= 2; ++k) {
            const float x = 7.5f * static_cast<float>(i);
            const float z = 7.0f * static_cast<float>(k) - 3.5f;
            const bool outside = k == -1 || k == 2;
            // The boiler hangs in the middle of the house: no columns there.
            if (!outside && std::abs(i) < 2) continue;
            beam({x, 0, z}, {x, kHouseHeight, z}, 0.26f);
            for (float y = kFloorHeight; y <= kHouseHeight + 0.1f; y += kFloorHeight) {
                if (i < 2) beam({x, y, z}, {x + 7.5f, y, z}, 0.2f);
                if (k < 2) beam({x, y, z}, {x, y, z + 7}, 0.2f);
                if (outside && i < 2 && (i % 2 == 0)) beam({x, y - kFloorHeight, z}, {x + 7.5f, y, z}, 0.12f);
            }
        }
    }
    return parts;
}

PlantParts make_cladding() {
    PlantParts parts;
    const float back = -kHouseHalf.z - 0.3f;
    for (int bay = -2; bay < 2; ++bay) {
        const float x = 7.5f * static_cast<float>(bay);
        parts.emplace_back();
        parts.back().add_quad({x, 0.3f, back}, {x + 7.5f, 0.3f, back}, {x + 7.5f, kHouseHeight, back},
                              {x, kHouseHeight, back}, kHall, Finish::kPlain, 2, 6);
    }
    return parts;
}

PlantParts make_floors(std::uint64_t seed) {
    PlantParts parts;
    for (int level = 1; level <= 5; ++level) {
        const float y = kFloorHeight * static_cast<float>(level) + 0.22f;
        for (int i = -2; i < 2; ++i) {
            for (int k = -1; k < 2; ++k) {
                const std::uint64_t key =
                    mix64(seed ^ static_cast<std::uint64_t>(level * 64 + i * 8 + k + 20));
                const bool in_boiler = (i == -1 || i == 0) && k == 0;
                if (in_boiler || random_unit(key, 0) < 0.3f) continue;
                const float x = 7.5f * static_cast<float>(i);
                const float z = 7.0f * static_cast<float>(k) - 3.5f;
                parts.emplace_back();
                parts.back().add_quad({x, y, z + 7}, {x + 7.5f, y, z + 7}, {x + 7.5f, y, z}, {x, y, z},
                                      kGrating, Finish::kPlain, 2, 2);
            }
        }
        parts.emplace_back();
        for (float z : {-kHouseHalf.z, kHouseHalf.z}) {
            for (float up : {1.1f})
                add_beam(parts.back(), {-kHouseHalf.x, y + up, z}, {kHouseHalf.x, y + up, z}, 0.045f, kRail);
            for (float x = -kHouseHalf.x; x <= kHouseHalf.x; x += 3.75f)
                add_beam(parts.back(), {x, y, z}, {x, y + 1.1f, z}, 0.045f, kRail);
        }
        // Stairs in front, back and forth.
        parts.emplace_back();
        const float from = level % 2 == 0 ? 9.0f : 13.5f;
        const float to = 22.5f - from;
        for (int step = 0; step < 16; ++step) {
            const float t = static_cast<float>(step) / 15;
            parts.back().add_box({glm::mix(from, to, t), y - kFloorHeight * (1 - t), 11.4f},
                                 {0.16f, 0.03f, 0.6f}, kRail);
        }
        for (float z : {10.8f, 12.0f})
            add_beam(parts.back(), {from, y - kFloorHeight, z}, {to, y, z}, 0.1f, kSteel);
    }
    return parts;
}

PlantParts make_boiler() {
    PlantParts parts;
    const glm::vec3 half(6.2f, 0, 3.0f);
    const auto tube = [&](glm::vec3 foot, float top, float radius) {
        parts.emplace_back();
        add_pipe(parts.back(), {foot, {foot.x, top, foot.z}}, radius, 6, 2.2f, kTube);
    };
    constexpr float kPitch = 1.4f;
    for (float x = -half.x; x <= half.x; x += kPitch) {
        for (float z : {-half.z, half.z}) tube({x, 3, z}, 24, 0.16f);
    }
    for (float z = -half.z + kPitch; z < half.z; z += kPitch) {
        for (float x : {-half.x, half.x}) tube({x, 3, z}, 24, 0.16f);
    }
    // Between the tubes the walls are sheet.
    for (float z : {-half.z, half.z}) {
        for (float x : {-half.x, 0.0f}) {
            parts.emplace_back();
            parts.back().add_quad({x, 3, z}, {x + half.x, 3, z}, {x + half.x, 24, z}, {x, 24, z}, kSheet,
                                  Finish::kPlain, 1, 4);
        }
    }
    // Superheaters hang in the gas: bank behind bank.
    for (int row = 0; row < 12; ++row) {
        for (int column = 0; column < 9; ++column) {
            const float x = -0.4f + 0.44f * static_cast<float>(column);
            const float z = -2.65f + 0.47f * static_cast<float>(row);
            tube({x, 13.5f, z}, 23, 0.135f);
        }
    }
    for (float z : {-half.z, half.z}) {
        for (float y : {2.8f, 24.0f}) {
            parts.emplace_back();
            add_pipe(parts.back(), {{-half.x - 0.5f, y, z}, {half.x + 0.5f, y, z}}, 0.42f, 10, 1.4f, kTube);
        }
    }
    parts.emplace_back();
    add_pipe(parts.back(), {{-7.4f, 25.6f, 0.8f}, {7.4f, 25.6f, 0.8f}}, 1.0f, 18, 1.2f,
             {0.66f, 0.3f, 0.12f, 0.4f});
    return parts;
}

PlantParts make_vessels() {
    PlantParts parts;
    const glm::vec4 white(0.72f, 0.74f, 0.73f, 0.34f);
    const glm::vec4 green(0.3f, 0.5f, 0.36f, 0.34f);
    for (int i = 0; i < 3; ++i) {
        const float x = 20.5f + 8.8f * static_cast<float>(i);
        parts.push_back(turned(domed(3.7f, 7.0f, 6), 26, {x, 0, 19.5f}, i == 1 ? green : white));
    }
    for (int i = 0; i < 4; ++i) {
        const float z = -7.5f + 5.0f * static_cast<float>(i);
        std::vector<glm::vec2> profile = {{0.4f, 8.0f}, {1.2f, 9.6f}};
        for (const glm::vec2& p : domed(2.1f, 9.0f, 7)) profile.emplace_back(p.x, p.y + 11.5f);
        parts.push_back(turned(profile, 20, {-18.5f, 0, z}, kConcrete));
    }
    // Turbine and generator lie along x in the hall.
    const std::vector<glm::vec2> turbine = {{0.5f, 0.0f},  {1.2f, 0.2f},  {1.3f, 1.4f},  {1.9f, 2.2f},
                                            {2.2f, 3.4f},  {1.9f, 4.6f},  {1.0f, 5.2f},  {1.0f, 6.0f},
                                            {2.4f, 7.0f},  {2.6f, 8.4f},  {2.4f, 9.8f},  {0.9f, 10.6f},
                                            {0.9f, 11.6f}, {1.9f, 11.8f}, {1.9f, 16.4f}, {0.6f, 16.8f}};
    SceneryMesh lying;
    const glm::mat4 down = placed({17.5f, 4.2f, -4.5f}, glm::vec3(1), 0, -1.5708f);
    lying.add(lathe_mesh(turbine, 24), down, {0.2f, 0.36f, 0.5f, 0.42f});
    parts.push_back(lying);
    SceneryMesh bed;
    add_shell(bed, {17, 0, -7}, {35, 1.9f, -2}, 1.8f, kConcrete);
    parts.push_back(bed);
    return parts;
}

PlantParts make_ducts() {
    PlantParts parts;
    const auto shell = [&](glm::vec3 low, glm::vec3 high, float piece, glm::vec4 color) {
        parts.emplace_back();
        add_shell(parts.back(), low, high, piece, color);
    };
    shell({-14, 17, -17}, {-6, 23, -10.5f}, 3.0f, kDuct);
    for (int i = 0; i < 2; ++i) {
        const float x = -34 + 11 * static_cast<float>(i);
        shell({x, 8, -18}, {x + 9, 18, -8}, 3.2f, kDuct);
        for (int hopper = 0; hopper < 4; ++hopper) {
            const float middle_x = x + 2.4f + 4.3f * static_cast<float>(hopper % 2);
            const float middle_z = -15.5f + 5.0f * std::floor(0.5f * static_cast<float>(hopper));
            parts.push_back(turned({{0.5f, 4.2f}, {2.9f, 8.0f}}, 4, {middle_x, 0, middle_z}, kDuct));
        }
        for (int post = 0; post < 4; ++post) {
            parts.emplace_back();
            const float px = x + 9 * static_cast<float>(post % 2);
            const float pz = -18 + 10 * std::floor(0.5f * static_cast<float>(post));
            add_beam(parts.back(), {px, 0, pz}, {px, 8, pz}, 0.3f, kSteel);
        }
    }
    parts.emplace_back();
    add_pipe(parts.back(), {{-23, 15.5f, -13}, {-14, 20, -13}}, 2.0f, 16, 2.4f, kDuct);
    parts.emplace_back();
    add_pipe(parts.back(), {{-34, 13, -13}, {-37.5f, 13, -13}, {-37.5f, 13, -6}, {-37.5f, 9, -2}}, 1.8f, 16,
             2.4f, kDuct);
    std::vector<glm::vec2> stack;
    for (int i = 0; i <= 15; ++i)
        stack.emplace_back(3.1f - 0.08f * static_cast<float>(i), 2.9f * static_cast<float>(i));
    parts.push_back(turned(stack, 26, {-37.5f, 0, 1.0f}, kConcrete));
    for (float y : {14.0f, 28.0f, 41.0f}) {
        const float radius = 3.4f - 0.0276f * y;
        parts.push_back(
            turned({{radius, y}, {radius, y + 1.1f}}, 26, {-37.5f, 0, 1.0f}, {0.65f, 0.1f, 0.07f, 0.45f}));
    }
    return parts;
}

PlantParts make_hall() {
    PlantParts parts;
    const float left = 15.5f;
    const float right = 37.5f;
    const float front = 4.5f;
    const float back = -13.5f;
    const float eaves = 13.0f;
    const float ridge = 16.0f;
    const float middle = 0.5f * (front + back);
    const auto panel = [&](glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d, int columns, int rows) {
        parts.emplace_back();
        parts.back().add_quad(a, b, c, d, kHall, Finish::kPlain, columns, rows);
    };
    for (int bay = 0; bay < 4; ++bay) {
        const float from = glm::mix(left, right, static_cast<float>(bay) / 4);
        const float to = glm::mix(left, right, static_cast<float>(bay + 1) / 4);
        panel({from, 0, front}, {to, 0, front}, {to, eaves, front}, {from, eaves, front}, 2, 3);
        panel({to, 0, back}, {from, 0, back}, {from, eaves, back}, {to, eaves, back}, 2, 3);
        panel({from, eaves, front}, {to, eaves, front}, {to, ridge, middle}, {from, ridge, middle}, 2, 2);
        panel({to, eaves, back}, {from, eaves, back}, {from, ridge, middle}, {to, ridge, middle}, 2, 2);
    }
    panel({right, 0, front}, {right, 0, back}, {right, eaves, back}, {right, eaves, front}, 6, 3);
    for (int truss = 0; truss <= 4; ++truss) {
        const float x = glm::mix(left, right, static_cast<float>(truss) / 4);
        parts.emplace_back();
        for (float z : {front, back}) {
            add_beam(parts.back(), {x, 0, z}, {x, eaves, z}, 0.22f, kSteel);
            add_beam(parts.back(), {x, eaves, z}, {x, ridge, middle}, 0.16f, kSteel);
        }
        add_beam(parts.back(), {x, eaves, front}, {x, eaves, back}, 0.16f, kSteel);
        for (int web = 1; web < 6; ++web) {
            const float z = glm::mix(front, back, static_cast<float>(web) / 6);
            const float top = glm::mix(eaves, ridge, 1 - std::abs(z - middle) / (front - middle));
            add_beam(parts.back(), {x, eaves, z}, {x, top, z}, 0.09f, kSteel);
        }
    }
    return parts;
}

}  // namespace ropsim
