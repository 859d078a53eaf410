// The motor's insides: stator with windings, rotor, gears and bearings.
#include "capture/geometry/lathe_mesh.h"
#include "capture/geometry/profile.h"
#include "capture/geometry/swept_mesh.h"
#include "capture/scenes/motor_parts.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {
namespace {

constexpr float kTau = glm::two_pi<float>();
constexpr int kSlots = 30;

glm::mat4 about_x(float angle) {
    return glm::rotate(glm::mat4(1.0f), angle, glm::vec3(1, 0, 0));
}

// Extrusions have their depth along z; the shaft runs along x.
glm::mat4 along_x(float x, glm::vec2 line = glm::vec2(0)) {
    const glm::mat4 place = glm::translate(glm::mat4(1.0f), glm::vec3(x, line.x, line.y));
    return glm::rotate(place, 0.25f * kTau, glm::vec3(0, 1, 0));
}

// A point of a coil: `t` from 0 to 4 goes along one slot, round the end, back along the other, and round.
glm::vec3 coil_point(float t, float from, float to, float radius, float bulge) {
    constexpr float kHalf = 0.66f;  // of the slots' length
    const int leg = static_cast<int>(t) % 4;
    const float s = t - std::floor(t);
    float x = 0;
    float angle = leg < 2 ? from : to;
    float r = radius;
    if (leg % 2 == 0) {
        x = (leg == 0 ? 1.0f : -1.0f) * kHalf * (2 * s - 1);
    } else {
        const float ease = 0.5f - 0.5f * std::cos(glm::pi<float>() * s);
        angle = leg == 1 ? glm::mix(from, to, ease) : glm::mix(to, from, ease);
        const float arch = std::sin(glm::pi<float>() * s);
        x = (leg == 1 ? 1.0f : -1.0f) * (kHalf + bulge * std::sqrt(arch));
        r += 0.06f * arch;
    }
    return {x, r * std::cos(angle), r * std::sin(angle)};
}

void add_windings(TriangleMesh& mesh) {
    constexpr int kPoints = 44;
    constexpr int kPitch = 5;  // slots that a coil spans
    for (int coil = 0; coil < kSlots; ++coil) {
        const float from = kTau * static_cast<float>(coil) / kSlots;
        const float to = kTau * static_cast<float>(coil + kPitch) / kSlots;
        for (int wire = 0; wire < 8; ++wire) {
            const float step = static_cast<float>(wire);
            std::vector<glm::vec3> path;
            for (int i = 0; i < kPoints; ++i) {
                const float t = 4.0f * static_cast<float>(i) / kPoints;
                path.push_back(coil_point(t, from - 0.009f * step, to + 0.009f * step, 0.655f + 0.017f * step,
                                          0.13f + 0.016f * step));
            }
            SweptProfile sweep;
            sweep.path = path;
            sweep.outline = circle_outline(0.009f, 6);
            sweep.closed = true;
            sweep.up = {0, std::cos(from), std::sin(from)};
            sweep.crease_degrees = 100;
            append_mesh(mesh, swept_mesh(sweep));
        }
    }
}

// Outline of an involute-like spur gear: straight-flanked teeth with rounded tips.
std::vector<glm::vec2> gear_outline(int teeth, float pitch_radius) {
    const float module = 2 * pitch_radius / static_cast<float>(teeth);
    const float tip = pitch_radius + module;
    const float root = pitch_radius - 1.2f * module;
    constexpr glm::vec2 kTooth[] = {{-0.5f, 0},      {-0.33f, 0}, {-0.27f, 0.3f}, {-0.2f, 0.62f},
                                    {-0.12f, 0.93f}, {0, 1},      {0.12f, 0.93f}, {0.2f, 0.62f},
                                    {0.27f, 0.3f},   {0.33f, 0}};
    std::vector<glm::vec2> outline;
    for (int tooth = 0; tooth < teeth; ++tooth) {
        for (const glm::vec2& p : kTooth) {
            const float angle = kTau * (static_cast<float>(tooth) + p.x) / static_cast<float>(teeth);
            const float radius = glm::mix(root, tip, p.y);
            outline.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
        }
    }
    return outline;
}

void add_gear(TriangleMesh& mesh, int teeth, float radius, float width, float x, glm::vec2 line, float turn) {
    const glm::mat4 place =
        about_x(0) * along_x(x, line) * glm::rotate(glm::mat4(1.0f), turn, glm::vec3(0, 0, 1));
    append_mesh(mesh, extruded_mesh(gear_outline(teeth, radius), 0.5f * width, 40), place);
    // Hub and a turned recess on either side.
    append_mesh(mesh, turned_ring({{0.3f * radius, x - 0.8f * width},
                                   {0.3f * radius, x + 0.8f * width},
                                   {0.2f * radius, x + 0.8f * width},
                                   {0.2f * radius, x - 0.8f * width}},
                                  48, line));
    for (const float side : {-1.0f, 1.0f}) {
        const float face = x + side * 0.53f * width;
        append_mesh(mesh, flat_ring(0.72f * radius, 0.8f * radius, face - 0.02f, face + 0.02f, 72, line));
    }
    // Lightening bosses between hub and rim.
    for (int boss = 0; boss < 6 && radius > 0.3f; ++boss) {
        const float angle = turn + kTau * static_cast<float>(boss) / 6;
        const glm::vec2 at = line + 0.52f * radius * glm::vec2(std::cos(angle), std::sin(angle));
        append_mesh(mesh,
                    flat_ring(0.09f * radius, 0.13f * radius, x - 0.6f * width, x + 0.6f * width, 28, at));
    }
}

void add_bearing(TriangleMesh& mesh, float bore, float outer, float x, glm::vec2 line = glm::vec2(0)) {
    const float middle = 0.5f * (bore + outer);
    const float ball = 0.3f * (outer - bore);
    const float half = 0.42f * (outer - bore);
    // Races with a groove for the balls.
    for (const float side : {-1.0f, 1.0f}) {
        const float wall = side < 0 ? bore : outer;
        std::vector<glm::vec2> profile;
        constexpr int kGroove = 8;
        for (int i = 0; i <= kGroove; ++i) {
            const float angle = glm::mix(-0.8f, 0.8f, static_cast<float>(i) / kGroove);
            profile.emplace_back(middle + side * 1.06f * ball * std::cos(angle),
                                 x + 1.06f * ball * std::sin(angle));
        }
        profile.emplace_back(profile.back().x, x + half);
        profile.emplace_back(wall, x + half);
        profile.emplace_back(wall, x - half);
        profile.emplace_back(profile.front().x, x - half);
        if (side > 0) std::reverse(profile.begin(), profile.end());
        append_mesh(mesh, turned_ring(profile, 60, line));
    }
    const int balls = static_cast<int>(kTau * middle / (2.5f * ball));
    const TriangleMesh sphere = sphere_mesh(10);
    for (int i = 0; i < balls; ++i) {
        const float angle = kTau * static_cast<float>(i) / static_cast<float>(balls);
        const glm::vec3 at(x, line.x + middle * std::cos(angle), line.y + middle * std::sin(angle));
        append_mesh(mesh, sphere, glm::scale(glm::translate(glm::mat4(1.0f), at), glm::vec3(ball)));
    }
    // Cage.
    append_mesh(mesh, flat_ring(middle - 0.2f * ball, middle + 0.2f * ball, x + 0.9f * ball, x + 1.05f * ball,
                                60, line));
    append_mesh(mesh, flat_ring(middle - 0.2f * ball, middle + 0.2f * ball, x - 1.05f * ball, x - 0.9f * ball,
                                60, line));
}

}  // namespace

TriangleMesh turned_ring(std::vector<glm::vec2> profile, int sectors, glm::vec2 line) {
    profile.push_back(profile.front());
    const glm::mat4 place = glm::translate(glm::mat4(1.0f), glm::vec3(0, line.x, line.y));
    TriangleMesh mesh;
    append_mesh(mesh, lathe_mesh(profile, sectors), glm::rotate(place, -0.25f * kTau, glm::vec3(0, 0, 1)));
    return mesh;
}

TriangleMesh flat_ring(float inner, float outer, float from_x, float to_x, int sectors, glm::vec2 line) {
    return turned_ring({{inner, from_x}, {outer, from_x}, {outer, to_x}, {inner, to_x}}, sectors, line);
}

TriangleMesh motor_stator() {
    TriangleMesh mesh;
    constexpr int kPackets = 6;
    // Packets of laminations with gaps for the air.
    for (int i = 0; i < kPackets; ++i) {
        const float x = -0.6f + 1.2f * (static_cast<float>(i) + 0.5f) / kPackets;
        append_mesh(mesh, flat_ring(0.78f, 0.9f, x - 0.075f, x + 0.075f, 90));
    }
    // Teeth with their shoes towards the air gap, radially outwards along the outline's x.
    const std::vector<glm::vec2> tooth = {{0.8f, 0.03f},    {0.63f, 0.028f},  {0.605f, 0.052f},
                                          {0.59f, 0.052f},  {0.59f, -0.052f}, {0.605f, -0.052f},
                                          {0.63f, -0.028f}, {0.8f, -0.03f}};
    for (int slot = 0; slot < kSlots; ++slot) {
        const float angle = kTau * (static_cast<float>(slot) + 0.5f) / kSlots;
        for (int i = 0; i < kPackets; ++i) {
            const float x = -0.6f + 1.2f * (static_cast<float>(i) + 0.5f) / kPackets;
            append_mesh(mesh, extruded_mesh(tooth, 0.075f), about_x(angle) * along_x(x));
        }
    }
    add_windings(mesh);
    // The can in the air gap, and the sleeve that the packets are shrunk into.
    append_mesh(mesh, flat_ring(0.572f, 0.582f, -0.95f, 0.95f, 96));
    append_mesh(mesh, flat_ring(0.9f, 0.907f, -0.9f, 0.9f, 96));
    return mesh;
}

TriangleMesh motor_rotor() {
    TriangleMesh mesh;
    // The stepped shaft, solid.
    append_mesh(mesh, turned_ring({{0, -1.75f},
                                   {0.1f, -1.75f},
                                   {0.12f, -1.72f},
                                   {0.12f, -1.3f},
                                   {0.15f, -1.3f},
                                   {0.15f, -0.72f},
                                   {0.2f, -0.68f},
                                   {0.2f, 0.68f},
                                   {0.15f, 0.72f},
                                   {0.15f, 1.3f},
                                   {0.12f, 1.3f},
                                   {0.12f, 2.05f},
                                   {0.1f, 2.08f},
                                   {0, 2.08f}},
                                  72));
    constexpr int kDiscs = 58;
    for (int i = 0; i < kDiscs; ++i) {
        const float x = -0.6f + 1.2f * (static_cast<float>(i) + 0.5f) / kDiscs;
        append_mesh(mesh, flat_ring(0.21f, 0.56f, x - 0.006f, x + 0.006f, 72));
    }
    constexpr int kBars = 24;
    for (int bar = 0; bar < kBars; ++bar) {
        const float angle = kTau * static_cast<float>(bar) / kBars;
        std::vector<glm::vec3> path;
        for (int i = 0; i <= 8; ++i) {
            // Skewed by a slot along the rotor.
            const float turn = angle + 0.26f * static_cast<float>(i) / 8;
            path.emplace_back(-0.66f + 1.32f * static_cast<float>(i) / 8, 0.51f * std::cos(turn),
                              0.51f * std::sin(turn));
        }
        append_mesh(mesh, tube_mesh(path, 0.026f, 8));
    }
    for (const float side : {-1.0f, 1.0f})
        append_mesh(mesh, flat_ring(0.44f, 0.56f, side * 0.69f - 0.035f, side * 0.69f + 0.035f, 72));
    // The fan behind.
    append_mesh(mesh, flat_ring(0.125f, 0.22f, -1.64f, -1.42f, 64));
    const std::vector<glm::vec2> blade = {{0.2f, -0.012f}, {0.45f, 0.02f},  {0.78f, 0.09f}, {0.8f, 0.11f},
                                          {0.77f, 0.115f}, {0.44f, 0.045f}, {0.2f, 0.012f}};
    for (int i = 0; i < 11; ++i) {
        const float angle = kTau * static_cast<float>(i) / 11;
        append_mesh(mesh, extruded_mesh(blade, 0.09f), about_x(angle) * along_x(-1.53f));
    }
    return mesh;
}

TriangleMesh motor_gears() {
    TriangleMesh mesh;
    const glm::vec2 lay(-0.42f, 0.5f);   // the layshaft's axis
    const glm::vec2 out(-0.1f, -0.52f);  // the output's
    const float to_lay = glm::length(lay);
    const float small = 0.3f * to_lay;
    add_gear(mesh, 16, small, 0.2f, 1.62f, {0, 0}, 0);
    add_gear(mesh, 37, to_lay - small, 0.18f, 1.62f, lay, 0.06f);
    const float across = glm::length(out - lay);
    add_gear(mesh, 18, 0.34f * across, 0.2f, 1.92f, lay, 0.1f);
    add_gear(mesh, 35, 0.66f * across, 0.18f, 1.92f, out, 0.02f);
    append_mesh(mesh, turned_ring({{0, 1.38f}, {0.09f, 1.38f}, {0.09f, 2.12f}, {0, 2.12f}}, 40, lay));
    append_mesh(mesh, turned_ring({{0, 1.5f},
                                   {0.13f, 1.5f},
                                   {0.13f, 2.35f},
                                   {0.11f, 2.37f},
                                   {0.11f, 2.78f},
                                   {0.095f, 2.8f},
                                   {0, 2.8f}},
                                  56, out));
    return mesh;
}

TriangleMesh motor_bearings() {
    TriangleMesh mesh;
    add_bearing(mesh, 0.15f, 0.34f, -1.0f);
    add_bearing(mesh, 0.15f, 0.34f, 1.05f);
    add_bearing(mesh, 0.09f, 0.22f, 1.44f, {-0.42f, 0.5f});
    add_bearing(mesh, 0.09f, 0.22f, 2.08f, {-0.42f, 0.5f});
    add_bearing(mesh, 0.13f, 0.3f, 2.25f, {-0.1f, -0.52f});
    return mesh;
}

}  // namespace ropsim
