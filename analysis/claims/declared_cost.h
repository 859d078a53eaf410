// What a technique's own declaration says of its memory and of its worst case, without a trace.
#pragma once

#include "rop/cost.h"

#include <string>

namespace ropsim {

struct DeclaredCost {
    int storage_bits = 0;     // a pixel
    ByteCount worst_case;     // of a fragment, all passes over the fragments, nothing cached
    int geometry_passes = 0;  // over the fragments, every round of a repeated one
    Declaration declaration;

    double bytes() const { return static_cast<double>(worst_case.read + worst_case.write); }
    // Of one surface a pixel; 0 where there is none of that name.
    int surface_bits(const std::string& name) const;
};

// `technique`: NAME[:key=value,...], on a trace with so many spatial samples, whose surfaces have materials
// or not. Throws UserError for a faulty one.
DeclaredCost declared_cost(const std::string& technique, int spatial_samples = 1, bool materials = false);

}  // namespace ropsim
