// The opaque layer's section of a trace file.
#pragma once

#include "traces/trace.h"
#include "traces/trace_layout.h"

namespace ropsim {

// Columns r, g, b, depth of each run of up to 2^18 pixels.
Bytes encode_opaque(const OpaqueLayer& opaque);
// The inverse for an image of `pixels` pixels. Throws FormatFault.
OpaqueLayer decode_opaque(const Bytes& section, std::size_t pixels);

}  // namespace ropsim
