// Reads back the deep OpenEXR files that this program wrote, bit for bit.
#pragma once

#include "traces/interchange/deep_exr_file.h"
#include "traces/trace.h"

namespace ropsim {

struct OwnDeepExr {
    TraceHeader header;     // with the opaque layer
    FragmentChunk content;  // all of it, in arrival order
};

// Whether the file carries a trace's header.
bool is_own_deep_exr(const DeepExrFile& file);

// Throws UserError when anything is not as it was written: the arrival numbers are no permutation, a value is
// out of range, or the content does not match the hash that stands in the file.
OwnDeepExr read_own_deep_exr(DeepExrFile& file);

}  // namespace ropsim
