// How bright a pixel may come out: what its technique's formula does with light (LightLaw), and how far
// stored formats round it.
#pragma once

#include "analysis/stress/stress_variants.h"
#include "rop/single_pixel.h"

namespace ropsim {

struct PixelLight {
    double brightest = 0;      // of the straight colours of the background and of what has alpha
    double all = 0;            // of the background and all fragments, none behind another
    double without_alpha = 0;  // of fragments that hide nothing
    double scale = 1;          // what errors are relative to: the brightest of all, at least 1
    double stores = 1;         // of light: one a fragment, and the background's
};
PixelLight light_of(const PixelScene& pixel);

// What no channel may exceed in formats that hold what is declared for them. Formulas that are hazards have
// the bound of kConserved.
double most_light(const StressVariant& variant, const PixelLight& light);

}  // namespace ropsim
