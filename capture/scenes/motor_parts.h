// The assemblies of a geared electric motor, from housing to bolts, as meshes.
#pragma once

#include "capture/geometry/mesh.h"

#include <string>
#include <vector>

namespace ropsim {

struct MotorAssembly {
    std::string name;
    TriangleMesh mesh;
};

// Decimetres; the shaft lies along x about the origin, the gears at positive x, feet towards -y. Parts follow
// one another as a model file would list them. Surfaces have no thickness tricks: every part is closed.
std::vector<MotorAssembly> motor_assemblies();

// What motor_assemblies() puts together.
TriangleMesh motor_housing();
TriangleMesh motor_cowl();
TriangleMesh motor_gear_case();
TriangleMesh motor_stator();
TriangleMesh motor_rotor();
TriangleMesh motor_gears();
TriangleMesh motor_bearings();

// An outline about the origin, anticlockwise, its corners rounded in `steps` pieces.
std::vector<glm::vec2> rounded_rectangle(glm::vec2 half, float radius, int steps);

// A surface of revolution about the line (y, z) parallel to x: profile points are (distance, x), closed by
// joining its ends. Broken preconditions are a CHECK.
TriangleMesh turned_ring(std::vector<glm::vec2> profile, int sectors, glm::vec2 line = glm::vec2(0));

// A ring of rectangular section: radii and the range of x.
TriangleMesh flat_ring(float inner, float outer, float from_x, float to_x, int sectors,
                       glm::vec2 line = glm::vec2(0));

// Cuts the largest triangles of the assemblies at their middles until there are `triangles` altogether, which
// must not be fewer than now, differ by an even number, and be at most three times as many (CHECK). No
// surface changes.
void refine_to(std::vector<MotorAssembly>& assemblies, std::uint32_t triangles);

}  // namespace ropsim
