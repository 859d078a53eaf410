// A smooth random flow, for whatever drifts and billows.
#pragma once

#include <cstdint>

#include <glm/glm.hpp>

namespace ropsim {

// A vector field of a few seeded waves, each octave finer and weaker; divergence-free, about 1 in size; the
// coarsest waves are some six units long.
class Turbulence {
 public:
    explicit Turbulence(std::uint64_t seed);
    glm::vec3 operator()(glm::vec3 position) const;

 private:
    static constexpr int kWavesAnOctave = 6;
    static constexpr int kWaves = 4 * kWavesAnOctave;
    struct Wave {
        glm::vec3 number;
        glm::vec3 push;
        float phase;
    };
    Wave waves_[kWaves];
};

}  // namespace ropsim
