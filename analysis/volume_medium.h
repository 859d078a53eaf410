// What a participating medium does to light at a point: extinction, phase function, light scattered towards
// the eye.
#pragma once

#include <optional>

#include <glm/glm.hpp>

namespace ropsim {

// Lengths in metres; world y points up.
struct VolumeMedium {
    double extinction = 0.02;    // per metre: absorption and out-scattering together
    glm::dvec3 albedo{1, 1, 1};  // share of the extinction that scatters
    double anisotropy = 0;       // g of the phase function, its mean cosine, in (-1, 1); > 0: forwards
    std::optional<double> height_falloff;  // extinction falls to 1/e over so much height above base_height
    double base_height = 0;
    double collimation = 0;  // of the fragments' Material: 0 as McGuire and Mara 2017 (section 4.1) for fog
};

// Henyey and Greenstein's phase function, per steradian: the density of light that travelled along one
// direction and leaves along another, whose cosine is `cosine`. Integrates to 1 over the sphere.
double henyey_greenstein(double cosine, double anisotropy);

// 1 - exp(-depth) for depth >= 0, to the last bits for small depths too; the same bits on every machine.
double absorbed_share(double depth);

// At world height y.
double extinction_at(const VolumeMedium& medium, double height);

}  // namespace ropsim
