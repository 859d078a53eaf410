// One technique on one pixel after another in double precision, nothing rounded to a stored format: the
// technique's own operation without its rounding.
#pragma once

#include "rop/single_pixel.h"

#include <memory>
#include <string>

namespace ropsim_double {

// As ropsim::make_single_pixel. `technique` must keep all its values in float32: format=float32 and no other
// format named (a name that it refuses throws UserError, one that rounds aborts).
std::unique_ptr<ropsim::SinglePixel> make_single_pixel(const std::string& technique,
                                                       const ropsim::TraceHeader& header, std::uint64_t seed);

}  // namespace ropsim_double
