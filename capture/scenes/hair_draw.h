// Strands of hair as a draw: ribbons that face the camera, shadowed by each other.
#pragma once

#include "capture/scene.h"
#include "capture/scenery/light_volume.h"

#include <cstdint>
#include <string>
#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// Strands with the same number of points each. Colours are linear; w is the strand's alpha.
struct StrandGroup {
    std::string name;
    std::uint32_t points_a_strand = 0;  // at least 2
    float half_width = 0;               // of the ribbons, scene units; tapers over the last third
    std::vector<glm::vec3> points;      // strand by strand, root first
    std::vector<glm::vec4> looks;       // one a strand

    std::uint32_t strands() const { return static_cast<std::uint32_t>(looks.size()); }
};

// How much of the light that arrives at a strand the hair between takes away.
struct HairShadow {
    const LightVolume* volume = nullptr;  // illuminated already
    float strength = 1;
};

// Deposits the area of a group's strands; `share` scales it.
void deposit_strands(const StrandGroup& group, float share, LightVolume& volume);

// Kajiya-Kay shading, two triangles a segment, in the group's order.
SceneDraw strand_draw(const StrandGroup& group, const HairShadow& shadow);

// Two triangles between every two consecutive points of ribbons with two vertices a point.
void append_ribbon_indices(std::uint32_t first_point, std::uint32_t points,
                           std::vector<std::uint32_t>& indices);

}  // namespace ropsim
