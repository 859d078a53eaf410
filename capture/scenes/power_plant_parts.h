// Parts of a power plant, as a designer's model holds them: thin shells of one colour a system.
#pragma once

#include "capture/scenery/scenery_mesh.h"

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// A system of the plant: parts that can be left out one by one.
using PlantParts = std::vector<SceneryMesh>;

// The boiler house stands about the origin: this many metres to either side, and high.
inline constexpr glm::vec3 kHouseHalf{15.0f, 0.0f, 10.5f};
inline constexpr float kHouseHeight = 27.0f;
inline constexpr float kFloorHeight = 4.5f;

// Columns, beams and braces of the boiler house.
PlantParts make_frame();
// Sheets that close its back.
PlantParts make_cladding();
// Gratings and handrails of its floors, and its stairs.
PlantParts make_floors(std::uint64_t seed);
// Walls of tubes, hanging banks of tubes, drum and headers.
PlantParts make_boiler();
// Storage tanks with domed roofs, silos, the turbine with its generator.
PlantParts make_vessels();
// Flue gas ducts, precipitators, the stack.
PlantParts make_ducts();
// The turbine hall: walls, roof, girders.
PlantParts make_hall();
// `count` pipes that run along the axes with bends, inside the boiler house and on the rack to the tanks; the
// first n are the same for every count.
PlantParts make_pipework(std::uint32_t count, std::uint64_t seed);

// A pipe through these corners, its bends rounded, cut into lengths of at most `length` metres.
void add_pipe(SceneryMesh& mesh, const std::vector<glm::vec3>& corners, float radius, int sides, float length,
              glm::vec4 color);
// A beam: a box of this thickness from end to end, four sides and no ends.
void add_beam(SceneryMesh& mesh, glm::vec3 from, glm::vec3 to, float half, glm::vec4 color);

}  // namespace ropsim
