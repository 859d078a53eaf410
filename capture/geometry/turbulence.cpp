// Turbulence as a sum of transverse waves.
#include "capture/geometry/turbulence.h"

#include "base/random.h"

#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {

Turbulence::Turbulence(std::uint64_t seed) {
    for (int i = 0; i < kWaves; ++i) {
        const std::uint64_t key = mix64(seed ^ (0x57617665ull << 32) ^ static_cast<std::uint64_t>(i));
        const auto direction = [&](std::uint32_t draw) {
            return glm::normalize(
                glm::vec3(random_unit(key, draw), random_unit(key, draw + 1), random_unit(key, draw + 2)) *
                    2.0f -
                1.0f + 1e-3f);
        };
        const int octave = i / kWavesAnOctave;
        waves_[i].number = direction(0) * (1.1f * std::exp2(static_cast<float>(octave)));
        // Across the direction of travel, so nothing is compressed.
        waves_[i].push = glm::normalize(glm::cross(waves_[i].number, direction(3))) *
                         (0.55f * std::exp2(-0.75f * static_cast<float>(octave)));
        waves_[i].phase = glm::two_pi<float>() * random_unit(key, 6);
    }
}

glm::vec3 Turbulence::operator()(glm::vec3 position) const {
    glm::vec3 sum(0);
    for (const Wave& wave : waves_) sum += wave.push * std::sin(glm::dot(wave.number, position) + wave.phase);
    return sum;
}

}  // namespace ropsim
