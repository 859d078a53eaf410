// Optical depth towards a light on a coarse grid.
#include "capture/scenery/light_volume.h"

#include <algorithm>
#include <cmath>

namespace ropsim {

LightVolume::LightVolume(glm::vec3 low, glm::vec3 high)
    : low_(low),
      cell_size_((high - low) / static_cast<float>(kCells)),
      matter_(static_cast<std::size_t>(kCells) * kCells * kCells),
      depth_(matter_.size()) {}

std::size_t LightVolume::cell(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * kCells + static_cast<std::size_t>(y)) * kCells +
           static_cast<std::size_t>(x);
}

void LightVolume::deposit(glm::vec3 position, float area) {
    const glm::vec3 at = (position - low_) / cell_size_;
    if (!glm::all(glm::greaterThanEqual(at, glm::vec3(0))) || !glm::all(glm::lessThan(at, glm::vec3(kCells))))
        return;
    const glm::ivec3 i(at);
    matter_[cell(i.x, i.y, i.z)] += area / (cell_size_.x * cell_size_.y * cell_size_.z);
}

float LightVolume::sample(const std::vector<float>& grid, glm::vec3 at) const {
    const glm::vec3 base = glm::floor(at - 0.5f);
    const glm::vec3 f = at - 0.5f - base;
    float sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 step(corner & 1, (corner >> 1) & 1, corner >> 2);
        const glm::ivec3 i = glm::clamp(glm::ivec3(base) + step, glm::ivec3(0), glm::ivec3(kCells - 1));
        const glm::vec3 w = glm::mix(1.0f - f, f, glm::vec3(step));
        sum += w.x * w.y * w.z * grid[cell(i.x, i.y, i.z)];
    }
    return sum;
}

void LightVolume::illuminate(glm::vec3 to_light) {
    // One pass, slice by slice away from the light: a cell's depth is that of the point one slice nearer to
    // the light, plus the matter in between.
    const glm::vec3 direction = to_light / cell_size_;
    int axis = 0;
    for (int i = 1; i < 3; ++i) {
        if (std::fabs(direction[i]) > std::fabs(direction[axis])) axis = i;
    }
    const glm::vec3 step = direction / std::fabs(direction[axis]);  // in cells; one slice
    const float length = glm::length(step * cell_size_);
    const bool descending = step[axis] > 0;
    for (int slice = 0; slice < kCells; ++slice) {
        glm::ivec3 i;
        i[axis] = descending ? kCells - 1 - slice : slice;
        for (int u = 0; u < kCells; ++u) {
            for (int v = 0; v < kCells; ++v) {
                i[(axis + 1) % 3] = u;
                i[(axis + 2) % 3] = v;
                const glm::vec3 at = glm::vec3(i) + 0.5f + step;
                const bool inside = slice > 0;
                depth_[cell(i.x, i.y, i.z)] =
                    inside ? sample(depth_, at) + length * sample(matter_, at) : 0.0f;
            }
        }
    }
}

float LightVolume::transmittance(glm::vec3 position, float scale) const {
    return std::exp(-scale * sample(depth_, (position - low_) / cell_size_));
}

}  // namespace ropsim
