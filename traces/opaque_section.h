// The opaque layer's section of a trace file.
#pragma once

#include "traces/trace.h"
#include "traces/trace_layout.h"

namespace ropsim {

// Columns r, g, b, depth of each run of up to 2^18 elements (samples of pixels).
Bytes encode_opaque(const OpaqueLayer& opaque);
// The inverse for `elements` samples in all. Throws FormatFault.
OpaqueLayer decode_opaque(const Bytes& section, std::size_t elements);

}  // namespace ropsim
