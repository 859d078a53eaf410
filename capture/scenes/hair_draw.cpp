// Packs strands into buffers and lights them.
#include "capture/scenes/hair_draw.h"

#include "base/error.h"
#include "base/parallel.h"
#include "capture/scenery/scene_parts.h"
#include "capture/shader_sources.h"

#include <algorithm>

namespace ropsim {

void deposit_strands(const StrandGroup& group, float share, LightVolume& volume) {
    const std::size_t step = group.points_a_strand;
    for (std::size_t first = 0; first < group.points.size(); first += step) {
        for (std::size_t i = first; i + 1 < first + step; ++i) {
            const glm::vec3 a = group.points[i];
            const glm::vec3 b = group.points[i + 1];
            volume.deposit(0.5f * (a + b), share * 2 * group.half_width * glm::distance(a, b));
        }
    }
}

void append_ribbon_indices(std::uint32_t first_point, std::uint32_t points,
                           std::vector<std::uint32_t>& indices) {
    for (std::uint32_t k = 0; k + 1 < points; ++k) {
        const std::uint32_t v = 2 * (first_point + k);
        indices.insert(indices.end(), {v, v + 1, v + 2, v + 1, v + 3, v + 2});
    }
}

SceneDraw strand_draw(const StrandGroup& group, const HairShadow& shadow) {
    const std::uint32_t count = group.strands();
    const std::uint32_t points_a_strand = group.points_a_strand;
    CHECK(points_a_strand >= 2 && group.points.size() == std::size_t{count} * points_a_strand,
          "{} points, {} strands of {}", group.points.size(), count, points_a_strand);
    SceneDraw draw;
    draw.state.name = group.name;
    draw.vertex = shader_source("hair_vertex");
    draw.shading = shader_source("hair_shading");
    draw.primitives = count * 2 * (points_a_strand - 1);
    SceneBuffer points{1, std::vector<float>(4 * group.points.size())};
    constexpr std::size_t kBatch = 8192;
    const auto batches = static_cast<int>((group.points.size() + kBatch - 1) / kBatch);
    parallel_for(default_threads(), batches, [&](int batch) {
        const std::size_t first = static_cast<std::size_t>(batch) * kBatch;
        for (std::size_t i = first; i < std::min(first + kBatch, group.points.size()); ++i) {
            const glm::vec3& p = group.points[i];
            const float light = shadow.volume->transmittance(p, shadow.strength);
            const float values[] = {p.x, p.y, p.z, light};
            std::copy(std::begin(values), std::end(values), &points.values[4 * i]);
        }
    });
    SceneBuffer looks{2, {}};
    looks.values.reserve(std::size_t{4} * count);
    draw.indices.reserve(std::size_t{3} * draw.primitives);
    for (std::uint32_t i = 0; i < count; ++i) {
        const glm::vec4& look = group.looks[i];
        looks.values.insert(looks.values.end(), {look.r, look.g, look.b, look.a});
        append_ribbon_indices(i * points_a_strand, points_a_strand, draw.indices);
    }
    draw.buffers = {std::move(points), std::move(looks)};
    draw.parameters = {glm::vec4(light_direction(), 0),
                       glm::vec4(static_cast<float>(points_a_strand), group.half_width, 0, 0)};
    return draw;
}

}  // namespace ropsim
