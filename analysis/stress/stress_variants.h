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
    int node_bits = 0;      // and, of lists, of a stored fragment
    // Too narrow whatever the scene; and on scenes with colours above 1.
    std::vector<NarrowField> narrow = {};
    std::vector<NarrowField> narrow_if_bright = {};
    // The coarsest rounding of what light is stored in, and of what is declared within [-1, 1], as
    // transmittances are: see half_step(Format).
    double half_step = 0;
    double unit_half_step = 0;
    int elements = 1;         // of a pixel's layers or nodes that light is stored in
    bool light_ends = false;  // all of it in formats that end at 1
    LightLaw light = LightLaw::kLayers;

    // Of a pixel that has stored one fragment.
    int all_bits() const { return bits + node_bits; }
};

// "288", or "32 + 192 a node"; and of two variants what one has more: "+64", "+0, a node +32".
std::string bits_text(int bits, int node_bits);
std::string more_bits_text(int bits, int node_bits);

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
