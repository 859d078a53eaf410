// Techniques with their settings, and every stored format that their surfaces take.
#pragma once

#include "rop/declaration.h"

#include <cstddef>
#include <string>
#include <vector>

namespace ropsim {

// A field whose format cannot hold what its technique declares for it.
struct NarrowField {
    std::string surface;
    Format format = Format::kFloat32;
    ValueRange range = ValueRange::kUnit;
};

struct StressVariant {
    std::string technique;  // NAME[:key=value,...], complete
    std::string formats;    // "paper", "float32", "SURFACE FORMAT" (the others float32) or "all FORMAT"
    int bits = 0;           // storage of a pixel
    // Too narrow whatever the scene; and on scenes with colours above 1.
    std::vector<NarrowField> narrow = {};
    std::vector<NarrowField> narrow_if_bright = {};
    double half_step = 0;  // the coarsest rounding of what light is stored in: see half_step(Format)
    LightLaw light = LightLaw::kConserved;
};

// A technique's settings without its formats, and the variants that differ in formats alone.
struct StressTechnique {
    std::string settings;  // as it is named: NAME[:key=value,...]
    std::string exact;     // the same with all values in float32, for a double-precision run; empty: none
    std::vector<StressVariant> variants;
};

// Of each of `techniques` that makes a colour image. `every_format`: else paper and float32 alone.
std::vector<StressTechnique> stress_techniques(const std::vector<std::string>& techniques, bool every_format);
// The configurations that the study takes when none is named: the standard ones, and those whose arithmetic
// is another.
std::vector<std::string> stress_configurations();

}  // namespace ropsim
