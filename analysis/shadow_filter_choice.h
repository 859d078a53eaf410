// How `ropsim shadow` looks a map up, from what the user wrote.
#pragma once

#include "base/parameters.h"
#include "rop/shadow/shadow_filter.h"
#include "rop/shadow/variance_options.h"

#include <string>

namespace ropsim {

struct FilterChoice {
    bool variance = false;
    ShadowFilter closer;         // percentage-closer; its side alone is set, and its shape
    VarianceOptions conversion;  // where `variance`
    std::string name;            // square, tent, disc or variance
    Parameters parameters;       // as resolved
};

// "K", a square of K x K texels; "tent[:side=K]", "disc[:side=K]"; or "variance[:key=value,...]". Throws
// UserError naming --filter.
FilterChoice parse_filter(const std::string& text);

}  // namespace ropsim
