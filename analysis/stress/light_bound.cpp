#include "analysis/stress/light_bound.h"

#include <algorithm>

namespace ropsim {
namespace {

constexpr double kVisible = 1.0 / 255;

double light(const glm::vec3& color) {
    return std::max(
        {static_cast<double>(color.r), static_cast<double>(color.g), static_cast<double>(color.b)});
}

// Floating-point sums of what is never negative move by at most twice a term and stand still only at terms
// below half a step. So a sum of colours over the sum of their weights, and a colour under the product of
// transmittances it is merged with, is at most three times the brightest, however many there are: this much
// above it.
constexpr double kMostAboveBrightest = 2;

// Of the brightest colour, above it.
double rounding_of_layers(const StressVariant& variant, double stores) {
    const double light = stores * variant.half_step;
    const double transmittance = stores * variant.unit_half_step;
    // None of the stored colours exceeds 1.
    if (variant.light_ends) return std::min(light + transmittance, static_cast<double>(variant.elements));
    // A product of transmittances that rounding keeps from falling lets light through for every layer.
    return std::min(light, kMostAboveBrightest * variant.elements) + transmittance;
}

}  // namespace

PixelLight light_of(const PixelScene& pixel) {
    PixelLight most;
    most.brightest = most.all = light(pixel.background);
    most.scale = std::max(1.0, most.brightest);
    most.stores = static_cast<double>(pixel.fragments.size() + 1);
    for (const Fragment& f : pixel.fragments) {
        const double own = light({f.r, f.g, f.b});
        const auto alpha = static_cast<double>(f.a);
        most.all += own;
        if (alpha > 0)
            most.brightest = std::max(most.brightest, own / alpha);
        else
            most.without_alpha += own;
        most.scale = std::max(most.scale, alpha > 0 ? own / alpha : own);
    }
    return most;
}

double most_light(const StressVariant& variant, const PixelLight& light) {
    const double scale = light.scale;
    const double step = light.stores * variant.half_step;
    switch (variant.light) {
        case LightLaw::kLayers:
            return light.brightest + light.without_alpha +
                   std::max(kVisible, rounding_of_layers(variant, light.stores)) * scale;
        case LightLaw::kMean:
        case LightLaw::kScaled:
            return light.brightest + light.without_alpha +
                   std::max(kVisible, std::min(step, kMostAboveBrightest)) * scale;
        case LightLaw::kConserved:
        case LightLaw::kAdded:
            break;
    }
    return light.all + std::max(kVisible * scale, std::min(step * scale, light.all));
}

}  // namespace ropsim
